"""A continuous-discrete extended Kalman filter, one scalar measurement at a time. It knows no wagon.

Written in plain loops over vectors and matrices of numbers: what runs for every sample is compiled from it by
`straight_line`. References: Simon, Optimal State Estimation (2006), ch. 6 and 13; Van Loan, IEEE Trans. Autom. Control
23 (1978) 395-404; Schmidt (1966) for the consider (hold) gain.
"""

from collections.abc import Sequence
from typing import NamedTuple

Vector = list[float]
Matrix = list[Vector]


class Measured(NamedTuple):
    """A row of H: a measurement tells of one state, and to some extent of another."""

    state: int
    other: int = 0
    weight: float = 0.0  # of the other

    def of(self, numbers: Sequence[float]) -> float:
        """What it makes of a state, or of a row of P."""
        return numbers[self.state] + self.weight * numbers[self.other]


class Innovation(NamedTuple):
    """What a scalar measurement said against the prediction."""

    residual: float
    variance: float  # predicted variance of the residual, S = H P H' + R


def zeros(size: int) -> Matrix:
    """A matrix of zeros, shape (n, n)."""
    return [[0.0] * size for _ in range(size)]


def scaled(matrix: Matrix, factor: float) -> Matrix:
    """The matrix times a number."""
    return [[value * factor for value in row] for row in matrix]


def product(a: Matrix, b: Matrix) -> Matrix:
    """A B, all of shape (n, n)."""
    places = range(len(a))
    return [[sum([row[k] * b[k][j] for k in places]) for j in places] for row in a]


def process_noise(jacobian: Matrix, density: Matrix, dt_s: float) -> Matrix:
    """∫ e^{As} Q e^{A's} ds over the step, shape (n, n), with e^{As} = I + A s: exact where A² = 0.

    `density` is the spectral density matrix Q, shape (n, n). A² = 0 is an integrator chain of length two: speeds
    driven by their coefficients. What drag, or friction that relaxes, adds to A² is next to nothing in a step.
    """
    size = len(jacobian)
    step = scaled(jacobian, dt_s)
    drift = product(step, density)
    noise = zeros(size)
    for i in range(size):
        for j in range(i, size):
            driven = sum([drift[i][k] * step[j][k] for k in range(size)])
            noise[i][j] = noise[j][i] = dt_s * (density[i][j] + 0.5 * (drift[i][j] + drift[j][i]) + driven / 3.0)
    return noise


def predict(covariance: Matrix, step: Matrix, noise: Matrix) -> Matrix:
    """F P F' + Q_d with F = I + `step`, the change of the transition over the time step; all of shape (n, n)."""
    size = len(covariance)
    moved = product(step, covariance)
    predicted = zeros(size)
    for i in range(size):
        for j in range(i, size):  # one half and its mirror image: rounding cannot let them drift apart
            both = sum([moved[i][k] * step[j][k] for k in range(size)])
            predicted[i][j] = predicted[j][i] = covariance[i][j] + noise[i][j] + moved[i][j] + moved[j][i] + both
    return predicted


def update(
    x: Vector, covariance: Matrix, measured: Measured, seen: Innovation, free: Sequence[float]
) -> tuple[Vector, Matrix]:
    """Fuse a measurement; see `correct`."""
    corrected, updated = [0.0] * len(x), zeros(len(x))
    correct((x, covariance), measured, seen, free, (corrected, updated))
    return corrected, updated


def correct(
    before: tuple[Vector, Matrix],
    measured: Measured,
    seen: Innovation,
    free: Sequence[float],
    after: tuple[Vector, Matrix],
) -> None:
    """Fuse a measurement, of a state that is never a held one; held states keep value and variance.

    `before` and `after` are x and P; `free`, n numbers, is 1 for states to correct and 0 for held ones (Schmidt's
    consider gain). With p = P H' and K = p / S where free, Joseph's form P - K p' - p K' + K S K' comes down to taking
    p p' / S off every element but those between two held states.
    """
    x, covariance = before
    corrected, updated = after
    per_variance = 1.0 / seen.variance
    for i in range(len(x)):
        gain = measured.of(covariance[i]) * per_variance  # of a filter that holds nothing
        held = gain * (1.0 - free[i])
        corrected[i] = x[i] + gain * free[i] * seen.residual
        for j in range(i, len(x)):
            told = measured.of(covariance[j])
            taken = gain * told - held * (told * (1.0 - free[j]))
            updated[i][j] = updated[j][i] = covariance[i][j] - taken
    i = measured.state
    told = measured.of(covariance[i])
    updated[i][i] = covariance[i][i] - told + told * per_variance * (seen.variance - told)  # free of cancellation
