"""Options that several commands have, and how their values are read."""

import os
import sys
from argparse import ArgumentParser, ArgumentTypeError
from collections.abc import Callable
from math import inf, nan
from pathlib import Path

from brake_monitor.settings.key_space import fault_of

SLOWEST = 1e-3  # of real time
SMALLEST, LARGEST = sys.float_info.min, sys.float_info.max


def add_config(parser: ArgumentParser) -> None:
    """-c CONFIG, the vehicle's configuration."""
    parser.add_argument(
        "-c", "--config", type=path, required=True, metavar="CONFIG", help="the vehicle's configuration (TOML)"
    )


def add_zenoh_source(parser: ArgumentParser) -> None:
    """--connect, --zenoh-config and --prefix: where to hear what is published."""
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--connect", metavar="ENDPOINT", default="tcp/127.0.0.1:7447", help="router or daemon (default: %(default)s)"
    )
    where.add_argument("--zenoh-config", type=path, metavar="FILE", help="a Zenoh configuration (JSON5) of your own")
    parser.add_argument("--prefix", type=key, default="brake/v1", help="of the keys (default: %(default)s)")


def add_jobs(parser: ArgumentParser, what: str = "processes") -> None:
    """--jobs: how many processes work at the same time."""
    jobs = os.cpu_count() or 1
    parser.add_argument("--jobs", type=count, default=jobs, metavar="N", help=f"{what} (default: one per processor)")


def path(text: str) -> Path:
    """A file's or folder's; a shell variable that is not set makes an empty one, which Path takes for the folder."""
    if not text:
        raise ArgumentTypeError("expected a path, got ''")
    return Path(text)


def key(text: str) -> str:
    """A Zenoh key without wildcards."""
    return "/".join(map(key_part, text.split("/")))


def key_part(text: str) -> str:
    """What can stand between two slashes of a Zenoh key, as a wagon's id does."""
    if fault := fault_of(text):
        raise ArgumentTypeError(fault)
    return text


def number(what: str, least: float, greatest: float = LARGEST) -> Callable[[str], float]:
    """Return an option type: a finite number within bounds, which `what` describes, as in "minutes, 0.1 to 600"."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = nan
        if not least <= value <= greatest:
            raise ArgumentTypeError(f"expected {what}, got {text!r}")
        return value

    return read


def speed(text: str) -> float:
    """A playing speed: a factor of real time, or `max` for as fast as possible (infinity)."""
    return inf if text == "max" else _factor(text)


_factor = number(f"a number from {SLOWEST:g} on or 'max'", SLOWEST)


def count(text: str) -> int:
    """A whole number from 1 on."""
    return _whole(text, 1)


def seed(text: str) -> int:
    """A whole number from 0 on."""
    return _whole(text, 0)


def _whole(text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise ArgumentTypeError(f"expected a whole number from {least} on, got {text!r}")
    return int(text)
