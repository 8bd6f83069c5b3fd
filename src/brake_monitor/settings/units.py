"""The units in which a quantity may be configured, and their factors to SI."""

import re
from collections.abc import Mapping
from math import pi

_KMH = 1.0 / 3.6
_FLAG = {"": 1.0}
_DEGREES = {"deg": 1.0, "°": 1.0}  # the only quantity kept out of SI: places are read in degrees
_NEWTON_METRES = {"N m": 1.0, "Nm": 1.0, "kN m": 1e3, "kNm": 1e3}

# Quantity as named in [signals] → unit → factor. The first unit of each is its default.
UNITS: Mapping[str, Mapping[str, float]] = {
    "speed": {"m/s": 1.0, "km/h": _KMH},
    "axle_speed": {"rad/s": 1.0, "rpm": 2.0 * pi / 60.0, "m/s": 1.0, "km/h": _KMH},
    "pressing_force": {"N": 1.0, "kN": 1e3},
    "wsp_active": _FLAG,
    "sanding": _FLAG,
    "load_force": {"N": 1.0, "kN": 1e3},
    "gradient": {"m/m": 1.0, "%": 1e-2, "‰": 1e-3, "permille": 1e-3},
    "wheel_torque": _NEWTON_METRES,
    "latitude": _DEGREES,
    "longitude": _DEGREES,
}

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
    """Return SI value / value in `unit` (a key of UNITS[quantity], or "" for its default unit).

    An axle speed in m/s or km/h is circumferential: it becomes rad/s through `wheel_radius_m`.
    """
    factor = UNITS[quantity][unit or default_unit(quantity)]
    if quantity == "axle_speed" and unit in _CIRCUMFERENTIAL:
        factor /= wheel_radius_m
    return factor


def default_unit(quantity: str) -> str:
    """Return the unit that a mapping has when it names none."""
    return next(iter(UNITS[quantity]))


def is_unit(written: str, unit: str) -> bool:
    """Return whether a DBC's unit is `unit`, a key of some UNITS[quantity], in one of its spellings."""
    plain, named = (re.sub(r"[\s*·]", "", text).lower() for text in (written, unit))
    return plain == named or plain in _SPELLINGS.get(unit, ())


def has_unit(quantity: str) -> bool:
    """Return whether a quantity is measured in something: flags are not, and a bare ratio needs no name."""
    return default_unit(quantity) not in {"", "m/m"}


def shown_unit(quantity: str) -> str:
    """Return the unit of a quantity's samples as a person reads it, "" for a flag or a ratio."""
    unit = default_unit(quantity)
    return _SHOWN.get(unit, unit)
