"""Brakes that are at fault, as the plant has it, through frames and pipeline: what is told of them, and what is not."""

from functools import cache

import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.alarm_settings import BrakeNotAppliedRule
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.physics.coupler import GivenPull
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, Track, steps
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S, run

BRAKE_KINDS = {
    "dragging_brake",
    "brake_not_applied",
    "uneven_braking",
    "friction_out_of_band",
    "friction_drift",
    "hot_disc",
    "pad_near_limit",
    "pad_at_limit",
}
RELEASE_S = 20.0
WITHIN_S = 30.0  # of the release a brake that drags is told
STRAIGHT = Profile(((0.0, 0.0),))


@cache
def alarms(modifiers: Modifiers, track: Track | None = None, wagon: str = "wagon") -> tuple[Alarm, ...]:
    """Of a drive that brakes from 10 s to 20 s and then coasts: each alarm as it was raised, times from the start."""
    scenario = Scenario(
        name="one braking",
        summary="coast, brake from 10 s to 20 s, coast",
        initial_speed_mps=30.0,
        duration_s=RELEASE_S + WITHIN_S + 1.0,
        demand=steps((10.0, 0.55), (RELEASE_S, 0.0)),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=track,
    )
    settings = example_settings(wagon)
    pipeline = Pipeline.from_settings(settings)
    frames = run(scenario, settings, 4, modifiers).frames
    changed = [alarm for frame in frames for alarm in pipeline.step(frame).alarms if alarm.kind in BRAKE_KINDS]
    return tuple({alarm.id: alarm for alarm in reversed(changed)}.values())


def kinds(raised: tuple[Alarm, ...]) -> set[tuple[str, int | None]]:
    return {(alarm.kind, alarm.wheelset) for alarm in raised}


def fault(**what: object) -> Modifiers:
    return Modifiers(brake_faults=(BrakeFault(0, **what),))  # type: ignore[arg-type]


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_sound_brakes_raise_nothing(wagon: str) -> None:
    assert alarms(Modifiers(), wagon=wagon) == ()


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_residual_pressure_is_a_dragging_brake_within_30_s(wagon: str) -> None:
    raised = alarms(fault(residual_bar=0.6), wagon=wagon)
    assert kinds(raised) == {("dragging_brake", 1)}
    assert RELEASE_S < raised[0].raised_time_s - EPOCH_S < RELEASE_S + WITHIN_S


def test_two_of_four_cylinders_that_keep_a_rest_are_told_of_and_not_the_sound_ones() -> None:
    both = Modifiers(brake_faults=(BrakeFault(0, residual_bar=1.2), BrakeFault(1, residual_bar=1.2)))
    raised = alarms(both, wagon="bogie")
    assert kinds(raised) == {("dragging_brake", 1), ("dragging_brake", 2)}
    assert all(RELEASE_S < alarm.raised_time_s - EPOCH_S < RELEASE_S + WITHIN_S for alarm in raised)


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_pads_that_stick_unseen_by_the_sensor_are_found_within_30_s(wagon: str) -> None:
    raised = alarms(fault(stuck_force_n=15e3), wagon=wagon)
    assert kinds(raised) == {("dragging_brake", 1)}
    assert RELEASE_S < raised[0].raised_time_s - EPOCH_S < RELEASE_S + WITHIN_S
    retarding_n = 0.34 * 15e3 * 0.247 / 0.445
    assert raised[0].evidence["retarding_force_n"] == pytest.approx(retarding_n, rel=0.15)
    speed_kmh = 3.6 * float(raised[0].evidence["speed_mps"] or 0.0)
    assert "brake of wheelset 1 drags" in raised[0].message
    assert f"at {speed_kmh:.0f} km/h" in raised[0].message


@pytest.mark.parametrize("gradient", [0.012, -0.012, 0.025])
def test_a_gradient_that_begins_while_braking_is_no_dragging_brake(gradient: float) -> None:
    assert alarms(Modifiers(), Track(Profile(((350.0, 0.0), (450.0, gradient))), STRAIGHT)) == ()


@pytest.mark.parametrize("radius_m", [300.0, 1200.0])
def test_nor_is_a_curve_that_begins_as_the_brake_is_released(radius_m: float) -> None:
    curve = Profile(((520.0, 0.0), (580.0, 1.0 / radius_m)))
    assert alarms(Modifiers(), Track(STRAIGHT, curve)) == ()


def test_nor_is_a_curve_with_a_gradient_in_the_middle_of_braking() -> None:
    track = Track(Profile(((360.0, 0.0), (430.0, 0.008))), Profile(((400.0, 0.0), (460.0, 1.0 / 600.0))))
    assert alarms(Modifiers(), track) == ()


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_an_isolated_cylinder_is_a_brake_not_applied_and_nothing_else(wagon: str) -> None:
    raised = alarms(fault(isolated=True), wagon=wagon)
    assert kinds(raised) == {("brake_not_applied", 1)}
    assert raised[0].raised_time_s - EPOCH_S < 15.0


def test_of_four_a_cylinder_that_loses_its_air_in_mid_application_is_a_brake_not_applied() -> None:
    raised = alarms(fault(isolated=True, from_s=14.0), wagon="bogie")
    assert kinds(raised) == {("brake_not_applied", 1)}


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_rigging_that_passes_on_half_the_force_is_told_of_its_own_wheelset(wagon: str) -> None:
    assert kinds(alarms(fault(rigging=0.5), wagon=wagon)) == {("uneven_braking", 1), ("friction_out_of_band", 1)}


def test_pads_that_give_too_little_everywhere_are_told_of_every_wheelset() -> None:
    weak = Profile(((0.0, 0.66),))
    everywhere = Modifiers(brake_faults=(BrakeFault(0, friction=weak), BrakeFault(1, friction=weak)))
    assert kinds(alarms(everywhere)) == {("friction_out_of_band", 1), ("friction_out_of_band", 2)}


def test_in_a_train_a_force_that_says_0_is_in_the_end_its_sensors_fault_alone() -> None:
    """In so light a braking its creep shows only after some seconds that its brake works."""
    settings = example_settings("bogie")
    quick = replace(settings.alarms, brake_not_applied=BrakeNotAppliedRule(debounce_s=1.0))
    settings = replace(settings, estimator=replace(settings.estimator, preset="train"), alarms=quick)
    scenario = Scenario(
        name="a light braking",
        summary="coast, brake lightly from 8 s",
        initial_speed_mps=38.0,
        duration_s=17.0,
        demand=steps((8.0, 0.25)),
        rail_over_time=Profile(((0.0, 0.45),)),
    )
    dead = SensorFault("pressing_force", 0, SensorFailure.STUCK, from_s=0.0)
    pipeline = Pipeline.from_settings(settings)
    modifiers = Modifiers(train=GivenPull, sensor_faults=(dead,))
    given = [alarm for frame in run(scenario, settings, 1, modifiers).frames for alarm in pipeline.step(frame).alarms]
    assert ("brake_not_applied", 1) in kinds(tuple(given))
    assert kinds(pipeline.monitor.open_alarms()) == {("input_implausible", 1)}


@pytest.mark.parametrize("wagon", ["wagon", "bogie"])
def test_a_sensor_that_dies_in_mid_brake_accuses_no_brake_in_a_slow_release(wagon: str) -> None:
    """Its brake is released with the others, which takes up to a minute in a goods train."""
    settings = example_settings(wagon)
    settings = replace(settings, estimator=replace(settings.estimator, preset="train"))
    scenario = Scenario(
        name="a slow release",
        summary="coast, brake from 8 s, release from 18 s to 68 s",
        initial_speed_mps=38.0,
        duration_s=80.0,
        demand=Profile(((0.0, 0.0), (8.0, 0.0), (10.0, 0.4), (18.0, 0.4), (68.0, 0.0))),
        rail_over_time=Profile(((0.0, 0.45),)),
    )
    pipeline = Pipeline.from_settings(settings)
    dead = Modifiers(sensor_faults=(SensorFault("pressing_force", 0, SensorFailure.STUCK, from_s=14.0),))
    given = [alarm for frame in run(scenario, settings, 1, dead).frames for alarm in pipeline.step(frame).alarms]
    assert ("input_implausible", 1) in kinds(tuple(given))
    assert {kind for kind, _ in kinds(tuple(given))} & BRAKE_KINDS == set()
