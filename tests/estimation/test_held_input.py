"""A held input gives the filter the impulse that really acted."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.estimation.inputs.held_input import HeldInput


def used_impulse(sample_times: np.ndarray, values: np.ndarray, step_times: np.ndarray) -> float:
    """Play samples and steps in time order; the impulse that the steps were given."""
    held = HeldInput()
    held.restart(float(step_times[0]))
    events = [(t, 0, v) for t, v in zip(sample_times, values, strict=True)] + [(t, 1, 0.0) for t in step_times[1:]]
    impulse, last_s = 0.0, float(step_times[0])
    for time_s, kind, value in sorted(events):
        if kind == 0:
            held.sample(time_s, value, 1.0)
        else:
            impulse += held.use_until(time_s, time_s - last_s) * (time_s - last_s)
            last_s = time_s
    return impulse


@given(st.lists(st.floats(0.0, 9e4), min_size=3, max_size=30), st.floats(0.005, 0.05))
def test_the_impulse_is_the_trapezoid_whatever_the_steps(values: list[float], period_s: float) -> None:
    times = np.arange(len(values)) * period_s
    steps = np.append(np.arange(0.0, times[-1], 0.013), times[-1] + 1e-9)
    exact = float(np.trapezoid(values, times))
    assert used_impulse(times, np.array(values), steps) == pytest.approx(exact, abs=1e-3)


def test_a_falling_force_is_not_held_too_high_for_good() -> None:
    times = np.arange(0.0, 0.5, 0.05)
    force = 40_000.0 * np.exp(-times / 0.1)
    steps = np.arange(0.0, 0.46, 0.01)
    given = used_impulse(times, force, steps)
    assert given == pytest.approx(40_000.0 * 0.1 * (1.0 - np.exp(-4.5)), rel=0.025)  # ∫ of the exponential
    holding = float(np.sum(force[:-1]) * 0.05)
    assert holding > 1.2 * given


def test_a_gap_is_not_filled_with_a_guess() -> None:
    held = HeldInput()
    held.restart(0.0)
    held.sample(0.0, 10.0, 1.0)
    assert held.use_until(0.1, 0.1) == pytest.approx(10.0)
    held.sample(5.0, 0.0, 1.0)
    assert held.use_until(5.1, 5.0) == pytest.approx(0.0)


def test_a_steady_input_is_not_doubted_and_a_falling_one_by_what_holding_gets_wrong() -> None:
    held = HeldInput()
    held.restart(0.0)
    for tick in range(5):
        held.sample(tick / 100, 40_000.0, 1.0)
    assert held.impulse_std_until(0.05) == 0.0
    held.use_until(0.05, 0.05)
    held.sample(0.05, 36_000.0, 1.0)  # falls by 400 kN/s
    made_up_ns = 0.5 * 4000.0 * 0.01
    assert held.impulse_std_until(0.05) == pytest.approx(made_up_ns)
    held.use_until(0.05, 0.01)
    assert held.impulse_std_until(0.07) == pytest.approx(0.5 * 400_000.0 * 0.02**2)  # two samples were lost


def test_samples_in_frames_that_a_gateway_bunches_do_not_tell_how_fast_a_force_moves() -> None:
    """Which of them came by how many microseconds later is chance: what may be off must not hang on it."""
    stds_ns = []
    for gap_s in (1e-7, 1e-6, 2e-6):
        held = HeldInput()
        held.sample(1.0, 20_000.0, 1.0)
        held.use_until(1.0, 1.0)  # what came before
        held.sample(1.0 + gap_s, 21_000.0, 1.0)
        stds_ns.append(held.impulse_std_until(1.01))
    assert stds_ns == pytest.approx([stds_ns[0]] * 3, rel=1e-3)
    assert stds_ns[0] < 1_000.0 / 0.001 * 0.01**2
