"""What the filter did, in order, for a smoother that goes back over it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from brake_monitor.estimation.ekf import Matrix, Measured, Vector

Array = NDArray[np.float64]


class Step(NamedTuple):
    """x moved to F x + w with w ~ N(0, noise); a prediction, or what was admitted or forgotten in between."""

    change: Array  # F - I, shape (n, n)
    noise: Array  # shape (n, n)


class Reading(NamedTuple):
    """A scalar measurement, and what the filter made of it."""

    measured: Measured
    residual: float  # against the state as predicted
    variance: float  # R, of the measurement alone
    correction: Array  # by what the state was moved, shape (n,)


class Tape:
    """Records the filter's doings until they are cut off."""

    def __init__(self) -> None:
        self.events: list[Step | Reading] = []

    def step(self, change: Matrix, noise: Matrix) -> None:
        """Note a step; one that is not finite says nothing, the filter's reset follows it."""
        step = Step(np.array(change), np.array(noise))
        if np.isfinite(step.change).all() and np.isfinite(step.noise).all():
            self.events.append(step)

    def reading(self, measured: Measured, residual: float, variance: float, correction: Vector) -> None:
        """Note a measurement that was fused; one that is not finite says nothing, the filter's reset follows it."""
        if np.isfinite(residual) and np.isfinite(correction).all():
            self.events.append(Reading(measured, residual, variance, np.array(correction)))

    def cut(self, count: int) -> None:
        """Drop the oldest `count` events."""
        del self.events[:count]
