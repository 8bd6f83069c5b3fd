"""A speed that a gateway repeats is found by readings that are the same while the speed changes."""

import numpy as np
import pytest

from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.repeated import remarks_on_repetitions, times_repeated
from brake_monitor.samples import Quantity
from first_hours import of_readings, speed_channel

SPACING_S, NOISE_MPS = 0.05, 0.02


def heard(repeated: int, *, step_mps: float = 0.003, braked: bool = True) -> FirstHour:
    """A speed in steps, told every SPACING_S and measured every so many times, from 25 m/s on."""
    rng, times_s = np.random.default_rng(1), np.arange(0.0, 40.0, SPACING_S)
    measured_s = times_s[::repeated].repeat(repeated)[: len(times_s)]
    true_mps = 25.0 - 0.5 * np.maximum(measured_s - 10.0, 0.0) * braked
    noise_mps = rng.normal(size=len(times_s))[::repeated].repeat(repeated)[: len(times_s)] * NOISE_MPS
    told_mps = np.round((true_mps + noise_mps) / step_mps) * step_mps
    return of_readings([speed_channel(NOISE_MPS)], times_s, told_mps)


@pytest.mark.parametrize("repeated", [2, 4, 5])
def test_how_often_a_speed_is_repeated_is_found(repeated: int) -> None:
    assert times_repeated(heard(repeated), Quantity.SPEED) == repeated


def test_a_speed_that_is_told_as_it_is_measured_is_not_repeated() -> None:
    assert times_repeated(heard(1), Quantity.SPEED) == 1


@pytest.mark.parametrize(("step_mps", "braked"), [(0.1, True), (0.003, False)], ids=["coarse steps", "steady speed"])
def test_what_may_be_the_same_by_chance_tells_nothing(step_mps: float, braked: bool) -> None:
    assert times_repeated(heard(4, step_mps=step_mps, braked=braked), Quantity.SPEED) == 1


def test_the_remark_says_what_makes_up_for_it() -> None:
    (remark,) = remarks_on_repetitions(heard(4))
    assert remark.startswith("speed is told 4 times before it is measured anew")
    assert remark.endswith("multiply its noise_std by 2.0")
    assert not list(remarks_on_repetitions(heard(1)))
