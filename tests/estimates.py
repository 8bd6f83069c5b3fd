"""Estimates and alarms made by hand, for tests of what comes after the estimator."""

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.estimate import Estimate, Status, WheelsetEstimate
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.reports import BusReport, InputReport, InputReports
from brake_monitor.samples import Channel, InputCondition, Quantity
from brake_monitor.settings.wear_settings import WearSettings


def wheelset(**changes: object) -> WheelsetEstimate:
    values = {
        "omega_radps": 40.0,
        "omega_noise": 1e-5,
        "slip": 0.02,
        "friction": 0.34,
        "friction_std": 0.01,
        "friction_status": Status.VALID,
        "adhesion": 0.09,
        "adhesion_std": 0.004,
        "adhesion_status": Status.VALID,
        "pressing_force_n": 41000.0,
        "renewed_slides": 0,
        "wsp_active": False,
        "is_protected": False,
        "work": WheelsetWork(),
    }
    return WheelsetEstimate(**(values | changes))


def estimate(**changes: object) -> Estimate:
    values = {
        "time_s": 1700000000.25,
        "speed_mps": 18.0,
        "distance_m": 0.0,
        "adhesion": 0.08,
        "adhesion_std": 0.003,
        "saturated": True,
        "deceleration_mps2": 0.01,
        "deceleration_std_mps2": 0.02,
        "wheelsets": (wheelset(), wheelset(friction=0.31, wsp_active=True, friction_status=Status.HELD)),
        "mass_kg": 36000.0,
        "sanding": False,
        "latitude_deg": None,
        "longitude_deg": None,
        "status": Status.VALID,
        "reasons": (),
        "nis": 1.1,
        "reset_count": 0,
    }
    return Estimate(**(values | changes))


def observation(
    now: Estimate,
    inputs: tuple[InputReport, ...] = (),
    buses: tuple[BusReport, ...] = (),
    *,
    brakes: Brakes | None = None,
    wheels: tuple[WheelState, ...] = (),
    memory_failure: str = "",
) -> Observation:
    """What rules see of an estimate; with new brakes where none are given."""
    brakes = brakes or Brakes.new(len(now.wheelsets), WearSettings())
    return Observation(now, InputReports(inputs), buses, brakes, wheels, memory_failure)


def alarm(**changes: object) -> Alarm:
    values = {
        "id": "low_adhesion-1700000000000",
        "kind": "low_adhesion",
        "wheelset": None,
        "severity": Severity.ALARM,
        "raised_time_s": 1700000000.0,
        "updated_time_s": 1700000001.0,
        "acknowledged_time_s": None,
        "cleared_time_s": None,
        "message": "The rail gives 0.03.",
        "evidence": {"adhesion": 0.03, "place": "km 12", "temperature_c": None},
    }
    return Alarm(**(values | changes))


def report(
    quantity: Quantity, wheelset: int, source: str, condition: InputCondition, *, bus: str = "", losses: int = 0
) -> InputReport:
    """Of a signal that is mapped like this."""
    message, _, signal = source.partition(".")
    return InputReport(Channel(quantity, wheelset, bus, message, signal, 0.01, 0.0, 1.0), condition, losses)
