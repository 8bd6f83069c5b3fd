"""Outputs as a person reads them while they happen: a panel on a terminal, else one line per second."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import floor
from typing import TYPE_CHECKING

from brake_monitor.desk.board import Board
from brake_monitor.desk.board_lines import plain_alarm, plain_line
from brake_monitor.host import extras
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.settings.config import Vehicle

if TYPE_CHECKING:
    from brake_monitor.processing.pipeline import Outputs

REFRESH_HZ = 8


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
    from rich.console import Console  # noqa: PLC0415 - an extra, and slow to import
    from rich.live import Live  # noqa: PLC0415

    from brake_monitor.desk.board_panel import panel  # noqa: PLC0415 - needs it

    console = Console()

    def show(outputs: "Outputs") -> None:
        nonlocal board
        board = board.after(outputs)

    with Live(
        console=console, refresh_per_second=REFRESH_HZ, get_renderable=lambda: panel(board, console.width, footer)
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
