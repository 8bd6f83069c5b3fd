"""What was known a while ago: a reading that turns out to have stood still has taught nonsense since then."""

from collections.abc import Sequence
from math import inf

KEPT_S = 1.5  # from one to the next
KEPT = 3


class Earlier:
    """x and P, row by row, at some time."""

    def __init__(self, size: int) -> None:
        self.time_s = -inf
        self.x = [0.0] * size
        self.covariance = [0.0] * (size * size)

    def keep(self, time_s: float, x: Sequence[float], covariance: Sequence[Sequence[float]]) -> None:
        """Take over what is known now."""
        self.time_s = time_s
        for i in range(len(x)):
            self.x[i] = x[i]
            for j in range(len(x)):
                self.covariance[i * len(x) + j] = covariance[i][j]
