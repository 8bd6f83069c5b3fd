"""How much a line's gradient changes with the way is learned while the wagon rolls freely: it adds to the tuning."""

import random
from math import sqrt

import pytest

from brake_monitor.estimation.rolling.line_roughness import (
    LARGEST_DENSITY,
    LARGEST_LOOK,
    LONGEST_WAY_M,
    PRIOR_M,
    LineRoughness,
)
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.scenarios import Profile, Scenario, Track, steps
from drives import drive, play_to

EXPECTED = 1e-6
STEP_M = 20.0
NOISE_STD = 0.006  # m/s², of d as the filter knows it while rolling


def learned(density: float, *, way_m: float, pulled: float = 0.0, noise_std: float = NOISE_STD) -> LineRoughness:
    """Of a line whose d walks by this density, reverting to 0 as lines do; pulled over a share of each kilometre."""
    rng, line, d_mps2, place_m = random.Random(7), LineRoughness(EXPECTED), 0.0, 0.0
    while place_m < way_m:
        place_m += STEP_M
        d_mps2 += rng.gauss(0.0, sqrt(density * STEP_M)) - d_mps2 * STEP_M / 2500.0
        pull_mps2 = 0.3 if place_m % 1000.0 < 1000.0 * pulled else 0.0
        line.see_rolling(place_m, d_mps2 + rng.gauss(0.0, noise_std) - pull_mps2, noise_std**2)
    return line


@pytest.mark.parametrize("density", [3e-6, 8e-6])
def test_a_hilly_line_is_learned(density: float) -> None:
    assert learned(density, way_m=60e3).density == pytest.approx(density, rel=0.4)  # of some hundred independent looks
    assert learned(density, way_m=60e3).more == pytest.approx(density - EXPECTED, rel=0.5)


def test_a_level_line_takes_nothing_from_what_is_expected() -> None:
    line = learned(0.0, way_m=60e3)
    assert line.density < 0.5 * EXPECTED
    assert line.more == 0.0


def test_noise_of_the_sensors_is_not_the_line() -> None:
    assert learned(0.0, way_m=60e3, noise_std=0.019).more == 0.0


def test_a_d_that_is_not_known_tells_nothing() -> None:
    assert learned(8e-6, way_m=60e3, noise_std=0.03).density == EXPECTED


def test_where_the_wagon_is_pulled_nothing_is_looked_at() -> None:
    assert learned(0.0, way_m=60e3, pulled=0.5).more == 0.0


def test_where_d_is_not_the_lines_nothing_is_learned() -> None:
    line = LineRoughness(0.0)
    line.density = 8e-6  # of a memory from when the preset was another
    for k in range(100):
        line.see_rolling(400.0 * k, 0.1 * (k % 2), 1e-6)
    assert line.density == 8e-6
    assert line.more == 0.0


def test_what_lies_too_far_back_is_not_compared_with() -> None:
    """By one look it would decide alone; what comes next is compared with the new one."""
    line = LineRoughness(EXPECTED)
    line.see_rolling(0.0, 0.0, 1e-6)
    line.see_rolling(LONGEST_WAY_M + 1.0, 0.4, 1e-6)
    assert line.density == EXPECTED
    line.see_rolling(LONGEST_WAY_M + 401.0, 0.2, 1e-6)
    assert line.density > EXPECTED


def test_what_has_changed_otherwise_is_not_looked_at() -> None:
    """As a gradient that is told no more, which d takes over."""
    line = LineRoughness(EXPECTED)
    line.see_rolling(0.0, 0.0, 1e-6)
    line.forget_look()
    line.see_rolling(400.0, 0.2, 1e-6)
    assert line.density == EXPECTED
    line.see_rolling(800.0, 0.2, 1e-6)
    assert line.density < EXPECTED


def test_one_look_does_not_decide() -> None:
    line = LineRoughness(EXPECTED)
    line.see_rolling(0.0, 0.0, 1e-6)
    line.see_rolling(300.0, 0.3, 1e-6)
    assert EXPECTED < line.density <= EXPECTED + (LARGEST_LOOK - EXPECTED) * 300.0 / PRIOR_M


def test_nothing_is_taken_for_rougher_than_the_roughest_line() -> None:
    line = LineRoughness(EXPECTED)
    for k in range(200):
        line.see_rolling(400.0 * k, 0.3 * (k % 2), 1e-6)
    assert line.density == LARGEST_DENSITY


CLIMB = 0.01
UP_AND_DOWN = Profile(
    tuple((500.0 * k + ramp_m, CLIMB * (k % 2)) for k in range(4) for ramp_m in (0.0, 450.0)),
)
LEVEL = Profile(((0.0, 0.0),))


def over(gradient: Profile) -> Scenario:
    return Scenario(
        name="coasting, then a brake",
        summary="coast for 50 s, brake until 60 s",
        initial_speed_mps=32.0,
        duration_s=60.0,
        demand=steps((50.0, 0.5)),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=Track(gradient=gradient, curvature_pm=LEVEL),
    )


def after(settings: Settings, gradient: Profile) -> tuple[float, float]:
    """The density of d by the way as learned, and the friction's deviation, after a drive."""
    pipeline = Pipeline.from_settings(settings)
    told = play_to(pipeline, list(drive(over(gradient)).frames))
    found = pipeline.estimator.learned()
    assert found is not None
    assert found.deceleration_per_metre is not None
    return found.deceleration_per_metre, max(wheelset.friction_std for wheelset in told[-1].wheelsets)


def test_friction_is_less_sure_on_a_line_that_has_gone_up_and_down() -> None:
    settings = example_settings("wagon")
    (rough, unsure), (level, sure) = after(settings, UP_AND_DOWN), after(settings, LEVEL)
    assert level <= EXPECTED
    assert rough > 3.0 * EXPECTED
    assert unsure > 1.1 * sure
