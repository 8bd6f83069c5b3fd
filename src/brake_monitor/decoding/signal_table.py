"""Signals of several messages as tables, by which many readings of any of them are taken at once.

Every number is the same to the last bit as `MappedSignal.convert` and `ordinary_frame` give it, to which a test holds
them: all integers here are doubles, and the operations are theirs in their order. Signals for which that would not hold
are left to the way of the single frame: those with more bits than a double has, and those that spread over nine bytes.
"""

from collections.abc import Sequence

import numpy as np

from brake_monitor.arrays import Floats, Ints
from brake_monitor.decoding.mapped_signal import MappedSignal, addend
from brake_monitor.decoding.signal_field import SignalField
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import Quality

_WORD_BITS = 64
_EXACT = 1 << 53  # up to here an integer is a double
_LARGEST = np.finfo(np.float64).max
_FLOATS = {16: (np.uint16, np.float16), 32: (np.uint32, np.float32), 64: (np.uint64, np.float64)}


def fits_table(field: SignalField) -> bool:
    """Whether a signal can be taken by a table."""
    largest = 1 << field.length
    is_exact = (field.is_float or largest <= _EXACT) and all(abs(code) <= _EXACT for code in field.not_available)
    multiplexers = [condition.multiplexer for condition in field.conditions]
    is_told = all(fits_table(multiplexer) and not multiplexer.is_float for multiplexer in multiplexers)
    return is_exact and is_told and field.end - 8 * _first_byte(field) <= _WORD_BITS


def _first_byte(field: SignalField) -> int:
    return (field.end - field.length) // 8


class RawTable:
    """Where signals lie in their frames."""

    def __init__(self, fields: Sequence[SignalField]) -> None:
        """All of them fit (`fits_table`)."""
        self._byte = np.array([_first_byte(field) for field in fields], dtype=np.int64)
        begin = np.array([field.end - field.length for field in fields], dtype=np.int64) - 8 * self._byte
        length = np.array([field.length for field in fields], dtype=np.int64)
        self._is_big = np.array([field.is_big_endian for field in fields], dtype=np.bool_)
        self._shift = np.where(self._is_big, _WORD_BITS - begin - length, begin).astype(np.uint64)
        self._mask = np.array([(1 << field.length) - 1 for field in fields], dtype=np.uint64)
        signs = [field.is_signed and not field.is_float and 1 << (field.length - 1) for field in fields]
        self._sign = np.array(signs, dtype=np.int64)
        self._float_length = np.array([field.is_float and field.length for field in fields], dtype=np.int64)
        self._float_lengths = set(self._float_length.tolist()) - {0}

    def raw(self, block: FrameBlock, frame: Ints, signal: Ints) -> Floats:
        """Raw numbers: with each place of a frame that is whole the place of a signal of its."""
        word = block.words(frame, self._byte[signal])
        word = np.where(self._is_big[signal], word.byteswap(), word)
        bits = word >> self._shift[signal] & self._mask[signal]
        sign = self._sign[signal]
        raw = ((bits.astype(np.int64) ^ sign) - sign).astype(np.float64)
        for length in self._float_lengths:
            unsigned, kind = _FLOATS[length]
            which = self._float_length[signal] == length
            with np.errstate(invalid="ignore"):  # a NaN that signals
                raw[which] = bits[which].astype(unsigned).view(kind)
        return raw


class ValueTable:
    """What the raw numbers of mapped signals mean."""

    def __init__(self, entries: Sequence[MappedSignal]) -> None:
        fields = [entry.field for entry in entries]
        self._scale = _doubles([field.scale for field in fields])
        self._offset = _doubles([addend(field.offset) for field in fields])
        self._gain = _doubles([entry.gain for entry in entries])
        self._bias = _doubles([addend(entry.bias) for entry in entries])
        self._clamps = _doubles([entry.minimum for entry in entries]), _doubles([entry.maximum for entry in entries])
        self._least = np.maximum(_doubles([field.minimum for field in fields]), -_LARGEST)
        self._greatest = np.minimum(_doubles([field.maximum for field in fields]), _LARGEST)
        self._is_flag = np.array([entry.is_flag for entry in entries], dtype=np.bool_)
        self._no_data_from = _doubles([entry.no_data_from for entry in entries])
        codes = max((len(field.not_available) for field in fields), default=0)
        self._not_available = np.full((codes, len(fields)), np.nan)
        for place, field in enumerate(fields):
            self._not_available[: len(field.not_available), place] = sorted(field.not_available)

    def convert(self, signal: Ints, raw: Floats) -> tuple[Floats, Ints]:
        """The SI values of readings, and what is to be thought of them."""
        physical = raw * self._scale[signal] + self._offset[signal]
        value = physical * self._gain[signal] + self._bias[signal]
        good = (self._least[signal] <= physical) & (physical <= self._greatest[signal])
        good &= ~self._is_flag[signal] | (value == 0.0) | (value == 1.0)
        absent = (raw >= self._no_data_from[signal]) | np.isnan(raw)
        for codes in self._not_available:
            absent |= raw == codes[signal]
        quality = np.where(good, Quality.GOOD, Quality.OUT_OF_RANGE)
        quality[absent] = Quality.NOT_AVAILABLE
        least, greatest = (clamp[signal] for clamp in self._clamps)
        value = np.where(value < least, least, value)
        return np.where(value > greatest, greatest, value), quality


def _doubles(numbers: Sequence[float]) -> Floats:
    return np.array(numbers, dtype=np.float64)
