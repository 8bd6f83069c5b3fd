"""The one path: frame → samples → estimate → alarms. No threads, no clock, no I/O: time is the frame's."""

from msgspec import Struct

from brake_monitor.alarms import Alarm
from brake_monitor.estimator import Estimate


class Outputs(Struct, frozen=True):
    """What one step gave out: an estimate when one was due, and the alarms that changed."""

    estimate: Estimate | None
    alarms: tuple[Alarm, ...] = ()
