"""The lines of a text format as python-can's reader needs them, which else loses some and misunderstands others."""

import io
import re
from collections.abc import Callable, Iterator
from itertools import chain
from typing import BinaryIO

AsRead = Callable[[Iterator[str]], Iterator[str]]

_EVENT = re.compile(r"\s*\d+\.\d+\s", re.ASCII)  # in .asc
_BASE = re.compile(r"\s*base\s+(hex|dec)", re.IGNORECASE)
_REQUEST = re.compile(r"\s*\d+\.\d+\s+(\d+\s+\w+|CANFD\s+\d+)\s+TxRq\s", re.ASCII | re.IGNORECASE)
_NUMBER = re.compile(r"\s*[-+.]*\d")


class CountedLines(io.TextIOWrapper):
    """A text file that knows which line it gave out last."""

    number = 0  # of that line, from 1
    are_cut_off = False  # that line is one of several, and has no end

    def __init__(self, content: BinaryIO, as_read: AsRead) -> None:
        super().__init__(content, encoding="utf-8-sig", errors="replace")
        self._lines = as_read(iter(self._next_line, ""))

    def _next_line(self) -> str:
        self.number += 1
        line = self.readline()
        self.are_cut_off = self.number > 1 and line != "" and not line.endswith("\n")
        return line

    def __next__(self) -> str:  # type: ignore[override]
        return next(self._lines)


def asc_lines(lines: Iterator[str]) -> Iterator[str]:
    """python-can ends the header at a line that it does not know, which it drops, and takes what follows for hex.

    And it takes a request to send, TxRq, for a frame, which is told of again when it was sent.
    """
    first = ""
    for first in lines:
        if _EVENT.match(first):
            break
        if _BASE.match(first):
            yield first.lower()
    yield "internal events logged\n"  # as any header ends
    for line in chain((first,), lines):
        if not _REQUEST.match(line):
            yield line


def csv_lines(lines: Iterator[str]) -> Iterator[str]:
    """python-can drops the first line, as a header; where it appends to a file it writes none."""
    first = next(lines, "")
    if _NUMBER.match(first):
        yield "\n"  # to be dropped
    yield first
    yield from lines


def trc_lines(lines: Iterator[str]) -> Iterator[str]:
    """python-can takes an empty line behind the header for a frame."""
    return filter(str.strip, lines)
