"""What a filter believes: x and P, and what is done to single states of them beside predictions and corrections."""

from math import inf
from typing import Any


class Belief:
    """x and P. Written as loops over numbers that stay in their places, which run compiled as they stand."""

    x: Any  # n numbers
    covariance: Any  # P, n rows of n numbers
    direction: Any  # n numbers, see `admit_along`
    saved: Any  # x and P row by row, n + n * n numbers, of a few earlier times

    def forget(self, place: int, value: float, std: float) -> None:
        """Give a state a new value that is unrelated to everything else."""
        self.x[place] = value
        for k in range(len(self.x)):
            self.covariance[place][k] = self.covariance[k][place] = 0.0
        self.covariance[place][place] = std**2

    def scale(self, place: int, factor: float, about: float) -> None:
        """Multiply a state's distance from `about` by a known factor."""
        self.x[place] = about + factor * (self.x[place] - about)
        for k in range(len(self.x)):
            self.covariance[place][k] *= factor
        for k in range(len(self.x)):
            self.covariance[k][place] *= factor

    def admit_jump(self, place: int, variance: float, shown_by: int, per_jump: float) -> None:
        """Take a state to have jumped by an unknown amount, and another by so many times as much."""
        self.covariance[shown_by][shown_by] += variance * per_jump * per_jump
        self.covariance[shown_by][place] += variance * per_jump
        self.covariance[place][shown_by] += variance * per_jump
        self.covariance[place][place] += variance

    def admit_along(self, variance: float) -> None:
        """Take the state to have moved by an unknown amount along the vector `direction`."""
        for i in range(len(self.direction)):
            for j in range(len(self.direction)):
                self.covariance[i][j] += variance * self.direction[i] * self.direction[j]

    def save(self, place: int) -> None:
        """Keep what is known now in one of the places for it."""
        size = len(self.x)
        for i in range(size):
            self.saved[place][i] = self.x[i]
            for j in range(size):
                self.saved[place][size + i * size + j] = self.covariance[i][j]

    def is_sound(self) -> bool:
        """Whether state and variances are finite and no variance is negative."""
        total = 0.0
        for k in range(len(self.x)):
            total += self.x[k] + self.covariance[k][k]
            if self.covariance[k][k] < 0.0:
                return False
        return abs(total) < inf
