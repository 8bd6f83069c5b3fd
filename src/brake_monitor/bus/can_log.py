"""Recordings of any format that python-can reads, as the frames that a bus gave.

Damage is refused as far as it can be seen: a line that cannot be read, by its number, one with fewer bytes than it
announces, a BLF file that is shorter than its header says. A recorder that loses power leaves a text whose last line is
incomplete: that line is left out, with a remark. So is that of any packed text that was cut, and the remains of a
candump line that something else was written behind: see `candump_log`. An MDF or BLF file that its recorder did not
finish, as some never do, is read as far as it goes, with a remark: nothing in it tells whether it was cut. Frames that
are years apart are remarked on. What cannot be told: text that was cut between two lines; an ASC line that ends before
its identifier, which could be an event of another kind, or within its last byte; a candump line that lacks whole bytes
(its signals are then missing, none is wrong).
"""

import codecs
import gzip
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from io import BufferedIOBase
from math import inf
from pathlib import Path
from typing import Any, BinaryIO, cast

import can
from can.io.generic import MessageReader

from brake_monitor.bus import mf4
from brake_monitor.bus.blf_blocks import BlfBlocks
from brake_monitor.bus.can_message import frame_of
from brake_monitor.bus.candump_blocks import CandumpBlocks
from brake_monitor.bus.candump_log import behind_tear, parse_line, writes_eight_digits_for_all
from brake_monitor.bus.damage import printable, what_is_wrong
from brake_monitor.bus.gathering import in_blocks
from brake_monitor.bus.log_channels import LogChannels
from brake_monitor.bus.text_lines import AsRead, CountedLines, asc_lines, csv_lines, trc_lines
from brake_monitor.bus.time_order import TimeOrder
from brake_monitor.bus.trc_reader import TrcReader
from brake_monitor.errors import InputError
from brake_monitor.frame import CLASSIC_LENGTH, LARGEST_EXTENDED_ID, LATEST_TIME_S, Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.host import extras
from brake_monitor.nearest import nearest_file
from brake_monitor.plural import plural
from brake_monitor.settings.config import CanBus

_TEXT_READERS: dict[str, tuple[Callable[..., Any], AsRead]] = {
    ".asc": (can.ASCReader, asc_lines),
    ".trc": (TrcReader, trc_lines),
    ".csv": (can.CSVReader, csv_lines),
}
_OF_LINES = (".log", *_TEXT_READERS)
_SUFFIXES = (*_OF_LINES, ".blf", ".db", ".mf4")
_LAST_LINE = "the last line is cut off: left out"
_TORN = "torn, as a power cut leaves it: only what stands whole behind the tear is read"
_NOT_FINISHED = "was not finished by its recorder, as those of some never are, or was cut off: read as far as it goes"
_LONGEST_FILE = 1 << 40  # bytes; no recording has them, and not every file system lets one look further
_COUNTED_FROM_1 = frozenset({".trc", ".mf4"})  # those of the other formats python-can counts from 0


def open_log(path: Path, buses: Sequence[CanBus]) -> "LogSource":
    """Open a recording, by its suffix: .log (candump) .asc .blf .trc .csv .db .mf4, each also .gz.

    Its channels are named as the buses that they stand for, see `LogChannels`.
    InputError when the file cannot be read, is of no known kind, or holds no frame.
    """
    suffixes = [suffix.lower() for suffix in path.suffixes]
    is_gzip = suffixes[-1:] == [".gz"]
    suffix = "".join((suffixes[:-1] if is_gzip else suffixes)[-1:])
    if suffix not in _SUFFIXES:
        raise InputError(f"{path}: unknown kind of log, expected one of {', '.join(_SUFFIXES)} (each also with .gz)")
    with suppress(OSError):  # of which is told as it is opened
        if path.is_fifo():  # it would be waited for, perhaps for ever, and can be read only once
            raise InputError(f"{path}: expected a recording, this is a pipe")
    return LogSource(path, suffix, is_gzip, buses)


class LogSource:
    """The frames of a recording in the order and with the times of the file; each iteration starts from the beginning.

    `remarks` tell what had to be assumed of the file. Damage met on the way raises InputError naming the file and,
    in a text format, the line.
    """

    def __init__(self, path: Path, suffix: str, is_gzip: bool, buses: Sequence[CanBus]) -> None:
        self.remarks: tuple[str, ...] = ()
        self._path = path
        self._suffix = suffix
        self._is_gzip = is_gzip
        self._buses = buses
        self._file: BinaryIO | None = None
        self._lines: CountedLines | None = None  # of a text format that python-can reads
        self._is_padded = False
        self._torn: list[int] = []  # lines of a candump log
        self._channels = LogChannels(buses, int(suffix in _COUNTED_FROM_1), self._remark)
        self._look_into()

    def progress(self) -> float:
        """Return how much of the file was read, 0 to 1."""
        if self._file is None:
            return 0.0
        return 1.0 if self._file.closed else self._file.tell() / max(1, os.fstat(self._file.fileno()).st_size)

    def __iter__(self) -> Generator[Frame]:
        for block in self.blocks():
            yield from block

    def blocks(self) -> Generator[FrameBlock]:
        """The same frames, by the block."""
        order = TimeOrder()
        self._torn = []
        with self._opened() as (stack, content):
            try:
                for block in self._blocks(stack, content):
                    order.see(block)
                    yield block
            except EOFError:  # from what is packed; all whole lines before came before
                if self._suffix not in _OF_LINES:
                    raise
                self._remark("is cut off: read up to there")
            except Exception:  # python-can meets a line that is cut off with whatever its parsing raises
                if self._lines is None or not self._lines.are_cut_off:
                    raise
                self._remark(_LAST_LINE, self._lines.number)
        if self._torn:
            first, *further = self._torn
            self._remark(f"{_TORN}, as of {plural(len(further), 'further line')}" if further else _TORN, first)
        for remark in order.remarks:
            self._remark(remark)

    def _blocks(self, stack: ExitStack, content: BinaryIO) -> Iterator[FrameBlock]:
        """Read the format that the suffix names; what is to be closed goes onto the stack."""
        reader: MessageReader
        match self._suffix:
            case ".log":
                candump = CandumpBlocks(self._is_padded, self._channels.__getitem__, self._candump_frame)
                return candump.read(cast(BufferedIOBase, content))
            case ".blf":
                blf = BlfBlocks(content, self._channels.__getitem__, self._frame)
                stack.callback(blf.stop)
                _check_is_whole(content, blf.file_size)
                if blf.is_unfinished:
                    self._remark(_NOT_FINISHED)
                return in_blocks(blf.read())
            case ".mf4":
                return in_blocks(map(self._frame, self._mf4(stack, content)))
            case ".db":
                reader = can.SqliteReader(str(self._unpacked_path(stack, content)))
            case text:
                _refuse_what_is_only_logged(stack)
                new_reader, as_read = _TEXT_READERS[text]
                self._lines = CountedLines(content, as_read)
                reader = new_reader(self._lines)
        stack.callback(reader.stop)
        messages = self._of_absolute_times(reader) if isinstance(reader, can.ASCReader) else reader
        return in_blocks(map(self._frame, messages))

    def _look_into(self) -> None:
        """Find out what must be known beforehand; InputError when it cannot be read or holds no frame."""
        with self._opened() as (_, content):
            if not content.read(1):
                raise InputError(f"{self._path}: is empty")
        if self._suffix == ".log":
            with self._opened() as (_, content):
                self._is_padded = writes_eight_digits_for_all(_lines_there(content))
        if self._is_padded:
            self._remark("every id has eight digits and none is above 7FF: taken for 11-bit ids")
        blocks = self.blocks()
        if next(blocks, None) is None:
            raise InputError(f"{self._path}: holds no CAN frame")
        blocks.close()
        if self._channels.first < (self._suffix in _COUNTED_FROM_1) and len(self._buses) > 1:
            self._remark(f"it has a bus channel 0: taken for {self._buses[0].name}, 1 for the next")
        self._file = None

    @contextmanager
    def _opened(self) -> Iterator[tuple[ExitStack, BinaryIO]]:
        """Open the file, unpacked; whatever goes wrong while it is open becomes an InputError."""
        self._lines = None
        with ExitStack() as stack:
            try:
                self._file = stack.enter_context(self._path.open("rb"))
                unpacked = stack.enter_context(gzip.open(self._file)) if self._is_gzip else self._file
                content = cast(BinaryIO, unpacked)
                if self._suffix == ".log":
                    _skip_byte_order_mark(content)
                yield stack, content
            except InputError:
                raise
            except OSError as error:
                reason = f"{error.strerror or error}{nearest_file(self._path)}"
                raise InputError(f"{self._path}: cannot be read: {reason}") from None
            except Exception as error:  # noqa: BLE001 - readers meet damage with whatever their parsing raises
                place = f"{self._path}:{self._lines.number}" if self._lines else str(self._path)
                raise InputError(f"{place}: damaged, or not a {self._suffix} file: {what_is_wrong(error)}") from None

    def _remark(self, sentence: str, line: int | None = None) -> None:
        """Say something of the file, once however often it is read."""
        place = f"{self._path}:{line}" if line else str(self._path)
        if (remark := f"{place}: {sentence}") not in self.remarks:
            self.remarks += (remark,)

    def _candump_frame(self, raw: bytes, number: int) -> Frame | None:
        """The frame of one line; None when the line is empty, or only what a power cut left of one."""
        text = raw.decode("ascii", errors="replace")
        if text.isspace():
            return None
        try:
            frame = parse_line(text, self._is_padded)
        except ValueError as error:
            if number > 1 and not raw.endswith(b"\n"):
                self._remark(_LAST_LINE, number)
                return None
            behind = behind_tear(text)
            if behind is None:
                raise InputError(f"{self._path}:{number}: {error}: {printable(text)!r}") from None
            self._torn.append(number)
            if not behind:
                return None
            frame = parse_line(behind, self._is_padded)
        return frame._replace(bus=self._channels[frame.bus])

    def _mf4(self, stack: ExitStack, content: BinaryIO) -> Iterator[can.Message]:
        extras.require("mf4", f"{self._path}: reading .mf4")
        complaints = stack.enter_context(mf4.complaints())
        stack.callback(lambda: self._remark_complaint(complaints.first))
        if mf4.is_unfinished(content):
            self._remark(_NOT_FINISHED)
        reader = mf4.reader(content)
        # Loggers count from 1, python-can's own writer leaves the number of can0 as it is.
        self._channels.first = 0 if 0 in mf4.channels(reader) else 1
        stack.callback(reader.stop)
        return mf4.messages(reader)

    def _of_absolute_times(self, reader: can.ASCReader) -> Iterator[can.Message]:
        """The messages; InputError where each time counts from the line before, which python-can does not know.

        "Relative" in the header may mean that, or that all count from the start: those do not fall.
        """
        before_s = -inf
        for message in reader:
            if message.timestamp < before_s and reader.timestamps_format == "relative":
                raise InputError(
                    f"{self._path}: its header says that timestamps are relative, and they fall, so that each counts "
                    "from the line before: expected absolute ones"
                )
            before_s = message.timestamp
            yield message

    def _remark_complaint(self, complaint: str) -> None:
        if complaint:
            self._remark(f"may be damaged: {printable(complaint)}")

    def _unpacked_path(self, stack: ExitStack, content: BinaryIO) -> Path:
        """Return a path to the content, for SQLite, which opens its files itself."""
        if not self._is_gzip:
            return self._path
        unpacked = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "log.db"
        with unpacked.open("wb") as copy:
            shutil.copyfileobj(content, copy)
        return unpacked

    def _frame(self, message: can.Message) -> Frame:
        frame = frame_of(message, self._channels[message.channel])
        if not abs(frame.time_s) < LATEST_TIME_S:
            raise ValueError(f"time stamp {frame.time_s:g}")
        if frame.can_id > LARGEST_EXTENDED_ID:
            raise ValueError(f"identifier 0x{frame.can_id:X} has more than 29 bits")
        if self._lines and frame.kind is FrameKind.DATA:
            classic = min(message.dlc, CLASSIC_LENGTH)  # they may say up to 15
            announced = message.dlc if message.is_fd else classic
            if len(frame.data) < announced:
                raise ValueError(f"{len(frame.data)} of {announced} bytes are there")
        return frame


def _skip_byte_order_mark(content: BinaryIO) -> None:
    """Skip the byte-order mark that some editors put before UTF-8."""
    if content.read(len(codecs.BOM_UTF8)) != codecs.BOM_UTF8:
        content.seek(0)


def _lines_there(content: BinaryIO) -> Iterator[bytes]:
    """The lines, of a packed file that was cut off those that can be read."""
    try:
        yield from content
    except EOFError:
        return


def _check_is_whole(content: BinaryIO, size: int) -> None:
    """ValueError when the content is shorter than its header says (0 where the recorder was not stopped in order)."""
    place = content.tell()
    content.seek(min(max(0, size - 1), _LONGEST_FILE))
    if size and not content.read(1):
        raise ValueError(f"cut off: its header says {size} bytes")
    content.seek(place)


class _Refuse(logging.Handler):
    """Makes an error of what a reader would only log: a line that is not what it must be."""

    def emit(self, record: logging.LogRecord) -> None:
        raise ValueError(record.getMessage())


def _refuse_what_is_only_logged(stack: ExitStack) -> None:
    logger, handler = logging.getLogger("can.io.trc"), _Refuse(logging.WARNING)
    logger.addHandler(handler)
    stack.callback(logger.removeHandler, handler)
