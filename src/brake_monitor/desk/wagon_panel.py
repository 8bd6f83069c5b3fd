"""One watched wagon in full on a terminal, drawn with the extra `desk`. A ± is one standard deviation.

80 columns suffice; below that it leaves out what matters least.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, NamedTuple

from rich import get_console
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from brake_monitor.desk.text_marks import (
    LEVEL_STYLE,
    SEVERITY_STYLE,
    STATUS_STYLE,
    band,
    bar,
    number,
    plus_minus,
    scale_top,
    sparkline,
    wsp,
)
from brake_monitor.desk.watched import BIN_S, HISTORY, Wagon, moment_of
from brake_monitor.desk.watched_lines import alarm_name, last_said, life, value_of
from brake_monitor.plural import plural
from brake_monitor.publishing.payloads import AdhesionMessage, AlarmMessage, FrictionMessage, WearMessage

FULL_FORCE_KN = 100.0  # where the bar of the pressing force ends
FULL_SLIP = 0.30
SLIPPING = 0.05
SHORTEST_BAR, LONGEST_BAR = 3, 12  # characters
ROOM_FOR_ALL = 76  # characters inside the frame
CLEARED_SHOWN = 4  # alarms that are over, the newest
ALARMS_BEFORE_WHEELSETS = 3  # so many alarms have a line before the last wheelsets have theirs

Style = Callable[[str], str]  # how to draw what would be drawn in this style


class Column(NamedTuple):
    """A column of the wheelsets' table."""

    heading: str
    width: int  # characters, without bars
    rank: int  # where there is no room, the highest go first
    justify: Literal["left", "right"] = "left"


COLUMNS = (
    Column("", 1, 0),  # wheelset
    Column("km/h", 5, 7, "right"),
    Column("slip", 7, 3),
    Column("force", 8, 4),
    Column(" adhesion", 13, 8),
    Column(" pad friction", 13, 1),
    Column("", 10, 2),  # status
    Column("", 3, 5),  # WSP
    Column("pads mm", 7, 6, "right"),
)


def in_full(wagon: Wagon, now_s: float, width: int, height: int) -> RenderableType:
    """All that is known of a wagon, in so many columns and, where alarms are many, lines."""
    is_live = wagon.is_live(now_s)
    style: Style = (lambda of: of) if is_live else (lambda _: "dim")
    head = Text(no_wrap=True, overflow="ellipsis")
    head.append(life(wagon, now_s), style="bold green" if is_live else "bold yellow")
    if wagon.adhesion is not None:
        head.append("   ").append(last_said(wagon, now_s), style="dim")
        _append_adhesion(head, wagon, wagon.adhesion, width, style)
    blocks: list[RenderableType] = [head]
    lines = len(head.plain.splitlines())
    foot = _foot(wagon)
    if wagon.friction:
        least_alarms = min(len(wagon.open_alarms()), ALARMS_BEFORE_WHEELSETS)
        table, count = _wheelsets(wagon, width, height - lines - 3 - len(foot) - least_alarms, style)
        blocks += ["", *table, ""]
        lines += count + 3
    blocks += foot
    return Group(*blocks, *_alarms(wagon, width, height - lines - len(foot)))


def _append_adhesion(text: Text, wagon: Wagon, message: AdhesionMessage, width: int, style: Style) -> None:
    """What the wagon does and what it uses of the rail: now, on a scale, and lately."""
    now = moment_of(message)
    std = value_of(message.adhesion_std)
    top = scale_top([*(moment.adhesion for moment in wagon.history if moment), now.adhesion + std])
    room = max(width - 20, 1)
    rail = style(LEVEL_STYLE[wagon.level])
    text.append(f"{number(value_of(message.speed_mps) * 3.6, 1)} km/h   ", style=style("bold"))
    text.append(", ".join((message.status, *message.reasons)), style=style(STATUS_STYLE[message.status]))
    if width >= ROOM_FOR_ALL:
        text.append(f"   unmodelled deceleration {number(message.deceleration_mps2, 3)} m/s²", style=style(""))
    meaning = "the rail gives no more" if message.saturated else "in use; the rail may give more"
    text.append(f"\nadhesion  {plus_minus(message.adhesion, message.adhesion_std)}  {meaning}\n", style=rail)
    text.append(f"          {band(now.adhesion, std, top, room)}", style=rail).append(f" 0–{top:.2f}\n", style="dim")
    room = min(room, HISTORY)
    shown = list(wagon.history)[-room:]
    text.append(f"{f'last {room * BIN_S:.0f} s':10}" + " " * (room - len(shown)), style=style(""))
    for moment in shown:
        colour = style(LEVEL_STYLE[wagon.level_of(moment)]) if moment else ""
        text.append(sparkline([moment], top), style=colour)


def _wheelsets(wagon: Wagon, width: int, height: int, style: Style) -> tuple[list[RenderableType], int]:
    """A line for each, as many as fit, with the number of these lines."""
    # Fixed widths: nothing moves but what changes. Bars only where all columns have room.
    bar_width = min((width - ROOM_FOR_ALL) // 2 - 1, LONGEST_BAR)
    bar_width = bar_width if bar_width >= SHORTEST_BAR else 0
    wider = {"slip": bar_width + 1, "force": bar_width + 1} if bar_width else {}
    columns = [column._replace(width=column.width + wider.get(column.heading, 0)) for column in COLUMNS]
    columns[0] = columns[0]._replace(width=len(str(max(wagon.friction))))
    shown = _that_fit(columns, width)
    table = Table(box=None, padding=(0, 1, 0, 0), header_style="dim")
    for k in shown:
        table.add_column(columns[k].heading, justify=columns[k].justify, width=columns[k].width, no_wrap=True)
    all_of_them = sorted(wagon.friction.items())
    told = all_of_them if len(all_of_them) <= height else all_of_them[: max(height - 1, 1)]
    for i, own in told:
        cells = _cells(own, wagon.wheel_kmh(own), wagon.wear.get(i), bar_width, style)
        table.add_row(*(cells[k] for k in shown))
    if more := len(all_of_them) - len(told):
        return [table, Text(f"… and {plural(more, 'more wheelset')}", style="dim")], len(told) + 1
    return [table], len(told)


def _cells(
    own: FrictionMessage, wheel_kmh: float, pads: WearMessage | None, bar_width: int, style: Style
) -> Sequence[Text]:
    """What stands in COLUMNS for one wheelset."""
    slip, force_kn = value_of(own.slip), value_of(own.pressing_force_n) / 1000
    slipping = "bold red" if slip > FULL_SLIP / 2 else "yellow" if slip > SLIPPING else ""
    acts = wsp(own.wsp_active)
    return (
        Text(str(own.wheelset), style=style("bold")),
        Text(number(wheel_kmh, 1, 5), style=style("")),
        Text(f"{number(slip * 100, 1, 5)} % {bar(slip, FULL_SLIP, bar_width)}".rstrip(), style=style(slipping)),
        Text(f"{number(force_kn, 1, 5)} kN {bar(force_kn, FULL_FORCE_KN, bar_width)}".rstrip(), style=style("")),
        Text(plus_minus(own.adhesion, own.adhesion_std), style=style("")),
        Text(plus_minus(own.friction, own.friction_std), style=style("bold")),
        Text(own.status, style=style(STATUS_STYLE[own.status])),
        Text(acts, style=style("black on yellow" if own.wsp_active else "dim")),
        Text(number(pads.thickness_mm, 1) if pads else "", style=style("")),
    )


def _that_fit(columns: Sequence[Column], room: int) -> list[int]:
    """The places of the columns that have room beside each other, the most important first to get it."""
    found: list[int] = []
    for k in sorted(range(len(columns)), key=lambda k: columns[k].rank):
        if columns[k].width + 1 <= room:
            room -= columns[k].width + 1
            found.append(k)
    return sorted(found)


def _foot(wagon: Wagon) -> list[Text]:
    """A line of how the daemon does, and one of what to think of the alarms that follow."""
    lines = []
    if health := wagon.health:
        lines.append(
            f"{plural(health.frames, 'frame')}, {plural(health.decode_errors, 'decode error')}, "
            f"{plural(len(health.stale_signals), 'stale signal')}, {health.memory_bytes / 1e6:.0f} MB"
        )
    alarms = wagon.open_alarms()
    if not wagon.alive:
        lines.append("alarms as last heard:" if alarms else "no alarms as last heard")
    elif not alarms:
        lines.append("no alarms")
    return [Text(line, style="dim", no_wrap=True, overflow="ellipsis") for line in lines]


def _alarms(wagon: Wagon, width: int, height: int) -> Iterator[Text]:
    """The gravest first, then what is over. Sentences are wrapped as long as a line is left for each, else cut."""
    alarms = [*wagon.open_alarms(), *wagon.past_alarms()[:CLEARED_SHOWN]]
    shown = alarms if len(alarms) <= height else alarms[: max(height - 1, 0)]
    spare = height - len(shown) - (len(shown) < len(alarms))  # lines, when each sentence has one
    for alarm in shown:
        text = _cleared(alarm) if alarm.state == "cleared" else _alarm(alarm, is_past=not wagon.alive)
        further = len(text.wrap(get_console(), width)) - 1
        if further > spare:
            text.no_wrap, text.overflow, further = True, "ellipsis", 0
        spare -= further
        yield text
    if len(shown) < len(alarms):
        yield Text(f"… and {len(alarms) - len(shown)} more", style="dim")


def _alarm(alarm: AlarmMessage, *, is_past: bool) -> Text:
    seen = " (acknowledged)" if alarm.acknowledged_time_s is not None else ""
    tag, name, sentence = ("dim",) * 3 if is_past else (SEVERITY_STYLE[alarm.severity], "bold", "")
    text = Text().append(f" {alarm.severity.upper()} ", style=tag)
    text.append(f" {alarm_name(alarm)}{seen}: ", style=name)
    return text.append(alarm.message, style=sentence)


def _cleared(alarm: AlarmMessage) -> Text:
    lasted_s = value_of(alarm.cleared_time_s) - alarm.raised_time_s
    return Text(f"cleared {alarm_name(alarm)}, lasted {number(lasted_s, 1)} s: {alarm.message}", style="dim")
