"""Messages ↔ bytes: JSON on one line in UTF-8, or MessagePack; fields by name in both."""

from collections.abc import Callable, Sequence
from typing import Any, Literal, TypeVar

import msgspec
from msgspec import Struct

Format = Literal["json", "msgpack"]
T = TypeVar("T")

MEDIA_TYPES: dict[Format, str] = {"json": "application/json", "msgpack": "application/msgpack"}

_ENCODERS: dict[Format, Callable[[object], bytes]] = {
    "json": msgspec.json.Encoder().encode,
    "msgpack": msgspec.msgpack.Encoder().encode,
}
_DECODERS: dict[Format, Callable[..., Any]] = {"json": msgspec.json.decode, "msgpack": msgspec.msgpack.decode}


class NotUnderstoodError(Exception):
    """The bytes are no message of this kind; the text says why."""


def encode(message: Struct | Sequence[Struct], format: Format = "json") -> bytes:
    """The bytes of a message, or of a list of them, which answers a range of time."""
    return _ENCODERS[format](message)


def decode(payload: bytes, kind: type[T], format: Format) -> T:
    """What `encode` made bytes of; NotUnderstoodError when they are nothing of this kind."""
    try:
        message: T = _DECODERS[format](payload, type=kind)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:  # a text that is not UTF-8 is a ValueError
        raise NotUnderstoodError(str(error)) from None
    return message


def format_of(media_type: str) -> Format:
    """The format of a payload that comes with this media type."""
    return "msgpack" if media_type == MEDIA_TYPES["msgpack"] else "json"
