"""The board as a panel on a terminal, drawn with the extra `desk`. A ± is one standard deviation."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from brake_monitor.desk.board import (
    BIN_S,
    Board,
    alarm_name,
    force_kn_of,
    slip_of,
    speed_kmh,
    status_words,
    wheel_kmh,
    wsp_of,
)
from brake_monitor.desk.text_marks import (
    SEVERITY_STYLE,
    STATUS_STYLE,
    Moment,
    band,
    bar,
    number,
    plus_minus,
    scale_top,
    sparkline,
)
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.settings.alarm_settings import LowAdhesionRule

FULL_FORCE_KN = 100.0  # where the bar of the pressing force ends
FULL_SLIP = 0.30
ROOM_FOR_ALL = 76  # characters inside the frame


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


def rail_style(moment: Moment, rule: LowAdhesionRule) -> str:
    """Return the colour of an adhesion: of the rail's condition once the wheels got all that there was."""
    if not moment.saturated:
        return "cyan"
    if moment.adhesion < rule.very_low:
        return "bold red"
    return "yellow" if moment.adhesion < rule.low else "green"


def panel(board: Board, width: int, footer: str = "") -> RenderableType:
    """The whole view. Below 80 columns it leaves out what matters least."""
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


def _wagon(board: Board, estimate: Estimate, width: int) -> Text:
    adhesions = [moment.adhesion for moment in board.history if moment]
    top = scale_top([*adhesions, estimate.adhesion + estimate.adhesion_std])
    room = width - 20
    style = rail_style(Moment(estimate.adhesion, estimate.saturated), board.rule)
    text = Text(no_wrap=True, overflow="ellipsis")
    text.append("speed     ").append(f"{number(speed_kmh(estimate), 1, 6)} km/h", style="bold")
    if width >= ROOM_FOR_ALL:
        text.append(f"   unmodelled deceleration {number(estimate.deceleration_mps2, 3)} m/s²")
    text.append("   ").append(status_words(estimate), style=STATUS_STYLE[estimate.status]).append("\n")
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


def _wheelsets(board: Board, estimate: Estimate, width: int) -> Table:
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
        slip, force_kn = slip_of(estimate, place), force_kn_of(estimate, place)
        slipping = "bold red" if slip > FULL_SLIP / 2 else "yellow" if slip > 0.05 else ""
        cells = (
            Text(str(place + 1), style="bold"),
            Text(number(wheel_kmh(board, estimate, place), 1, 5)),
            Text(f"{number(slip * 100, 1, 5)} % {bar(slip, FULL_SLIP, bar_width)}", style=slipping),
            Text(f"{number(force_kn, 1, 5)} kN {bar(force_kn, FULL_FORCE_KN, bar_width)}"),
            Text(plus_minus(wheelset.adhesion, wheelset.adhesion_std)),
            Text(plus_minus(wheelset.friction, wheelset.friction_std), style="bold"),
            Text(wheelset.friction_status, style=STATUS_STYLE[wheelset.friction_status]),
            Text(wsp_of(estimate, place), style="black on yellow" if wsp_of(estimate, place) == "WSP" else "dim"),
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


def _alarms(board: Board) -> Text:
    if not board.alarms:
        return Text("\nno alarms", style="dim")
    text = Text()
    for alarm in board.alarms:
        begun = f"{number(alarm.raised_time_s - board.begun_s, 1)} s"
        text.append("\n")
        if alarm.cleared_time_s is None:
            text.append(f" {alarm.severity.upper()} ", style=SEVERITY_STYLE[alarm.severity])
            text.append(f" {alarm_name(alarm)} since {begun}: ", style="bold").append(alarm.message)
        else:
            lasted = f"{number(alarm.cleared_time_s - alarm.raised_time_s, 1)} s"
            text.append(f" cleared {alarm_name(alarm)} at {begun}, lasted {lasted}: {alarm.message}", style="dim")
    return text
