"""The command line: `brake-monitor COMMAND …`. Errors end as one sentence and an exit code, never a traceback."""

import errno
import os
import re
import signal
import sys
from argparse import SUPPRESS, Action, ArgumentError, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Sequence
from contextlib import nullcontext
from importlib import import_module
from io import TextIOWrapper
from textwrap import fill
from typing import Any, NoReturn

from brake_monitor import __version__
from brake_monitor.errors import BrakeMonitorError, brief
from brake_monitor.host.python_can import load_cantools_alone, load_without_asammdf
from brake_monitor.host.stop_signals import ended_by_signals
from brake_monitor.nearest import nearest

DESCRIPTION = """\
Listens to a railway wagon's CAN bus and estimates wheel-rail adhesion and brake pad friction.
It only listens: nothing is ever sent to the vehicle."""

FIRST_STEPS = """\
first steps:
  brake-monitor demo                                     see it work
  brake-monitor simulate wsp -o wsp.log --truth wsp.csv  a recording to play
  brake-monitor replay -c wagon.toml wsp.log -o out.csv  estimates from it
  brake-monitor check -c wagon.toml wsp.log              does the mapping fit?
  brake-monitor run -c wagon.toml                        the daemon

exit codes: 0 good, 1 the work failed, 2 bad usage, configuration or input, 130 interrupted"""

# Each is a module of `commands`, loaded when it is asked for: neither the daemon nor --help waits for what others need.
COMMANDS = {
    "demo": "see it work: simulate, listen, estimate, publish, all in one",
    "run": "the daemon: listen, estimate, publish",
    "watch": "what a wagon or a fleet publishes, live",
    "dashboard": "what a fleet publishes, as a web page",
    "replay": "estimates and alarms from recordings",
    "report": "all of a recording in one HTML file",
    "simulate": "a recording with its truth, or live traffic, from an independent plant",
    "check": "validate a configuration, its DBC and its mapping",
    "observability": "what the sensors can tell about friction and adhesion",
    "tune": "fit the noise densities to recordings",
    "validate": "how accurate the estimates are, as a report (extra 'report')",
    "validate-alarms": "detection delays and false alarms over simulated faults and hours of service",
    "schema": "the JSON Schemas of what is published",
    "wear": "brake pads: show what is left, note what was measured or replaced",
}
WITHOUT_PYTHON_CAN = ("run",)  # until a bus needs it
DISK_FAILS = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}
LEAST_BESIDE, BELOW = 40, " " * 6  # characters for what is told beside a name; before what stands below it
_ENTRY = re.compile(r"(  .*\S {2,})([^\s-].*)")  # of a list: a name or an example, and what is told of it
STOP_THEMSELVES = ("demo", "run", "watch", "dashboard")  # each at signals of its choice, in an order of its own


class WrappedHelp(RawDescriptionHelpFormatter):
    """Help whose prose and lists fit the terminal; an example is in one piece, to be copied."""

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        paragraphs = text.split("\n\n")
        return "\n\n".join(_list(part, width) if "\n  " in part else fill(part, width) for part in paragraphs)


def _list(text: str, width: int) -> str:
    """Names and what is told of each: beside it, or of all below where one leaves too little room."""
    lines = text.split("\n")
    entries = [_ENTRY.fullmatch(line) for line in lines]
    if max(map(len, lines)) <= width:
        return text
    has_room = all(width - len(found[1]) >= LEAST_BESIDE for found in entries if found)
    return "\n".join(
        line if found is None else _entry(found[1], found[2], width, has_room)
        for line, found in zip(lines, entries, strict=True)
    )


def _entry(name: str, told: str, width: int, has_room: bool) -> str:
    if has_room:
        return fill(told, width, initial_indent=name, subsequent_indent=" " * len(name))
    return f"{name.rstrip()}\n{fill(told, width, initial_indent=BELOW, subsequent_indent=BELOW)}"


class OneSentenceParser(ArgumentParser):
    """Says in one sentence what is wrong with the options; --help tells how a command is used."""

    def error(self, message: str) -> NoReturn:
        """End with exit code 2."""
        self.exit(2, f"{self.prog}: {brief(message)} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Let the command itself refuse what it does not know; its options are not those of the program."""
        if self._subparsers is None:  # first, as the value of an unknown option would be blamed for another argument
            self._refuse_unknown_options(args)
        options, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(f"unrecognized arguments: {' '.join(unknown)}")
        return options, unknown

    def _refuse_unknown_options(self, args: Sequence[str]) -> None:
        names = [name for action in self._actions for name in action.option_strings]
        shown = [name for action in self._actions if action.help != SUPPRESS for name in action.option_strings]
        for given in args[: args.index("--")] if "--" in args else args:
            name = given.partition("=")[0]
            if name.startswith("--") and not any(known.startswith(name) for known in names):
                close = nearest(name, shown)
                self.error(f"unknown option {name}{f', {close}' if close.startswith('did') else ''}")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Write help and version, or fail where they cannot be written, which argparse would keep to itself."""
        if file is sys.stdout:
            sys.stdout.write(message)
        else:
            super()._print_message(message, file)

    def _check_value(self, action: Action, value: Any) -> None:
        """Name the choice that was probably meant, where argparse lists them all."""
        if action.choices is not None and value not in action.choices:
            raise ArgumentError(action, f'invalid choice: "{value}", {nearest(value, list(action.choices))}')


def build_parser(asked_for: str | None) -> ArgumentParser:
    """All commands, and of the one that is asked for its options and help, which its module tells."""
    parser = OneSentenceParser(
        prog="brake-monitor",
        description=DESCRIPTION,
        epilog=FIRST_STEPS,
        formatter_class=WrappedHelp,
    )
    parser.add_argument("--version", action="version", version=f"brake-monitor {__version__}")
    subparsers = parser.add_subparsers(title="commands", dest="command", required=True, metavar="COMMAND")
    for name, summary in COMMANDS.items():
        own = subparsers.add_parser(name, help=summary, formatter_class=WrappedHelp)
        if name == asked_for:
            command = import_module(f"brake_monitor.commands.{name.replace('-', '_')}")
            own.description = command.DESCRIPTION
            own.epilog = command.EPILOG
            command.add_options(own)
            own.set_defaults(run=command.run)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    given = sys.argv[1:] if arguments is None else arguments
    _open_closed_outputs()
    if isinstance(sys.stdout, TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # a character that its encoding lacks, ± or °, must not lose the rest
    asked_for = next((argument for argument in given if argument in COMMANDS), None)
    try:  # from here on, since what a command needs takes a while to load, in which Ctrl-C may come
        return _run(asked_for, given)
    except BrakeMonitorError as error:
        print(f"brake-monitor: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:  # the reader of our output went away (| head); there is nobody left to tell
        _drop_output()
        return 128 + signal.SIGPIPE
    except UnicodeEncodeError as error:
        print(
            f"brake-monitor: {error.object!a}: this system's encoding ({error.encoding}) has no letters for this name; "
            "PYTHONUTF8=1 lets it be used",
            file=sys.stderr,
        )
        return 2
    except OSError as error:  # what no command has explained better
        _drop_output()
        place = "" if error.filename is None else f"{error.filename}: "
        if not place and error.errno in DISK_FAILS:  # that of a file would be named
            place = "standard output: cannot be written: "
        print(f"brake-monitor: {place}{error.strerror or error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("brake-monitor: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT


def _run(asked_for: str | None, given: Sequence[str]) -> int:
    """Load what the command needs, and run it; its exit code, once all that it says is written."""
    if asked_for in WITHOUT_PYTHON_CAN:
        load_cantools_alone()
    elif asked_for:
        load_without_asammdf()
    options = _parsed(asked_for, given)
    with nullcontext() if options.command in STOP_THEMSELVES else ended_by_signals():
        code: int = options.run(options)
    sys.stdout.flush()
    return code


def _parsed(asked_for: str | None, given: Sequence[str]) -> Namespace:
    """The options, or the program's end once help or version has been written, which may fail."""
    try:
        return build_parser(asked_for).parse_args(given)
    finally:
        sys.stdout.flush()


def _open_closed_outputs() -> None:
    """Where the shell closed one (>&-), Python has none; what is written to it goes nowhere, as asked."""
    sys.stdout = sys.stdout or os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")
    sys.stderr = sys.stderr or os.fdopen(os.open(os.devnull, os.O_WRONLY), "w")


def _drop_output() -> None:
    """Let nothing more go to standard output, not even what still waits in its buffer."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
