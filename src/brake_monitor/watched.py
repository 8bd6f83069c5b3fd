"""What a watcher knows of a fleet from what it has heard over Zenoh. No clock, no network: time and bytes are given."""

from collections import deque
from typing import Any

import msgspec

from brake_monitor.live_view import Moment
from brake_monitor.payloads import (
    MEDIA_TYPES,
    AdhesionMessage,
    AlarmMessage,
    FrictionMessage,
    HealthMessage,
    WearMessage,
)

LARGEST_PAYLOAD = 100_000  # bytes; ours are far smaller
MOST_WAGONS = 2000
HISTORY = 120  # sparkline bins
BIN_S = 1.0
STALE_S = 3.0
ALARMS_KEPT = 50  # per wagon, cleared ones first to go

_KINDS: dict[str, type] = {"adhesion": AdhesionMessage, "health": HealthMessage}
_AXLE_KINDS: dict[str, type] = {"friction": FrictionMessage, "wear": WearMessage}


class Wagon:
    """The newest that was heard of one wagon."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.alive = False  # its liveliness token is there
        self.heard_s: float | None = None  # when the last estimate came, by the watcher's clock
        self.adhesion: AdhesionMessage | None = None
        self.health: HealthMessage | None = None
        self.friction: dict[int, FrictionMessage] = {}
        self.wear: dict[int, WearMessage] = {}
        self.alarms: dict[str, AlarmMessage] = {}
        self.history: deque[Moment | None] = deque(maxlen=HISTORY)
        self._bin = 0

    def open_alarms(self) -> list[AlarmMessage]:
        """The gravest first, then the newest."""
        still = [alarm for alarm in self.alarms.values() if alarm.state == "open"]
        return sorted(still, key=lambda alarm: (-alarm.severity.rank, -alarm.raised_time_s))

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the last estimate came; None before the first."""
        return None if self.heard_s is None else now_s - self.heard_s

    def is_stale(self, now_s: float) -> bool:
        """Whether what is shown may no longer be so."""
        age_s = self.age_s(now_s)
        return not self.alive or age_s is None or age_s > STALE_S

    def take(self, message: Any, now_s: float) -> None:
        """Note a message of this wagon."""
        match message:
            case AdhesionMessage():
                self.adhesion, self.heard_s = message, now_s
                self._remember(message, now_s)
            case HealthMessage():
                self.health = message
            case FrictionMessage():
                self.friction[message.wheelset] = message
            case WearMessage():
                self.wear[message.wheelset] = message
            case AlarmMessage():
                self.alarms[message.id] = message
                while len(self.alarms) > ALARMS_KEPT:
                    cleared = (name for name, alarm in self.alarms.items() if alarm.state == "cleared")
                    del self.alarms[next(cleared, next(iter(self.alarms)))]

    def _remember(self, message: AdhesionMessage, now_s: float) -> None:
        now = Moment(float("nan") if message.adhesion is None else message.adhesion, message.saturated)
        step = int(now_s // BIN_S) - self._bin
        self._bin += step
        if step or not self.history:
            self.history.extend([None] * min(step - 1, HISTORY) if len(self.history) else [])
            self.history.append(now)
        elif now.saturated or not (self.history[-1] and self.history[-1].saturated):
            self.history[-1] = now


class Watched:
    """A fleet under one prefix. What cannot be understood is counted and left out."""

    def __init__(self, prefix: str) -> None:
        self.wagons: dict[str, Wagon] = {}
        self.not_understood = 0
        self._prefix = f"{prefix}/"

    def take(self, key: str, encoding: str, payload: bytes, now_s: float) -> AlarmMessage | None:
        """Note what was heard; the alarm when it was a change of one that is news."""
        name, _, below = key.removeprefix(self._prefix).partition("/")
        kind = _kind(below.split("/"))
        if kind is None:
            return None
        message = _decoded(kind, encoding, payload)
        wagon = self._wagon(name)
        if message is None or wagon is None:
            self.not_understood += 1
            return None
        is_news = isinstance(message, AlarmMessage) and wagon.alarms.get(message.id) != message
        wagon.take(message, now_s)
        return message if is_news else None

    def lives(self, key: str, alive: bool) -> None:
        """Note that a wagon's daemon came or went."""
        wagon = self._wagon(key.removeprefix(self._prefix))
        if wagon is not None:
            wagon.alive = alive

    def _wagon(self, name: str) -> Wagon | None:
        if name not in self.wagons and len(self.wagons) < MOST_WAGONS and name.isprintable():
            self.wagons[name] = Wagon(name)
        return self.wagons.get(name)


def _kind(chunks: list[str]) -> type | None:
    match chunks:
        case [name]:
            return _KINDS.get(name)
        case ["axle", _, name]:
            return _AXLE_KINDS.get(name)
        case ["alarm", _] | ["alarm", _, _]:
            return AlarmMessage
    return None


def _decoded(kind: type, encoding: str, payload: bytes) -> Any:
    """The message; None when it is none, or would do more to a terminal than to be read."""
    decode = msgspec.msgpack.decode if encoding == MEDIA_TYPES["msgpack"] else msgspec.json.decode
    try:
        message = decode(payload, type=kind) if len(payload) <= LARGEST_PAYLOAD else None
    except (msgspec.MsgspecError, ValueError, RecursionError):
        return None
    return message if all(text.isprintable() for text in _texts(message)) else None


def _texts(message: Any) -> tuple[str, ...]:
    match message:
        case AdhesionMessage():
            return message.reasons
        case AlarmMessage():
            return message.id, message.kind, message.message
        case _:
            return ()
