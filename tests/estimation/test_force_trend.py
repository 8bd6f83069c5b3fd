"""Forces that change slowly may follow the line; what a driver, a filling cylinder or its release does is quicker."""

import numpy as np
import pytest

from brake_monitor.estimation.doubts.force_trend import ForceTrend

STEP_S = 0.01
HELD_MPS2 = 2.0  # what the brakes give per unit of friction


def seen(*points: tuple[float, float]) -> list[float]:
    """The slow rate after each step of a force that is linear between points of time and share of the held one."""
    times, shares = zip(*points, strict=True)
    trend, rates = ForceTrend(), []
    for time_s in np.arange(STEP_S, times[-1], STEP_S):
        trend.see(STEP_S, HELD_MPS2 * float(np.interp(time_s, times, shares)))
        rates.append(trend.slow_rate_mps3)
    return rates


@pytest.mark.parametrize("per_s", [0.03, -0.03])
def test_a_slow_change_is_followed(per_s: float) -> None:
    rates = seen((0.0, 0.0), (1.0, 1.0), (6.0, 1.0), (11.0, 1.0 + 5.0 * per_s))
    assert rates[-1] == pytest.approx(HELD_MPS2 * per_s, rel=0.03)


def test_a_held_force_does_not_change() -> None:
    assert seen((0.0, 0.0), (1.0, 1.0), (10.0, 1.0))[-1] == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize(("fills_s", "until"), [(1.0, 1.0), (4.0, 1.0), (25.0, 0.8)], ids=["disc brake", "P", "G"])
def test_a_brake_that_is_put_on_follows_no_line(fills_s: float, until: float) -> None:
    assert not any(seen((0.0, 0.0), (until * fills_s, until)))


@pytest.mark.parametrize("share", [0.0, 0.8, 1.2])
def test_nor_does_a_step_of_the_driver(share: float) -> None:
    rates = seen((0.0, 0.0), (1.0, 1.0), (6.0, 1.0), (6.8, share), (12.0, share))
    assert max(abs(rate) for rate in rates) < 0.06 * HELD_MPS2  # before it is seen to be quick, a quarter per second
