"""Outputs as a person reads them while they happen: a panel on a terminal, else one line per second.

What is shown is a `Board`, a value; drawing it is pure. Only `live_view` touches the terminal, and only there is rich
needed. Speeds are shown in km/h, forces in kN; a ± is one standard deviation.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import ceil, floor, isfinite, nan
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.host import extras
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.settings.config import Vehicle

if TYPE_CHECKING:
    from rich.console import RenderableType
    from rich.table import Table
    from rich.text import Text

    from brake_monitor.processing.pipeline import Outputs

REFRESH_HZ = 8
BIN_S = 0.5  # of the sparkline
HISTORY = 240  # bins kept
ALARMS_SHOWN = 6
FULL_FORCE_KN = 100.0  # where the bar of the pressing force ends
FULL_SLIP = 0.30
ROOM_FOR_ALL = 76  # characters inside the frame

STATUS_STYLE = {Status.VALID: "green", Status.HELD: "yellow", Status.CONVERGING: "cyan", Status.INVALID: "bold red"}
SEVERITY_STYLE = {Severity.INFO: "cyan", Severity.WARNING: "black on yellow", Severity.ALARM: "bold white on red"}

_EIGHTHS_UP = " ▁▂▃▄▅▆▇█"
_EIGHTHS_RIGHT = " ▏▎▍▌▋▊▉█"


class Column(NamedTuple):
    """A column of the wheelsets' table."""

    heading: str
    width: int  # characters, without bars
    rank: int  # where there is no room, the highest go first
    justify: Literal["left", "right"] = "left"


COLUMNS = (
    Column("", 1, 0),  # wheelset
    Column("km/h", 5, 6, "right"),
    Column("slip", 8, 3),
    Column("pad force", 9, 4),
    Column(" adhesion", 13, 7),
    Column(" pad friction", 13, 1),
    Column("", 10, 2),  # status
    Column("", 3, 5),  # WSP
)


class Moment(NamedTuple):
    """One bin of the sparkline: the lowest adhesion while saturated, else the last."""

    adhesion: float
    saturated: bool


class Board(Struct, frozen=True):
    """Everything that the view shows, after some outputs."""

    vehicle: Vehicle
    rule: LowAdhesionRule
    begun_s: float = nan
    estimate: Estimate | None = None
    history: tuple[Moment | None, ...] = ()  # None: nothing came in that time
    alarms: tuple[Alarm, ...] = ()  # as they stand now, oldest first

    def after(self, outputs: "Outputs") -> Self:
        """Return the board with the outputs on it."""
        board = self
        if outputs.alarms:
            changed = {alarm.id for alarm in outputs.alarms}
            alarms = (*(alarm for alarm in self.alarms if alarm.id not in changed), *outputs.alarms)
            cleared = [alarm for alarm in alarms if alarm.cleared_time_s is not None]
            gone = {alarm.id for alarm in cleared[: max(0, len(alarms) - ALARMS_SHOWN)]}
            board = replace(board, alarms=tuple(alarm for alarm in alarms if alarm.id not in gone))
        if outputs.estimate is not None:
            board = board._with_estimate(outputs.estimate)
        return board

    def _with_estimate(self, estimate: Estimate) -> Self:
        moment = Moment(estimate.adhesion, estimate.saturated)
        step = HISTORY if self.estimate is None else _bin(estimate.time_s) - _bin(self.estimate.time_s)
        begun_s, history = self.begun_s, self.history
        if not 0 <= step < HISTORY:  # the beginning, or time jumped
            begun_s, history = estimate.time_s, (moment,)
        elif step == 0:
            history = (*history[:-1], _worse(history[-1], moment))
        else:
            history = (*history, *[None] * (step - 1), moment)[-HISTORY:]
        return replace(self, begun_s=begun_s, estimate=estimate, history=history)


def _bin(time_s: float) -> int:
    return floor(time_s / BIN_S)


def _worse(before: Moment | None, now: Moment) -> Moment:
    if before is None or not before.saturated:
        return now
    return min(before, now) if now.saturated else before


def number(value: float, decimals: int, width: int = 0) -> str:
    """Fixed-point, or a dash when there is no number."""
    return (f"{value:.{decimals}f}" if isfinite(value) else "–").rjust(width)


def wsp(acts: bool | None) -> str:
    """Whether a slide protection acts, in three characters; a dash where no signal tells."""
    return " – " if acts is None else "WSP" if acts else "   "


def plus_minus(value: float, std: float) -> str:
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
    """Return the end of a scale from 0 that holds all values, at least 0.10, in steps of 0.05."""
    highest = max((value for value in values if isfinite(value)), default=0.0)
    return max(2, ceil(highest / 0.05 - 1e-9)) * 0.05


def plain_line(board: Board) -> str:
    """One line of everything that is known now."""
    estimate = board.estimate
    if estimate is None:
        return "nothing received yet"
    state = "saturated" if estimate.saturated else "used"
    parts = [
        f"{number(estimate.time_s - board.begun_s, 1, 7)} s  {number(_kmh(estimate), 1, 5)} km/h  "
        f"adhesion {plus_minus(estimate.adhesion, estimate.adhesion_std)} {state:9} {_status_words(estimate)}"
    ]
    for place, wheelset in enumerate(estimate.wheelsets):
        parts.append(
            f"{place + 1}: {number(_wheel_kmh(board, estimate, place), 1, 5)} km/h"
            f"  slip {number(_slip(estimate, place) * 100, 1, 5)} %"
            f"  force {number(_force_kn(estimate, place), 1, 5)} kN"
            f"  friction {plus_minus(wheelset.friction, wheelset.friction_std)} {wheelset.friction_status}"
            + f"  {_wsp(estimate, place)}".rstrip()
        )
    return " | ".join(parts)


def plain_alarm(alarm: Alarm) -> str:
    """One line of a change of an alarm."""
    state = "open" if alarm.cleared_time_s is None else "cleared"
    return f"  {alarm.severity.upper()} {_alarm_name(alarm)} {state}: {alarm.message}"


def _alarm_name(alarm: Alarm) -> str:
    return alarm.kind.replace("_", " ") + ("" if alarm.wheelset is None else f", wheelset {alarm.wheelset}")


def _status_words(estimate: Estimate) -> str:
    return ", ".join((estimate.status, *estimate.reasons))


def _kmh(estimate: Estimate) -> float:
    return estimate.speed_mps * 3.6 if estimate.knows(Quantity.SPEED) else nan


def _wheel_kmh(board: Board, estimate: Estimate, place: int) -> float:
    if not estimate.knows(Quantity.AXLE_SPEED, place):
        return nan
    return estimate.wheelsets[place].omega_radps * board.vehicle.wheel_radius_m[place] * 3.6


def _slip(estimate: Estimate, place: int) -> float:
    return estimate.wheelsets[place].slip if estimate.knows_slip(place) else nan


def _force_kn(estimate: Estimate, place: int) -> float:
    return estimate.wheelsets[place].pressing_force_n / 1000 if estimate.knows(Quantity.PRESSING_FORCE, place) else nan


def _wsp(estimate: Estimate, place: int) -> str:
    return wsp(estimate.wheelsets[place].wsp_active if estimate.knows(Quantity.WSP_ACTIVE, place) else None)


def rail_style(moment: Moment, rule: LowAdhesionRule) -> str:
    """Return the colour of an adhesion: of the rail's condition once the wheels got all that there was."""
    if not moment.saturated:
        return "cyan"
    if moment.adhesion < rule.very_low:
        return "bold red"
    return "yellow" if moment.adhesion < rule.low else "green"


def panel(board: Board, width: int, footer: str = "") -> "RenderableType":
    """The whole view. Below 80 columns it leaves out what matters least."""
    from rich.box import ROUNDED  # noqa: PLC0415 - an extra, and slow to import
    from rich.console import Group  # noqa: PLC0415
    from rich.panel import Panel  # noqa: PLC0415
    from rich.text import Text  # noqa: PLC0415

    if board.estimate is None:
        inside: RenderableType = Text("waiting for the first estimate …", style="dim")
        elapsed = ""
    else:
        estimate = board.estimate
        inside = Group(_wagon(board, estimate, width - 4), _wheelsets(board, estimate, width), _alarms(board))
        elapsed = f" {number(estimate.time_s - board.begun_s, 1)} s "
    return Panel(
        inside,
        title=f"[bold] {board.vehicle.id} [/bold]{elapsed}",
        title_align="left",
        subtitle=footer or None,
        subtitle_align="left",
        box=ROUNDED,
        width=width,
    )


def _wagon(board: Board, estimate: Estimate, width: int) -> "Text":
    from rich.text import Text  # noqa: PLC0415 - as above

    adhesions = [moment.adhesion for moment in board.history if moment]
    top = scale_top([*adhesions, estimate.adhesion + estimate.adhesion_std])
    room = width - 20
    style = rail_style(Moment(estimate.adhesion, estimate.saturated), board.rule)
    text = Text(no_wrap=True, overflow="ellipsis")
    text.append("speed     ").append(f"{number(_kmh(estimate), 1, 6)} km/h", style="bold")
    if width >= ROOM_FOR_ALL:
        text.append(f"   unmodelled deceleration {number(estimate.deceleration_mps2, 3)} m/s²")
    text.append("   ").append(_status_words(estimate), style=STATUS_STYLE[estimate.status]).append("\n")
    text.append("adhesion  ").append(plus_minus(estimate.adhesion, estimate.adhesion_std), style=f"bold {style}")
    meaning = " the rail gives no more" if estimate.saturated else " in use"
    if width >= ROOM_FOR_ALL:
        meaning += " (saturated)" if estimate.saturated else "; the rail may give more"
    text.append(f"  {meaning}\n", style=style)
    text.append("          ").append(band(estimate.adhesion, estimate.adhesion_std, top, room), style=style)
    text.append(f" 0–{top:.2f}\n", style="dim")
    shown = board.history[-room:]
    text.append(f"{f'last {room * BIN_S:.0f} s':10}").append(" " * (room - len(shown)))
    for moment in shown:
        text.append(sparkline([moment], top), style=rail_style(moment, board.rule) if moment else "")
    return text.append("\n")


def _wheelsets(board: Board, estimate: Estimate, width: int) -> "Table":
    from rich.table import Table  # noqa: PLC0415 - as above
    from rich.text import Text  # noqa: PLC0415

    room = width - 4
    # Fixed widths: nothing moves but what changes. Bars only where all columns have room.
    bar_width = 3 + min(max(width - 80, 0), 24) // 2 if room >= ROOM_FOR_ALL else 0
    wider = {"slip": bar_width, "pad force": bar_width}
    columns = [column._replace(width=column.width + wider.get(column.heading, 0)) for column in COLUMNS]
    columns[0] = columns[0]._replace(width=len(str(len(estimate.wheelsets))))
    shown = _that_fit(columns, room)
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="dim")
    for k in shown:
        table.add_column(columns[k].heading, justify=columns[k].justify, width=columns[k].width, no_wrap=True)
    for place, wheelset in enumerate(estimate.wheelsets):
        slip, force_kn = _slip(estimate, place), _force_kn(estimate, place)
        slipping = "bold red" if slip > FULL_SLIP / 2 else "yellow" if slip > 0.05 else ""
        cells = (
            Text(str(place + 1), style="bold"),
            Text(number(_wheel_kmh(board, estimate, place), 1, 5)),
            Text(f"{number(slip * 100, 1, 5)} % {bar(slip, FULL_SLIP, bar_width)}", style=slipping),
            Text(f"{number(force_kn, 1, 5)} kN {bar(force_kn, FULL_FORCE_KN, bar_width)}"),
            Text(plus_minus(wheelset.adhesion, wheelset.adhesion_std)),
            Text(plus_minus(wheelset.friction, wheelset.friction_std), style="bold"),
            Text(wheelset.friction_status, style=STATUS_STYLE[wheelset.friction_status]),
            Text(_wsp(estimate, place), style="black on yellow" if _wsp(estimate, place) == "WSP" else "dim"),
        )
        table.add_row(*(cells[k] for k in shown))
    return table


def _that_fit(columns: Sequence[Column], room: int) -> list[int]:
    """The places of the columns that have room beside each other, the most important first to get it."""
    found: list[int] = []
    for k in sorted(range(len(columns)), key=lambda k: columns[k].rank):
        if columns[k].width + 1 <= room:
            room -= columns[k].width + 1
            found.append(k)
    return sorted(found)


def _alarms(board: Board) -> "Text":
    from rich.text import Text  # noqa: PLC0415 - as above

    if not board.alarms:
        return Text("\nno alarms", style="dim")
    text = Text()
    for alarm in board.alarms:
        begun = f"{number(alarm.raised_time_s - board.begun_s, 1)} s"
        text.append("\n")
        if alarm.cleared_time_s is None:
            text.append(f" {alarm.severity.upper()} ", style=SEVERITY_STYLE[alarm.severity])
            text.append(f" {_alarm_name(alarm)} since {begun}: ", style="bold").append(alarm.message)
        else:
            lasted = f"{number(alarm.cleared_time_s - alarm.raised_time_s, 1)} s"
            text.append(f" cleared {_alarm_name(alarm)} at {begun}, lasted {lasted}: {alarm.message}", style="dim")
    return text


@contextmanager
def live_view(vehicle: Vehicle, rule: LowAdhesionRule, footer: str = "") -> Iterator[Callable[["Outputs"], None]]:
    """Show outputs on standard output until the end of the context; yields what they are to be given to.

    On a terminal the panel, which needs the extra `desk` (InputError where it is missing); else plain lines.
    """
    board = Board(vehicle, rule)
    if not sys.stdout.isatty():
        yield _PlainLines(board).show
        return
    extras.require("desk", "the live view on a terminal")
    from rich.console import Console  # noqa: PLC0415 - as above
    from rich.live import Live  # noqa: PLC0415

    console = Console()

    def show(outputs: "Outputs") -> None:
        nonlocal board
        board = board.after(outputs)

    with Live(
        console=console,
        refresh_per_second=REFRESH_HZ,
        get_renderable=lambda: panel(board, console.width, footer),
    ):
        yield show


class _PlainLines:
    """One line per second of the estimates' time, and one per change of an alarm."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self._second: int | None = None

    def show(self, outputs: "Outputs") -> None:
        self._board = self._board.after(outputs)
        for alarm in outputs.alarms:
            print(plain_alarm(alarm), flush=True)
        if outputs.estimate is not None and floor(outputs.estimate.time_s) != self._second:
            self._second = floor(outputs.estimate.time_s)
            print(plain_line(self._board), flush=True)
