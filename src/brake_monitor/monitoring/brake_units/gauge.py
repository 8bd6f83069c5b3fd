"""What people measure of the pads, that they fitted new ones or were wrong, and what it makes of the brake units."""

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.errors import InputError
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.settings.wear_settings import WearSettings

LARGEST_THICKNESS_MM = 100.0  # of a pad, and of what a reading of it is in doubt


class Gauge(Struct, frozen=True):
    """A person measured the pads of a wheelset, fitted new ones, or takes the last such entry back."""

    time_s: float
    wheelset: int  # from 1
    thickness_mm: float | None  # None: new pads
    std_mm: float | None = None  # None: as configured
    takes_back: bool = False  # the entry before, and tells nothing else

    def told(self) -> str:
        """In words."""
        if self.takes_back:
            return "last entry taken back"
        return "new pads" if self.thickness_mm is None else f"pads measured, {self.thickness_mm:g} mm"


def after_gauge(brakes: Brakes, gauge: Gauge, settings: WearSettings) -> Brakes:
    """The brake units as they are counted on from the gauge entry; unchanged where there is no such wheelset.

    InputError when its numbers cannot be calculated with.
    """
    units = [
        unit if i != gauge.wheelset else BrakeUnit(_pads_after(unit, gauge, settings), unit.disc_temperature_c)
        for i, unit in enumerate(brakes.units, 1)
    ]
    return replace(brakes, units=tuple(units))


def _pads_after(unit: BrakeUnit, gauge: Gauge, settings: WearSettings) -> PadWear:
    if gauge.takes_back:
        return unit.pads.taken_back()
    if gauge.thickness_mm is None:
        return unit.pads.renewed(settings, gauge.time_s)
    if not all(0.0 < told_mm <= LARGEST_THICKNESS_MM for told_mm in (gauge.thickness_mm, gauge.std_mm or 1.0)):
        raise InputError(f"wheelset {gauge.wheelset}: {gauge.told()}: this entry is none that can be")
    return unit.pads.gauged(settings, gauge.time_s, gauge.thickness_mm, gauge.std_mm)
