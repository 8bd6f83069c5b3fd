"""The raw number of a signal in the bytes of a frame: shifts and masks over the bytes taken as one number."""

import struct
from collections.abc import Callable
from functools import partial

from cantools.database.can import Signal

FLOAT_FORMATS = {16: ">e", 32: ">f", 64: ">d"}  # by length in bits


def extent(signal: Signal) -> tuple[int, int]:
    """Return the first bit and the one past the last, counted along the bytes in the signal's own bit order."""
    first = signal.start
    # A big-endian one starts at its most significant bit; DBC numbers the bits of a byte from 0 up.
    if signal.byte_order == "big_endian":
        first = 8 * (first // 8) + 7 - first % 8
    return first, first + signal.length


def integers(length: int, is_signed: bool) -> tuple[int, int]:
    """Return the least and the greatest of so many bits."""
    least = -(1 << (length - 1)) if is_signed else 0
    return least, least + (1 << length) - 1


def raw_of(signal: Signal) -> Callable[[bytes], float | None]:
    """Return what gives the raw number of a signal in a frame's bytes; None when the frame is too short for it."""
    first, last = extent(signal)
    mask = (1 << signal.length) - 1
    needed_bytes = -(-last // 8)
    if signal.byte_order == "little_endian":
        unsigned = partial(_intel, first, mask, needed_bytes)
    else:
        unsigned = partial(_motorola, last, mask, needed_bytes)
    if signal.is_float:
        return partial(_as_float, unsigned, FLOAT_FORMATS[signal.length], signal.length // 8)
    if signal.is_signed:
        return partial(_as_signed, unsigned, 1 << (signal.length - 1))
    return unsigned


def _intel(shift: int, mask: int, needed_bytes: int, data: bytes) -> int | None:
    if len(data) < needed_bytes:
        return None
    return int.from_bytes(data, "little") >> shift & mask


def _motorola(last: int, mask: int, needed_bytes: int, data: bytes) -> int | None:
    size = len(data)
    if size < needed_bytes:
        return None
    return int.from_bytes(data, "big") >> (8 * size - last) & mask


def _as_signed(unsigned: Callable[[bytes], int | None], sign_bit: int, data: bytes) -> int | None:
    raw = unsigned(data)
    return None if raw is None else (raw ^ sign_bit) - sign_bit


def _as_float(unsigned: Callable[[bytes], int | None], layout: str, size: int, data: bytes) -> float | None:
    raw = unsigned(data)
    if raw is None:
        return None
    value: float = struct.unpack(layout, raw.to_bytes(size, "big"))[0]  # no struct.Struct: that cannot be copied
    return value
