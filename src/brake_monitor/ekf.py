"""A continuous-discrete extended Kalman filter, one scalar measurement at a time. It knows no wagon.

Covariances are plain arrays, changed in place. References: Simon, Optimal State Estimation (2006), ch. 6 and 13;
Van Loan, IEEE Trans. Autom. Control 23 (1978) 395-404; Schmidt (1966) for the consider (hold) gain.
"""

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
    drift = jacobian @ density
    return density * dt_s + (drift + drift.T) * (dt_s * dt_s / 2.0) + (drift @ jacobian.T) * (dt_s * dt_s * dt_s / 3.0)


def predict(covariance: Array, transition: Array, noise: Array) -> None:
    """P ← F P F' + Q_d, kept symmetric; F is `transition`, Q_d is `noise`, all of shape (n, n)."""
    covariance[:] = transition @ covariance @ transition.T + noise
    covariance += covariance.T
    covariance *= 0.5


def innovation(x: Array, covariance: Array, index: int, value: float, variance: float) -> Innovation:
    """Compare a direct measurement of state `index` with the prediction; changes nothing."""
    return Innovation(value - float(x[index]), float(covariance[index, index]) + variance)


def update(x: Array, covariance: Array, index: int, seen: Innovation, held: NDArray[np.bool_]) -> None:
    """Fuse the measurement of state `index`; held states keep value and variance (Schmidt's consider gain).

    The covariance update is Joseph's form, valid for any gain K, written out for a scalar measurement:
    P - K p' - p K' + K S K' with p = P H'.
    """
    column = covariance[:, index].copy()
    gain = np.where(held, 0.0, column / seen.variance)
    x += gain * seen.residual
    cross = np.outer(gain, column)
    covariance += np.outer(gain * seen.variance, gain) - cross - cross.T


def is_sound(x: Array, covariance: Array) -> bool:
    """Whether state and covariance are finite and no variance is negative."""
    return bool(np.isfinite(x).all() and np.isfinite(covariance).all() and (covariance.diagonal() >= 0.0).all())
