"""Samples of sensors that lag, many at once: in the order of the instants that they tell of, not of their arrival."""

from bisect import bisect_left
from collections.abc import Sequence

import numpy as np

from brake_monitor.arrays import Ints
from brake_monitor.decoding.sample_block import Columns, SampleBlock
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.processing.block_taker import BlockTaker, OneByOne
from brake_monitor.samples import Quality, Sample


class AlignedTaker:
    """Puts samples in order for a taker, by the thousand, as `Alignment` does one by one."""

    def __init__(self, estimator: Estimator, taker: BlockTaker) -> None:
        """`taker`: of this estimator; it takes samples as they are given."""
        self._estimator, self._taker, self._one_by_one = estimator, taker, OneByOne(estimator)
        self._delay_s = np.array([channel.delay_s for channel in estimator.channels])
        self._largest = np.array([told.largest for told in estimator.core.channels])
        self._numbers = {channel.measurand: number for number, channel in enumerate(estimator.channels)}
        self._block: SampleBlock | None = None  # as captured
        self._aligned: SampleBlock | None = None  # the same, with what has waited, in order; None: time goes back in it
        self._taken_with: list[int]  # for each aligned sample the place of the one with whose arrival it is taken
        self._impossible: list[int]  # places of samples that do not wait
        self._next = 0  # aligned sample to be taken
        self._end = 0  # of what has arrived, a place in the block

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places, none of them STALE; the place of the one that the last was fused with."""
        if samples is not self._block:
            self._begin(samples, begin)
        if self._aligned is None:
            return self._one_by_one.take(samples, begin, end)
        fused = None
        first, last = bisect_left(self._impossible, begin), bisect_left(self._impossible, end)
        for stop in self._impossible[first:last]:
            fused = self._take_until(self._aligned, stop, fused)
            self._taker.settle()
            self._estimator.take(samples.sample(stop))
        return self._take_until(self._aligned, end, fused)

    def settle(self) -> None:
        """Let the estimator know of them, and of those that wait."""
        self._taker.settle()
        if self._aligned is not None:
            waits = self._next + np.flatnonzero(self._aligned.frame[self._next :] < self._end)
            self._estimator.alignment.give_back(self._aligned.at(waits))
        self._block = self._aligned = None

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator says after them, at time_s; None: as of the last fused one."""
        return self._taker.estimate(time_s)

    def _take_until(self, aligned: SampleBlock, end: int, fused: int | None) -> int | None:
        """Take what is ready before the arrival of the sample in this place; `fused` if none of it is fused."""
        begin, self._next, self._end = self._next, bisect_left(self._taken_with, end), end
        last = self._taker.take(aligned, begin, self._next)
        return fused if last is None else self._taken_with[last]

    def _begin(self, samples: SampleBlock, begin: int) -> None:
        """Put in order what waits, and what is to come of a block."""
        self._block, self._aligned = samples, None
        waiting = self._estimator.alignment.take_over()
        time_s = samples.time_s[begin:]
        if np.any(np.diff(time_s) < 0.0) or (waiting and time_s[0] < waiting[-1].time_s):
            self._estimator.alignment.give_back(waiting)
            return
        is_impossible = (samples.quality == Quality.GOOD) & ~(np.abs(samples.value) <= self._largest[samples.channel])
        self._impossible = np.flatnonzero(is_impossible).tolist()
        self._aligned = self._in_order(waiting, samples, begin + np.flatnonzero(~is_impossible[begin:]))
        ready = begin + np.searchsorted(time_s - np.max(self._delay_s), self._aligned.time_s)
        self._taken_with = np.maximum(ready, self._aligned.frame).tolist()
        self._next = self._end = 0

    def _in_order(self, waiting: Sequence[Sample], samples: SampleBlock, places: Ints) -> SampleBlock:
        """What waits and the samples in these places, as of the instants that they tell of.

        What they have for a frame is the place of arrival in the block, -1 for what waits from before.
        """
        old = Columns.of([(-1, self._numbers[one.measurand], one.value, one.quality) for one in waiting])
        channel = samples.channel[places]
        seen_s = np.concatenate(([one.time_s for one in waiting], samples.time_s[places] - self._delay_s[channel]))
        order = np.argsort(seen_s, kind="stable")
        return SampleBlock(
            samples.channels,
            np.concatenate((old.frame, places))[order],
            seen_s[order],
            np.concatenate((old.channel, channel))[order],
            np.concatenate((old.value, samples.value[places]))[order],
            np.concatenate((old.quality, samples.quality[places]))[order],
        )


def block_taker(estimator: Estimator, taker: BlockTaker) -> BlockTaker:
    """`taker` by itself, or behind what puts samples in order, where those of an estimator wait for others."""
    return AlignedTaker(estimator, taker) if estimator.waits else taker
