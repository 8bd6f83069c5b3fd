"""A recording for the tuner: its samples, decoded once, and the truth beside it where there is one."""

import csv
import re
from collections.abc import Iterable, Iterator
from itertools import count
from math import isfinite
from pathlib import Path
from typing import TextIO

import numpy as np
from msgspec import Struct

from brake_monitor.arrays import Floats
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.frame_block import FrameBlock
from brake_monitor.nearest import nearest_file
from brake_monitor.plural import plural
from brake_monitor.processing.whole_recording import all_samples
from brake_monitor.samples import ESSENTIAL

_LONGEST_LINE = 100_000  # characters; a device may have no end


class Truth(Struct, frozen=True):
    """What really was, at ascending times; shapes (K,), and (K, N) or (K, 0) for a friction that nobody knows."""

    path: Path
    time_s: Floats
    adhesion: Floats
    friction: Floats


class Recording(Struct, frozen=True):
    """Samples in the order in which the daemon would have had them."""

    samples: SampleBlock
    truth: Truth | None


def read_recording(path: Path, blocks: Iterable[FrameBlock], decoder: SignalDecoder, truth: Truth | None) -> Recording:
    """Decode all frames of the log at `path`; InputError when speeds, pressing forces or a common time are missing."""
    samples = all_samples(decoder, blocks)
    for quantity in ESSENTIAL:
        if not any(len(samples.good(quantity, i).places) for i in range(len(decoder.channels))):
            raise InputError(f"{path}: no {quantity} is in this recording, which cannot be fitted without it")
    if truth is not None:
        first_s, last_s = samples.time_s[0], samples.time_s[-1]
        if truth.time_s[-1] < first_s or truth.time_s[0] > last_s:
            raise InputError(
                f"{truth.path}: has no time in common with {path}: {truth.time_s[0]:.3f} to {truth.time_s[-1]:.3f} s "
                f"against {first_s:.3f} to {last_s:.3f} s"
            )
    return Recording(samples, truth)


def read_truth(path: Path, wheelset_count: int) -> Truth:
    """Read a CSV with `time_s` (as in the log), `adhesion` and, all or none, `friction_1` … `friction_N`.

    Other columns are passed over. InputError names the file, and the line where a row is the matter.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            reader = csv.reader(_lines(path, stream))
            header = next(reader, [])
            places = _places(path, header, wheelset_count)
            rows: list[list[float]] = []
            for row in filter(None, reader):  # without empty lines, with which some programs end a file
                if len(row) > len(header):
                    sentence = f"expected {plural(len(header), 'cell')}, as the header has, got {len(row)}"
                    raise InputError(f"{path}:{reader.line_num}: {sentence}; is there a decimal comma?")
                rows.append(_numbers(f"{path}:{reader.line_num}", row, places))
                if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
                    raise InputError(f"{path}:{reader.line_num}: time_s: expected a later time than in the row before")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}{nearest_file(path)}") from None
    except (UnicodeDecodeError, csv.Error):
        raise InputError(f"{path}: expected a truth as CSV, this is not text") from None
    if not rows:
        raise InputError(f"{path}: expected rows of numbers, there are none")
    table = np.array(rows)
    return Truth(path, table[:, 0], table[:, 1], table[:, 2:])


def _lines(path: Path, stream: TextIO) -> Iterator[str]:
    for number in count(1):
        line = stream.readline(_LONGEST_LINE + 1)
        if len(line) > _LONGEST_LINE:
            sentence = f"expected a truth as CSV, this line has more than {_LONGEST_LINE} characters"
            raise InputError(f"{path}:{number}: {sentence}")
        if not line:
            return
        yield line


def _places(path: Path, header: list[str], wheelset_count: int) -> dict[str, int]:
    """Where the columns that are needed stand."""
    friction = [f"friction_{i}" for i in range(1, wheelset_count + 1)]
    names = ["time_s", "adhesion", *(friction if any(name in header for name in friction) else [])]
    for name in names:
        if name not in header:
            raise InputError(f'{path}: expected a truth as CSV with a column "{name}", there is none')
    for name in header:
        if re.fullmatch(r"friction_\d+", name) and name not in friction:
            raise InputError(f'{path}: column "{name}": the vehicle has {plural(wheelset_count, "wheelset")}')
    return {name: header.index(name) for name in names}


def _numbers(where: str, row: list[str], places: dict[str, int]) -> list[float]:
    numbers = []
    for name, place in places.items():
        try:
            number = float(row[place])
        except (IndexError, ValueError):
            raise InputError(f"{where}: {name}: expected a number") from None
        if not isfinite(number):
            raise InputError(f"{where}: {name}: expected a finite number")
        numbers.append(number)
    return numbers
