"""What outlives the program: the state that the pipeline goes on with."""

from msgspec import Struct

from brake_monitor.estimation.learned import Learned
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes


class Remembered(Struct, frozen=True):
    """The pipeline's slow state; what is None or empty was never known."""

    learned: Learned | None = None
    brakes: Brakes | None = None
    open_alarms: tuple[Alarm, ...] = ()
