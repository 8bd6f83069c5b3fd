"""How an estimator takes the samples of a recording: one by one, or many at once by machine code."""

from typing import Protocol

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator


class BlockTaker(Protocol):
    """Takes the samples of recordings for an estimator."""

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places; the place of the last one that was fused."""

    def settle(self) -> None:
        """Bring the estimator up to date with the samples taken."""

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator says after them, at time_s; None: as of the last fused one."""


class OneByOne:
    """Has the estimator take one sample after the other."""

    def __init__(self, estimator: Estimator) -> None:
        self._estimator = estimator

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places; the place of the last one that was fused."""
        fused = None
        for place in range(begin, end):
            if self._estimator.take(samples.samples[place]):
                fused = place
        return fused

    def settle(self) -> None:
        """Nothing: the estimator has taken each sample itself."""

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator says."""
        return self._estimator.estimate(time_s)
