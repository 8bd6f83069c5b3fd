"""The newest entries of a stream, packed: in a seventh of the memory of single estimates, a tenth of frames'."""

import zlib
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from math import inf
from typing import Generic, Protocol, TypeVar

from msgspec import msgpack

ENTRIES_IN_BLOCK = 64
_FASTEST = 1  # of zlib's levels; others save little more


class Timed(Protocol):
    """What has a time."""

    @property
    def time_s(self) -> float:
        """When it was captured."""


T = TypeVar("T", bound=Timed)


@dataclass(frozen=True, slots=True)
class Block(Generic[T]):
    """Successive entries, packed."""

    content: bytes
    decoder: msgpack.Decoder[list[T]]
    count: int
    begin_s: float  # the least and the greatest of their times
    end_s: float

    def __iter__(self) -> Iterator[T]:
        return iter(self.decoder.decode(zlib.decompress(self.content)))


@dataclass(frozen=True, slots=True)
class Span(Generic[T]):
    """The entries of a span of time, unpacked as they are read. Spans that overlap share their blocks."""

    blocks: tuple[Block[T], ...]
    begin_s: float
    end_s: float

    def __iter__(self) -> Iterator[T]:
        return chain.from_iterable(map(self._within, self.blocks))

    def newest(self, count: int) -> list[T]:
        """The last so many, oldest first."""
        found: list[T] = []
        for block in reversed(self.blocks):
            if len(found) >= count:
                break
            found = self._within(block) + found
        return found[-count:]

    def _within(self, block: Block[T]) -> list[T]:
        return [entry for entry in block if self.begin_s <= entry.time_s <= self.end_s]


def entry_count(spans: Iterable[Span[T]]) -> int:
    """How many entries the blocks of the spans hold in memory; a block in several spans counts once."""
    return sum(block.count for block in {id(block): block for span in spans for block in span.blocks}.values())


class AtHand(Generic[T]):
    """What arrived last. Time is the entries' own."""

    def __init__(self, kind: type[T], most: int) -> None:
        """`kind`: the type of the entries; an entry with `most` or more newer ones may be dropped, with its block."""
        self._most = most
        self._encode = msgpack.Encoder().encode
        self._decoder = msgpack.Decoder(list[kind])  # type: ignore[valid-type]
        self._blocks: deque[Block[T]] = deque()
        self._loose: list[T] = []  # newer than all blocks
        self._packed = 0

    def add(self, entries: Iterable[T]) -> None:
        """Take what arrived."""
        self._loose.extend(entries)
        while len(self._loose) >= ENTRIES_IN_BLOCK:
            self._pack(ENTRIES_IN_BLOCK)

    def forget_before(self, time_s: float) -> None:
        """Drop blocks that end before `time_s`."""
        while self._blocks and self._blocks[0].end_s < time_s:
            self._forget_block()

    def keep_near(self, time_s: float, within_s: float) -> None:
        """Keep only what is within `within_s` of `time_s`, wherever it stands: a clock was set."""
        old = self.between(-inf, inf).blocks
        self._blocks.clear()
        self._packed = 0
        for block in old:
            self.add(entry for entry in block if abs(entry.time_s - time_s) < within_s)

    def between(self, begin_s: float, end_s: float) -> Span[T]:
        """The entries between these times, both included."""
        if self._loose:
            self._pack(len(self._loose))
        near = (block for block in self._blocks if block.end_s >= begin_s and block.begin_s <= end_s)
        return Span(tuple(near), begin_s, end_s)

    def _pack(self, count: int) -> None:
        entries, self._loose = self._loose[:count], self._loose[count:]
        times_s = [entry.time_s for entry in entries]
        content = zlib.compress(self._encode(entries), _FASTEST)
        self._blocks.append(Block(content, self._decoder, count, min(times_s), max(times_s)))
        self._packed += count
        while self._packed - self._blocks[0].count >= self._most:
            self._forget_block()

    def _forget_block(self) -> None:
        self._packed -= self._blocks.popleft().count
