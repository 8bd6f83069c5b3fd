"""One CAN frame as every layer above the bus sees it, and which frames a bus lets through."""

from enum import IntEnum
from typing import NamedTuple, TypedDict

LARGEST_ID, LARGEST_EXTENDED_ID = 0x7FF, 0x1FFFFFFF  # 11 and 29 bits
CLASSIC_LENGTH = 8  # bytes; a frame with more is CAN FD
MOST_LATE_S = 0.05  # captured as much before others that came, a frame is late and still used; else time went back
CLOCK_STEP_S = 1.0  # older than what came before it by more: the clock was set back
YEAR_S = 365.25 * 86400.0  # no bus or recorder pauses for so long: where time goes ahead by more, a clock was set
LATEST_TIME_S = 1e11  # of a capture, in the year 5138; anything later is not a time


class FrameKind(IntEnum):
    """What the frame carries; only DATA frames are decoded, the others are counted."""

    DATA = 0
    REMOTE = 1
    ERROR = 2


class Frame(NamedTuple):
    """A received frame. `time_s` is its capture time: the kernel's stamp or the log's own, in seconds."""

    time_s: float
    bus: str  # the configured name of the bus, not the interface it happens to run on
    can_id: int
    extended: bool
    data: bytes
    kind: FrameKind = FrameKind.DATA


def can_id_digits(can_id: int, extended: bool) -> str:
    """An identifier as candump writes it: three hexadecimal digits, or eight when extended."""
    return f"{can_id:08X}" if extended else f"{can_id:03X}"


def can_id_text(can_id: int, extended: bool) -> str:
    """An identifier as people write it: 320 alone might be decimal."""
    return f"0x{can_id_digits(can_id, extended)}"


class CanFilter(TypedDict):
    """Lets a frame through when `received_id & can_mask == can_id & can_mask`; error frames always come through.

    Made where signals are mapped, applied by the kernel or, of buses that it does not know, as frames arrive.
    """

    can_id: int
    can_mask: int
    extended: bool
