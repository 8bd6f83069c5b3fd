"""Pads, discs, pneumatics, rail and profiles: each part of the plant by itself."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.simulator.pad import AMBIENT_C, DISC_HEAT_CAPACITY_JPK, Pad, steady_friction
from brake_monitor.simulator.pneumatics import (
    DUMP_TIME_CONSTANT_S,
    FULL_PRESSURE_BAR,
    VALVE_DELAY_S,
    BrakeGear,
    Cylinder,
    Supply,
    Valve,
)
from brake_monitor.simulator.rail import SAND_DELAY_S, Rail
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario, steps

STEP_S = 0.001


@given(st.floats(0.0, 30.0), st.floats(0.0, 1.0), st.floats(-20.0, 400.0))
def test_pad_friction_stays_in_the_band_of_organic_pads(speed: float, force: float, temperature: float) -> None:
    assert 0.30 <= steady_friction(speed, force, temperature) <= 0.45


def test_friction_rises_as_the_disc_slows_and_fades_when_it_is_hot() -> None:
    assert steady_friction(0.5, 0.5, 100.0) > steady_friction(15.0, 0.5, 100.0)
    assert steady_friction(15.0, 0.5, 600.0) < 0.9 * steady_friction(15.0, 0.5, 400.0)


def test_friction_does_not_jump_when_the_force_does() -> None:
    pad = Pad(full_force_n=60e3)
    pad.settle(15.0)
    before = pad.friction
    pad.step(STEP_S, 60e3, 15.0, 30.0)
    assert abs(pad.friction - before) < 1e-4


def test_the_disc_takes_the_heat_of_the_pads_and_gives_it_to_the_air() -> None:
    pad = Pad(full_force_n=60e3)
    heat_j = 0.0
    for _ in range(1000):
        heat_j += pad.friction * 50e3 * 10.0 * STEP_S
        pad.step(STEP_S, 50e3, 10.0, 20.0)
    assert pad.temperature_c - AMBIENT_C == pytest.approx(heat_j / DISC_HEAT_CAPACITY_JPK, rel=0.01)
    hot = pad.temperature_c
    for _ in range(1000):
        pad.step(STEP_S, 0.0, 0.0, 20.0)
    assert AMBIENT_C < pad.temperature_c < hot


@given(st.floats(0.0, 10.0))
def test_the_pressing_force_is_the_mapping_and_never_negative(pressure_bar: float) -> None:
    force_n = BrakeGear(18600.0, -4650.0).pressing_force_n(pressure_bar)
    assert force_n == (18600.0 * pressure_bar - 4650.0 if pressure_bar > 0.25 else 0.0)


def filled(cylinder: Cylinder, from_s: float, for_s: float) -> float:
    """Advance with full supply and return the time reached."""
    for k in range(round(for_s / STEP_S)):
        cylinder.step(from_s + k * STEP_S, STEP_S, FULL_PRESSURE_BAR)
    return from_s + for_s


def test_the_valve_moves_after_its_delay_and_dumps_with_its_time_constant() -> None:
    cylinder = Cylinder(pressure_bar=3.0)
    cylinder.command(0.0, Valve.HOLD)
    now = filled(cylinder, 0.0, 0.5)
    held = cylinder.pressure_bar
    cylinder.command(now, Valve.DUMP)
    now = filled(cylinder, now, VALVE_DELAY_S - STEP_S)
    assert cylinder.pressure_bar == held
    filled(cylinder, now, DUMP_TIME_CONSTANT_S + STEP_S)
    assert cylinder.pressure_bar == pytest.approx(held / 2.718, rel=0.02)


def test_a_full_brake_fills_within_the_usual_time_and_a_held_cylinder_empties_with_the_supply() -> None:
    supply, cylinder = Supply(), Cylinder()
    for k in range(1000):
        supply.step(STEP_S, 1.0)
        cylinder.step(k * STEP_S, STEP_S, supply.pressure_bar)
    assert 0.63 * FULL_PRESSURE_BAR < cylinder.pressure_bar < FULL_PRESSURE_BAR  # time constant below 1 s
    cylinder.command(1.0, Valve.HOLD)
    for k in range(3000):
        supply.step(STEP_S, 0.0)
        cylinder.step(1.0 + k * STEP_S, STEP_S, supply.pressure_bar)
    assert cylinder.pressure_bar < 0.05


def slippery(sanding_from_s: float = 0.0) -> Scenario:
    flat = Profile(((0.0, 0.05),))
    return Scenario("slippery", "", 30.0, 20.0, steps((5.0, 1.0)), flat, sanding_from_s=sanding_from_s)


def test_sand_lifts_a_slippery_rail_from_about_5_to_about_10_percent_after_a_delay() -> None:
    rail = Rail(slippery(), random.Random(1))
    before = rail.friction_level(100.0, 0)
    now_s = 0.0
    while now_s < SAND_DELAY_S - 0.1:
        rail.step(now_s, STEP_S, sanding=True)
        now_s += STEP_S
    assert rail.friction_level(100.0, 0) == before
    for _ in range(5000):
        rail.step(now_s, STEP_S, sanding=True)
    assert 0.08 < rail.friction_level(100.0, 0) < 0.11
    for _ in range(20000):
        rail.step(now_s, STEP_S, sanding=False)
    assert rail.friction_level(100.0, 0) == pytest.approx(before, rel=0.01)


def test_following_wheelsets_find_a_slippery_rail_a_little_better_and_a_dry_one_the_same() -> None:
    rail = Rail(slippery(), random.Random(1))
    levels = [rail.friction_level(100.0, passed) for passed in range(4)]
    assert levels == sorted(levels)
    assert levels[0] < levels[3] < 1.25 * levels[0]
    dry = Rail(SCENARIOS["dry"], random.Random(1))
    assert dry.friction_level(100.0, 0) == dry.friction_level(100.0, 3)


@given(st.floats(-100.0, 2000.0))
def test_the_rail_varies_smoothly_along_the_track(place_m: float) -> None:
    rail = Rail(slippery(), random.Random(1))
    assert abs(rail.friction_level(place_m + 0.01, 0) - rail.friction_level(place_m, 0)) < 1e-4


@given(st.floats(-1.0, 5.0))
def test_a_profile_stays_between_its_points(place: float) -> None:
    assert 1.0 <= Profile(((0.0, 1.0), (2.0, 3.0), (4.0, 2.0))).at(place) <= 3.0


def test_a_profile_out_of_order_is_refused() -> None:
    with pytest.raises(ValueError, match="ascending"):
        Profile(((1.0, 0.0), (0.0, 0.0)))


@pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=SCENARIOS)
def test_each_scenario_coasts_first(scenario: Scenario) -> None:
    assert all(scenario.demand.at(t / 10) == 0.0 for t in range(51))
