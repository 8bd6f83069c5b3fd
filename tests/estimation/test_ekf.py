"""The filter by itself: against the textbook's batch solution and van Loan's discretisation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from brake_monitor.estimation.kalman import ekf
from brake_monitor.estimation.kalman.ekf import Innovation, Matrix, Measured, Vector

ALL_FREE = [1.0, 1.0, 1.0]


def van_loan(jacobian: np.ndarray, density: np.ndarray, dt_s: float) -> np.ndarray:
    """The discrete covariance by the matrix exponential of Van Loan (1978)."""
    n = len(jacobian)
    block = np.block([[-jacobian, density], [np.zeros((n, n)), jacobian.T]]) * dt_s
    exponential = expm(block)
    return exponential[n:, n:].T @ exponential[:n, n:]


def predict(covariance: Matrix, jacobian: Matrix, density: Matrix, dt_s: float) -> Matrix:
    return ekf.predict(covariance, ekf.scaled(jacobian, dt_s), ekf.process_noise(jacobian, density, dt_s))


def diagonal(*values: float) -> Matrix:
    return np.diag(values).tolist()


def integrator_chain() -> tuple[Matrix, Matrix]:
    """A wheel: speed driven by a coefficient (and weakly by itself), both with noise."""
    jacobian = [[-0.01, 600.0, -80.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    return jacobian, diagonal(1e-3, 4e-4, 1e-5)


@pytest.mark.parametrize("dt_s", [0.001, 0.01, 0.05])
def test_process_noise_agrees_with_van_loan(dt_s: float) -> None:
    jacobian, density = integrator_chain()
    exact = van_loan(np.array(jacobian), np.array(density), dt_s)
    assert np.array(ekf.process_noise(jacobian, density, dt_s)) == pytest.approx(exact, rel=2e-3, abs=1e-12)


def test_two_half_steps_are_one_step() -> None:
    jacobian, density = integrator_chain()
    begin = diagonal(1e-3, 1e-4, 1e-3)
    whole = predict(begin, jacobian, density, 0.02)
    halves = predict(predict(begin, jacobian, density, 0.01), jacobian, density, 0.01)
    assert np.array(whole) == pytest.approx(np.array(halves), rel=2e-3)


def told(x: Vector, covariance: Matrix, state: int, value: float, variance: float) -> Innovation:
    """What a direct measurement of a state says."""
    return Innovation(value - x[state], covariance[state][state] + variance)


@given(st.lists(st.floats(-5, 5), min_size=2, max_size=6), st.floats(-3.0, 3.0), st.floats(1e-3, 10.0))
def test_a_measurement_of_two_states_gives_the_batch_least_squares(
    values: list[float], weight: float, variance: float
) -> None:
    prior = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])
    h = np.array([0.0, 1.0, weight])
    x, covariance = [0.0] * 3, prior.tolist()
    for value in values:
        seen = Innovation(value - float(h @ x), float(h @ np.array(covariance) @ h) + variance)
        x, covariance = ekf.update(x, covariance, Measured(1, 2, weight), seen, ALL_FREE)
    information = np.linalg.inv(prior) + len(values) * np.outer(h, h) / variance
    assert np.array(covariance) == pytest.approx(np.linalg.inv(information), rel=1e-6, abs=1e-9)
    assert x == pytest.approx(np.linalg.solve(information, h * sum(values) / variance), rel=1e-6, abs=1e-9)


@given(st.lists(st.floats(-5, 5), min_size=2, max_size=6), st.floats(1e-6, 10.0))
def test_scalar_updates_give_the_batch_least_squares(values: list[float], variance: float) -> None:
    """Fusing one by one equals solving all at once; a correlated state is corrected along."""
    prior = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])
    x, covariance = [0.0] * 3, prior.tolist()
    for value in values:
        seen = told(x, covariance, 1, value, variance)
        x, covariance = ekf.update(x, covariance, Measured(1), seen, ALL_FREE)
    h = np.zeros((len(values), 3))
    h[:, 1] = 1.0
    information = np.linalg.inv(prior) + h.T @ h / variance
    assert np.array(covariance) == pytest.approx(np.linalg.inv(information), rel=1e-6, abs=1e-9)
    assert x == pytest.approx(np.linalg.solve(information, h.T @ np.array(values) / variance), rel=1e-6, abs=1e-9)


def test_a_held_state_keeps_value_and_variance_but_not_a_false_correlation() -> None:
    x, covariance = [0.0] * 3, [[2.0, 0.5, 0.8], [0.5, 1.0, 0.2], [0.8, 0.2, 3.0]]
    x, covariance = ekf.update(x, covariance, Measured(0), told(x, covariance, 0, 1.0, 1e-4), [1.0, 1.0, 0.0])
    assert x[2] == 0.0
    assert covariance[2][2] == 3.0
    assert x[1] > 0.0
    assert abs(covariance[0][2]) < 1e-3  # the measured state is now known, whatever the held one is
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_covariance_stays_symmetric_and_positive_over_a_long_run() -> None:
    rng = np.random.default_rng(1)
    jacobian, density = integrator_chain()
    x, covariance = [0.0] * 3, diagonal(1.0, 1e-2, 1e-2)
    for step in range(20_000):
        covariance = predict(covariance, jacobian, density, 0.01)
        free = [1.0, 1.0, float(step % 700 <= 350)]
        seen = told(x, covariance, 0, rng.normal(), 1e-9)
        x, covariance = ekf.update(x, covariance, Measured(0), seen, free)
    assert np.isfinite(x).all()
    assert (np.array(covariance) == np.array(covariance).T).all()
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_innovations_of_a_matched_filter_are_chi_squared() -> None:
    """Truth from its own random walk; the mean NIS of n samples lies within 4 sigma of 1."""
    rng = np.random.default_rng(7)
    jacobian, density = integrator_chain()
    dt_s, variance = 0.02, 5e-4
    drift = np.array(jacobian)
    root = np.linalg.cholesky(van_loan(drift, np.array(density), dt_s))
    x, covariance = [0.0] * 3, diagonal(1e-3, 1e-3, 1e-3)
    truth = rng.normal(size=3) * np.sqrt(np.diag(covariance))
    transition = expm(drift * dt_s)
    total, count = 0.0, 20_000
    for _ in range(count):
        truth = transition @ truth + root @ rng.normal(size=3)
        x = (x + drift @ x * dt_s).tolist()
        covariance = predict(covariance, jacobian, density, dt_s)
        seen = told(x, covariance, 0, truth[0] + rng.normal() * np.sqrt(variance), variance)
        x, covariance = ekf.update(x, covariance, Measured(0), seen, ALL_FREE)
        total += seen.residual**2 / seen.variance
    assert abs(total / count - 1.0) < 4.0 * np.sqrt(2.0 / count)
