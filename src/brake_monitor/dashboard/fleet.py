"""What the dashboard knows of a fleet: what a watcher knows, and the last minutes of every wagon."""

import threading
from typing import Any

from brake_monitor.dashboard.recent import Recent
from brake_monitor.desk.foreign_message import decoded, is_sound
from brake_monitor.desk.watched import Watched
from brake_monitor.publishing.payloads import AdhesionMessage, AlarmMessage, FrictionMessage

MOST_WAGONS = 400  # whose curves are kept, some 0.3 MB each with two wheelsets
LARGEST_ANSWER = 4_000_000  # bytes of a list from the past


class Fleet:
    """Told by the threads that hear, looked at by the one that serves; whoever does either holds `lock`."""

    def __init__(self, prefix: str) -> None:
        self.lock = threading.Lock()
        self.prefix = prefix
        self.watched = Watched(prefix)
        self.recent: dict[str, Recent] = {}
        self.heard = 0  # messages
        self.is_connected = False  # to a router or daemon ...
        self.was_connected = False  # ... now or ever
        self.looked_at: str | None = None  # the wagon whose page was opened last

    def note_connection(self, *, is_connected: bool) -> None:
        """Note whether a router or daemon answers."""
        self.is_connected = is_connected
        self.was_connected |= is_connected

    def take(self, key: str, encoding: str, payload: bytes, now_s: float) -> None:
        """Note what was heard."""
        self.heard += 1
        heard = self.watched.understood(key, encoding, payload)
        if heard is None:
            return
        wagon, message = heard
        wagon.take(message, now_s)
        recent = self._recent(wagon.name)
        if recent is None:
            return
        if isinstance(message, AdhesionMessage):
            recent.take(message)
        elif isinstance(message, FrictionMessage):
            recent.take_wheelset(message)

    def take_past(self, name: str, answers: list[tuple[str, str, bytes]]) -> float | None:
        """Note what is older than what is known of a wagon: lists of estimates, as a range of time is answered with.

        The time of the oldest; None when there was none.
        """
        wagon: list[AdhesionMessage] = []
        wheelsets: list[FrictionMessage] = []
        for key, encoding, payload in answers:
            if key.endswith("/adhesion") and "/axle/" not in key:
                wagon += self._list(AdhesionMessage, encoding, payload)
            elif key.endswith("/friction"):
                wheelsets += self._list(FrictionMessage, encoding, payload)
        recent = self._recent(name) if name in self.watched.wagons else None
        if recent is not None:
            recent.precede(wagon, wheelsets)
        return min((message.time_s for message in wagon), default=None)

    def is_alive(self, name: str) -> bool:
        """Whether a wagon's daemon lives, as far as was heard."""
        wagon = self.watched.wagons.get(name)
        return wagon is not None and wagon.alive

    def take_alarms(self, name: str, answers: list[tuple[str, str, bytes]], now_s: float) -> None:
        """Note the alarms that a daemon knows, those that are over as well."""
        wagon = self.watched.wagons.get(name)
        if wagon is None:
            return
        alarms = [alarm for _, encoding, payload in answers for alarm in self._list(AlarmMessage, encoding, payload)]
        for alarm in sorted(alarms, key=lambda alarm: alarm.sequence):
            wagon.take(alarm, now_s)

    def _recent(self, name: str) -> Recent | None:
        if name not in self.recent and len(self.recent) < MOST_WAGONS:
            self.recent[name] = Recent()
        return self.recent.get(name)

    def _list(self, kind: Any, encoding: str, payload: bytes) -> list[Any]:
        messages: list[Any] | None = decoded(payload, list[kind], encoding, LARGEST_ANSWER)
        if messages is None:
            self.watched.not_understood += 1
            return []
        sound = [message for message in messages if is_sound(message)]
        self.watched.not_understood += len(messages) - len(sound)
        return sound
