"""When a channel that says nothing good any more is told to be stale."""

from bisect import bisect_left
from collections.abc import Sequence
from math import inf, nan

import numpy as np

from brake_monitor.arrays import Bools, Floats, indices
from brake_monitor.decoding.mapped_signal import MappedSignal
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame import CLOCK_STEP_S
from brake_monitor.samples import Quality, Sample


class TimeOuts:
    """Watches `good_s` of all mapped signals."""

    def __init__(self, entries: Sequence[MappedSignal]) -> None:
        self._entries = [(entry, entry.channel.timeout_s) for entry in entries]
        self._next_look_s = -inf  # before it no channel can lapse
        self._last_time_s = -inf

    def expire(self, time_s: float) -> list[Sample]:
        """See `SignalDecoder.expire`."""
        if time_s < self._last_time_s:
            self._next_look_s = -inf  # what becomes good now lapses sooner
            if self.is_set_back(time_s):
                for entry, _ in self._entries:
                    entry.good_s = -inf
        self._last_time_s = time_s
        if time_s < self._next_look_s:
            return []
        lapsed, next_look_s = [], inf
        for entry, timeout_s in self._entries:
            good_s = entry.good_s
            if good_s == -inf:
                entry.good_s = good_s = time_s
            elif good_s + timeout_s <= time_s:
                entry.good_s = good_s = inf
                lapsed.append(Sample(time_s, entry.channel.quantity, entry.channel.wheelset, nan, Quality.STALE))
            # What becomes good from now on lapses a time-out after now at the soonest.
            may_lapse_s = (good_s if good_s < time_s else time_s) + timeout_s
            next_look_s = may_lapse_s if may_lapse_s < next_look_s else next_look_s
        self._next_look_s = next_look_s
        return lapsed

    def is_set_back(self, time_s: float) -> bool:
        """Whether the clock was, if the next frame has this time."""
        return time_s < self._last_time_s - CLOCK_STEP_S

    def pass_over(self, time_s: float, next_look_s: float) -> None:
        """Note that there was nothing to tell until `time_s`, nor can be before `next_look_s`."""
        self._last_time_s, self._next_look_s = time_s, next_look_s


class Passage:
    """How long each channel is good while the samples of a block pass, one frame with samples after the other.

    It begins with the entries as they are, and is right as long as nothing but the samples makes a channel good or
    lapsed: after anything else another one has to be begun.
    """

    def __init__(
        self, time_outs: TimeOuts, entries: Sequence[MappedSignal], samples: SampleBlock, first_frame: int
    ) -> None:
        """`entries` in the order of the samples' channels."""
        self._time_outs = time_outs
        self._entries = entries
        self._first_frame = first_frame
        time_s = samples.frame_times_s
        good = samples.quality == Quality.GOOD
        number = np.repeat(np.arange(len(time_s)), indices(np.diff(samples.first)))
        good &= number >= first_frame
        last_good = np.full((len(entries), len(time_s)), -1)
        last_good[samples.channel[good], number[good]] = number[good]
        last_good = np.maximum.accumulate(last_good, axis=1)
        before_s = np.array([entry.good_s for entry in entries])[:, np.newaxis]
        timeout_s = np.array([entry.channel.timeout_s for entry in entries])[:, np.newaxis]
        self._good_s = np.where(last_good >= 0, time_s[last_good], before_s)
        self._times_s = samples.listed_frame_times_s
        self._looks_s: Floats = (np.minimum(self._good_s, time_s) + timeout_s).min(axis=0)  # when to look next
        ends: Bools = (self._good_s + timeout_s <= time_s).any(axis=0)  # where a look would tell
        ends[1:] |= np.diff(time_s) < -CLOCK_STEP_S
        self._ends: list[int] = [*np.flatnonzero(ends).tolist(), len(time_s)]

    def quiet_until(self, frame: int, end: int) -> int:
        """Do what `TimeOuts.expire` does at successive frames with samples, as long as that tells and changes nothing.

        Returns the number of the first frame that is left, `end` if none is.
        """
        if frame < end and self._time_outs.is_set_back(self._times_s[frame]):
            return frame
        left = min(self._ends[bisect_left(self._ends, frame)], end)
        if frame < left:
            self._time_outs.pass_over(self._times_s[left - 1], self._looks_s.item(left - 1))
        return left

    def settle(self, frame: int) -> None:
        """Make the entries what they are when this frame has been decoded."""
        if frame >= self._first_frame:
            for entry, good_s in zip(self._entries, self._good_s[:, frame].tolist(), strict=True):
                entry.good_s = good_s
