"""Looking back over more than one braking: what moved the wagon afterwards tells nothing of its brakes before.

A driver lets go of the brake and pulls. d then moves at once, by more than lines do. A smoother that took it to have
moved slowly would find a part of that in the braking before, and more friction to make up for it.
"""

from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.arrays import Floats
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator import journey
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.scenarios import Profile, Scenario
from brake_monitor.simulator.simulate import run
from test_smoother import Played, play

SEEDS = 3, 4, 5
LET_GO_AND_PULLED = Scenario(
    name="pulled",
    summary="braked, and then pulled on a dry rail",
    initial_speed_mps=18.0,
    duration_s=45.0,
    demand=LegJourney(
        (
            Leg(Act.COAST, lasts_s=5.0),
            Leg(Act.BRAKE, 14.0, demand=0.2),
            Leg(Act.PULL, 20.0, lasts_s=15.0, pull_mps2=0.55),
            Leg(Act.COAST, lasts_s=5.0),
        ),
        4000.0,
    ),
    rail_over_time=Profile(((0.0, 0.4),)),
)


@cache
def frictions(vehicle: str) -> Floats:
    """Of wheelset 1 while its pads press, shape (k, 4): true, as the filter and as the smoother say it, their std."""
    settings = example_settings(vehicle)
    settings = replace(settings, estimator=replace(settings.estimator, preset="wagon"))
    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(journey, "PULL_CHANGE_MPS3", 1.0)  # as drivers of railcars pull
        for seed in SEEDS:
            recording = run(LET_GO_AND_PULLED, settings, seed)
            drive = Played(recording, *play(settings, recording.frames))
            presses = drive.judged() & (drive.truth("pressing_force_1_n") > 5000.0)
            live, back = ([e.wheelsets[0].friction for e in told] for told in (drive.filtered, drive.smoothed))
            std = [e.wheelsets[0].friction_std for e in drive.smoothed]
            found.append(np.column_stack((drive.truth("friction_1"), live, back, std))[presses])
    return np.concatenate(found)


@pytest.mark.parametrize("vehicle", ["wagon", "rig"])
def test_friction_is_off_by_no_more_than_is_published(vehicle: str) -> None:
    truth, _, back, std = frictions(vehicle).T
    assert len(truth) > 300
    assert np.sqrt(np.mean((back - truth) ** 2)) <= np.sqrt(np.mean(std**2))


def test_who_knows_what_came_afterwards_knows_friction_better() -> None:
    truth, live, back, _ = frictions("wagon").T
    assert np.mean((back - truth) ** 2) < np.mean((live - truth) ** 2)
