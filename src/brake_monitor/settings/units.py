"""The units in which a quantity may be configured, as in `TRAITS`, and how they are written."""

import re
from collections.abc import Mapping

from brake_monitor.samples import TRAITS

# How DBC files write them otherwise, in small letters and without what joins factors.
_SPELLINGS: Mapping[str, frozenset[str]] = {
    "m/s": frozenset({"mps", "m/sec", "ms-1", "ms^-1"}),
    "km/h": frozenset({"kmh", "kph", "kmph", "km/hr"}),
    "rad/s": frozenset({"rad/sec", "rads-1", "rads^-1"}),
    "rpm": frozenset({"1/min", "/min", "min-1", "min^-1", "r/min", "rev/min", "u/min"}),
    "N": frozenset({"newton"}),
    "m/m": frozenset({"-", "1"}),
    "%": frozenset({"percent", "pct"}),
    "‰": frozenset({"permille"}),
    "permille": frozenset({"‰"}),
    "deg": frozenset({"°", "degree", "degrees"}),
    "°": frozenset({"deg", "degree", "degrees"}),
}

_CIRCUMFERENTIAL = frozenset({"m/s", "km/h"})
_SHOWN = {"deg": "°", "m/m": ""}  # otherwise as it is named


def si_factor(quantity: str, unit: str, wheel_radius_m: float) -> float:
    """Return SI value / value in `unit` (one of the quantity's, or "" for its default).

    An axle speed in m/s or km/h is circumferential: it becomes rad/s through `wheel_radius_m`.
    """
    factor = TRAITS[quantity].units[unit or default_unit(quantity)]
    if quantity == "axle_speed" and unit in _CIRCUMFERENTIAL:
        factor /= wheel_radius_m
    return factor


def default_unit(quantity: str) -> str:
    """Return the unit that a mapping has when it names none."""
    return next(iter(TRAITS[quantity].units))


def is_unit(written: str, unit: str) -> bool:
    """Return whether a DBC's unit is `unit`, one of some quantity's, in one of its spellings."""
    plain, named = (re.sub(r"[\s*·]", "", text).lower() for text in (written, unit))
    return plain == named or plain in _SPELLINGS.get(unit, ())


def has_unit(quantity: str) -> bool:
    """Return whether a quantity is measured in something: flags are not, and a bare ratio needs no name."""
    return default_unit(quantity) not in {"", "m/m"}


def shown_unit(quantity: str) -> str:
    """Return the unit of a quantity's samples as a person reads it, "" for a flag or a ratio."""
    unit = default_unit(quantity)
    return _SHOWN.get(unit, unit)
