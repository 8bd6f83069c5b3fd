"""`brake-monitor run`: the daemon."""

import signal
import sys
from argparse import ArgumentParser, Namespace

from brake_monitor.commands import options as shared
from brake_monitor.daemon.log_lines import log_to
from brake_monitor.daemon.succession import Daemon
from brake_monitor.host.stop_signals import stopped_by_signals

DESCRIPTION = """\
Listens to the configured CAN bus until SIGTERM or Ctrl-C, estimates, and publishes over Zenoh.
It sends nothing to the bus. A bus that goes down is opened anew; a Zenoh router may come and go.
SIGHUP makes it read its configuration again; one that is not good is refused, and the old one stays."""

EPILOG = """\
examples:
  brake-monitor run -c /etc/brake-monitor/config.toml
  brake-monitor check -c wagon.toml && brake-monitor run -c wagon.toml"""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument(
        "--wait-for-bus",
        action="store_true",
        help="when a bus is missing, down or able to send at the start, wait until it is not, instead of failing",
    )
    parser.add_argument(
        "--log-level",
        choices=("debug", "info", "warning", "error"),
        default="info",
        help="least severity that is logged on standard error (default: info)",
    )
    parser.add_argument(
        "--log-format", choices=("text", "json"), default="text", help="of each line that is logged (default: text)"
    )


def run(options: Namespace) -> int:
    """Run the service until it is told to stop."""
    log_to(sys.stderr, options.log_level, options.log_format)
    reloads = not (sys.stdin and sys.stdin.isatty())  # without a terminal SIGHUP is not the terminal's end
    if reloads:
        signal.signal(signal.SIGHUP, signal.SIG_IGN)  # until there is a daemon: what it reads is the newest there is
    daemon = Daemon(options.config, waits_for_bus=options.wait_for_bus)
    with stopped_by_signals(daemon.stop, daemon.reload if reloads else None):
        daemon.run()
    return 0
