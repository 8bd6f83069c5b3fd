"""`brake-monitor dashboard`: what a fleet publishes, as a web page."""

import asyncio
import os
import signal
import socket
import sys
from argparse import SUPPRESS, ArgumentParser, ArgumentTypeError, Namespace

from brake_monitor.commands import options as shared
from brake_monitor.dashboard.fleet import Fleet
from brake_monitor.dashboard.hearing import Hearing
from brake_monitor.desk.fleet_listener import watcher_config
from brake_monitor.errors import WorkError
from brake_monitor.host import extras
from brake_monitor.publishing.zenoh_endpoints import is_loopback

DESCRIPTION = """\
Serves a web page of what is published: the fleet, and every wagon with live curves, alarms, wear and health.
It only reads, needs no internet, and listens on this machine only unless told otherwise.
Needs the extra 'dashboard'."""

EPILOG = """\
examples:
  brake-monitor dashboard                                      the demo, or a router on this machine
  brake-monitor dashboard --connect tcp/192.0.2.1:7447         a router elsewhere
  brake-monitor dashboard --zenoh-config dashboard.json5       with certificates, as in docs/security
  brake-monitor dashboard --listen 0.0.0.0:8337 --name depot   for phones in the depot: whoever gets there may look"""

PORT = 8337
CHECK_S = 0.25


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_zenoh_source(parser)
    parser.add_argument(
        "--listen",
        type=address,
        default=("127.0.0.1", PORT),
        metavar="HOST:PORT",
        help=f"where browsers find it; port 0 takes any (default: 127.0.0.1:{PORT})",
    )
    parser.add_argument(
        "--name",
        type=machine_name,
        action="append",
        default=[],
        help="a name that browsers may call this machine by, besides its addresses, its own name and localhost",
    )
    parser.add_argument("--parent", type=int, help=SUPPRESS)  # of the demo: ends with the process of this number


def address(text: str) -> tuple[str, int]:
    """HOST:PORT, an IPv6 address in brackets."""
    host, _, port = text.rpartition(":")
    if not host or not (port.isascii() and port.isdigit() and int(port) < 2**16):
        raise ArgumentTypeError(f"expected HOST:PORT such as 127.0.0.1:{PORT}, got {text!r}")
    return host.removeprefix("[").removesuffix("]"), int(port)


def machine_name(text: str) -> str:
    """A name that a browser may ask for, in small letters."""
    if not text:
        raise ArgumentTypeError("expected a name, got ''")
    return text.lower()


def run(options: Namespace) -> int:
    """Serve until Ctrl-C or SIGTERM."""
    extras.require("dashboard", "the dashboard")
    fleet = Fleet(options.prefix)
    hearing = Hearing(fleet, watcher_config(options.connect, options.zenoh_config))
    try:
        asyncio.run(_serve(fleet, hearing, options))
    finally:
        hearing.close()
    return 0


async def _serve(fleet: Fleet, hearing: Hearing, options: Namespace) -> None:
    from brake_monitor.dashboard.server import Server  # noqa: PLC0415 - needs an extra

    host, port = options.listen
    stopping = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, stopping.set)
    known = frozenset({"localhost", socket.gethostname().lower(), *options.name})
    async with Server(fleet, known).serving(host, port) as real_port:
        shown = f"[{host}]" if ":" in host else host
        print(f"dashboard at http://{shown}:{real_port}/", flush=True)
        hearing.start()
        if not is_loopback(host):
            print("whoever reaches this address may look; there is no login and no encryption", file=sys.stderr)
        while not stopping.is_set() and options.parent in (None, os.getppid()):
            if hearing.is_over():
                raise hearing.failure or WorkError("the Zenoh session ended")
            try:
                await asyncio.wait_for(stopping.wait(), CHECK_S)
            except TimeoutError:
                continue
