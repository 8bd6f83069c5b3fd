"""The state of the brake units as the rules see it and the memory keeps it."""

from msgspec import Struct

from brake_monitor.monitoring.stops import StopRecord
from brake_monitor.monitoring.wear import PadWear


class BrakeUnit(Struct, frozen=True):
    """Pads and discs of one wheelset."""

    pads: PadWear
    disc_temperature_c: float


class Brakes(Struct, frozen=True):
    """All brake units of the wagon; enough to go on with after a restart."""

    time_s: float | None  # of the last observation; None before the first
    units: tuple[BrakeUnit, ...]
    stops: tuple[StopRecord, ...]  # the last ones, oldest first


NO_BRAKES = Brakes(None, (), ())
