"""Checks of files: no recording is given twice, no output goes over an input or another output."""

import sys
from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import combinations
from os.path import realpath
from pathlib import Path
from typing import TextIO

from brake_monitor.errors import InputError
from brake_monitor.host.whole_file import check_can_write, check_can_write_in
from brake_monitor.settings.config import Settings

STDOUT = Path("-")
_STDOUTS = frozenset(map(Path, ("-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1")))


def beside(outputs: Iterable[Path | None]) -> TextIO:
    """The stream for a command's own messages: standard output, unless one of its outputs goes there."""
    return sys.stdout if _STDOUTS.isdisjoint(outputs) else sys.stderr


def check_suffix(path: Path, *suffixes: str) -> None:
    """InputError when a file's name promises another kind of content than these; one without suffix promises none."""
    if path.suffix and path.suffix.lower() not in suffixes:
        raise InputError(f"-o {path}: expected a file name that ends in {' or '.join(suffixes)}")


def check_once(recordings: Iterable[Path]) -> None:
    """InputError when a recording is given more than once, however its path is spelled."""
    for recording, times in Counter(realpath(path) for path in recordings).items():
        if times > 1:
            raise InputError(f"{recording}: this recording is given {times} times")


def check_outputs(
    outputs: Mapping[str, Path | None],
    settings: Settings,
    recording: Path | None = None,
    figures: Path | None = None,
    *,
    may_be_stdout: bool = False,
) -> None:
    """Refuse what would be lost under an output, however its path is spelled; outputs by their options.

    `figures` is the folder of --figures. InputError when an output is a folder, in one that is not there, the
    recording, the configuration or a DBC file of it, '-' where that does not mean standard output, or when two are
    the same. WorkError when one cannot be written, as far as that can be known before.
    """
    inputs = {realpath(dbc): "a DBC file of the configuration" for bus in settings.can for dbc in bus.dbc}
    inputs[realpath(settings.path)] = "the configuration"
    if recording is not None:
        inputs[realpath(recording)] = "the recording"
    given = {option: path for option, path in outputs.items() if path is not None}
    for option, path in given.items():
        if path == STDOUT and not may_be_stdout:
            raise InputError(f"{option} {path}: expected the name of a file, this does not go to standard output")
        if path.is_dir():
            raise InputError(f"{option} {path}: expected a file, this is a directory")
        if not path.parent.is_dir():
            raise InputError(f"{option} {path}: there is no directory {path.parent}")
        if what := inputs.get(realpath(path)):
            raise InputError(f"{option} {path}: this is {what}, which would be lost")
        if path != STDOUT:
            check_can_write(path)
    if figures is not None:
        check_can_write_in(figures)
        given["--figures"] = figures
    for (first, path), (second, other) in combinations(given.items(), 2):
        if realpath(path) == realpath(other) or {path, other} <= _STDOUTS:
            raise InputError(f"{path}: {first} and {second} cannot go to the same place")
