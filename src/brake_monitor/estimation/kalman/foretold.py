"""How probable each reading was before it was seen, added up: what noise densities are fitted by.

A reading is either one of the model's, N(0, S) about the prediction, or with the probability STRANGE_SHARE a strange
one, N(0, STRANGE_STD²). Both are fixed before the reading is seen, so neither the gate nor the widening after a
surprise can improve the sum: every reading counts, and a rejected one costs what a strange one costs.
"""

from math import exp, inf, log, log1p, pi

STRANGE_SHARE = 0.01  # readings that the model does not explain: outliers, jumps of the adhesion
STRANGE_STD_MPS = 1.0  # how far from the prediction such a reading lies (of a wheel: at its circumference)


class Foretold:
    """The log-likelihood of all readings so far, in nats; added up only where it is asked for."""

    def __init__(self, is_asked: bool) -> None:
        self.is_asked = is_asked
        self.readings = 0
        self.nats = 0.0

    def see(self, residual: float, variance: float, strange_std: float) -> None:
        """Add a reading by its residual, whose predicted variance is S."""
        usual = log1p(-STRANGE_SHARE) + log_normal(residual, variance)
        self._add(log_sum(usual, log(STRANGE_SHARE) + log_normal(residual, strange_std * strange_std)))

    def see_first(self, strange_std: float) -> None:
        """Add the first reading after a start, which was not foretold."""
        self._add(log(STRANGE_SHARE) + log_normal(0.0, strange_std * strange_std))

    def _add(self, nats: float) -> None:
        self.readings += 1
        self.nats += nats


def log_normal(residual: float, variance: float) -> float:
    """The logarithm of the density of N(0, variance)."""
    return -0.5 * (residual * residual / variance + log(2.0 * pi * variance))


def log_sum(one: float, other: float) -> float:
    """log(e^one + e^other)."""
    low, high = min(one, other), max(one, other)
    return high + log1p(exp(low - high)) if low > -inf else high
