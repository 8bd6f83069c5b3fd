"""`brake-monitor watch`: what a wagon or a fleet publishes, live in a terminal."""

import json
import sys
import threading
import time
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from contextlib import ExitStack
from pathlib import Path

import zenoh
from zenoh import ext

from brake_monitor.errors import InputError, WorkError
from brake_monitor.service import stopped_by_signals
from brake_monitor.watch_view import panel, plain_alarm, plain_line
from brake_monitor.watched import Watched

DESCRIPTION = """\
Shows what is published: one wagon in full, or a line for each of a fleet, with alarms, sparklines and staleness.
On a terminal it needs the extra 'desk'; into a pipe it prints plain lines, one per wagon and second."""

EXAMPLES = """\
examples:
  brake-monitor watch                                          the demo, or a router on this machine
  brake-monitor watch --connect tcp/192.0.2.1:7447 wagon-8127  one wagon
  brake-monitor watch --zenoh-config dashboard.json5           with certificates, as in docs/security"""

REFRESH_HZ = 4
RETRY_S = 1.0


def add_parser(subparsers: "_SubParsersAction[ArgumentParser]") -> None:
    """Describe the command."""
    parser = subparsers.add_parser(
        "watch",
        help="what a wagon or a fleet publishes, live",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    parser.add_argument("wagon", nargs="?", help="only this one")
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--connect", metavar="ENDPOINT", default="tcp/127.0.0.1:7447", help="router or daemon (default: %(default)s)"
    )
    where.add_argument("--zenoh-config", type=Path, metavar="FILE", help="a Zenoh configuration (JSON5) of your own")
    parser.add_argument("--prefix", default="brake/v1", help="of the keys (default: %(default)s)")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Watch until Ctrl-C or SIGTERM."""
    stopping = threading.Event()
    watcher = _Watcher(options.prefix, options.wagon)
    with stopped_by_signals(stopping.set), ExitStack() as stack:
        session = _session(_config(options), stopping)
        if session is None:
            return 0
        stack.enter_context(session)
        watcher.listen(session, stack)
        if sys.stdout.isatty():
            _show_panel(watcher, stopping)
        else:
            _print_lines(watcher, stopping)
    return 0


def _config(options: Namespace) -> zenoh.Config:
    if options.zenoh_config is not None:
        try:
            return zenoh.Config.from_file(options.zenoh_config)
        except zenoh.ZError as error:
            raise InputError(f"{options.zenoh_config}: not a Zenoh configuration: {error}") from None
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("scouting/multicast/enabled", "false")
    try:
        config.insert_json5("connect/endpoints", json.dumps([options.connect]))
    except zenoh.ZError:
        raise InputError(f"--connect {options.connect}: expected an endpoint such as tcp/192.0.2.1:7447") from None
    return config


def _session(config: zenoh.Config, stopping: threading.Event) -> zenoh.Session | None:
    """The session, as soon as somebody answers; None when told to stop before."""
    told = False
    while not stopping.is_set():
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            if "Unable to connect" not in str(error):
                raise WorkError(f"no Zenoh session: {error}") from None
            if not told:
                told = True
                print("nobody answers yet; trying on", file=sys.stderr, flush=True)
        stopping.wait(RETRY_S)
    return None


class _Watcher:
    """Hears in Zenoh's threads, is looked at from the main one."""

    def __init__(self, prefix: str, only: str | None) -> None:
        self.watched = Watched(prefix)
        self.only = only
        self.lock = threading.Lock()
        self.news: list[str] = []  # lines about alarms
        self._keys = f"{prefix}/{only or '*'}"

    def listen(self, session: zenoh.Session, stack: ExitStack) -> None:
        """Subscribe, and ask for what was published before."""
        history = ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
        stack.enter_context(session.liveliness().declare_subscriber(self._keys, self._lives, history=True))
        for key in ("adhesion", "health", "axle/*/friction"):
            stack.enter_context(session.declare_subscriber(f"{self._keys}/{key}", self._hear))
        for key in ("alarm/**", "axle/*/wear"):
            stack.enter_context(
                ext.declare_advanced_subscriber(session, f"{self._keys}/{key}", self._hear, history=history)
            )
        for reply in session.get(f"{self._keys}/**", timeout=2.0):
            if reply.ok is not None:
                self._hear(reply.ok)

    def _hear(self, sample: zenoh.Sample) -> None:
        key = str(sample.key_expr)
        with self.lock:
            alarm = self.watched.take(key, str(sample.encoding), sample.payload.to_bytes(), time.monotonic())
            if alarm is not None:
                self.news.append(plain_alarm(key.split("/alarm/", maxsplit=1)[0].rpartition("/")[2], alarm))

    def _lives(self, sample: zenoh.Sample) -> None:
        with self.lock:
            self.watched.lives(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)


def _show_panel(watcher: _Watcher, stopping: threading.Event) -> None:
    try:
        from rich.console import Console, RenderableType  # noqa: PLC0415 - an extra, and slow to import
        from rich.live import Live  # noqa: PLC0415
    except ImportError:
        raise InputError("the view on a terminal needs an extra: pip install 'brake-monitor[desk]'") from None
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
        print("\n".join(lines or ["nobody is heard yet"]), flush=True)
