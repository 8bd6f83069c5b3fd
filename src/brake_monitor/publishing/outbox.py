"""Events that nobody may miss (alarms, wear): numbered, stamped and kept, so that a restart loses and repeats none.

An advanced subscriber knows what it had of a source by the source's id and the time stamp. Both are kept with each
event: a daemon that starts anew takes up its old id and puts the kept events back into its cache under their old
stamps, and the subscriber takes from them exactly what it has not had.

The stamps are not times; they only count, from 1970 on. A router whose clock is half a second behind ours would replace
stamps of now by its own, and subscribers would no longer know what they had.
"""

import os
from collections.abc import Callable, Iterable, Mapping
from typing import Annotated, Protocol

import msgspec
from msgspec import Meta, Struct

from brake_monitor.publishing.encoding import Format

_STAMPS_PER_START = 1_000_000  # an earlier run may have sent as many that it could not keep

# What Zenoh and the memory take, and so does whatever is counted on from it.
_Source = Annotated[str, Meta(pattern="^[89a-f][0-9a-f]{31}$")]
_Count = Annotated[int, Meta(ge=1, lt=1 << 53)]
_Stamp = Annotated[int, Meta(ge=1, lt=1 << 45)]  # of a year or so, in microseconds
_Key = Annotated[str, Meta(pattern="^[a-z0-9_]+(/[a-z0-9_]+)*$")]


class Event(Struct, frozen=True):
    """One event as it was or will be published."""

    source: _Source  # hexadecimal id of the session that publishes it
    number: _Count  # over all events
    sequences: dict[str, _Count]  # the last of each stream, this event's included
    stamp_us: _Stamp  # counts up; what Zenoh takes for the time
    key: _Key  # below the wagon's
    encoding: Format
    payload: bytes
    over: bool  # whether late joiners need not hear of it any more


class Outbox(Protocol):
    """Keeps the newest events, as opaque messages with growing numbers. Only one thread calls it."""

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep these; WorkError when that cannot be done now. When it returns they are safe from a crash."""

    def kept(self) -> Iterable[bytes]:
        """Every message that is kept, in the order of their numbers."""

    def close(self) -> None:
        """Give back what they are kept in."""


class NoOutbox:
    """The outbox of a daemon without a memory: keeps nothing."""

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep none."""

    def kept(self) -> tuple[bytes, ...]:
        """There is none."""
        return ()

    def close(self) -> None:
        """There is nothing to give back."""


class EventLog:
    """Numbers and stamps events; what was kept of an earlier run goes on behind the last that can be read."""

    def __init__(self, kept: Iterable[bytes], take: Callable[[Event], None] = lambda event: None) -> None:
        """`take` is given each of those that can be read, for there are thousands."""
        self.damaged = 0  # how many kept messages can no longer be read
        damaged_last = 0  # of them, behind all that can be read
        last: Event | None = None
        decoder = msgspec.msgpack.Decoder(Event)
        for message in kept:
            try:
                last = decoder.decode(message)
            except (msgspec.MsgspecError, ValueError):  # ValueError: text that is not UTF-8
                self.damaged += 1
                damaged_last += 1
            else:
                damaged_last = 0
                take(last)
        self.source = last.source if last else f"{int.from_bytes(os.urandom(16)) | 1 << 127:032x}"
        self._number = last.number if last else 0
        self._stamp_us = last.stamp_us + _STAMPS_PER_START if last else 0
        # Whichever stream the damaged ones were of, no sequence is told twice: subscribers see a gap.
        self._sequences = {stream: n + damaged_last for stream, n in last.sequences.items()} if last else {}

    def next_sequence(self, stream: str) -> int:
        """What the next event of a stream is numbered, from 1."""
        return self._sequences.get(stream, 0) + 1

    def skip(self, stream: str, count: int) -> None:
        """Leave a gap that subscribers see: as many events of a stream were lost."""
        self._sequences[stream] = self._sequences.get(stream, 0) + count

    def add(self, stream: str, key: str, payload: bytes, encoding: Format, *, over: bool) -> Event:
        """Make the next event of a stream."""
        self._number += 1
        self._stamp_us += 1
        self._sequences[stream] = self.next_sequence(stream)
        return Event(self.source, self._number, dict(self._sequences), self._stamp_us, key, encoding, payload, over)


def message_of(event: Event) -> bytes:
    """The event as an outbox keeps it."""
    return msgspec.msgpack.encode(event)
