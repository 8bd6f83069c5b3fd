"""`brake-monitor watch`: what a wagon or a fleet publishes, live in a terminal."""

import sys
import threading
import time
from argparse import ArgumentParser, Namespace
from contextlib import ExitStack

import zenoh

from brake_monitor.commands import options as shared
from brake_monitor.desk.fleet_listener import listen, patient_session, watcher_config
from brake_monitor.desk.watched import Watched
from brake_monitor.desk.watched_lines import not_heard, plain_alarm, plain_line
from brake_monitor.host import extras
from brake_monitor.host.stop_signals import stopped_by_signals

DESCRIPTION = """\
Shows what is published: one wagon in full, or a line for each of a fleet, with alarms, sparklines, and whether it is
live. On a terminal it needs the extra 'desk'; into a pipe it prints plain lines, one per wagon and second. A ± is one
standard deviation."""

EPILOG = """\
examples:
  brake-monitor watch                                          the demo, or a router on this machine
  brake-monitor watch --connect tcp/192.0.2.1:7447 wagon-8127  one wagon
  brake-monitor watch --zenoh-config dashboard.json5           with certificates, as in docs/security"""

REFRESH_HZ = 8


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("wagon", nargs="?", type=shared.key_part, help="only this one")
    shared.add_zenoh_source(parser)


def run(options: Namespace) -> int:
    """Watch until Ctrl-C or SIGTERM."""
    stopping = threading.Event()
    with stopped_by_signals(stopping.set):
        show(watcher_config(options.connect, options.zenoh_config), stopping, options.prefix, options.wagon)
    return 0


def show(config: zenoh.Config, stopping: threading.Event, prefix: str, only: str | None = None) -> None:
    """Show what is published under the prefix, by `only` this wagon where one is given, until told to stop."""
    watcher = _Watcher(prefix, only)
    with ExitStack() as stack:
        session = patient_session(config, stopping)
        if session is None:
            return
        stack.enter_context(session)
        listen(session, watcher.keys, watcher, stack)
        if sys.stdout.isatty():
            _show_panel(watcher, stopping)
        else:
            _print_lines(watcher, stopping)


class _Watcher:
    """Hears in Zenoh's threads, is looked at from the main one."""

    def __init__(self, prefix: str, only: str | None) -> None:
        self.watched = Watched(prefix)
        self.only = only
        self.lock = threading.Lock()
        self.news: list[str] = []  # lines about alarms
        self.keys = f"{prefix}/{only or '*'}"

    def hear(self, sample: zenoh.Sample) -> None:
        """Note a message, and what of it is news."""
        key = str(sample.key_expr)
        with self.lock:
            alarm = self.watched.take(key, str(sample.encoding), sample.payload.to_bytes(), time.monotonic())
            if alarm is not None:
                self.news.append(plain_alarm(self.watched.wagon_of(key), alarm))

    def lives(self, sample: zenoh.Sample) -> None:
        """Note who came or went."""
        with self.lock:
            self.watched.lives(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)


def _show_panel(watcher: _Watcher, stopping: threading.Event) -> None:
    extras.require("desk", "the view on a terminal")
    from rich.console import Console, RenderableType  # noqa: PLC0415 - an extra, and slow to import
    from rich.live import Live  # noqa: PLC0415

    from brake_monitor.desk.watched_panel import panel  # noqa: PLC0415 - needs it

    console = Console()

    def drawn() -> RenderableType:
        with watcher.lock:
            watcher.news.clear()
            return panel(watcher.watched, time.monotonic(), console.width, console.height, watcher.only)

    with Live(console=console, refresh_per_second=REFRESH_HZ, get_renderable=drawn):
        stopping.wait()


def _print_lines(watcher: _Watcher, stopping: threading.Event) -> None:
    while not stopping.wait(1.0):
        now_s = time.monotonic()
        with watcher.lock:
            lines = [*watcher.news, *(plain_line(wagon, now_s) for wagon in watcher.watched.wagons.values())]
            watcher.news.clear()
        print("\n".join(lines or [not_heard(watcher.only)]), flush=True)
