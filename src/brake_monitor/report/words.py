"""How a report writes times, values and names for people."""

from datetime import UTC, datetime
from math import isfinite
from typing import Any

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.value_names import UNITS

LEAST_UNIX_S = 1e8  # what is smaller is no date but seconds from some beginning
SHARES = {"apart", "change", "creep", "slip"}  # words of names whose values are shares of something
PREFIXES = dict.fromkeys(("J", "N", "N m"), ((1e6, "M"), (1e3, "k")))  # from which factor on


def number(value: float | None, decimals: int) -> str:
    """Fixed-point with a proper minus sign; a dash when there is no number."""
    if value is None or not isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.replace("-", "") if float(text) == 0.0 else text.replace("-", "−")


def count(value: float, word: str) -> str:
    """`1 alarm`, `3 alarms`, `no alarms`."""
    return f"{'no' if value == 0 else grouped(value)} {word}{'' if value == 1 else 's'}"


def elapsed(seconds: float) -> str:
    """`1:02:03.4`, or `2:03.4` below an hour."""
    tenths = round(abs(seconds) * 10)
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    shown = f"{hours}:{minutes:02}:{rest / 10:04.1f}" if hours else f"{minutes}:{rest / 10:04.1f}"
    return f"−{shown}" if seconds < 0 and tenths else shown


def duration(seconds: float) -> str:
    """`42 s`, `1 min 57 s`, `1 h 2 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    return f"{whole // 60} min {whole % 60} s" if whole < 3600 else f"{whole // 3600} h {whole % 3600 // 60} min"


def grouped(value: float) -> str:
    """A whole number with thin groups of three digits: `12 345`."""
    return f"{value:,.0f}".replace(",", " ")


def date(time_s: float) -> str:
    """Date and time, UTC; seconds where the recording has no date."""
    if time_s < LEAST_UNIX_S:
        return f"{time_s:.1f} s"
    return datetime.fromtimestamp(time_s, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")


def described(name: str, value: Any) -> tuple[str, str]:
    """A value of an alarm's evidence in words with its unit: `speed_start_mps`, 21.3 → `speed start`, `21.3 m/s`."""
    parts = name.split("_")
    place = next((k for k in (len(parts) - 1, len(parts) - 2) if k > 0 and parts[k] in UNITS), None)
    unit = "" if place is None else UNITS[parts.pop(place)]
    words = " ".join(parts)
    if not isinstance(value, int | float) or isinstance(value, bool):
        return words, "–" if value is None else str(value)
    if unit == "s" and value > LEAST_UNIX_S:
        return words, date(value)
    if unit == "°":
        return words, f"{number(value, 6)} °"
    if not unit and not SHARES.isdisjoint(parts):
        value, unit = 100.0 * value, "%"
    for factor, prefix in PREFIXES.get(unit, ()):
        if abs(value) >= factor:
            value, unit = value / factor, prefix + unit
            break
    decimals = 0 if float(value).is_integer() or abs(value) >= 100 else 1 if abs(value) >= 10 else 3
    return words, f"{number(value, decimals)} {unit}".strip()


def title(alarm: Alarm) -> str:
    """`Low adhesion`, `Hot disc, wheelset 2`."""
    words = alarm.kind.replace("_", " ").capitalize()
    return words if alarm.wheelset is None else f"{words}, wheelset {alarm.wheelset}"
