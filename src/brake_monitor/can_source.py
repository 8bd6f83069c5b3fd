"""Where frames come from: a recording in any format that python-can reads, or a live bus that is only listened to."""

import gc
import gzip
import io
import logging
import shutil
import socket
import sys
import tempfile
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from importlib.util import find_spec
from math import isfinite
from pathlib import Path
from typing import IO, Any, BinaryIO, Self

import can

from brake_monitor.can_filter import CanFilter
from brake_monitor.candump_log import parse_line
from brake_monitor.config import CanBus
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.nearest import nearest

_TEXT_READERS: dict[str, Callable[..., Any]] = {".asc": can.ASCReader, ".trc": can.TRCReader, ".csv": can.CSVReader}
_SUFFIXES = (".log", *_TEXT_READERS, ".blf", ".db", ".mf4")
_COUNTED_FROM_1 = frozenset({".trc", ".mf4"})  # python-can counts the channels of the other formats from 0
_RECEIVE_BUFFER_BYTES = 4 << 20  # the kernel's default holds 278 frames, a tenth of a second of a busy bus
_SO_RCVBUFFORCE = 33  # Linux; beyond the system's limit, for those who may (CAP_NET_ADMIN)


class BusError(WorkError):
    """The bus failed while it was listened to (interface down or gone); opening it anew may help."""


def open_log(path: Path, buses: Sequence[CanBus]) -> "LogSource":
    """Open a recording, by its suffix: .log (candump) .asc .blf .trc .csv .db .mf4, each also .gz.

    With one bus every channel of the log counts as that bus. With several, a channel is the bus whose `channel` or
    `name` it carries, a numbered one the bus in that place; frames of other channels have bus "".
    InputError when the file cannot be read, is of no known kind, or holds no frame.
    """
    suffixes = [suffix.lower() for suffix in path.suffixes]
    is_gzip = suffixes[-1:] == [".gz"]
    suffix = "".join((suffixes[:-1] if is_gzip else suffixes)[-1:])
    if suffix not in _SUFFIXES:
        raise InputError(f"{path}: unknown kind of log, expected one of {', '.join(_SUFFIXES)} (each also with .gz)")
    if suffix == ".mf4" and find_spec("asammdf") is None:
        raise InputError(f"{path}: reading .mf4 needs an extra: pip install 'brake-monitor[mf4]'")
    frames = iter(LogSource(path, suffix, is_gzip, buses))
    if next(frames, None) is None:
        raise InputError(f"{path}: holds no CAN frame")
    frames.close()
    return LogSource(path, suffix, is_gzip, buses)


class LogSource:
    """The frames of a recording in the order and with the times of the file; each iteration starts anew.

    Damage met on the way raises InputError naming the file and, in a text format, the line.
    """

    def __init__(self, path: Path, suffix: str, is_gzip: bool, buses: Sequence[CanBus]) -> None:
        self._path = path
        self._suffix = suffix
        self._is_gzip = is_gzip
        self._buses = buses
        self._bus_names: dict[object, str] = {}  # by channel as the log has it; filled as they turn up
        self._file: IO[bytes] | None = None

    def progress(self) -> float:
        """Return how much of the file was read, 0 to 1."""
        if self._file is None:
            return 0.0
        return 1.0 if self._file.closed else self._file.tell() / max(1, self._path.stat().st_size)

    def __iter__(self) -> Generator[Frame]:
        with ExitStack() as stack:
            line: Callable[[], int] | None = None
            try:
                self._file = stack.enter_context(self._path.open("rb"))
                content = stack.enter_context(gzip.open(self._file)) if self._is_gzip else self._file
                if self._suffix == ".log":
                    yield from self._candump_frames(content)
                else:
                    reader, line = self._reader(stack, content)
                    for message in reader:
                        yield self._frame(message)
            except InputError:
                raise
            except OSError as error:
                raise InputError(f"{self._path}: cannot be read: {error.strerror or error}") from None
            except Exception as error:  # noqa: BLE001 - readers meet damage with whatever their parsing raises
                place = f"{self._path}:{line()}" if line else str(self._path)
                what = _printable(str(error)) or type(error).__name__
                raise InputError(f"{place}: damaged, or not a {self._suffix} file: {what}") from None

    def _candump_frames(self, content: Iterable[bytes]) -> Iterator[Frame]:
        bus_names = self._bus_names
        for number, raw in enumerate(content, start=1):
            text = raw.decode("ascii", errors="replace")
            if text.isspace():
                continue
            try:
                frame = parse_line(text)
            except ValueError as error:
                found = repr(_printable(text))
                hint = "" if raw.endswith(b"\n") else " (the last line is cut off)"
                raise InputError(f"{self._path}:{number}: {error}: {found}{hint}") from None
            bus = bus_names.get(frame.bus)
            yield frame._replace(bus=self._bus_name(frame.bus) if bus is None else bus)

    def _reader(self, stack: ExitStack, content: Any) -> tuple[Iterable[can.Message], Callable[[], int] | None]:
        """Return python-can's reader of the format, and where it is in the file if that has lines."""
        line = None
        reader: Any
        match self._suffix:
            case ".blf":
                reader = can.BLFReader(content)
            case ".db":
                reader = can.SqliteReader(str(self._unpacked_path(stack, content)))
            case ".mf4":
                reader = _mf4_reader(content)
            case text:
                _refuse_what_is_only_logged(stack)
                lines = _CountedLines(content, encoding="utf-8", errors="replace")
                reader, line = _TEXT_READERS[text](lines), lines.number
        stack.callback(reader.stop)
        return reader, line

    def _unpacked_path(self, stack: ExitStack, content: IO[bytes]) -> Path:
        """Return a path to the content, for SQLite, which opens its files itself."""
        if not self._is_gzip:
            return self._path
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "log.db"
        with unpacked.open("wb") as copy:
            shutil.copyfileobj(content, copy)
        return unpacked

    def _frame(self, message: can.Message) -> Frame:
        bus = self._bus_names.get(message.channel)
        frame = _frame(message, self._bus_name(message.channel) if bus is None else bus)
        if not isfinite(frame.time_s):
            raise ValueError(f"time stamp {frame.time_s}")
        return frame

    def _bus_name(self, channel: object) -> str:
        """Return the bus that a channel of the log stands for; "" for none."""
        buses = self._buses
        name = ""
        if len(buses) == 1:
            name = buses[0].name
        elif isinstance(channel, int):
            place = channel - (self._suffix in _COUNTED_FROM_1)
            name = buses[place].name if 0 <= place < len(buses) else ""
        else:
            name = next((bus.name for bus in buses if channel in (bus.channel, bus.name)), "")
        self._bus_names[channel] = name
        return name


def _printable(text: str) -> str:
    """Return the beginning of a text of unknown origin as one line."""
    line = " ".join(text.split())[:80]
    return "".join(character if character.isprintable() else "?" for character in line)


def _mf4_reader(content: BinaryIO) -> can.MF4Reader:
    """Open an MDF file; ValueError when it is damaged.

    An object that asammdf failed to build writes a traceback to stderr when it is dropped, so it is dropped here,
    while nobody listens.
    """
    hook, sys.unraisablehook = sys.unraisablehook, lambda _: None
    try:
        try:
            return can.MF4Reader(content)
        except Exception as error:  # noqa: BLE001 - as above, anything
            what = str(error).rpartition("object at 0x")[2].partition('>" ')[2] or str(error)
        gc.collect()
    finally:
        sys.unraisablehook = hook
    raise ValueError(what)


class _Refuse(logging.Handler):
    """Makes an error of what a reader would only log: a line that is not what it must be."""

    def emit(self, record: logging.LogRecord) -> None:
        raise ValueError(record.getMessage())


def _refuse_what_is_only_logged(stack: ExitStack) -> None:
    logger, handler = logging.getLogger("can.io.trc"), _Refuse(logging.WARNING)
    logger.addHandler(handler)
    stack.callback(logger.removeHandler, handler)


class _CountedLines(io.TextIOWrapper):
    """A text file that knows which line it gave out last."""

    _number = 0

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        self._number += 1
        return super().readline(size)

    def __next__(self) -> str:  # type: ignore[override]
        line = self.readline()
        if not line:
            raise StopIteration
        return line

    def number(self) -> int:
        """The line given out last, from 1."""
        return self._number


def open_bus(bus: CanBus, filters: Sequence[CanFilter]) -> "LiveBus":
    """Open a bus to listen to, letting through only what passes the filters (all, when there are none).

    InputError when there is no such interface or channel.
    """
    if bus.interface not in can.VALID_INTERFACES:
        hint = nearest(bus.interface, sorted(can.VALID_INTERFACES))
        raise InputError(f'bus "{bus.name}": cannot open {bus.interface}:{bus.channel}: no such interface, {hint}')
    options: dict[str, Any] = {"receive_own_messages": False, "ignore_config": True}
    if bus.interface == "socketcan":
        options["fd"] = True  # a socket that takes FD frames takes classic ones too, whatever the interface's MTU
    try:
        opened = can.Bus(channel=bus.channel, interface=bus.interface, can_filters=[*filters] or None, **options)
    except (can.CanError, OSError, ImportError, TypeError, ValueError) as error:
        what = getattr(error, "strerror", None) or " ".join(str(error).split()) or type(error).__name__
        raise InputError(f'bus "{bus.name}": cannot open {bus.interface}:{bus.channel}: {what}') from None
    _enlarge_receive_buffer(opened)
    return LiveBus(bus, opened)


class LiveBus:
    """A bus that is listened to and nothing else: of python-can's bus it keeps only what receives and closes."""

    def __init__(self, bus: CanBus, opened: can.BusABC) -> None:
        self.name = bus.name
        self._place = f"{bus.interface}:{bus.channel}"
        self._recv = opened.recv
        self._shutdown = opened.shutdown

    def recv(self, timeout_s: float) -> Frame | None:
        """Return the next frame with the time at which the kernel got it, or None when none came in time.

        BusError when the bus failed.
        """
        try:
            message = self._recv(timeout_s)
        except (can.CanError, OSError, ValueError) as error:  # ValueError: the socket is closed
            raise BusError(f'bus "{self.name}" ({self._place}) failed while listening: {error}') from None
        return None if message is None else _frame(message, self.name)

    def close(self) -> None:
        """Give the bus back; a bus that already failed may be closed too."""
        with suppress(can.CanError, OSError):
            self._shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()


def _frame(message: can.Message, bus: str) -> Frame:
    kind = FrameKind.DATA
    if message.is_error_frame:
        kind = FrameKind.ERROR
    elif message.is_remote_frame:
        kind = FrameKind.REMOTE
    return Frame(message.timestamp, bus, message.arbitration_id, message.is_extended_id, bytes(message.data), kind)


def _enlarge_receive_buffer(opened: can.BusABC) -> None:
    """Make room for the frames of a few seconds, where the bus is a socket of the kernel."""
    opened_socket = getattr(opened, "socket", None)
    if not isinstance(opened_socket, socket.socket):
        return
    try:
        opened_socket.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _RECEIVE_BUFFER_BYTES)
    except OSError:  # not permitted: as much as the system's limit allows
        opened_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER_BYTES)
