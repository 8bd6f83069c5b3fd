"""A force that stands still while its wheelset slides time and again; and those that stand still by right."""

from collections.abc import Callable
from math import cos, pi

import pytest

from brake_monitor.estimation.doubts.consistency import STILL, Consistency, WheelChecks
from brake_monitor.estimation.doubts.still_force import StillForce

PERIOD_S = 1.2  # of slides that a slide protection ends
STEP_S = 0.01

Over = Callable[[float], float]


def slides(time_s: float) -> float:
    """Slip between 0 and 0.12, time and again."""
    return 0.06 * (1.0 - cos(2.0 * pi * time_s / PERIOD_S))


def renewals(
    force_n: Over,
    slip: Over,
    until_s: float,
    *,
    step_s: float = STEP_S,
    speed_mps: float = 25.0,
    doubted_from: int = 1,
) -> list[int]:
    force, counted = StillForce(), []
    for k in range(round(until_s / step_s)):
        is_doubted = force.see(k * step_s, force_n(k * step_s), slip(k * step_s), speed_mps)
        is_new = force.renewals > (counted[-1] if counted else 0)
        assert is_doubted is (is_new and force.renewals >= doubted_from)
        counted.append(force.renewals)
    return counted


@pytest.mark.parametrize("force_n", [0.0, 30e3])
def test_each_slide_but_the_first_one_tells(force_n: float) -> None:
    counted = renewals(lambda t: force_n, slides, 4.0 * PERIOD_S)
    assert counted[round(PERIOD_S / STEP_S)] == 0
    assert counted[-1] == 3


@pytest.mark.parametrize("until_s", [10.0, 0.4])
def test_a_force_that_only_trembles_is_measured_before_the_valves(until_s: float) -> None:
    """Of the third slide anew: one or two may be the rail's doing. It need not go on trembling."""
    force_n: Over = lambda t: 30e3 + 10.0 * (t < until_s and int(t / 0.3) % 2)  # noqa: E731
    assert renewals(force_n, slides, 5.0 * PERIOD_S, doubted_from=3)[-1] == 4


def test_a_force_that_moves_as_slide_protection_moves_it_is_measured() -> None:
    assert renewals(lambda t: 30e3 + 1e3 * (int(t / 0.3) % 2), slides, 10.0)[-1] == 0


def test_a_steady_brake_that_comes_upon_a_slippery_rail_is_none() -> None:
    """The valve answers after 0.3 s; until then its sensor rightly says what it said for a minute."""
    force_n: Over = lambda t: 40e3 if t < 60.3 else 40e3 - 20e3 * (t - 60.3)  # noqa: E731
    assert renewals(force_n, lambda t: 0.0 if t < 60.0 else slides(t - 60.0), 62.0)[-1] == 0


@pytest.mark.parametrize("held_n", [0.0, 8e3])
def test_a_brake_that_is_held_while_its_wheelset_finds_back_to_rolling_is_none(held_n: float) -> None:
    slip: Over = lambda t: 0.08 + 0.2 * t if t < 0.4 else max(0.16 - 0.05 * (t - 0.4), 0.0)  # noqa: E731
    assert renewals(lambda t: held_n, slip, 6.0)[-1] == 0


def test_a_wheelset_without_slide_protection_that_locks_slides_once() -> None:
    assert renewals(lambda t: 40e3, lambda t: min(0.2 * t, 1.0), 10.0)[-1] == 0


def test_what_is_told_slowly_may_have_moved_between_two_readings() -> None:
    step_s = 0.25 * PERIOD_S
    assert renewals(lambda t: 0.0, slides, 9 * step_s, step_s=step_s)[-1] == 0
    assert renewals(lambda t: 0.0, slides, 9 * PERIOD_S, step_s=step_s)[-1] > 0


def test_slides_within_a_second_leave_a_valve_no_time_to_answer() -> None:
    assert renewals(lambda t: 30e3, lambda t: slides(2.4 * t), 0.9)[-1] == 0


def test_where_nothing_seems_to_press_less_slip_tells() -> None:
    """A rail that changes lets slip grow and fall at the same force; who is not braked finds back to rolling."""
    slip: Over = lambda t: 0.3 * slides(t)  # noqa: E731
    assert renewals(lambda t: 30e3, slip, 4.0 * PERIOD_S)[-1] == 0
    assert renewals(lambda t: 0.0, slip, 4.0 * PERIOD_S)[-1] == 3


@pytest.mark.parametrize("force_n", [0.0, 30e3])
def test_what_a_lagging_vehicle_speed_makes_up_tells_nothing(force_n: float) -> None:
    """By 0.4 s, while the wagon's deceleration swings by 1 m/s²: the slower it is, the more slip that seems to be."""
    speed_mps = 5.0
    slip: Over = lambda t: 0.4 * (1.0 - cos(2.0 * pi * t / PERIOD_S)) / 2.0 / speed_mps  # noqa: E731
    assert renewals(lambda t: force_n, slip, 4.0 * PERIOD_S, speed_mps=speed_mps)[-1] == 0


def test_a_wheelset_that_spins_under_its_motor_and_finds_back_is_none() -> None:
    """On a slippery rail, one that rolls meanwhile with the slip that coarse speeds make."""
    assert renewals(lambda t: 0.0, lambda t: 0.03 - 5.0 * slides(t), 6.0 * PERIOD_S, speed_mps=2.0)[-1] == 0


def test_a_wagon_that_stops_in_a_slide_has_no_speed_to_divide_by() -> None:
    force = StillForce()
    for k in range(100):
        force.see(k * STEP_S, 30e3, slides(k * STEP_S), 25.0)
    assert not force.see(1.0, 30e3, 0.0, 0.0)


def test_a_clock_that_is_set_back_begins_anew() -> None:
    force = StillForce()
    for k in range(round(3.0 * PERIOD_S / STEP_S)):
        force.see(1000.0 + k * STEP_S, 0.0, slides(k * STEP_S), 25.0)
    assert force.renewals == 2
    force.see(5.0, 0.0, 0.0, 25.0)
    assert force.renewals == 0


@pytest.mark.parametrize(("noise_sigmas", "is_doubted"), [(1.0, True), (30.0, False)])
def test_slip_that_a_vehicle_speed_makes_up_as_it_scatters_is_none(noise_sigmas: float, is_doubted: bool) -> None:
    """Its readings are off by so many deviations, now to this side and now to the other."""
    checks, wheel = Consistency(), WheelChecks()
    for k in range(round(4.0 * PERIOD_S / STEP_S)):
        checks.see_speed(k * STEP_S, noise_sigmas * (-1.0) ** k, 1.0)
        checks.see_force(k * STEP_S, wheel, 30e3, slides(k * STEP_S), 25.0)
    assert checks.is_on(STILL, 4.0 * PERIOD_S) is is_doubted
    assert (wheel.still.renewals > 0) is is_doubted


@pytest.mark.parametrize("lasts_s", [0.02, 0.05])
def test_readings_of_a_wheel_speed_that_err_are_no_slides(lasts_s: float) -> None:
    slip: Over = lambda t: 0.06 if t % 1.1 < lasts_s else 0.001  # noqa: E731
    assert renewals(lambda t: 0.0, slip, 20.0)[-1] == 0


@pytest.mark.parametrize("slip", [0.5, 1.0])
def test_a_wheel_speed_that_is_0_for_moments_and_back_at_once_is_no_slide(slip: float) -> None:
    """A loose contact: no wheelset stops from one reading to the next. One that slips by half may have."""
    counted = renewals(lambda t: 30e3, lambda t: slip if t % 1.0 < 0.3 else 0.0, 10.0)
    assert (counted[-1] == 0) is (slip == 1.0)


def test_what_slides_after_it_rolled_for_a_while_is_another_slide() -> None:
    """A vehicle speed that jumps now and then looks like one."""
    slip: Over = lambda t: 0.06 if t % 4.0 < 0.5 else 0.001  # noqa: E731
    assert renewals(lambda t: 0.0, slip, 30.0)[-1] == 0
