"""The counter that a sender advances by one in each frame of a message, so that a receiver notices when it froze."""

from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats, Ints
from brake_monitor.decoding.signal_field import SignalField
from brake_monitor.errors import InputError

_LEAST_COUNTER = 3  # numbers: with fewer, forward and back are the same


class RollingCounter:
    """Judges the frames of one message by their counter.

    Compared with the frame before, modulo the counter's range:

    - +1: good.
    - 0: the sender repeats an old frame (it froze, or a gateway plays its buffer): bad.
    - +2 to half the range: frames were lost on the way, this one is new: good, and the loss is counted. A wagon's
      bus loses frames now and then; refusing the first one after each gap would only lengthen the gap.
    - more than half: it stepped back, or the sender started anew: bad once, then counted from there.

    The first frame is good, and so is the first after a silence longer than the time-out, or after a step back of
    the clock: there is nothing to compare it with.
    """

    def __init__(self, field: SignalField, timeout_s: float) -> None:
        """It runs from the lowest raw number of its signal to the highest, and then from the lowest again."""
        self.field = field
        self._lowest, self._highest = field.raw_range()
        self._timeout_s = timeout_s
        self._size = self._highest - self._lowest + 1
        self._furthest = max(1, self._size // 2)  # that it may advance by
        self._last: int | None = None
        self._last_time_s = -inf

    def check(self, time_s: float, data: bytes) -> tuple[bool, int]:
        """Return whether the frame is good, and how many frames before it were lost."""
        raw = self.field.raw_of(data)
        if raw is None or not self._lowest <= raw <= self._highest:
            return False, 0
        count, last, passed_s = int(raw), self._last, time_s - self._last_time_s
        self._last, self._last_time_s = count, time_s
        if last is None or not 0.0 <= passed_s <= self._timeout_s:
            return True, 0
        advance = (count - last) % self._size
        if 1 <= advance <= self._furthest:
            return True, advance - 1
        return False, 0

    def check_all(self, time_s: Floats, raw: Ints) -> tuple[Bools, int]:
        """Return which of successive frames are good, as `check` says of each, and how many were lost.

        `raw` are their counters, below 0 where a frame is too short for it.
        """
        good = (raw >= self._lowest) & (raw <= self._highest)
        there = np.flatnonzero(good)
        if not len(there):
            return good, 0
        times_s, counts = time_s[there], raw[there]
        last = int(counts[0]) if self._last is None else self._last
        passed_s = np.diff(times_s, prepend=self._last_time_s)
        advance = np.diff(counts, prepend=last) % self._size
        self._last, self._last_time_s = int(counts[-1]), float(times_s[-1])
        is_comparable = (passed_s >= 0.0) & (passed_s <= self._timeout_s)
        advances = (advance >= 1) & (advance <= self._furthest)
        good[there] = advances | ~is_comparable
        return good, int((advance - 1)[advances & is_comparable].sum())


def as_counter(field: SignalField) -> SignalField:
    """The signal that is named as a message's rolling counter; InputError when it cannot be one."""
    if fault := _no_counter(field):
        raise InputError(
            f'signal "{field.name}" cannot be a rolling counter: it {fault}, expected a whole number of two bits or '
            "more, without sign, in every frame"
        )
    return field


def _no_counter(field: SignalField) -> str:
    """Why it cannot be a rolling counter; "" where it may be one."""
    if field.is_float:
        return "is a floating-point number"
    if field.is_signed:
        return "has a sign"
    if field.conditions:
        return "is on one page of several"
    if field.scale % 1.0:
        return f"has steps of {field.scale:g}"
    lowest, highest = field.raw_range()
    numbers = max(highest - lowest + 1, 0)
    return f"has only {numbers} numbers" if numbers < _LEAST_COUNTER else ""
