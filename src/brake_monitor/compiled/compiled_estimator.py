"""An estimator that takes many samples at once: ordinary ones by its compiled core, the others itself, one by one."""

from bisect import bisect_left

import numpy as np

from brake_monitor.arrays import Floats, Ints
from brake_monitor.compiled.compiled_core import CompiledCore, SampleColumns
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.estimation.core.core import ELSE
from brake_monitor.estimation.core.correction import TAKEN
from brake_monitor.estimation.core.readout import read_out, width
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Quality, Sample


class CompiledEstimator:
    """Takes the samples of recordings for an estimator, which is always as if it had taken them one by one."""

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator
        self._compiled = CompiledCore(estimator.core)
        self._is_ahead = False  # the compiled core is, of the estimator's own
        self._changes = -1  # `Estimator.changes` when both cores last had the same numbers
        self._aside = np.array([told.tells == ELSE for told in estimator.core.channels], dtype=np.bool_)
        self._no_rows: Floats = np.zeros((0, width(estimator.core.wheelset_count)))
        self._block: SampleBlock | None = None
        self._columns: SampleColumns
        self._others: list[Sample] = []  # samples of the block that tell the filter nothing ...
        self._places: list[int] = []  # ... and their places in it

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places, none of them STALE; the place of the last one that was fused."""
        if samples is not self._block:
            self._begin(samples, np.full(len(samples), -1), self._no_rows)
        estimator, fused, place = self._estimator, None, begin
        while place < end:
            if estimator.changes != self._changes:
                assert not self._is_ahead  # else what was done since would be lost
                self._compiled.load()
                self._changes = estimator.changes
            played = self._compiled.play(self._columns, place, end)
            self._is_ahead = True
            for other in self._others[bisect_left(self._places, place) : bisect_left(self._places, played.place)]:
                estimator.take_aside(other)
            if played.fused >= 0:
                fused = played.fused
            place = played.place
            if played.outcome != TAKEN:
                self.settle()
                if estimator.conclude(played.outcome, samples.sample(place)):
                    fused = place
                self._note(place)
                place += 1
        return fused

    def take_all(self, samples: SampleBlock, row: Ints) -> Floats:
        """Take all samples; what is known after those that have a row, NaN where they did not move time on.

        `row` has an entry for each sample, -1 for none. See `readout` for what the columns are.
        """
        rows: Floats = np.full((int(row.max(initial=-1)) + 1, self._no_rows.shape[1]), np.nan)
        self._begin(samples, row, rows)
        begin = 0
        for stale in np.flatnonzero(samples.quality == Quality.STALE).tolist():
            self.take(samples, begin, stale)
            self.settle()
            self._estimator.take(samples.sample(stale))
            begin = stale + 1
        self.take(samples, begin, len(samples))
        self.settle()
        return rows

    def settle(self) -> None:
        """Copy the numbers of the compiled core to the estimator's own, where they are ahead."""
        if self._is_ahead:
            self._compiled.store()
            self._is_ahead = False

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator would say."""
        if self._is_ahead:
            return self._estimator.state(self._compiled.readout, time_s)
        return self._estimator.estimate(time_s)

    def _begin(self, samples: SampleBlock, row: Ints, rows: Floats) -> None:
        self._block = samples
        is_good = samples.quality == Quality.GOOD
        self._columns = SampleColumns(samples.channel, samples.time_s, samples.value, is_good, row, rows)
        places = np.flatnonzero(self._aside[samples.channel] & is_good)
        self._others, self._places = samples.at(places), places.tolist()

    def _note(self, place: int) -> None:
        """Write down what is known after a sample that the estimator has taken itself."""
        row, core = self._columns.row[place], self._estimator.core
        if row >= 0 and core.now.time_s == self._columns.time_s[place]:
            read_out(core, self._columns.rows[row])
