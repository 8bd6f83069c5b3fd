"""The filter by itself: against the textbook's batch solution and van Loan's discretisation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from brake_monitor import ekf

ALL_FREE = np.ones(3)


def van_loan(jacobian: np.ndarray, density: np.ndarray, dt_s: float) -> np.ndarray:
    """The discrete covariance by the matrix exponential of Van Loan (1978)."""
    n = len(jacobian)
    block = np.block([[-jacobian, density], [np.zeros((n, n)), jacobian.T]]) * dt_s
    exponential = expm(block)
    return exponential[n:, n:].T @ exponential[:n, n:]


def predict(covariance: np.ndarray, jacobian: np.ndarray, density: np.ndarray, dt_s: float) -> None:
    ekf.predict(covariance, jacobian * dt_s, ekf.process_noise(jacobian, density, dt_s))


def integrator_chain() -> tuple[np.ndarray, np.ndarray]:
    """A wheel: speed driven by a coefficient (and weakly by itself), both with noise."""
    jacobian = np.array([[-0.01, 600.0, -80.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    return jacobian, np.diag([1e-3, 4e-4, 1e-5])


@pytest.mark.parametrize("dt_s", [0.001, 0.01, 0.05])
def test_process_noise_agrees_with_van_loan(dt_s: float) -> None:
    jacobian, density = integrator_chain()
    exact = van_loan(jacobian, density, dt_s)
    assert ekf.process_noise(jacobian, density, dt_s) == pytest.approx(exact, rel=2e-3, abs=1e-12)


def test_two_half_steps_are_one_step() -> None:
    jacobian, density = integrator_chain()
    whole = np.diag([1e-3, 1e-4, 1e-3])
    halves = whole.copy()
    predict(whole, jacobian, density, 0.02)
    predict(halves, jacobian, density, 0.01)
    predict(halves, jacobian, density, 0.01)
    assert whole == pytest.approx(halves, rel=2e-3)


@given(st.lists(st.floats(-5, 5), min_size=2, max_size=6), st.floats(1e-6, 10.0))
def test_scalar_updates_give_the_batch_least_squares(values: list[float], variance: float) -> None:
    """Fusing one by one equals solving all at once; a correlated state is corrected along."""
    prior = np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 3.0]])
    x, covariance = np.zeros(3), prior.copy()
    for value in values:
        seen = ekf.innovation(x, covariance, 1, value, variance)
        ekf.update(x, covariance, 1, seen, ALL_FREE)
    h = np.zeros((len(values), 3))
    h[:, 1] = 1.0
    information = np.linalg.inv(prior) + h.T @ h / variance
    assert covariance == pytest.approx(np.linalg.inv(information), rel=1e-6, abs=1e-9)
    assert x == pytest.approx(np.linalg.solve(information, h.T @ np.array(values) / variance), rel=1e-6, abs=1e-9)


def test_a_held_state_keeps_value_and_variance_but_not_a_false_correlation() -> None:
    x, covariance = np.zeros(3), np.array([[2.0, 0.5, 0.8], [0.5, 1.0, 0.2], [0.8, 0.2, 3.0]])
    free = np.array([1.0, 1.0, 0.0])
    ekf.update(x, covariance, 0, ekf.innovation(x, covariance, 0, 1.0, 1e-4), free)
    assert x[2] == 0.0
    assert covariance[2, 2] == 3.0
    assert x[1] > 0.0
    assert abs(covariance[0, 2]) < 1e-3  # the measured state is now known, whatever the held one is
    assert np.linalg.eigvalsh(covariance).min() > 0.0


def test_covariance_stays_symmetric_and_positive_over_a_long_run() -> None:
    rng = np.random.default_rng(1)
    jacobian, density = integrator_chain()
    x, covariance = np.zeros(3), np.diag([1.0, 1e-2, 1e-2])
    for step in range(20_000):
        predict(covariance, jacobian, density, 0.01)
        free = np.array([1.0, 1.0, float(step % 700 <= 350)])
        ekf.update(x, covariance, 0, ekf.innovation(x, covariance, 0, rng.normal(), 1e-9), free)
    assert ekf.is_sound(x, covariance)
    assert (covariance == covariance.T).all()
    assert np.linalg.eigvalsh(covariance).min() > -1e-12


def test_innovations_of_a_matched_filter_are_chi_squared() -> None:
    """Truth from its own random walk; the mean NIS of n samples lies within 4 sigma of 1."""
    rng = np.random.default_rng(7)
    jacobian, density = integrator_chain()
    dt_s, variance = 0.02, 5e-4
    root = np.linalg.cholesky(van_loan(jacobian, density, dt_s))
    truth, x, covariance = np.zeros(3), np.zeros(3), np.diag([1e-3, 1e-3, 1e-3])
    truth += rng.normal(size=3) * np.sqrt(np.diag(covariance))
    transition = expm(jacobian * dt_s)
    total, count = 0.0, 20_000
    for _ in range(count):
        truth = transition @ truth + root @ rng.normal(size=3)
        x += jacobian @ x * dt_s
        predict(covariance, jacobian, density, dt_s)
        seen = ekf.innovation(x, covariance, 0, truth[0] + rng.normal() * np.sqrt(variance), variance)
        ekf.update(x, covariance, 0, seen, ALL_FREE)
        total += seen.nis
    assert abs(total / count - 1.0) < 4.0 * np.sqrt(2.0 / count)


@pytest.mark.parametrize("spoil", [np.nan, np.inf])
def test_an_unsound_filter_is_recognised(spoil: float) -> None:
    x, covariance = np.zeros(2), np.eye(2)
    assert ekf.is_sound(x, covariance)
    x[1] = spoil
    assert not ekf.is_sound(x, covariance)
    assert not ekf.is_sound(np.zeros(2), np.diag([1.0, -1e-3]))
