"""What brakes take from the speed, against how the wagon rolled just before."""

import pytest

from brake_monitor.monitoring.inputs.retardation import EXPIRES_S, Retardation, mean_retardation_mps2
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

BRAKES_MPS2 = 0.5
STEP_S = 0.1
ROTATING_KG = 2.0 * 118.0 / 0.445**2  # what two wheelsets weigh more as they turn


def by_brakes_mps2(*legs: tuple[float, float, float]) -> float | None:
    """At the end of these, one after the other: how long each lasts, what line and brakes take from the speed."""
    vehicle = example_settings("wagon").vehicle
    retardation, time_s, speed_mps = Retardation(vehicle), 0.0, 40.0
    own = wheelset(motor_force_n=0.0)
    for lasts_s, line_mps2, brakes_mps2 in legs:
        for _ in range(round(lasts_s / STEP_S)):
            now = estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=(own, own), mass_kg=vehicle.mass_kg)
            retardation.see(now, rolls_freely=brakes_mps2 == 0.0)
            time_s += STEP_S
            speed_mps -= STEP_S * (vehicle.resistance_n(speed_mps) / vehicle.mass_kg + line_mps2 + brakes_mps2)
    return retardation.by_brakes_mps2


def test_it_is_told_against_what_the_line_took_before() -> None:
    assert by_brakes_mps2((20.0, 0.1, 0.0), (5.0, 0.1, BRAKES_MPS2)) == pytest.approx(BRAKES_MPS2, abs=0.01)


def test_of_a_line_that_has_changed_only_what_came_after_counts() -> None:
    found = by_brakes_mps2((20.0, -0.1, 0.0), (8.0, 0.15, 0.0), (5.0, 0.15, BRAKES_MPS2))
    assert found == pytest.approx(BRAKES_MPS2, abs=0.02)


def test_a_pull_that_ends_is_forgotten_at_once() -> None:
    """It has ended for 7 s, the first 3 of which are still of both."""
    found = by_brakes_mps2((20.0, 0.0, 0.0), (7.0, 0.14, 0.0), (5.0, 0.14, BRAKES_MPS2))
    assert found == pytest.approx(BRAKES_MPS2, abs=0.03)


def test_while_a_wagon_is_pulled_nothing_shows_what_the_line_takes() -> None:
    assert by_brakes_mps2((20.0, 0.1, 0.0), (10.0, -0.5, 0.0), (5.0, 0.1, BRAKES_MPS2)) is None


def test_a_gradient_that_lies_further_behind_has_no_say() -> None:
    found = by_brakes_mps2((60.0, 0.1, 0.0), (20.0, 0.16, 0.0), (5.0, 0.16, BRAKES_MPS2))
    assert found == pytest.approx(BRAKES_MPS2, abs=0.02)


@pytest.mark.parametrize(("rolls_s", "is_told"), [(5.0, False), (6.2, True)])
def test_a_wagon_has_to_roll_for_two_seconds_before_it_shows_what_the_line_takes(rolls_s: float, is_told: bool) -> None:
    """After two in which the brakes come off, and as many as a mean takes."""
    assert (by_brakes_mps2((rolls_s, 0.1, 0.0), (5.0, 0.1, BRAKES_MPS2)) is not None) is is_told


@pytest.mark.parametrize(
    ("times_s", "expected"),
    [
        ([0.1 * k for k in range(8)], 0.7),
        ([0.1 * k for k in range(7)], None),
        ([5.0] * 8, None),
        ([1e9 + 0.1 * k**1.5 for k in range(20)], 0.7),
    ],
    ids=["enough", "too few", "all at once", "here and there"],
)
def test_the_mean_retardation_of_a_steady_braking_is_that(times_s: list[float], expected: float | None) -> None:
    speeds_mps = [20.0 - 0.7 * (time_s - times_s[0]) for time_s in times_s]
    found = mean_retardation_mps2(times_s, speeds_mps)
    assert found == (None if expected is None else pytest.approx(expected, rel=1e-5))


def test_time_that_stands_still_breaks_nothing() -> None:
    """As while no speed comes: the estimate is of the same instant, and may be the first that tells of free rolling."""
    retardation, own = Retardation(example_settings("wagon").vehicle), wheelset(motor_force_n=0.0)
    for time_s in (0.0, 100.0, 100.1, *[100.2] * 10):
        now = estimate(time_s=time_s, speed_mps=20.0, wheelsets=(own, own))
        retardation.see(now, rolls_freely=time_s > 0.0)
    assert retardation.by_brakes_mps2 is None


def test_a_line_that_was_long_ago_says_nothing() -> None:
    braked_s = 4.0
    for creeping_s, is_told in ((EXPIRES_S - braked_s - 5.0, True), (EXPIRES_S, False)):
        found = by_brakes_mps2((20.0, 0.1, 0.0), (creeping_s, 0.1, 0.01), (braked_s, 0.1, BRAKES_MPS2))
        assert (found is not None) is is_told


def after_seconds(
    seconds: float, *, line_mps2: float = 0.1, motor_n: float | None = 0.0, speed_mps: float = 20.0, step_s: float = 0.1
) -> Retardation:
    """Of a wagon that is slowed down by the line, and by each of its motors at the rail, where they say how much."""
    vehicle = example_settings("wagon").vehicle
    retardation, own = Retardation(vehicle), wheelset(motor_force_n=motor_n)
    by_motors_mps2 = 2.0 * (motor_n or 0.0) / (vehicle.mass_kg + ROTATING_KG)
    for k in range(round(seconds / step_s)):
        now = estimate(time_s=step_s * k, speed_mps=speed_mps, wheelsets=(own, own), mass_kg=vehicle.mass_kg)
        retardation.see(now, rolls_freely=not motor_n)
        speed_mps -= step_s * (vehicle.resistance_n(speed_mps) / vehicle.mass_kg + line_mps2 + by_motors_mps2)
    return retardation


@pytest.mark.parametrize("motor_n", [5e3, -3e3])
def test_what_motors_take_and_give_is_theirs(motor_n: float) -> None:
    vehicle = example_settings("wagon").vehicle
    assert (vehicle.wheelset_inertia_kgm2, vehicle.wheel_radius_m) == ((118.0, 118.0), (0.445, 0.445))
    retardation = after_seconds(3.0, motor_n=motor_n)
    assert retardation.by_motors_mps2 == pytest.approx(2.0 * motor_n / (vehicle.mass_kg + ROTATING_KG))
    assert retardation.total_mps2 == pytest.approx(0.1, abs=0.002)


@pytest.mark.parametrize(
    ("drive", "is_told"),
    [
        ({}, True),
        ({"motor_n": None}, False),
        ({"speed_mps": 4.0}, True),
        ({"speed_mps": 2.5}, False),  # a crawl
        ({"step_s": 0.8}, False),  # too few
    ],
)
def test_where_too_little_is_known_no_retardation_is_told(drive: dict[str, float], is_told: bool) -> None:
    assert (after_seconds(3.0, **drive).total_mps2 is not None) is is_told


@pytest.mark.parametrize(("line_mps2", "is_pulled"), [(0.1, False), (-0.01, False), (-0.2, True)])
def test_a_wagon_that_gains_speed_by_itself_is_pulled(line_mps2: float, is_pulled: bool) -> None:
    assert after_seconds(3.0, line_mps2=line_mps2).is_pulled is is_pulled
    assert not after_seconds(0.5, line_mps2=line_mps2).is_pulled  # nothing shows yet
