"""Whether what a person says of pads may be noted: it counts from then on, teaches the wear rate, and raises alarms."""

from math import hypot

from brake_monitor.errors import InputError
from brake_monitor.monitoring.brake_units.gauge import Gauge
from brake_monitor.monitoring.brake_units.wear import PadWear, Thickness, pad_life
from brake_monitor.settings.config import Settings

CONTRADICTS_SIGMAS = 4.0  # from what is expected: mistyped, or of another wheelset
OTHER_PADS_SIGMAS = 3.0  # above the last reading: no pad grows


def check_possible(gauge: Gauge, pads: PadWear, settings: Settings) -> None:
    """Refuse a thickness that can only be that of other pads: pads do not grow."""
    assert gauge.thickness_mm is not None
    gauge_std_mm, new = gauge.std_mm or settings.wear.gauge_std_mm, PadWear.new(settings.wear)
    if gauge.thickness_mm <= _greatest_mm(pads, gauge_std_mm):
        return
    if gauge.thickness_mm > _greatest_mm(new, gauge_std_mm):
        raise InputError(
            f"--thickness-mm {gauge.thickness_mm:g}: new pads have {new.gauge_thickness_mm:g} mm as it is configured; "
            "if yours have more, say so in [wear] new_pad_thickness_mm first"
        )
    raise InputError(
        f"--thickness-mm {gauge.thickness_mm:g}: these pads had {pads.gauge_thickness_mm:g} mm; if new ones were "
        f"fitted, say so with `wear reset --wheelset {gauge.wheelset}` first{_or_undo(gauge, pads)}"
    )


def check_expected(gauge: Gauge, pads: PadWear, settings: Settings) -> None:
    """Refuse a thickness that was hardly to be expected. Pads of which nothing was noted may be worn as far as it goes.

    The wear rate would be learned from it, and alarms that latch be raised.
    """
    assert gauge.thickness_mm is not None
    expected = pad_life(pads, settings.wear).by_energy
    doubt_mm = CONTRADICTS_SIGMAS * hypot(expected.std_mm, gauge.std_mm or settings.wear.gauge_std_mm)
    if pads.is_noted and abs(gauge.thickness_mm - expected.value_mm) > doubt_mm:
        raise InputError(
            f"--thickness-mm {gauge.thickness_mm:g}: expected {interval_text(expected)} mm; gauge again, and see that "
            f"it is wheelset {gauge.wheelset}; if it is right all the same, add --sure{_or_undo(gauge, pads)}"
        )


def _or_undo(gauge: Gauge, pads: PadWear) -> str:
    """What else may be wrong."""
    if pads.before_entry is None:
        return ""
    last = "that they are new" if pads.gauged_time_s is None else f"{pads.gauge_thickness_mm:g} mm"
    return f"; if the last entry ({last}) is wrong, take it back with `wear undo --wheelset {gauge.wheelset}`"


def check_entered(gauge: Gauge, pads: PadWear, settings: Settings) -> None:
    """Refuse to take an entry back where there is none."""
    if pads.before_entry is None:
        raise InputError(f"{settings.vehicle.id}: wheelset {gauge.wheelset} has no entry that could be taken back")


def _greatest_mm(pads: PadWear, gauge_std_mm: float) -> float:
    """What these pads may measure at most."""
    return pads.gauge_thickness_mm + OTHER_PADS_SIGMAS * hypot(pads.gauge_std_mm, gauge_std_mm)


def interval_text(thickness: Thickness) -> str:
    """The expected thickness, and between what it is with 95 %."""
    return f"{thickness.value_mm:.1f} ({thickness.low_mm:.1f} to {thickness.high_mm:.1f})"
