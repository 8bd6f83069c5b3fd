"""What has been published: the newest under every key for late joiners, estimates and alarms by range of time."""

import threading
from collections.abc import Callable, Iterator

from msgspec import Struct

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.processing.at_hand import AtHand
from brake_monitor.publishing.encoding import Format
from brake_monitor.publishing.payloads import (
    AdhesionMessage,
    AlarmMessage,
    AxleAdhesionMessage,
    FrictionMessage,
    Message,
)
from brake_monitor.settings.key_space import KeySpace

ESTIMATES_KEPT = 3000  # five minutes at 10 Hz
ALARMS_KEPT = 1000

Meant = Callable[[str], bool]  # whether a question means a key


class Payload(Struct, frozen=True):
    """Bytes and what they are."""

    encoding: Format
    content: bytes


class PublishedEstimate(Struct, frozen=True):
    """An estimate as it was published."""

    estimate: Estimate
    sequence: int
    publish_time_s: float

    @property
    def time_s(self) -> float:
        """When it was captured."""
        return self.estimate.time_s

    def messages(self, keys: KeySpace, meant: Meant = lambda key: True) -> Iterator[tuple[str, Message]]:
        """What is published of it under every key that is meant."""
        stamp = (self.sequence, self.publish_time_s)
        if meant(keys.adhesion):
            yield keys.adhesion, AdhesionMessage.of(self.estimate, *stamp)
        for i in range(1, len(self.estimate.wheelsets) + 1):
            if meant(keys.friction(i)):
                yield keys.friction(i), FrictionMessage.of(self.estimate, i, *stamp)
            if meant(keys.axle_adhesion(i)):
                yield keys.axle_adhesion(i), AxleAdhesionMessage.of(self.estimate, i, *stamp)


class Published:
    """Written by the thread that publishes, read by the one that answers."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._current: dict[str, Payload] = {}
        self._estimates = AtHand(PublishedEstimate, ESTIMATES_KEPT)
        self._alarms: dict[str, tuple[str, AlarmMessage]] = {}  # key and newest state of each, by id

    def set(self, key: str, payload: Payload | None) -> None:
        """Note the newest under a key; None when there is nothing to tell late joiners."""
        with self._lock:
            if payload is None:
                self._current.pop(key, None)
            else:
                self._current[key] = payload

    def add(self, estimate: PublishedEstimate) -> None:
        """Note an estimate for those who ask for a range of time."""
        with self._lock:
            self._estimates.add([estimate])

    def add_alarm(self, key: str, alarm: AlarmMessage) -> None:
        """Note how an alarm stands now."""
        with self._lock:
            self._alarms[alarm.id] = (key, alarm)
            if len(self._alarms) > ALARMS_KEPT:
                cleared = (name for name, (_, kept) in self._alarms.items() if kept.state == "cleared")
                del self._alarms[next(cleared, next(iter(self._alarms)))]

    def clear(self) -> None:
        """Nothing has been published after all."""
        with self._lock:
            self._current.clear()
            self._alarms.clear()

    def current(self) -> dict[str, Payload]:
        """The newest under every key."""
        with self._lock:
            return dict(self._current)

    def estimates(self, from_s: float, to_s: float, limit: int) -> list[PublishedEstimate]:
        """The newest `limit` estimates captured in [from_s, to_s], oldest first."""
        with self._lock:
            found = self._estimates.between(from_s, to_s)
        return found.newest(limit)

    def alarms(self, from_s: float, to_s: float) -> list[tuple[str, AlarmMessage]]:
        """All alarms that were open at some time in [from_s, to_s], with their keys, oldest first."""
        with self._lock:
            kept = [entry for entry in self._alarms.values() if _was_open(entry[1], from_s, to_s)]
        return sorted(kept, key=lambda entry: entry[1].raised_time_s)

    def open_alarms(self) -> dict[str, tuple[str, AlarmMessage]]:
        """Key and newest state of each open alarm, by id."""
        with self._lock:
            return {name: entry for name, entry in self._alarms.items() if entry[1].state == "open"}


def _was_open(alarm: AlarmMessage, from_s: float, to_s: float) -> bool:
    return alarm.raised_time_s <= to_s and (alarm.cleared_time_s is None or alarm.cleared_time_s >= from_s)
