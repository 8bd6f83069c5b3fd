"""A line whose gradient is a random walk of the way."""

import numpy as np
import pytest

from brake_monitor.simulator.line import undulating_line

FIRST_STD, DENSITY_PM = 0.01, 5e-9
SEEDS, LONGEST_M = 400, 1000.0


def gradients(position_m: float) -> np.ndarray:
    lines = (undulating_line(seed, LONGEST_M, FIRST_STD, DENSITY_PM) for seed in range(SEEDS))
    return np.array([line.gradient.at(position_m) for line in lines])


@pytest.mark.parametrize("way_m", [100.0, 1000.0])
def test_its_gradient_changes_by_the_root_of_the_way(way_m: float) -> None:
    changes = gradients(way_m) - gradients(0.0)
    assert np.mean(changes) == pytest.approx(0.0, abs=4.0 * np.sqrt(DENSITY_PM * way_m / SEEDS))
    assert np.mean(changes**2) == pytest.approx(DENSITY_PM * way_m, rel=0.3)  # four sigma of a variance


def test_what_it_has_at_first_is_not_known_either() -> None:
    assert np.std(gradients(0.0)) == pytest.approx(FIRST_STD, rel=0.15)


def test_the_seed_decides() -> None:
    one, same, other = (undulating_line(seed, LONGEST_M, FIRST_STD, DENSITY_PM) for seed in (1, 1, 2))
    assert one == same
    assert one != other
    assert not any(value for _, value in one.curvature_pm.points)
