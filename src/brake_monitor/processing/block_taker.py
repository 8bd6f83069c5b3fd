"""How an estimator takes the samples of a recording: each by itself, or as machine code does, many at once."""

from typing import Protocol

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator


class BlockTaker(Protocol):
    """Takes the samples of recordings for an estimator."""

    def take(self, samples: SampleBlock, begin: int, end: int) -> int | None:
        """Take the samples in these places; the place of the last one that was fused."""

    def settle(self) -> None:
        """Let the estimator know of them."""

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator says after them, at time_s; None: as of the last fused one."""


class OneByOne:
    """Takes them as the estimator takes each."""

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
        """Nothing to do: the estimator has taken each sample itself."""

    def estimate(self, time_s: float | None) -> Estimate:
        """What the estimator says."""
        return self._estimator.estimate(time_s)
