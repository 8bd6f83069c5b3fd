"""How much the gradient changes by the way is learned from a wagon that runs freely."""

from collections.abc import Iterator
from math import sqrt

import numpy as np
import pytest

from brake_monitor.estimation.hilliness import LARGEST, Hilliness

CONFIGURED = 1e-6  # (m/s²)²/m
STEP_S = 0.02
SPEED_STD_MPS = 0.003  # of an estimated speed, for some tenths of a second
MEMORY_STEPS = 15
RUNS = 20


def run(density: float, way_m: float, rng: np.random.Generator) -> Iterator[tuple[float, float]]:
    """Speed as estimated, and what retards the wagon beside the model: a walk of this density that hills end."""
    speed_mps, unmodelled_mps2, way, error_mps = 25.0, 0.0, 0.0, 0.0
    held = 1.0 - 1.0 / MEMORY_STEPS
    while way < way_m:
        error_mps = held * error_mps + sqrt(1.0 - held**2) * SPEED_STD_MPS * rng.standard_normal()
        yield speed_mps + error_mps, unmodelled_mps2
        speed_mps -= unmodelled_mps2 * STEP_S
        way += speed_mps * STEP_S
        unmodelled_mps2 += sqrt(density * speed_mps * STEP_S) * rng.standard_normal() - 0.05 * unmodelled_mps2 * STEP_S


def learned(density: float, way_m: float, rng: np.random.Generator) -> float:
    hilliness = Hilliness(CONFIGURED)
    for speed_mps, _ in run(density, way_m, rng):
        hilliness.see_coasting(speed_mps, SPEED_STD_MPS**2, 0.0, STEP_S)
    return hilliness.density


@pytest.mark.parametrize("density", [5e-7, 3e-6])
def test_it_is_learned_within_ten_kilometres(density: float) -> None:
    found = [learned(density, 10e3, np.random.default_rng(seed)) for seed in range(RUNS)]
    assert np.mean(found) == pytest.approx(density, rel=0.25)


def test_a_level_line_takes_it_back_by_the_way() -> None:
    found = [learned(0.0, way_m, np.random.default_rng(1)) for way_m in (1e3, 3e3, 9e3)]
    assert found == sorted(found, reverse=True)
    assert found[0] < 0.6 * CONFIGURED
    assert found[-1] < 0.15 * CONFIGURED


def test_a_gradient_that_is_told_is_none_of_it() -> None:
    told, untold = Hilliness(CONFIGURED), Hilliness(CONFIGURED)
    for speed_mps, unmodelled_mps2 in run(5e-6, 5e3, np.random.default_rng(2)):
        told.see_coasting(speed_mps, SPEED_STD_MPS**2, unmodelled_mps2, STEP_S)
        untold.see_coasting(speed_mps, SPEED_STD_MPS**2, 0.0, STEP_S)
    assert told.density < 0.3 * CONFIGURED
    assert untold.density > 2.0 * CONFIGURED


def test_what_a_brake_did_in_between_is_none_of_it() -> None:
    hilliness = Hilliness(CONFIGURED)
    for speed_mps, retards_mps2 in ((30.0, 0.0), (20.0, 0.05), (10.0, 0.0)):
        for step in range(400):  # 8 s each: one whole stretch, and a part that must not be gone on with
            hilliness.see_coasting(speed_mps - retards_mps2 * step * STEP_S, 0.0, 0.0, STEP_S)
        hilliness.interrupt()
    assert hilliness.density == CONFIGURED


def test_no_line_is_as_hilly_as_a_coupling_that_jerks() -> None:
    hilliness = Hilliness(CONFIGURED)
    for step in range(5000):
        hilliness.see_coasting(20.0 + (step // 400 % 2), 0.0, 0.0, STEP_S)
        assert hilliness.density <= LARGEST
