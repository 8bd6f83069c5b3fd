"""A watched fleet as a panel on a terminal, drawn with the extra `desk`: one wagon in full, or a line for each."""

from collections.abc import Sequence

from rich.console import RenderableType
from rich.panel import Panel
from rich.text import Text

from brake_monitor.desk.text_marks import LEVEL_STYLE, SEVERITY_STYLE, Moment, number, plus_minus, scale_top, sparkline
from brake_monitor.desk.wagon_panel import in_full
from brake_monitor.desk.watched import Wagon, Watched
from brake_monitor.desk.watched_lines import life, not_heard, value_of
from brake_monitor.plural import plural


def panel(watched: Watched, now_s: float, width: int, height: int, only: str | None = None) -> RenderableType:
    """The whole view: a wagon in full when it is asked for or the only one, else the fleet."""
    wagons = [watched.wagons[name] for name in sorted(watched.wagons) if only in (None, name)]
    shown: RenderableType
    if not wagons:
        shown = Text(f"{not_heard(only)} …", style="dim")
    elif len(wagons) == 1:
        shown = in_full(wagons[0], now_s, width - 4, height - 3)
    else:
        shown = _fleet(wagons, now_s, width - 4, height - 4)
    title = Text(f" {wagons[0].name if len(wagons) == 1 else f'{len(wagons)} wagons'} ", style="bold")
    doubt = f" {plural(watched.not_understood, 'message')} not understood " if watched.not_understood else None
    return Panel(shown, title=title, title_align="left", subtitle=doubt, subtitle_align="left", width=width)


def _fleet(wagons: Sequence[Wagon], now_s: float, width: int, height: int) -> RenderableType:
    """One line each: the most urgent first, as many as fit."""
    room = max(width - 60, 8)
    text = Text(f"{'wagon':14} {'':9} {'km/h':>6} {'adhesion':>14} {'last':{room}} alarms\n", style="dim", no_wrap=True)
    for wagon in sorted(wagons, key=lambda wagon: wagon.urgency(now_s))[: max(height, 1)]:
        dim = "" if wagon.is_live(now_s) else "dim"
        message = wagon.adhesion
        text.append(f"{wagon.name[:14]:14} ", style=dim or "bold")
        text.append(f"{life(wagon, now_s)[:9]:9} ", style="green" if not dim else "yellow")
        text.append(f"{number(value_of(message.speed_mps if message else None) * 3.6, 1, 6)} ", style=dim)
        adhesion, std = (message.adhesion, message.adhesion_std) if message else (None, None)
        text.append(f"{plus_minus(adhesion, std):14} ", style=dim or LEVEL_STYLE[wagon.level])
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


def _spark(wagon: Wagon, room: int) -> str:
    shown: list[Moment | None] = list(wagon.history)[-room:]
    return sparkline(shown, scale_top([moment.adhesion for moment in shown if moment]))
