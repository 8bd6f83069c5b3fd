"""When which alarm is due, told from the truth alone: the plant's state and the faults, never an estimate.

An alarm is *due* from when its condition qualifies by the truth, clearly; it *may* come (`by_s` is None) where the
condition is near its threshold, and where it is a consequence of another one. Anything else is a false alarm.
"""

from brake_monitor.simulator.due.alarm import Due
from brake_monitor.simulator.due.applications import brake_applications
from brake_monitor.simulator.due.brakes import brake_not_applied, dragging_brake, hot_disc
from brake_monitor.simulator.due.friction import friction_drift, friction_out_of_band, uneven_braking
from brake_monitor.simulator.due.pads import worn_pads
from brake_monitor.simulator.due.rail import low_adhesion, slide, wheelset_not_rotating
from brake_monitor.simulator.due.sensors import failed_buses, failed_sensors
from brake_monitor.simulator.due.truth import Truth
from brake_monitor.simulator.simulate import Recording


def dues(recording: Recording) -> list[Due]:
    """All alarms that are due or may come, in order of time."""
    truth = Truth.of(recording)
    applications = brake_applications(truth)
    found = [
        *low_adhesion(truth),
        *wheelset_not_rotating(truth),
        *slide(truth),
        *dragging_brake(truth),
        *brake_not_applied(truth),
        *hot_disc(truth),
        *uneven_braking(truth, applications),
        *friction_out_of_band(truth, applications),
        *friction_drift(truth, applications),
        *worn_pads(truth, applications),
        *failed_sensors(truth),
        *failed_buses(truth),
    ]
    return sorted(found, key=lambda due: (due.from_s, due.kind, due.wheelset or 0))
