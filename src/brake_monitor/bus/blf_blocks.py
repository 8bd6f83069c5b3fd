"""BLF, Vector's binary logging format, by the block: the classic data frames of a container are read together.

A container holds objects one after the other; each has a header of 4-byte words

    0 signature "LOBJ"   1 version << 16 | length of the header   2 length of the object   3 kind
    4 unit of the time   6, 7 time, low and high

and after it (8 words in version 1, 10 in version 2) a classic CAN message has

    0 length of the data << 24 | flags << 16 | channel   1 identifier   2, 3 data

Objects of other frames are read by python-can one by one, and so is a whole container with anything unusual in it.
Error frames of the old kind, which python-can passes over, have only their channel:

    0 length << 16 | channel
"""

import struct
from collections.abc import Callable, Iterator
from typing import BinaryIO, cast

import can
import numpy as np
from numpy.typing import NDArray

from brake_monitor.arrays import Ints, indices
from brake_monitor.frame import CLASSIC_LENGTH, LARGEST_EXTENDED_ID, Frame
from brake_monitor.frame_block import FrameBlock

_FILE_HEADER_BYTES = 144
_SIGNATURE = b"LOBJ"
_SIGNATURE_WORD = int.from_bytes(_SIGNATURE, "little")
_MOST_PADDING = 4  # between an object and the next
_SEARCHED = len(_SIGNATURE) + _MOST_PADDING
_HEADER_BASE = struct.Struct("<4sHHII")  # signature, length of the header, its version, length of the object, its kind
_HEADER_WORDS = {1: 8, 2: 10}  # by version
_MESSAGE_WORDS = 4

_CLASSIC = (1, 86)  # CAN_MESSAGE, CAN_MESSAGE2
_OLD_ERROR, _ERROR = 2, 73  # CAN_ERROR, CAN_ERROR_EXT
_OTHER_FRAMES = (_OLD_ERROR, _ERROR, 100, 101)  # CAN_FD_MESSAGE, CAN_FD_MESSAGE_64
_BEHIND = 320  # python-can may look so far behind the end of an object for its data
_REMOTE_FLAG = 0x80 << 16
_EXTENDED_FLAG = 0x80000000
_TEN_MICROSECONDS = 1
_EXACT_HIGH_WORD = 1 << 21  # below it a time is below 2**53 and, divided by its unit, the very double that it means

Words32 = NDArray[np.uint32]


class BlfBlocks(can.BLFReader):
    """python-can's reader; where it can it gives blocks instead of messages.

    ValueError beforehand where python-can would loop for ever: at an object of length 0.
    """

    def __init__(
        self, content: BinaryIO, bus_of: Callable[[int], str], frame_of: Callable[[can.Message], Frame]
    ) -> None:
        """`bus_of(channel)` names the bus of a channel, counted from 0; `frame_of(message)` makes our frame of it."""
        super().__init__(content)
        self._bus_of = bus_of
        self._frame_of = frame_of

    @property
    def is_unfinished(self) -> bool:
        """Whether its recorder has not come to write into the header how long it is."""
        size: int = self.file_size
        return size <= _FILE_HEADER_BYTES

    def read(self) -> Iterator[Frame | FrameBlock]:
        """All frames in their order; of a file that its recorder did not finish as far as it goes."""
        try:
            for item in cast(Iterator[can.Message | FrameBlock], iter(self)):
                yield item if isinstance(item, FrameBlock) else self._frame_of(item)
        except struct.error:  # it ends in the header of a container
            if not self.is_unfinished:
                raise

    def _parse_data(self, data: bytes) -> Iterator[can.Message]:
        """What python-can calls for each container, after what the one before left over."""
        objects = _objects(data)
        block = None if objects is None else self._block(data, *objects)
        if objects is None or block is None:
            _refuse_empty_objects(data)
            yield from super()._parse_data(data)
            return
        if len(block):
            yield cast(can.Message, block)
        _, begin, length = objects
        self._pos = int(begin[-1] + length[-1])

    def _block(self, data: bytes, words: Words32, begin: Ints, length: Ints) -> FrameBlock | None:
        """The frames of a container's objects; None when python-can should read it."""
        at = (begin - begin[0]) // 4
        version, kind, time_high = words[at + 1] >> 16, words[at + 3], words[at + 7].astype(np.int64)
        header_words = np.where(version == 1, _HEADER_WORDS[1], _HEADER_WORDS[2])
        is_classic = np.isin(kind, _CLASSIC)
        is_usual = ((version == 1) | (version == 2)) & (time_high < _EXACT_HIGH_WORD)
        is_usual &= length >= 4 * (header_words + np.where(is_classic, _MESSAGE_WORDS, kind == _OLD_ERROR))
        if not is_usual.all():
            return None
        message = at + header_words
        is_classic[is_classic] = words[message[is_classic]] & _REMOTE_FLAG == 0
        is_odd = ~is_classic & np.isin(kind, (*_CLASSIC, *_OTHER_FRAMES))
        at, time_high, message = at[is_classic], time_high[is_classic], message[is_classic]

        unit = np.where(words[at + 4] == _TEN_MICROSECONDS, 1e5, 1e9)
        time_s = (time_high << 32 | words[at + 6]) / unit + self.start_timestamp
        buses, bus = self._buses((words[message] & 0xFFFF).astype(np.int64))
        identifier = words[message + 1].astype(np.int64)
        can_id, extended = identifier & LARGEST_EXTENDED_ID, identifier & _EXTENDED_FLAG != 0
        start = begin[0] + 4 * (message + 2)
        stop = start + np.minimum(words[message] >> 24, CLASSIC_LENGTH)
        block = FrameBlock(buses, time_s, bus, can_id, extended, start, stop, data)
        if not is_odd.any():
            return block
        try:
            odd = {place: self._one(data, place, size) for place, size in np.stack((begin, length), 1)[is_odd].tolist()}
        except struct.error:
            return None
        return block.with_odd(begin[is_classic], odd)

    def _buses(self, channel: Ints) -> tuple[tuple[str, ...], Ints]:
        """The buses that these channels stand for, and which of them each one does."""
        frames = np.bincount(indices(channel))  # of each channel
        channels = np.flatnonzero(frames)
        names = [self._bus_of(number - 1) for number in channels.tolist()]
        buses = tuple(dict.fromkeys(names))
        place = np.zeros(len(frames), dtype=np.int64)
        place[channels] = [buses.index(name) for name in names]
        return buses, place[channel]

    def _one(self, data: bytes, place: int, length: int) -> Frame:
        """What python-can makes of one object that is a frame; of an old error frame as if it were of the new kind."""
        one = data[place : place + length + _BEHIND]
        *_, version, _, kind = _HEADER_BASE.unpack_from(one)
        if kind == _OLD_ERROR:
            channel_at = 4 * _HEADER_WORDS[version]
            kind_at = _HEADER_BASE.size - 4
            header = one[:kind_at] + _ERROR.to_bytes(4, "little") + one[_HEADER_BASE.size : channel_at]
            one = header + one[channel_at : channel_at + 2] + bytes(_BEHIND)
        return self._frame_of(next(super()._parse_data(one)))


def _objects(data: bytes) -> tuple[Words32, Ints, Ints] | None:
    """Return the words of a container from its first object on, and begin and length of the whole objects in it.

    None unless one object follows the other as python-can looks for them.
    """
    first = data.find(_SIGNATURE, 0, _SEARCHED)
    if first < 0:
        return None
    words = np.frombuffer(data, dtype="<u4", count=(len(data) - first) // 4, offset=first)
    at = np.flatnonzero(words == _SIGNATURE_WORD)
    at = at[at + _HEADER_BASE.size // 4 <= len(words)]
    begin, length = first + 4 * at, words[at + 2].astype(np.int64)
    end = begin + length
    count = int(np.searchsorted(np.maximum.accumulate(end), len(data), side="right"))  # the next one goes on elsewhere
    gaps = begin[1 : count + 1] - end[:count][: len(begin) - 1]
    if not count or (length[:count] < 4 * _HEADER_WORDS[1]).any() or (gaps < 0).any() or (gaps > _MOST_PADDING).any():
        return None
    if count == len(begin) and len(data) - end[-1] >= _SEARCHED:
        return None
    return words, begin[:count], length[:count]


def _refuse_empty_objects(data: bytes) -> None:
    """ValueError when an object is not even as long as its header."""
    place = data.find(_SIGNATURE, 0, _SEARCHED)
    while 0 <= place <= len(data) - _HEADER_BASE.size:
        *_, length, _ = _HEADER_BASE.unpack_from(data, place)
        if length < _HEADER_BASE.size:
            raise ValueError(f"an object says that it has {length} bytes")
        place = data.find(_SIGNATURE, place + length, place + length + _SEARCHED)
