"""A speed that its sender rounds more coarsely than its DBC says is found, with what it errs by."""

from math import sqrt

import numpy as np
import pytest

from brake_monitor.inspection.coarse import remarks_on_steps
from first_hours import Floats, of_readings, speed_channel, wheel_channel

RADIUS_M, NOISE_MPS, FINE_MPS, KMH_MPS = 0.45, 0.02, 0.001, 1.0 / 3.6
CHANNELS = [speed_channel(NOISE_MPS), wheel_channel(0, NOISE_MPS / RADIUS_M)]


def in_steps(values: Floats, step: float) -> Floats:
    return np.rint(values / step) * step


def remarks(step_mps: float, *, spacing_s: float = 0.05, noise_mps: float = NOISE_MPS) -> list[str]:
    """Of a wagon that brakes less and less; its DBC has millimetres per second."""
    rng, times_s = np.random.default_rng(7), np.arange(0.0, 60.0, spacing_s)
    true_mps = 5.0 + 25.0 * np.exp(-times_s / 40.0)
    noisy_mps = true_mps + noise_mps * rng.normal(size=len(times_s))
    wheel_radps = in_steps(true_mps / RADIUS_M + NOISE_MPS / RADIUS_M * rng.normal(size=len(times_s)), FINE_MPS)
    told = in_steps(in_steps(noisy_mps, step_mps), FINE_MPS)
    return list(remarks_on_steps(of_readings(CHANNELS, times_s, told, wheel_radps)))


def test_whole_kilometres_per_hour_are_found() -> None:
    """Rounding to a step errs by a step over the root of twelve: 0.080 m/s, where 0.02 are configured."""
    (remark,) = remarks(KMH_MPS)
    assert remark.startswith("speed comes in coarser steps than the DBC says, which alone err by 4.0 times its noise")


@pytest.mark.parametrize(("times", "is_told"), [(1.2, False), (1.8, True)])
def test_what_rounding_errs_by_is_told_where_it_is_clearly_more_than_the_noise(times: float, is_told: bool) -> None:
    told = remarks(times * NOISE_MPS * sqrt(12.0))
    assert [f"err by {times} times its noise" in remark for remark in told] == [True] * is_told


def test_a_speed_that_does_not_change_has_no_steps() -> None:
    times_s = np.arange(0.0, 60.0, 0.05)
    stands = [np.zeros_like(times_s)] * 2
    assert not list(remarks_on_steps(of_readings(CHANNELS, times_s, *stands)))


@pytest.mark.parametrize("step_mps", [FINE_MPS, 0.01 / 3.6, 0.1 / 3.6])
def test_steps_that_the_noise_covers_are_none(step_mps: float) -> None:
    assert not remarks(step_mps)


@pytest.mark.parametrize("noise_mps", [0.0, NOISE_MPS])
def test_a_speed_that_comes_seldom_has_no_steps(noise_mps: float) -> None:
    """Though it changes by far more than its noise from one reading to the next."""
    assert not remarks(FINE_MPS, spacing_s=1.0, noise_mps=noise_mps)
