"""What is believed of messages that anybody may have sent: nothing too large, impossible or unprintable."""

from collections.abc import Iterable
from typing import Any, TypeVar, get_type_hints

from brake_monitor.frame import LATEST_TIME_S
from brake_monitor.publishing.encoding import NotUnderstoodError, decode, format_of
from brake_monitor.publishing.payloads import (
    AdhesionMessage,
    AlarmMessage,
    FrictionMessage,
    HealthMessage,
    MetaMessage,
    WearMessage,
)
from brake_monitor.settings.bounds import MOST_WHEELSETS

LARGEST_PAYLOAD = 100_000  # bytes; ours are far smaller
LONGEST_TEXT = 1000  # characters
LARGEST_COUNT = 2**63  # of what is counted; whatever is more is no count

T = TypeVar("T")

_KINDS: dict[str, type] = {"adhesion": AdhesionMessage, "health": HealthMessage, "meta": MetaMessage}
_AXLE_KINDS: dict[str, type] = {"friction": FrictionMessage, "wear": WearMessage}
_COUNTS = {
    kind: tuple(name for name, hint in get_type_hints(kind).items() if hint is int)
    for kind in (*_KINDS.values(), *_AXLE_KINDS.values(), AlarmMessage)
}  # fields that are whole numbers, which a message may make as long as it likes


def kind_of(key: str) -> type | None:
    """What stands under a key below the wagon's, as far as watchers ask for it."""
    match key.split("/"):
        case [name]:
            return _KINDS.get(name)
        case ["axle", _, name]:
            return _AXLE_KINDS.get(name)
        case ["alarm", _] | ["alarm", _, _]:
            return AlarmMessage
    return None


def decoded(payload: bytes, kind: type[T], media_type: str, largest: int = LARGEST_PAYLOAD) -> T | None:
    """What the bytes say; None when it is nothing of this kind, or larger than anything of ours."""
    try:
        return decode(payload, kind, format_of(media_type)) if len(payload) <= largest else None
    except NotUnderstoodError:
        return None


def is_sound(message: Any) -> bool:
    """Whether times, counts and numbers of wheelsets can be, and texts are short and do nothing to a terminal."""
    wheelset = getattr(message, "wheelset", None)
    return (
        0.0 <= message.time_s <= LATEST_TIME_S
        and (wheelset is None or 1 <= wheelset <= MOST_WHEELSETS)
        and all(abs(getattr(message, name)) <= LARGEST_COUNT for name in _COUNTS[type(message)])
        and all(len(text) <= LONGEST_TEXT and text.isprintable() for text in _texts(message))
    )


def _texts(message: Any) -> Iterable[str]:
    match message:
        case AdhesionMessage():
            return message.reasons
        case AlarmMessage():
            values = (value for value in message.evidence.values() if isinstance(value, str))
            return (message.id, message.kind, message.message, *message.evidence, *values)
        case HealthMessage():
            return (*message.stale_signals, *message.buses_down, *message.open_alarms)
        case MetaMessage():
            return (message.wagon, message.preset, *message.buses, *message.signals, *message.signals.values())
        case _:
            return ()
