"""Adhesion of each wheelset where bogies pitch by themselves: right when the configuration tells of them."""

import dataclasses

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator import true_vehicle
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from drives import Judged, play

AGAIN_AND_AGAIN = Scenario(
    name="braking again and again",
    summary="three applications from 28 m/s",
    initial_speed_mps=28.0,
    duration_s=30.0,
    demand=steps((4.0, 0.8), (9.0, 0.0), (14.0, 1.0), (19.0, 0.0), (24.0, 0.9)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
BRAKED_S = (9.0, 15.0)  # from when on friction is known
BRAKING = Scenario(
    name="braking on bogies",
    summary="coast, brake from 5 s, coast",
    initial_speed_mps=32.0,
    duration_s=18.0,
    demand=steps((5.0, 0.8), (16.0, 0.0)),
    rail_over_time=Profile(((0.0, 0.45),)),
)


def vehicle(wheelsets_per_bogie: int, pivot_height_m: float) -> Settings:
    settings = example_settings("bogie")
    bogies = {"wheelsets_per_bogie": wheelsets_per_bogie, "pivot_height_m": pivot_height_m}
    return replace(settings, vehicle=replace(settings.vehicle, **bogies))


ON_BOGIES, RIGID = vehicle(2, 0.9), vehicle(1, 0.0)


@pytest.fixture(scope="module")
def recording() -> Recording:
    """With pads that are all alike: whose pads press better speeds and forces do not tell while nothing slides."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(true_vehicle, "PAD_QUALITY_SPREAD", 0.0)
        return simulate(BRAKING, ON_BOGIES, seed=5)


def told_of_wheelsets(recording: Recording, settings: Settings) -> tuple[np.ndarray, np.ndarray]:
    """Mean errors of each one's adhesion against all, relative; the share of its intervals that hold the truth."""
    judged = Judged.of(recording, play(settings, list(recording.frames)))
    braked = (judged.time_s > BRAKED_S[0]) & (judged.time_s < BRAKED_S[1])
    rows = np.rint(judged.time_s / recording.trace.step_s).astype(int)
    truth = np.array([recording.trace.wheelset(i, "adhesion")[rows] for i in range(4)]).T[braked]
    wheelsets = [estimate.wheelsets for estimate, is_so in zip(judged.told, braked, strict=True) if is_so]
    told = np.array([[own.adhesion for own in row] for row in wheelsets])
    std = np.array([[own.adhesion_std for own in row] for row in wheelsets])
    error = (told / truth).mean(axis=0)
    return error / error.mean() - 1.0, (np.abs(told - truth) < 1.96 * std).mean(axis=0)


def test_wheelsets_are_told_apart_rightly_where_bogies_are_configured(recording: Recording) -> None:
    error, held = told_of_wheelsets(recording, ON_BOGIES)
    assert (np.abs(error) < 0.005).all()
    assert (held > 0.9).all()


def test_without_bogies_the_wheelset_that_leads_in_each_seems_to_grip_more_than_the_other(recording: Recording) -> None:
    """By as much as its true load is greater: the force at the rail is known, and is divided by the load."""
    error, _ = told_of_wheelsets(recording, RIGID)
    assert (error[[0, 2]] > 0.01).all()
    assert (error[[1, 3]] < -0.01).all()


def test_who_starts_in_mid_brake_on_bogies_that_have_pitched_already_is_not_misled() -> None:
    """Their loads seem to change in the first second, which takes nothing from the rail and nothing from the pads.

    An empty wagon under its full brake pitches most.
    """
    empty = replace(ON_BOGIES, vehicle=replace(ON_BOGIES.vehicle, mass_kg=50e3))
    braked_fully = dataclasses.replace(BRAKING, demand=steps((5.0, 1.0), (16.0, 0.0)))
    braking = simulate(braked_fully, empty, seed=5)
    late = [frame for frame in braking.frames if frame.time_s > EPOCH_S + BRAKED_S[0]]
    judged = Judged.of(braking, play(empty, late)).during(BRAKED_S[0] + 1.0, BRAKED_S[1])
    within = [
        np.abs(judged.adhesion_error) < 1.96 * np.array([e.adhesion_std for e in judged.told]),
        np.abs(judged.friction_error) < 1.96 * np.array([[w.friction_std for w in e.wheelsets] for e in judged.told]),
    ]
    assert min(held.mean() for held in within) > 0.9


def test_in_a_train_a_light_car_that_pitches_under_the_brake_has_sound_pads_all_the_same() -> None:
    """What wheelsets use of the rail changes with their loads: no sign of weak pads, whose wagon would pitch less."""
    car = replace(ON_BOGIES, estimator=replace(ON_BOGIES.estimator, preset="train"))
    car = replace(car, vehicle=replace(car.vehicle, mass_kg=44e3, axle_positions_m=(7.4, 5.2, -5.2, -7.4)))
    recording = simulate(AGAIN_AND_AGAIN, car, seed=5)
    judged = Judged.of(recording, play(car, list(recording.frames))).during(25.0, 30.0)
    assert np.abs(judged.friction_error.mean()) < 0.03
