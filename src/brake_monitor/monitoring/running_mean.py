"""The mean of what has been seen so far, or lately."""

from math import inf


class RunningMean:
    """Mean of all values, or nearly that of the last so many, by their count or by how long each lasted."""

    def __init__(self, most: float = inf) -> None:
        self._most = most
        self.count = self.value = 0.0

    def begin(self) -> None:
        """The next value is the first one."""
        self.count = 0.0

    def add(self, value: float, weight: float = 1.0) -> None:
        """Take the next value; one that has lasted for no time yet counts where there is no other."""
        self.count = min(self.count + weight, self._most)
        self.value += (value - self.value) * (weight / self.count if self.count else 1.0)
