"""Whether a pressing force is told late, by what its wheelset does whenever the force changes."""

from itertools import cycle, islice

import numpy as np
import pytest

from brake_monitor.estimation.consistency import ForceTiming

STD_RADPS = 0.08  # of a wheel speed's innovation
SEEN_RADPS2 = (
    -10.0,
    -13.0,
    -20.0,
    -26.0,
    -20.0,
    -13.0,
)  # what a brake does that is vented and filled, reading by reading


def told_late(lag_s: float, readings: int, surprise_radps: float = 0.0) -> list[bool]:
    """What is said at each reading; innovations are what a lag leaves, noise, and in the last one a surprise."""
    rng, timing, last_radps2 = np.random.default_rng(1), ForceTiming(), SEEN_RADPS2[-1]
    said = []
    for k, brake_radps2 in enumerate(islice(cycle(SEEN_RADPS2), readings)):
        residual = -lag_s * (brake_radps2 - last_radps2) + rng.normal() * STD_RADPS
        residual += surprise_radps if k == readings - 1 else 0.0
        last_radps2 = brake_radps2
        said.append(timing.see(brake_radps2, residual, STD_RADPS**2))
    return said


@pytest.mark.parametrize("lag_s", [-0.02, 0.0, 0.006])
def test_a_force_that_is_on_time_is_in_no_doubt(lag_s: float) -> None:
    """What is left of no lag at all, at least and at most."""
    assert not any(told_late(lag_s, 600))


@pytest.mark.parametrize("lag_s", [0.015, 0.03])
def test_a_force_that_lags_is(lag_s: float) -> None:
    """What lasting lags of 0.1 s leave."""
    assert all(told_late(lag_s, 300)[100:])


@pytest.mark.parametrize("readings", range(60, 80))
def test_a_rail_that_slips_away_as_the_brake_is_vented_makes_no_lag(readings: int) -> None:
    """Slide protection vents because the wheelset falls: the two come at once now and then."""
    assert not any(told_late(0.006, readings, surprise_radps=-10.0))
