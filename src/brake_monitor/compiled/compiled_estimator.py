"""An estimator that takes many samples at once: what is ordinary its compiled core, the rest itself, one by one."""

from bisect import bisect_left

import numpy as np

from brake_monitor.compiled.compiled_core import CompiledCore, SampleColumns
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.estimation.core import ELSE, TAKEN
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Quality, Sample


class CompiledEstimator:
    """Takes the samples of recordings for an estimator, which is always as if it had taken them one by one."""

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self._compiled = CompiledCore(estimator.core)
        self._is_ahead = False  # of the estimator
        self._changes = -1  # the estimator's when both had the same numbers
        self._aside = np.array([told.tells == ELSE for told in estimator.core.channels], dtype=np.bool_)
        self._block: SampleBlock | None = None
        self._columns: SampleColumns
        self._others: list[Sample] = []  # that tell the filter nothing ...
        self._places: list[int] = []  # ... and where they are

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places; the place of the last one that was fused."""
        if samples is not self._block:
            self._begin(samples)
        estimator, fused, place = self._estimator, None, begin
        while place < end:
            if estimator.changes != self._changes:
                assert not self._is_ahead  # else what was done since would be lost
                self._compiled.load()
                self._changes = estimator.changes
            played, glances = self._compiled.play(self._columns, place, end)
            self._is_ahead = True
            for glance in glances:
                estimator.protections.see(glance)
            for other in self._others[bisect_left(self._places, place) : bisect_left(self._places, played.place)]:
                estimator.take_aside(other)
            if played.fused >= 0:
                fused = played.fused
            place = played.place
            if played.outcome != TAKEN:
                self.settle()
                if estimator.conclude(played.outcome, samples.sample(place)):
                    fused = place
                place += 1
        return fused

    def settle(self) -> None:
        """Let the estimator know what its compiled core has done."""
        if self._is_ahead:
            self._compiled.store()
            self._is_ahead = False

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator would say."""
        if self._is_ahead:
            return self._estimator.state(self._compiled.findings, time_s)
        return self._estimator.estimate(time_s)

    def _begin(self, samples: SampleBlock) -> None:
        self._block = samples
        is_good = samples.quality == Quality.GOOD
        no_row = np.full(len(samples), -1, dtype=np.int64)
        self._columns = SampleColumns(samples.channel, samples.time_s, samples.value, is_good, no_row)
        places = np.flatnonzero(self._aside[samples.channel] & is_good)
        self._others, self._places = samples.at(places), places.tolist()
