"""The frames of one message, many at once: what `MappedSignal.convert` and `ordinary_frame` do, as array arithmetic.

Every number is the same to the last bit, to which a test holds them: NumPy's integers and doubles go through the very
operations that Python's do. Signals for which that would not hold are left to the way of the single frame: those of
multiplexed messages, those with more bits than a double, and those that spread over nine bytes.
"""

from math import inf, isnan
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from brake_monitor.dbc import SignalField
from brake_monitor.frame_block import Bools, Bytes, Floats, Ints
from brake_monitor.routing import MappedSignal, Route
from brake_monitor.samples import Quality

_WORD_BITS = 64
_WORD_BYTES = 8
_EXACT = 1 << 53  # up to here an integer is a double
_FLOATS = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}

Raw = NDArray[Any]  # of int64 or float64


class Payloads:
    """The data of frames of one length."""

    def __init__(self, data: Bytes) -> None:
        """`data` has the shape (frames, bytes)."""
        self._length = data.shape[1]
        missing = max(_WORD_BYTES - self._length, 0)
        self._data = np.pad(data, ((0, 0), (0, missing))) if missing else data
        self._words: dict[tuple[int, bool], NDArray[np.uint64]] = {}

    def __len__(self) -> int:
        return len(self._data)

    def raw(self, field: SignalField) -> Raw:
        """The raw numbers of a signal, for which `are_columns` holds, of all frames."""
        byte = _first_byte(field, self._length)
        skipped = 8 * byte
        shift = _WORD_BITS - (field.end - skipped) if field.is_big_endian else field.end - field.length - skipped
        bits = self._word(byte, field.is_big_endian) >> np.uint64(shift) & np.uint64((1 << field.length) - 1)
        if field.is_float:
            unsigned, kind = _FLOATS[field.length]
            return bits.astype(unsigned).view(kind).astype(np.float64)
        raw = bits.astype(np.int64)
        if field.is_signed:
            sign = 1 << (field.length - 1)
            return (raw ^ sign) - sign
        return raw

    def _word(self, byte: int, is_big_endian: bool) -> NDArray[np.uint64]:
        """Eight bytes of each frame as a number."""
        key = byte, is_big_endian
        if key not in self._words:
            part = np.ascontiguousarray(self._data[:, byte : byte + _WORD_BYTES])
            self._words[key] = part.view(">u8" if is_big_endian else "<u8").ravel().astype(np.uint64)
        return self._words[key]


class MessageColumns(NamedTuple):
    """What is needed of a route to take its frames together."""

    entries: tuple[MappedSignal, ...]
    length: int  # bytes
    counter: SignalField | None

    @classmethod
    def of(cls, route: Route) -> Self | None:
        """None where the message's frames have to be taken one by one."""
        length, counter = route.message.length, route.counter_field
        fields = [entry.field for entry in route.entries]
        if not all(are_columns(field, length) for field in (fields if counter is None else [*fields, counter])):
            return None
        return cls(route.entries, length, counter)

    def decode(self, payloads: Payloads, counter_is_good: Bools) -> tuple[Floats, Ints]:
        """The values and qualities of all signals in whole frames; shape (frames, entries)."""
        shape = len(payloads), len(self.entries)
        values, qualities = np.empty(shape), np.empty(shape, dtype=np.int64)
        raws = [payloads.raw(entry.field) for entry in self.entries]
        with np.errstate(over="ignore", invalid="ignore"):
            for k, (entry, raw) in enumerate(zip(self.entries, raws, strict=True)):
                physical, values[:, k] = _values(entry, raw, adds_nothing=False)
                qualities[:, k] = _qualities(entry, raw, physical)
                if entry.counter:
                    qualities[~counter_is_good, k] = Quality.BAD_COUNTER
            usual = counter_is_good & (qualities == Quality.GOOD).all(axis=1)
            if not usual.all():
                for k, (entry, raw) in enumerate(zip(self.entries, raws, strict=True)):
                    _, values[~usual, k] = _values(entry, raw[~usual], adds_nothing=True)
        return values, qualities


def are_columns(field: SignalField, length: int) -> bool:
    """Whether a signal of a message of so many bytes can be taken of many frames at once."""
    reach = field.end - 8 * _first_byte(field, length)
    largest = 1 << field.length
    numbers = (0 if field.is_float else largest, field.scale, field.offset, largest * field.scale)
    sums = (largest * field.scale + field.offset, *field.not_available)
    exact = all(abs(number) <= _EXACT for number in (*numbers, *sums) if isinstance(number, int))
    return exact and reach <= _WORD_BITS and not field.conditions


def _first_byte(field: SignalField, length: int) -> int:
    """Where the eight bytes begin that a signal is read from."""
    return min((field.end - field.length) // 8, max(length - _WORD_BYTES, 0))


def _values(entry: MappedSignal, raw: Raw, *, adds_nothing: bool) -> tuple[Raw, Floats]:
    """The physical and the SI values. Adding an offset of nothing makes 0 of -0, and is left out of ordinary frames."""
    field = entry.field
    physical: Raw = raw * field.scale
    if field.offset or adds_nothing:
        physical = physical + field.offset
    value: Floats = physical * entry.gain
    if entry.bias or adds_nothing:
        value = value + entry.bias
    if entry.minimum > -inf:
        value = np.where(value < entry.minimum, entry.minimum, value)
    if entry.maximum < inf:
        value = np.where(value > entry.maximum, entry.maximum, value)
    return physical, value


def _qualities(entry: MappedSignal, raw: Raw, physical: Raw) -> Ints:
    field = entry.field
    good = (field.minimum <= physical) & (physical <= field.maximum)
    if field.is_float:
        good &= np.isfinite(physical)
    quality = np.where(good, Quality.GOOD, Quality.OUT_OF_RANGE)
    absent = raw >= entry.no_data_from if not isnan(entry.no_data_from) else np.zeros(len(raw), dtype=np.bool_)
    for code in field.not_available:
        absent |= raw == code
    if field.is_float:
        absent |= np.isnan(raw)
    quality[absent] = Quality.NOT_AVAILABLE
    return quality
