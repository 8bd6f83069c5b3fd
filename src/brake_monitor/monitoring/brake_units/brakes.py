"""The state of the brake units as the rules see it and the memory keeps it."""

from typing import Self

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.settings.wear_settings import WearSettings


class BrakeUnit(Struct, frozen=True):
    """Pads and discs of one wheelset."""

    pads: PadWear
    disc_temperature_c: float


class Brakes(Struct, frozen=True):
    """All brake units of the wagon; enough to go on with after a restart."""

    time_s: float | None  # of the last observation; None before the first
    units: tuple[BrakeUnit, ...]
    applications: tuple[ApplicationRecord, ...]  # the last ones, oldest first
    running: ApplicationRecord | None = None  # in the memory: the one that was going on, as far as it had come

    @classmethod
    def new(cls, wheelset_count: int, settings: WearSettings) -> Self:
        """New pads and cold discs, before the first observation."""
        return cls(None, (BrakeUnit(PadWear.new(settings), settings.ambient_c),) * wheelset_count, ())

    def as_configured(self, settings: WearSettings) -> "Brakes":
        """With all pads as `PadWear.as_configured`."""
        units = [BrakeUnit(unit.pads.as_configured(settings), unit.disc_temperature_c) for unit in self.units]
        return replace(self, units=tuple(units))
