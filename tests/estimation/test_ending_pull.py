"""Who is pulled and then brakes is pulled no longer: traction is cut as the brake comes on, and d with it.

Preset `train` is for wagons in trains. Others are pulled as well, by whoever fetches them or by motors that no signal
tells of, and then d must not stay where it was: the brake would seem to do what the pull no longer undoes.
"""

from itertools import product

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator import journey
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.scenarios import Profile, Scenario
from brake_monitor.simulator.simulate import run
from drives import Judged, play

SEEDS = 3, 4  # one alone may be beyond one standard deviation
BRAKED_S = 12.0
FROM_MPS = 17.0


def pulled_then_braked(pull_mps2: float, demand: float, from_mps: float = FROM_MPS, held_s: float = 0.0) -> Scenario:
    """From there it is pulled to 20 m/s, and then brakes; one that stands is held by its brake until it is pulled."""
    legs = (
        Leg(Act.BRAKE, -1.0, lasts_s=held_s, demand=0.3),
        Leg(Act.PULL, 20.0, lasts_s=90.0, pull_mps2=pull_mps2),
        Leg(Act.BRAKE, 3.0, lasts_s=BRAKED_S, demand=demand),
        Leg(Act.COAST, lasts_s=10.0),
    )
    pulled_s = held_s + (20.0 - from_mps) / (0.7 * pull_mps2)  # of which some is lost to resistance
    return Scenario(
        name="pulled",
        summary="pulled, and then braked on a dry rail",
        initial_speed_mps=from_mps,
        duration_s=pulled_s + BRAKED_S,
        demand=LegJourney(legs, 4000.0),
        rail_over_time=Profile(((0.0, 0.4),)),
    )


@pytest.mark.parametrize(
    ("vehicle", "demand", "pull_mps2"),
    [
        *product(["wagon"], [0.4, 0.9], [0.25, 0.45]),
        *product(["rig", "bogie"], [0.4], [0.45]),
        *product(["rig", "bogie"], [0.9], [0.25]),
    ],
)
def test_a_pull_that_ends_is_not_taken_for_the_brake(vehicle: str, demand: float, pull_mps2: float) -> None:
    shares, known = errors(vehicle, pulled_then_braked(pull_mps2, demand))
    assert shares <= known  # while d may be anything, pads alone tell of adhesion


@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_nor_one_that_began_while_the_brake_that_held_the_wagon_let_go(
    vehicle: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What d was within 3 s of that release was the pull already, and not the line: it comes within half a second.

    Of blocks less is known. What they do while nothing pulls tells twice as much as that.
    """
    monkeypatch.setattr(journey, "PULL_CHANGE_MPS3", 1.0)
    shares, known = errors(vehicle, pulled_then_braked(0.55, 0.25, from_mps=0.0, held_s=5.0), friction_std=0.08)
    assert shares <= 0.5 * known


def errors(vehicle: str, scenario: Scenario, friction_std: float | None = None) -> tuple[float, float]:
    """RMSE of adhesion over its greatest value, and what is known of friction beforehand, relative to it."""
    settings = example_settings(vehicle)
    friction_std = friction_std or settings.estimator.friction_nominal_std
    settings = replace(
        settings, estimator=replace(settings.estimator, preset="wagon", friction_nominal_std=friction_std)
    )
    shares = []
    for seed in SEEDS:
        recording = run(scenario, settings, seed)
        judged = Judged.of(recording, play(settings, recording.frames))
        presses = (judged.truth.pressing_force_n > 5e3).any(axis=1) & (judged.truth.speed_mps > FROM_MPS)
        braking = judged.during(judged.time_s[presses][0], 1e9)
        braking.assert_honest()
        shares.append(braking.rmse / braking.truth.adhesion.max())
    return float(np.sqrt(np.mean(np.square(shares)))), friction_std / settings.estimator.friction_nominal
