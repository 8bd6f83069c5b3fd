"""candump's log format by the block: lines of the ordinary form are read with array arithmetic.

(1436509052.249713) can0 1A0#0011223344556677
(1436509052.449847) can0 18FF5030#01 R

Any other line (error and remote frames, CAN FD, odd spacing, damage) is read by itself, in its place.
"""

from collections.abc import Callable, Iterator
from io import BufferedIOBase
from typing import NamedTuple, Self

import numpy as np

from brake_monitor.arrays import Bools, Bytes, Ints
from brake_monitor.bus.eight_digits import NOT_HEX, identifiers, times_us
from brake_monitor.errors import InputError
from brake_monitor.frame import LARGEST_EXTENDED_ID, LARGEST_ID, Frame
from brake_monitor.frame_block import FrameBlock

CHUNK_BYTES = 1 << 19
_MOST_CHANNELS, _LONGEST_CHANNEL = 32, 32  # lines of further and of longer ones are read singly
_UNKNOWN, _ODD = -1, -2  # instead of the place of a bus

_NIBBLES = bytes(int(chr(code), 16) if chr(code) in "0123456789abcdefABCDEF" else NOT_HEX for code in range(256))
_OPENING, _DOT, _CLOSING, _SPACE, _HASH, _NEWLINE, _R, _T = b"(.) #\nRT"

_EXACT_BELOW = 1 << 53  # whole microseconds; divided by 1e6 they are the very double that their text means


class _Lines(NamedTuple):
    """Lines in one stretch of text; each array with one entry per line."""

    line: Ints  # number in the text, from 0
    begin: Ints  # place of the first character
    closing: Ints  # of the bracket after the time
    separator: Ints  # of the space between channel and identifier
    hash: Ints
    end: Ints  # of the data
    newline: Ints

    def where(self, wanted: Bools) -> Self:
        return type(self)(*(column[wanted] for column in self))


class CandumpBlocks:
    """Reads a log by the block."""

    def __init__(
        self, is_padded: bool, bus_of: Callable[[str], str], one_line: Callable[[bytes, int], Frame | None]
    ) -> None:
        """`bus_of(channel)` names the bus that a channel stands for; `is_padded` as `parse_line` takes it.

        `one_line(line, number)` reads one line by itself: None where it is empty, InputError where it is damaged.
        """
        self._is_padded = is_padded
        self._bus_of = bus_of
        self._one_line = one_line
        self._buses: list[str] = []
        self._channels: dict[bytes, int] = {}  # as the log has them; the places of their buses

    def read(self, content: BufferedIOBase) -> Iterator[FrameBlock]:
        """All frames in their order; an error is raised after all frames before it."""
        lines_before = 0
        for piece in _whole_lines(content):
            text = piece.replace(b"\r\n", b"\n") if b"\r" in piece else piece
            nibbles = np.frombuffer(text.translate(_NIBBLES), dtype=np.uint8)
            begin, lines = _lines(text, nibbles)
            line, block = self._ordinary(text, nibbles, lines)
            odd: dict[int, Frame] = {}
            error: InputError | None = None
            is_odd = np.ones(len(begin) - 1, dtype=np.bool_)
            is_odd[line] = False
            for k in np.flatnonzero(is_odd).tolist():
                try:
                    frame = self._one_line(text[begin[k] : begin[k + 1]], lines_before + k + 1)
                except InputError as met:
                    error, block, line = met, block.where(line < k), line[line < k]
                    break
                if frame is not None:
                    odd[k] = frame
            if odd:
                block = block.with_odd(line, odd)
            if len(block):
                yield block
            if error is not None:
                raise error
            lines_before += len(is_odd)

    def _ordinary(self, text: bytes, nibbles: Bytes, lines: _Lines) -> tuple[Ints, FrameBlock]:
        """Return the numbers of the lines that need no closer look, and their frames."""
        width = lines.hash - lines.separator - 1
        time_us, is_time = times_us(nibbles, lines.begin, lines.closing)
        can_id = identifiers(nibbles, lines.hash, width)
        bus = self._places_of_buses(np.frombuffer(text, dtype=np.uint8), lines)
        extended = np.zeros(len(width), dtype=np.bool_) if self._is_padded else width == 8
        buses, time_s = tuple(self._buses), time_us / 1e6
        block = FrameBlock(buses, time_s, bus, can_id, extended, lines.hash + 1, lines.end, text, is_text=True)
        good = is_time & (bus >= 0)
        good &= (time_us < _EXACT_BELOW) & (can_id <= np.where(width == 3, LARGEST_ID, LARGEST_EXTENDED_ID))
        return (lines.line, block) if good.all() else (lines.line[good], block.where(good))

    def _places_of_buses(self, characters: Bytes, lines: _Lines) -> Ints:
        """Which bus the channel of each line is; below 0 where the line is better read by itself."""
        begin, length = lines.closing + 2, lines.separator - lines.closing - 2
        bus = np.full(len(begin), _UNKNOWN, dtype=np.int64)
        for channel, place in self._channels.items():
            bus[_are(channel, characters, begin, length)] = place
        for _ in range(_MOST_CHANNELS - len(self._channels)):
            unknown = np.flatnonzero(bus == _UNKNOWN)
            if not len(unknown):
                break
            first = unknown[0]
            channel = characters[begin[first] : begin[first] + min(length[first], _LONGEST_CHANNEL + 1)].tobytes()
            place = _ODD
            if len(channel) <= _LONGEST_CHANNEL and channel.split() == [channel] and b"\0" not in channel:
                place = self._place(self._bus_of(channel.decode("ascii", errors="replace")))
                self._channels[channel] = place
            bus[first] = place
            bus[_are(channel, characters, begin, length)] = place
        return bus

    def _place(self, bus: str) -> int:
        if bus not in self._buses:
            self._buses.append(bus)
        return self._buses.index(bus)


def _whole_lines(content: BufferedIOBase) -> Iterator[bytes]:
    """The content in pieces that end with a line; what could be read before an error comes before the error."""
    held: list[bytes] = []
    size = 0
    try:
        while piece := content.read1(CHUNK_BYTES):
            held.append(piece)
            size += len(piece)
            end = piece.rfind(b"\n") + 1
            if size >= CHUNK_BYTES and end:
                held[-1] = piece[:end]
                yield b"".join(held)
                held = [piece[end:]]
                size = len(held[0])
    except Exception:
        whole = b"".join(held)
        yield whole[: whole.rfind(b"\n") + 1]
        raise
    if rest := b"".join(held):
        yield rest


def _lines(text: bytes, nibbles: Bytes) -> tuple[Ints, _Lines]:
    """Return where each line begins, with the end of the text last, and the lines that have the ordinary form."""
    characters = np.frombuffer(text, dtype=np.uint8)
    marks = np.flatnonzero(nibbles == NOT_HEX)
    kind = characters[marks]
    ends = np.flatnonzero(kind == _NEWLINE)
    begin = np.concatenate(([0], marks[ends] + 1))
    first = np.concatenate(([0], ends[:-1] + 1))[: len(ends)]
    closing, hash_ = _first_of(kind, _CLOSING, first), _first_of(kind, _HASH, first)
    line = np.flatnonzero((first + 2 <= closing) & (closing < hash_) & (hash_ < ends))
    closing, hash_ = closing[line], hash_[line]
    opening, dot, space = marks[closing - 2], marks[closing - 1], marks[closing + 1]
    lines = _Lines(line, begin[line], *(marks[k] for k in (closing, hash_ - 1, hash_, hash_ + 1, ends[line])))

    seconds, digits = dot - opening - 1, lines.end - lines.hash - 1
    width, tail = lines.hash - lines.separator - 1, lines.newline - lines.end
    fits = (opening == lines.begin) & (characters[opening] == _OPENING) & (characters[dot] == _DOT)
    fits &= (seconds >= 1) & (seconds <= 10) & (lines.closing - dot == 7)
    fits &= (space == lines.closing + 1) & (characters[space] == _SPACE)
    fits &= (lines.separator > space + 1) & (characters[lines.separator] == _SPACE) & ((width == 3) | (width == 8))
    fits &= (digits <= 16) & (digits % 2 == 0)
    direction = characters[np.minimum(lines.end + 1, lines.newline)]
    fits &= (tail == 0) | ((tail == 2) & (characters[lines.end] == _SPACE) & ((direction == _R) | (direction == _T)))
    if begin[-1] < len(text):
        begin = np.append(begin, len(text))
    return begin, lines if fits.all() else lines.where(fits)


def _first_of(kind: Bytes, wanted: int, first: Ints) -> Ints:
    """From each of the rising ranks `first` on, the rank of the first mark of a kind; len(kind) when there is none."""
    ranks = np.flatnonzero(kind == wanted)
    if len(ranks) == len(first) and (ranks >= first).all() and (ranks[:-1] < first[1:]).all():  # one in each line
        return ranks
    ranks = np.append(ranks, len(kind))
    return ranks[np.searchsorted(ranks, first)]


def _are(channel: bytes, characters: Bytes, begin: Ints, length: Ints) -> Bools:
    """Which of the pieces of text are this channel."""
    are: Bools = length == len(channel)
    for k, character in enumerate(channel):
        are &= characters.take(begin + k, mode="clip") == character
    return are
