"""How values look as text: numbers, bars, bands, sparklines, and the styles of what is told in a word."""

from collections.abc import Sequence
from math import ceil, floor, isfinite
from typing import NamedTuple

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.alarm import Severity

STATUS_STYLE = {Status.VALID: "green", Status.HELD: "yellow", Status.CONVERGING: "cyan", Status.INVALID: "bold red"}
SEVERITY_STYLE = {Severity.INFO: "cyan", Severity.WARNING: "black on yellow", Severity.ALARM: "bold white on red"}
# Of an adhesion: the rail's condition while the wheels use all that there is.
LEVEL_STYLE = {"extremely_low": "bold red", "very_low": "bold red", "low": "yellow", "normal": "green", None: "cyan"}

BEYOND_MEASURE = 1e9  # no speed, force or time between alarms is more: decades, in seconds
HIGHEST = 10.0  # no coefficient is more; what comes over a network may be anything
LOWEST = 0.10  # a scale does not end before

_EIGHTHS_UP = " ▁▂▃▄▅▆▇█"
_EIGHTHS_RIGHT = " ▏▎▍▌▋▊▉█"


class Moment(NamedTuple):
    """One bin of the sparkline: the lowest adhesion while saturated, else the last."""

    adhesion: float
    saturated: bool

    def beside(self, before: "Moment | None") -> "Moment":
        """What to show of a bin in which this comes after that."""
        if before is None or not before.saturated or not isfinite(before.adhesion):
            return self
        return min(before, self) if self.saturated else before


def number(value: float | None, decimals: int, width: int = 0) -> str:
    """Fixed-point, or a dash when there is no number, or none that could be."""
    is_one = value is not None and abs(value) < BEYOND_MEASURE
    return (f"{value:z.{decimals}f}" if is_one else "–").rjust(width)


def wsp(acts: bool | None) -> str:
    """Whether a slide protection acts, in three characters; a dash where no signal tells."""
    return " – " if acts is None else "WSP" if acts else "   "


def plus_minus(value: float | None, std: float | None) -> str:
    """A coefficient with its standard deviation, always 13 characters: ` 0.083 ±0.006`."""
    return f"{number(value, 3, 6)} ±{number(std, 3, 5)}"


def bar(value: float, full: float, width: int) -> str:
    """A bar from the left, in eighths of a character; full at `full`, empty when there is no number."""
    share = min(max(value / full, 0.0), 1.0) if isfinite(value) else 0.0
    eighths = round(share * width * 8)
    whole, rest = divmod(eighths, 8)
    return ("█" * whole + (_EIGHTHS_RIGHT[rest] if rest else "")).ljust(width)


def band(value: float, std: float, top: float, width: int) -> str:
    """A value and its band of one standard deviation on a scale from 0 to `top`: `──────▒▒█▒▒──────`."""
    track = ["─"] * width
    if isfinite(value):
        spread = std if isfinite(std) else top
        place, low, high = (_place(at, top, width) for at in (value, value - spread, value + spread))
        track[low : high + 1] = "▒" * (high + 1 - low)
        track[place] = "█"
    return "".join(track)


def _place(value: float, top: float, width: int) -> int:
    return min(floor(min(max(value / top, 0.0), 1.0) * width), width - 1)


def sparkline(history: Sequence[Moment | None], top: float) -> str:
    """Adhesion over time in blocks, from 0 to `top`; a gap where nothing was known."""
    return "".join(_block(moment, top) for moment in history)


def _block(moment: Moment | None, top: float) -> str:
    if moment is None or not isfinite(moment.adhesion):
        return " "
    share = min(max(moment.adhesion / top, 0.0), 1.0)
    return _EIGHTHS_UP[max(1, round(share * 8))]


def scale_top(values: Sequence[float]) -> float:
    """Return the end of a scale from 0 that holds all values, from LOWEST to HIGHEST, in steps of 0.05."""
    highest = max((value for value in values if isfinite(value)), default=0.0)
    return ceil(min(max(highest, LOWEST), HIGHEST) / 0.05 - 1e-9) * 0.05
