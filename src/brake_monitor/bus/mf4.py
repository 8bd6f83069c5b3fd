"""MDF files as python-can reads them with asammdf, whose log messages are kept from the terminal."""

import gc
import io
import logging
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, redirect_stdout
from typing import Any, BinaryIO, cast

import can
from can.io.generic import MessageReader

from brake_monitor.bus.damage import what_is_wrong
from brake_monitor.host import python_can

_UNFINISHED = b"UnFinMF "  # with which an MDF file begins until its recorder has finished it


def is_unfinished(content: BinaryIO) -> bool:
    """Whether its recorder has not finished it; the content stands at its beginning, before and after."""
    begins_so = content.read(len(_UNFINISHED)) == _UNFINISHED
    content.seek(0)
    return begins_so


def reader(content: BinaryIO) -> MessageReader:
    """Open an MDF file; ValueError when it is damaged."""
    with _unheard():
        try:
            return cast(MessageReader, python_can.mf4().MF4Reader(content))
        except Exception as error:  # noqa: BLE001 - with whatever its parsing raises
            what = str(error).rpartition("object at 0x")[2].partition('>" ')[2] or what_is_wrong(error)
        gc.collect()  # objects that it failed to build, while its messages are hushed
    raise ValueError(what)


def messages(reader: MessageReader) -> Iterator[can.Message]:
    """The messages; what is done between them is not ours to hush."""
    all_of_them = iter(reader)
    while True:
        with _unheard():
            message = next(all_of_them, None)
        if message is None:
            return
        yield message


def channels(reader: Any) -> Collection[int]:
    """Return the bus channels that asammdf has found in a file as it opened it."""
    return cast(Collection[int], reader._mdf.bus_logging_map["CAN"])


@contextmanager
def complaints() -> Iterator["Complaints"]:
    """What asammdf logs meanwhile, of which nothing comes on stderr, with a traceback."""
    logger, complaints = logging.getLogger("asammdf"), Complaints()
    logger.addFilter(complaints)
    try:
        yield complaints
    finally:
        logger.removeFilter(complaints)


class Complaints(logging.Filter):
    """Keeps the first thing that a logger is told, and lets nobody else hear any."""

    first = ""

    def filter(self, record: logging.LogRecord) -> bool:
        """Keep it to oneself."""
        self.first = self.first or record.getMessage()
        return False


@contextmanager
def _unheard() -> Iterator[None]:
    """Let nobody hear the tracebacks that asammdf prints, of what it raises and of what it failed to build."""
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        with redirect_stdout(io.StringIO()):
            yield
    finally:
        sys.unraisablehook = hook
