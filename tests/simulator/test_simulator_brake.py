"""Pads, discs, pneumatics, rail and profiles: each part of the plant by itself."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.simulator.physics.pad import (
    AMBIENT_C,
    DISC_HEAT_CAPACITY_JPK,
    disc_temperature,
    following,
    steady_friction,
)
from brake_monitor.simulator.physics.pneumatics import (
    DUMP,
    DUMP_TIME_CONSTANT_S,
    FILL,
    FULL_PRESSURE_BAR,
    HOLD,
    VALVE_DELAY_S,
    DelayedValve,
    Valve,
    cylinder_after,
    supply_after,
)
from brake_monitor.simulator.physics.rail import SAND_DELAY_S, Rail, friction_level
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario, steps

STEP_S = 0.001


@given(st.floats(0.0, 30.0), st.floats(0.0, 1.0), st.floats(-20.0, 400.0))
def test_pad_friction_stays_in_the_band_of_organic_pads(speed: float, force: float, temperature: float) -> None:
    assert 0.30 <= steady_friction(speed, force, temperature) <= 0.45


def test_friction_rises_as_the_disc_slows_and_fades_when_it_is_hot() -> None:
    assert steady_friction(0.5, 0.5, 100.0) > steady_friction(15.0, 0.5, 100.0)
    assert steady_friction(15.0, 0.5, 600.0) < 0.9 * steady_friction(15.0, 0.5, 400.0)


def test_friction_does_not_jump_when_the_force_does() -> None:
    before = steady_friction(15.0, 0.0, AMBIENT_C)
    after = following(before, STEP_S, steady_friction(15.0, 1.0, AMBIENT_C))
    assert 0.0 < abs(after - before) < 1e-4


def test_the_disc_takes_the_heat_of_the_pads_and_gives_it_to_the_air() -> None:
    heat_j, hot_c = 0.0, AMBIENT_C
    for _ in range(1000):
        heat_j += 170e3 * STEP_S
        hot_c = disc_temperature(hot_c, STEP_S, 170e3, 20.0)
    assert hot_c - AMBIENT_C == pytest.approx(heat_j / DISC_HEAT_CAPACITY_JPK, rel=0.01)
    cooled_c = hot_c
    for _ in range(1000):
        cooled_c = disc_temperature(cooled_c, STEP_S, 0.0, 20.0)
    assert AMBIENT_C < cooled_c < hot_c
    assert disc_temperature(hot_c, STEP_S, 0.0, -20.0) == disc_temperature(hot_c, STEP_S, 0.0, 20.0)  # backwards


def after(pressure_bar: float, for_s: float, valve: float, supply_bar: float, least_bar: float = 0.0) -> float:
    for _ in range(round(for_s / STEP_S)):
        pressure_bar = cylinder_after(pressure_bar, STEP_S, valve, supply_bar, least_bar)
    return pressure_bar


def test_the_valve_moves_after_its_delay() -> None:
    valve = DelayedValve()
    valve.command(1.0, Valve.DUMP)
    assert valve.come_to(1.0 + VALVE_DELAY_S - STEP_S) is Valve.FILL
    assert valve.come_to(1.0 + VALVE_DELAY_S) is Valve.DUMP


def test_a_cylinder_holds_and_dumps_with_its_time_constant() -> None:
    assert after(3.0, 0.5, HOLD, FULL_PRESSURE_BAR) == 3.0
    assert after(3.0, DUMP_TIME_CONSTANT_S, DUMP, FULL_PRESSURE_BAR) == pytest.approx(3.0 / 2.718, rel=0.01)


def test_a_full_brake_fills_within_the_usual_time_and_a_held_cylinder_empties_with_the_supply() -> None:
    supply_bar, cylinder_bar = 0.0, 0.0
    for _ in range(1000):
        supply_bar = supply_after(supply_bar, STEP_S, 1.0)
        cylinder_bar = cylinder_after(cylinder_bar, STEP_S, FILL, supply_bar, 0.0)
    assert 0.63 * FULL_PRESSURE_BAR < cylinder_bar < FULL_PRESSURE_BAR  # time constant below 1 s
    assert after(cylinder_bar, 3.0, HOLD, 0.0) < 0.05


def test_a_cylinder_that_keeps_a_rest_neither_empties_below_it_nor_fills_by_itself() -> None:
    assert after(3.0, 5.0, FILL, 0.0, least_bar=0.6) == pytest.approx(0.6)
    assert after(0.2, 5.0, FILL, 0.2, least_bar=0.6) == pytest.approx(0.2)


def slippery() -> Scenario:
    flat = Profile(((0.0, 0.05),))
    return Scenario("slippery", "", 30.0, 20.0, steps((5.0, 1.0)), flat)


def level_at(rail: Rail, position_m: float, passed: int) -> float:
    return friction_level(position_m, passed, rail.state)


def test_sand_lifts_a_slippery_rail_from_about_5_to_about_10_percent_after_a_delay() -> None:
    rail = Rail(slippery(), random.Random(1))
    before = level_at(rail, 100.0, 0)
    now_s = 0.0
    while now_s < SAND_DELAY_S - 0.1:
        rail.step(now_s, STEP_S, sanding=True)
        now_s += STEP_S
    assert level_at(rail, 100.0, 0) == before
    for _ in range(5000):
        rail.step(now_s, STEP_S, sanding=True)
    assert 0.08 < level_at(rail, 100.0, 0) < 0.11
    for _ in range(20000):
        rail.step(now_s, STEP_S, sanding=False)
    assert level_at(rail, 100.0, 0) == pytest.approx(before, rel=0.01)


def test_following_wheelsets_find_a_slippery_rail_a_little_better_and_a_dry_one_the_same() -> None:
    rail = Rail(slippery(), random.Random(1))
    levels = [level_at(rail, 100.0, passed) for passed in range(4)]
    assert levels == sorted(levels)
    assert levels[0] < levels[3] < 1.25 * levels[0]
    dry = Rail(SCENARIOS["dry"], random.Random(1))
    assert level_at(dry, 100.0, 0) == level_at(dry, 100.0, 3)


@given(st.floats(-100.0, 2000.0))
def test_the_rail_varies_smoothly_along_the_track(position_m: float) -> None:
    rail = Rail(slippery(), random.Random(1))
    assert abs(level_at(rail, position_m + 0.01, 0) - level_at(rail, position_m, 0)) < 1e-4


@given(st.floats(-1.0, 5.0))
def test_a_profile_stays_between_its_points(place: float) -> None:
    assert 1.0 <= Profile(((0.0, 1.0), (2.0, 3.0), (4.0, 2.0))).at(place) <= 3.0


def test_a_profile_out_of_order_is_refused() -> None:
    with pytest.raises(ValueError, match="ascending"):
        Profile(((1.0, 0.0), (0.0, 0.0)))


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=SCENARIOS)
def test_each_scenario_coasts_first(scenario: Scenario) -> None:
    assert all(scenario.demand.at(t / 10) == 0.0 for t in range(51))
