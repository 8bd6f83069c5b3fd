"""A continuous-discrete extended Kalman filter, one scalar measurement at a time. It knows no wagon.

State and covariance are plain arrays, changed in place. References: Simon, Optimal State Estimation (2006), ch. 6
and 13; Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404; Schmidt (1966) for the consider (hold) gain.
"""

from math import isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Innovation(NamedTuple):
    """What a scalar measurement said against the prediction."""

    residual: float
    variance: float  # predicted variance of the residual, S = H P H' + R

    @property
    def nis(self) -> float:
        """Normalised innovation squared; chi-squared with one degree of freedom when the filter is consistent."""
        return self.residual * self.residual / self.variance


def process_noise(jacobian: Array, density: Array, dt_s: float) -> Array:
    """∫ e^{As} Q e^{A's} ds over the step, shape (n, n), to third order in dt.

    `density` is the spectral density matrix Q, shape (n, n). The series is exact when A Q A' has no further
    A left to act on, as for an integrator chain of length two (speeds driven by their coefficients).
    """
    step = jacobian * dt_s
    drift = step @ density
    noise = drift + drift.T
    noise *= 0.5
    noise += density
    drift *= 1.0 / 3.0
    noise += drift @ step.T
    noise *= dt_s
    return noise


def predict(covariance: Array, step: Array, noise: Array) -> None:
    """P ← F P F' + Q_d with F = I + `step`, the change of the transition over the time step; all of shape (n, n)."""
    moved = step @ covariance
    total = covariance + noise
    total += moved
    total += moved.T
    total += moved @ step.T
    np.add(total, total.T, out=covariance)  # rounding must not let the halves drift apart
    covariance *= 0.5


def innovation(x: Array, covariance: Array, index: int, value: float, variance: float) -> Innovation:
    """Compare a direct measurement of state `index` with the prediction; changes nothing."""
    return Innovation(value - float(x[index]), float(covariance[index, index]) + variance)


def update(x: Array, covariance: Array, index: int, seen: Innovation, free: Array) -> None:
    """Fuse the measurement of state `index`, never a held one; held states keep value and variance.

    `free`, shape (n,), is 1 for states to correct and 0 for held ones (Schmidt's consider gain). With p = P H'
    and K = p / S where free, Joseph's form P - K p' - p K' + K S K' comes down to taking p p' / S off every
    element but those between two held states.
    """
    column = covariance[:, index].copy()
    measured = float(column[index])
    gain = column * free
    gain *= seen.residual / seen.variance
    x += gain
    taken = column[:, None] * column  # symmetric to the last bit
    if not free.all():
        held = column * (1.0 - free)
        taken -= held[:, None] * held
    taken *= 1.0 / seen.variance
    covariance -= taken
    covariance[index, index] = measured * (seen.variance - measured) / seen.variance  # free of cancellation


def is_sound(x: Array, covariance: Array) -> bool:
    """Whether state and variances are finite and no variance is negative."""
    variances = covariance.diagonal().tolist()
    return isfinite(sum(x.tolist())) and isfinite(sum(variances)) and min(variances) >= 0.0
