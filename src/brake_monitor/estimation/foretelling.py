"""An estimator that adds up how probable each reading was before it was seen: what noise densities are fitted by."""

from dataclasses import dataclass, field
from math import exp, inf, log, log1p, pi

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.ekf import Innovation
from brake_monitor.estimation.estimator import Estimator

STRANGE_SHARE = 0.01  # readings that the model does not explain: outliers, jumps of the adhesion
STRANGE_STD_MPS = 1.0  # how far from the prediction such a reading lies (of a wheel: at its circumference)

take_reading = Core.fuse  # machine code calls functions, not those of a base class


class Foretold:
    """How probable all readings so far were, as the sum of the logarithms."""

    def __init__(self) -> None:
        self.readings = 0
        self.nats = 0.0

    def see(self, seen: Innovation, strange_std: float) -> None:
        """Add a reading."""
        usual = log1p(-STRANGE_SHARE) + log_normal(seen.residual, seen.variance)
        self.see_strange(log_sum(usual, log(STRANGE_SHARE) + log_normal(seen.residual, strange_std * strange_std)))

    def see_strange(self, nats: float) -> None:
        """Add a reading that was as probable as this."""
        self.readings += 1
        self.nats += nats


@dataclass(slots=True)
class ForetellingCore(Core):
    """The steps of an estimator, adding up how probable each reading was before it was seen.

    A reading is either one of the model's, N(0, S) about the prediction, or with the probability STRANGE_SHARE a
    strange one, N(0, STRANGE_STD²). Both are fixed before the reading is seen, so neither the gate nor the widening
    after a surprise can improve the sum: every reading counts, and a rejected one costs what a strange one costs.
    """

    foretold: Foretold = field(default_factory=Foretold)

    def fuse(self, index: int, value: float, variance: float) -> int:
        """Note a reading, and correct the estimate by it."""
        residual, total_variance = self.innovation(index, value, variance)
        self.foretell(index, Innovation(residual, total_variance))
        return take_reading(self, index, value, variance)

    def foretell(self, index: int, seen: Innovation) -> None:
        """Note a reading; the first after a start was not foretold."""
        strange_std = STRANGE_STD_MPS
        if index < self.wheelset_count:
            strange_std /= self.wheels[index].wheel_radius_m
        if self.readings[index].fused_s == -inf:
            self.foretold.see_strange(log(STRANGE_SHARE) + log_normal(0.0, strange_std * strange_std))
        else:
            self.foretold.see(seen, strange_std)


class ForetellingEstimator(Estimator):
    """The estimator, adding up how probable each reading was before it was seen."""

    core_type = ForetellingCore

    @property
    def foretold(self) -> Foretold:
        """The sum so far."""
        assert isinstance(self.core, ForetellingCore)
        return self.core.foretold


def log_normal(residual: float, variance: float) -> float:
    """The logarithm of the density of N(0, variance)."""
    return -0.5 * (residual * residual / variance + log(2.0 * pi * variance))


def log_sum(one: float, other: float) -> float:
    """log(e^one + e^other)."""
    low, high = min(one, other), max(one, other)
    return high + log1p(exp(low - high)) if low > -inf else high
