"""Numbers in text, eight digits at a time: those of many lines are read with a few operations on 64-bit words.

A word holds the digits' values, one in each byte, the first digit in the lowest. Neighbours are put together in pairs,
the pairs in fours, these in one number; each step is one operation for all.
"""

import numpy as np

from brake_monitor.arrays import Bools, Bytes, Ints, Words

NOT_HEX = 0x80  # the value of a character that is no hexadecimal digit
_DIGITS = 8
_ALL = np.uint64(0xFFFFFFFFFFFFFFFF)
_TENS = 0x7676767676767676  # added to 10 or more, a byte's top bit is set
_TOP_BITS = 0x8080808080808080


def times_us(values: Bytes, opening: Ints, closing: Ints) -> tuple[Ints, Bools]:
    """Whole microseconds of the times between these places, and where there is a time: 1 to 10 digits, a dot, 6 digits.

    `values` has the value of each character.
    """
    widths = closing - opening - 8
    width = int(widths[0]) if len(widths) and (widths == widths[0]).all() else widths
    fraction, seconds = _words(values, closing, 6), _words(values, closing - 7, width)
    is_time = _are_decimal(fraction) & _are_decimal(seconds)
    found = _decimal(seconds)
    for place in (9, 10):  # from the right
        digit = np.where(width >= place, values[closing - 7 - place], 0).astype(np.int64)
        is_time &= digit <= 9
        found += digit * 10 ** (place - 1)
    return found * 1_000_000 + _decimal(fraction), is_time


def identifiers(values: Bytes, end: Ints, width: Ints) -> Ints:
    """Hexadecimal numbers of at most eight digits that end before these places."""
    words = _words(values, end, width)
    pairs = words & 0x00FF00FF00FF00FF
    pairs = pairs << 4 | words >> 8 & 0x00FF00FF00FF00FF
    fours = (pairs << 8 | pairs >> 16) & 0x0000FFFF0000FFFF
    return ((fours << 16 | fours >> 32) & 0xFFFFFFFF).astype(np.int64)


def _decimal(words: Words) -> Ints:
    pairs = (words * 10 + (words >> 8)) & 0x00FF00FF00FF00FF
    fours = (pairs * 100 + (pairs >> 16)) & 0x0000FFFF0000FFFF
    return ((fours * 10_000 + (fours >> 32)) & 0xFFFFFFFF).astype(np.int64)


def _are_decimal(words: Words) -> Bools:
    are: Bools = (words + _TENS) & _TOP_BITS == 0
    return are


def _words(values: Bytes, end: Ints, width: Ints | int) -> Words:
    """The last so many of the eight characters before each of these rising places, zeros before them."""
    if len(end) and end[0] < _DIGITS:
        values, end = np.concatenate((np.zeros(_DIGITS, dtype=np.uint8), values)), end + _DIGITS
    windows: Words = np.ndarray(max(len(values) - _DIGITS + 1, 0), dtype="<u8", buffer=values, strides=(1,))
    left_out = _DIGITS - np.minimum(width, _DIGITS)
    return windows[end - _DIGITS] & _ALL << (8 * left_out).astype(np.uint64)
