"""Frames of a recording by the thousand, as arrays: a few of them are found without a look at each."""

from binascii import unhexlify
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from brake_monitor.arrays import Bools, Floats, Ints, Words, indices
from brake_monitor.frame import LARGEST_EXTENDED_ID, Frame, FrameKind

_AHEAD = 16  # characters in eight bytes
_COLUMNS = ("time_s", "bus", "can_id", "extended", "start", "stop")

Identifier = tuple[str, bool, int]  # bus, extended, id


@dataclass(frozen=True)
class FrameBlock:
    """Successive frames of a recording, each array with one entry per frame.

    The bytes of frame k are payload[start[k]:stop[k]], or what two hexadecimal digits each say there. Frames that are
    not of that form (other kinds than DATA, and whatever a reader read one by one) are kept whole in `odd`, by their
    place; the other arrays tell of them too.
    """

    buses: tuple[str, ...]  # distinct
    time_s: Floats
    bus: Ints  # place in `buses`
    can_id: Ints
    extended: Bools
    start: Ints
    stop: Ints
    payload: bytes
    is_text: bool = False  # the payload is: two hexadecimal digits for each byte
    odd: Mapping[int, Frame] = field(default_factory=dict)

    @classmethod
    def of(cls, frames: Sequence[Frame]) -> Self:
        """A block of existing frames."""
        places = {bus: place for place, bus in enumerate(dict.fromkeys(frame.bus for frame in frames))}
        length = np.array([len(frame.data) for frame in frames], dtype=np.int64)
        stop = np.cumsum(length)
        return cls(
            tuple(places),
            np.array([frame.time_s for frame in frames], dtype=np.float64),
            np.array([places[frame.bus] for frame in frames], dtype=np.int64),
            np.array([frame.can_id for frame in frames], dtype=np.int64),
            np.array([frame.extended for frame in frames], dtype=np.bool_),
            stop - length,
            stop,
            b"".join([frame.data for frame in frames]),
            odd={place: frame for place, frame in enumerate(frames) if frame.kind is not FrameKind.DATA},
        )

    @classmethod
    def joined(cls, blocks: Sequence[Self]) -> Self:
        """Successive blocks, of one kind of payload, as one."""
        if len(blocks) == 1:
            return blocks[0]
        buses = tuple(dict.fromkeys(bus for block in blocks for bus in block.buses))
        parts: list[Self] = []
        odd: dict[int, Frame] = {}
        frames = size = 0  # before each of them
        for block in blocks:
            bus = np.array([buses.index(bus) for bus in block.buses], dtype=np.int64)[block.bus]
            parts.append(replace(block, bus=bus, start=block.start + size, stop=block.stop + size))
            odd |= {frames + place: frame for place, frame in block.odd.items()}
            frames, size = frames + len(block), size + len(block.payload)
        columns: dict[str, Any] = {name: np.concatenate([getattr(part, name) for part in parts]) for name in _COLUMNS}
        payload = b"".join([block.payload for block in blocks])
        return cls(buses, payload=payload, is_text=blocks[0].is_text, odd=odd, **columns)

    def where(self, wanted: Bools) -> Self:
        """Some of the frames of a block without odd ones."""
        columns: dict[str, Any] = {name: getattr(self, name)[wanted] for name in _COLUMNS}
        return replace(self, **columns)

    def with_odd(self, number: Ints, odd: Mapping[int, Frame]) -> Self:
        """Put odd frames, by number, among those of a block without any, whose numbers are `number`."""
        others = self.of(list(odd.values()))
        buses = tuple(dict.fromkeys((*self.buses, *others.buses)))
        moved = np.array([buses.index(bus) for bus in others.buses], dtype=np.int64)
        nowhere = np.zeros(len(others), dtype=np.int64)  # in the payload
        others = replace(others, bus=moved[others.bus], start=nowhere, stop=nowhere)
        odd_number = np.array(list(odd), dtype=np.int64)
        numbers = np.concatenate((number, odd_number))
        order = np.argsort(numbers)
        columns: dict[str, Any] = {
            name: np.concatenate((getattr(self, name), getattr(others, name)))[order] for name in _COLUMNS
        }
        places = np.searchsorted(numbers[order], odd_number).tolist()
        return replace(self, buses=buses, odd=dict(zip(places, odd.values(), strict=True)), **columns)

    def __len__(self) -> int:
        return len(self.time_s)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.frames(np.arange(len(self))))

    def frames(self, places: Ints) -> list[Frame]:
        """The frames in these places."""
        payload = self.payload
        time_s, bus, can_id, extended, start, stop = (getattr(self, name)[places].tolist() for name in _COLUMNS)
        buses = map(self.buses.__getitem__, bus)
        data = [payload[a:b] for a, b in zip(start, stop, strict=True)]
        if self.is_text:
            data = list(map(unhexlify, data))
        found = list(map(Frame, time_s, buses, can_id, extended, data))
        if self.odd:
            return [self.odd.get(place, frame) for place, frame in zip(places.tolist(), found, strict=True)]
        return found

    @cached_property
    def length(self) -> Ints:
        """How many bytes each has; -1 for the odd ones."""
        length = self.stop - self.start
        length //= 1 + self.is_text
        length[list(self.odd)] = -1
        return length

    def words(self, places: Ints, byte: Ints) -> Words:
        """Eight bytes, from one of their bytes on, of each of the frames in these places, as little-endian numbers.

        What lies beyond a frame's end is anything.
        """
        begin = self.start[places] + (1 + self.is_text) * byte
        if not self.is_text:
            words: Words = self._windows[begin]
            return words
        return _bytes_of(self._windows[begin]) | _bytes_of(self._windows[begin + 8]) << np.uint64(32)

    @cached_property
    def _windows(self) -> Words:
        """From each place in the payload on eight bytes, as little-endian numbers; beyond its end there are zeros."""
        padded = self.payload + bytes(_AHEAD)
        return np.ndarray(len(padded) - 7, dtype="<u8", buffer=padded, strides=(1,))

    @cached_property
    def errors(self) -> list[int]:
        """The places of error frames, rising."""
        return sorted(place for place, frame in self.odd.items() if frame.kind is FrameKind.ERROR)

    @cached_property
    def is_data(self) -> Bools:
        """Which are data frames."""
        are = np.ones(len(self), dtype=np.bool_)
        are[[place for place, frame in self.odd.items() if frame.kind is not FrameKind.DATA]] = False
        return are

    @cached_property
    def identifiers(self) -> tuple[list[Identifier], Ints]:
        """The distinct identifiers, of whatever kind of frame, and the place of each frame's among them."""
        codes = self.bus << 30 | self.extended.astype(np.int64) << 29 | self.can_id
        ordered = np.sort(codes)
        distinct = ordered[np.diff(ordered, prepend=-1) != 0]
        named = [
            (self.buses[code >> 30], bool(code >> 29 & 1), code & LARGEST_EXTENDED_ID) for code in distinct.tolist()
        ]
        return named, np.searchsorted(distinct, codes)

    def identified(self, which: Bools) -> dict[Identifier, int]:
        """The identifiers of some frames, in the order in which they first come, and of how many frames each is."""
        named, places = self.identifiers
        place = places[which]
        first = np.full(len(named), len(place))
        first[place[::-1]] = np.arange(len(place))[::-1]  # of several the last one stays
        times = np.bincount(indices(place), minlength=len(named)).tolist()
        return {named[k]: times[k] for k in np.argsort(first).tolist() if times[k]}

    @cached_property
    def last_on_bus(self) -> list[tuple[str, Ints]]:
        """For each bus and each place the place of the last frame so far that was on it; -1 before the first."""
        places = np.arange(len(self))
        return [
            (name, np.maximum.accumulate(np.where(self.bus == number, places, -1)))
            for number, name in enumerate(self.buses)
        ]


def _bytes_of(characters: Words) -> Words:
    """Four bytes each of eight hexadecimal digits; the first is in the lowest place."""
    letters = characters >> np.uint64(6) & np.uint64(0x0101010101010101)
    digits = (characters & np.uint64(0x0F0F0F0F0F0F0F0F)) + letters * np.uint64(9)
    pairs = (digits << np.uint64(4) | digits >> np.uint64(8)) & np.uint64(0x00FF00FF00FF00FF)
    fours = (pairs | pairs >> np.uint64(8)) & np.uint64(0x0000FFFF0000FFFF)
    return (fours | fours >> np.uint64(16)) & np.uint64(0xFFFFFFFF)
