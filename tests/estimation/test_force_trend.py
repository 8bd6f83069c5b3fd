"""Forces that change slowly, and that the speed does not show, may follow the line; a brake that is put on does not."""

import numpy as np
import pytest

from brake_monitor.estimation.doubts.force_trend import ForceTrend

STEP_S = 0.01
HELD_MPS2 = 2.0  # what the brakes give per unit of friction
FRICTION = 0.35
BEGINS_MPS = 25.0


def hidden(*points: tuple[float, float], shown: float) -> list[float]:
    """The hidden rate after each step of a force that is linear between points of time and share of the held one.

    `shown`: how much of what the force gives the speed shows, beside a deceleration that stays.
    """
    times, shares = zip(*points, strict=True)
    trend, rates, rolling_mps = ForceTrend(), [], BEGINS_MPS
    for time_s in np.arange(STEP_S, times[-1], STEP_S):
        per_friction_mps2 = HELD_MPS2 * float(np.interp(time_s, times, shares))
        rolling_mps -= STEP_S * FRICTION * (shown * per_friction_mps2 + (1.0 - shown) * HELD_MPS2)
        trend.see(STEP_S, per_friction_mps2, rolling_mps, FRICTION)
        rates.append(trend.hidden_rate_mps3)
    return rates


@pytest.mark.parametrize("per_s", [0.03, 0.08, -0.03])
def test_a_change_that_the_speed_does_not_show_is_hidden(per_s: float) -> None:
    rates = hidden((0.0, 0.0), (1.0, 1.0), (6.0, 1.0), (11.0, 1.0 + 5.0 * per_s), shown=0.0)
    assert rates[-1] == pytest.approx(FRICTION * HELD_MPS2 * per_s, rel=0.05)


@pytest.mark.parametrize("per_s", [0.03, 0.08, -0.03])
def test_a_change_that_the_speed_shows_is_not(per_s: float) -> None:
    rates = hidden((0.0, 0.0), (1.0, 1.0), (6.0, 1.0), (11.0, 1.0 + 5.0 * per_s), shown=1.0)
    assert abs(rates[-1]) < 0.1 * FRICTION * HELD_MPS2 * abs(per_s)


def test_a_held_force_does_not_change() -> None:
    rates = hidden((0.0, 0.0), (1.0, 1.0), (10.0, 1.0), shown=1.0)
    assert rates[-1] == pytest.approx(0.0, abs=1e-4)


def test_nor_does_one_that_is_told_to_the_last_bit() -> None:
    trend = ForceTrend()
    for _ in range(1000):
        trend.see(STEP_S, 0.0, BEGINS_MPS, FRICTION)
    assert trend.hidden_rate_mps3 == 0.0


def test_what_was_told_seldom_leaves_no_trace_in_what_is_told_often() -> None:
    """Steps as long as these go past what forces are smoothed over."""
    trend = ForceTrend()
    for _ in range(30):
        trend.see(0.9, HELD_MPS2, BEGINS_MPS, FRICTION)
    for k in range(round(5.0 / STEP_S)):
        trend.see(STEP_S, HELD_MPS2 * (1.0 + 0.03 * k * STEP_S), BEGINS_MPS, FRICTION)
    assert trend.hidden_rate_mps3 == pytest.approx(FRICTION * HELD_MPS2 * 0.03, rel=0.05)


@pytest.mark.parametrize(("fills_s", "until"), [(1.0, 1.0), (4.0, 1.0), (25.0, 1.0)], ids=["disc brake", "P", "G"])
def test_a_brake_that_is_put_on_follows_no_line(fills_s: float, until: float) -> None:
    rates = hidden((0.0, 0.0), (until * fills_s, until), shown=1.0)
    assert max(abs(rate) for rate in rates) < 0.1 * FRICTION * HELD_MPS2 / fills_s


@pytest.mark.parametrize("share", [0.0, 0.8, 1.2])
def test_nor_does_a_step_of_the_driver(share: float) -> None:
    rates = hidden((0.0, 0.0), (1.0, 1.0), (6.0, 1.0), (6.8, share), (12.0, share), shown=1.0)
    assert max(abs(rate) for rate in rates) < 0.06 * FRICTION * HELD_MPS2  # a quarter per second while it steps


def test_a_release_that_the_speed_has_shown_says_nothing_of_the_next_braking() -> None:
    trend, rolling_mps = ForceTrend(), BEGINS_MPS
    for time_s in np.arange(STEP_S, 20.0, STEP_S):
        per_friction_mps2 = HELD_MPS2 * float(np.interp(time_s, (0.0, 1.0, 5.0, 20.0), (0.0, 1.0, 1.0, 0.7)))
        rolling_mps -= STEP_S * FRICTION * per_friction_mps2
        trend.see(STEP_S, per_friction_mps2, rolling_mps, FRICTION)
    assert abs(trend.hidden_rate_mps3) < 1e-3
    trend.rest()
    for time_s in np.arange(STEP_S, 10.0, STEP_S):
        per_friction_mps2 = HELD_MPS2 * (1.0 + 0.03 * time_s)
        rolling_mps -= STEP_S * FRICTION * HELD_MPS2
        trend.see(STEP_S, per_friction_mps2, rolling_mps, FRICTION)
    assert trend.hidden_rate_mps3 == pytest.approx(0.03 * FRICTION * HELD_MPS2, rel=0.1)
