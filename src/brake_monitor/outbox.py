"""Events that nobody may miss (alarms, wear): numbered, stamped and kept, so that a restart loses and repeats none.

An advanced subscriber knows what it had of a source by the source's id and the time stamp. Both are kept with each
event: a daemon that starts anew takes up its old id and puts the kept events back into its cache under their old
stamps, and the subscriber takes from them exactly what it has not had.

The stamps are no time, they only count, from 1970 on. A router whose clock is half a second behind ours would replace
stamps of now by its own, and subscribers would no longer know what they had.
"""

import secrets
from collections.abc import Iterable, Mapping
from itertools import islice
from typing import Protocol

import msgspec
from msgspec import Struct

from brake_monitor.payloads import Format

MESSAGES_KEPT = 10_000  # by the memory; each is about 1 kB
_STAMPS_PER_START = 1_000_000  # an earlier run may have sent as many that it could not keep


class Event(Struct, frozen=True):
    """One event as it was or will be published."""

    source: str  # hexadecimal id of the session that publishes it
    number: int  # over all events
    sequences: dict[str, int]  # the last of each stream, this event's included
    stamp_us: int  # counts up; what Zenoh takes for the time
    key: str  # below the wagon's
    encoding: Format
    payload: bytes
    over: bool  # whether late joiners need not hear of it any more


class Outbox(Protocol):
    """Where events are kept: opaque messages with growing numbers, the last of them. Only one thread calls it."""

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep these; WorkError when that cannot be done now. When it returns they are safe from a crash."""

    def kept(self) -> Iterable[bytes]:
        """Every message that is kept, in the order of their numbers."""


class MemoryOutbox:
    """Keeps events as long as the program runs, for when nothing else is configured."""

    def __init__(self) -> None:
        self._messages: dict[int, bytes] = {}

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep these."""
        self._messages |= messages
        for number in list(islice(self._messages, max(0, len(self._messages) - MESSAGES_KEPT))):
            del self._messages[number]

    def kept(self) -> list[bytes]:
        """Every message that is kept, oldest first."""
        return list(self._messages.values())


class EventLog:
    """Numbers and stamps events; what was kept of an earlier run goes on."""

    def __init__(self, kept: Iterable[bytes]) -> None:
        """ValueError when a kept message is none of ours."""
        decoder = msgspec.msgpack.Decoder(Event)
        self.kept = [decoder.decode(message) for message in kept]
        last = self.kept[-1] if self.kept else None
        self.source = last.source if last else f"{secrets.randbits(128) | 1 << 127:032x}"
        self._number = last.number if last else 0
        self._stamp_us = last.stamp_us + _STAMPS_PER_START if last else 0
        self._sequences = dict(last.sequences) if last else {}

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
