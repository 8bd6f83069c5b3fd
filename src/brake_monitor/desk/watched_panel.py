"""A watched fleet as a panel on a terminal, drawn with the extra `desk`: one wagon in full, or a line for each.

80 columns suffice.
"""

from collections.abc import Iterator, Sequence

from rich import get_console
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.text import Text

from brake_monitor.desk.text_marks import (
    SEVERITY_STYLE,
    STATUS_STYLE,
    Moment,
    number,
    plus_minus,
    scale_top,
    sparkline,
    wsp,
)
from brake_monitor.desk.watched import Wagon, Watched
from brake_monitor.desk.watched_lines import last_said, life, value_of
from brake_monitor.publishing.payloads import AlarmMessage

ROOM_FOR_NAMES = 72  # characters inside the frame


def panel(watched: Watched, now_s: float, width: int, height: int, only: str | None = None) -> RenderableType:
    """The whole view: a wagon in full when it is asked for or the only one, else the fleet."""
    wagons = [watched.wagons[name] for name in sorted(watched.wagons) if only in (None, name)]
    shown: RenderableType
    if not wagons:
        shown = Text("nobody is heard yet …", style="dim")
    elif len(wagons) == 1:
        shown = _in_full(wagons[0], now_s, width - 4, height - 3)
    else:
        shown = _fleet(wagons, now_s, width - 4, height - 4)
    title = f"[bold] {wagons[0].name if len(wagons) == 1 else f'{len(wagons)} wagons'} [/bold]"
    doubt = f" {watched.not_understood} messages were not understood " if watched.not_understood else None
    return Panel(shown, title=title, title_align="left", subtitle=doubt, subtitle_align="left", width=width)


def _fleet(wagons: Sequence[Wagon], now_s: float, width: int, height: int) -> RenderableType:
    """One line each: the most urgent first, as many as fit."""

    def urgency(wagon: Wagon) -> tuple[int, bool, str]:
        still = wagon.open_alarms()
        return (-still[0].severity.rank if still else 1, not wagon.is_stale(now_s), wagon.name)

    room = max(width - 60, 8)
    text = Text(f"{'wagon':14} {'':9} {'km/h':>6} {'adhesion':>14} {'last':{room}} alarms\n", style="dim", no_wrap=True)
    for wagon in sorted(wagons, key=urgency)[: max(height, 1)]:
        dim = "dim" if wagon.is_stale(now_s) else ""
        message = wagon.adhesion
        text.append(f"{wagon.name[:14]:14} ", style=dim or "bold")
        text.append(f"{life(wagon, now_s)[:9]:9} ", style="green" if not dim else "yellow")
        text.append(f"{number(value_of(message.speed_mps if message else None) * 3.6, 1, 6)} ", style=dim)
        adhesion, std = (message.adhesion, message.adhesion_std) if message else (None, None)
        style = dim or ("bold red" if message and message.saturated else "cyan")
        text.append(f"{plus_minus(adhesion, std):14} ", style=style)
        text.append(f"{_spark(wagon, room):{room}} ", style=dim or "cyan")
        _append_alarm_count(text, wagon)
        text.append("\n")
    if len(wagons) > height:
        text.append(f"… and {len(wagons) - max(height, 1)} more", style="dim")
    return text


def _append_alarm_count(text: Text, wagon: Wagon) -> None:
    still = wagon.open_alarms()
    if still:
        text.append(
            f" {len(still)} {still[0].severity} ", style=SEVERITY_STYLE[still[0].severity] if wagon.alive else "dim"
        )
    else:
        text.append("none", style="dim")


def _in_full(wagon: Wagon, now_s: float, width: int, height: int) -> RenderableType:
    text = Text(no_wrap=True, overflow="ellipsis")
    stale = wagon.is_stale(now_s)
    text.append(life(wagon, now_s), style="bold yellow" if stale else "bold green")
    message = wagon.adhesion
    if message is not None:
        text.append("   ").append(last_said(wagon, now_s), style="dim")
        text.append(f"{number(value_of(message.speed_mps) * 3.6, 1)} km/h   ", style="dim" if stale else "bold")
        status = ", ".join((message.status, *message.reasons))
        text.append(f"{status}\n", style="dim" if stale else STATUS_STYLE[message.status])
        meaning = "the rail gives no more" if message.saturated else "in use"
        style = "dim" if stale else "bold red" if message.saturated else "cyan"
        value = plus_minus(message.adhesion, message.adhesion_std)
        text.append(f"adhesion  {value}  {meaning}\n", style=style)
        text.append(f"          {_spark(wagon, width - 12)}\n", style=style)
    wheelset, friction = ("wheelset ", "friction ") if width >= ROOM_FOR_NAMES else ("", "")
    for i, own in sorted(wagon.friction.items()):
        pads = wagon.wear.get(i)
        thickness = f"pads {number(pads.thickness_mm, 1)} mm" if pads else ""
        text.append(
            f"{wheelset}{i}  slip {number(value_of(own.slip) * 100, 1, 5)} %  "
            f"{number(value_of(own.pressing_force_n) / 1000, 1, 5)} kN  "
            f"{friction}{plus_minus(own.friction, own.friction_std).strip()} ",
            style="dim" if stale else "",
        )
        text.append(f"{own.status:10}", style="dim" if stale else STATUS_STYLE[own.status])
        text.append(f" {wsp(own.wsp_active)} {thickness}\n", style="dim" if stale else "")
    if health := wagon.health:
        text.append(
            f"{health.frames} frames, {health.decode_errors} decode errors, {len(health.stale_signals)} stale signals, "
            f"{health.memory_bytes / 1e6:.0f} MB\n",
            style="dim",
        )
    alarms = wagon.open_alarms()
    if not wagon.alive:
        text.append("alarms as last heard:\n" if alarms else "no alarms as last heard\n", style="dim")
    elif not alarms:
        text.append("no alarms\n", style="dim")
    text.rstrip()
    return Group(text, *_alarms(alarms, width, height - len(text.plain.splitlines()), is_past=not wagon.alive))


def _alarms(alarms: Sequence[AlarmMessage], width: int, height: int, *, is_past: bool) -> Iterator[Text]:
    """The gravest first. Sentences are wrapped as long as a line is left for each that follows, else cut."""
    shown = alarms if len(alarms) <= height else alarms[: max(height - 1, 0)]
    spare = height - len(shown) - (len(shown) < len(alarms))  # lines, when each sentence has one
    for alarm in shown:
        text = _alarm(alarm, is_past=is_past)
        further = len(text.wrap(get_console(), width)) - 1
        if further > spare:
            text.no_wrap, text.overflow, further = True, "ellipsis", 0
        spare -= further
        yield text
    if len(shown) < len(alarms):
        yield Text(f"… and {len(alarms) - len(shown)} more", style="dim")


def _alarm(alarm: AlarmMessage, *, is_past: bool) -> Text:
    place = "" if alarm.wheelset is None else f" {alarm.wheelset}"
    seen = " (acknowledged)" if alarm.acknowledged_time_s is not None else ""
    tag, name, sentence = ("dim",) * 3 if is_past else (SEVERITY_STYLE[alarm.severity], "bold", "")
    text = Text().append(f" {alarm.severity.upper()} ", style=tag)
    text.append(f" {alarm.kind.replace('_', ' ')}{place}{seen}: ", style=name)
    return text.append(alarm.message, style=sentence)


def _spark(wagon: Wagon, room: int) -> str:
    shown: list[Moment | None] = list(wagon.history)[-room:]
    return sparkline(shown, scale_top([moment.adhesion for moment in shown if moment]))
