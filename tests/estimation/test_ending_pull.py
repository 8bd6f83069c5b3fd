"""Who is pulled and then brakes is pulled no longer: traction is cut as the brake comes on, and d with it.

Preset `train` is for wagons in trains. Others are pulled as well, by whoever fetches them or by motors that no signal
tells of, and then d must not stay where it was: the brake would seem to do what the pull no longer undoes.
"""

from itertools import product

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.scenarios import Profile, Scenario
from brake_monitor.simulator.simulate import run
from drives import Judged, play

SEEDS = 3, 4  # one alone may be beyond one standard deviation
BRAKED_S = 12.0
FROM_MPS = 17.0


def pulled_then_braked(pull_mps2: float, demand: float) -> Scenario:
    """From FROM_MPS it is pulled to 20 m/s, and then brakes."""
    legs = (
        Leg(Act.PULL, 20.0, lasts_s=90.0, pull_mps2=pull_mps2),
        Leg(Act.BRAKE, 3.0, lasts_s=BRAKED_S, demand=demand),
        Leg(Act.COAST, lasts_s=10.0),
    )
    pulled_s = (20.0 - FROM_MPS) / (0.7 * pull_mps2)  # of which some is lost to resistance
    return Scenario(
        name="pulled",
        summary="pulled, and then braked on a dry rail",
        initial_speed_mps=FROM_MPS,
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
    settings = example_settings(vehicle)
    settings = replace(settings, estimator=replace(settings.estimator, preset="wagon"))
    known = settings.estimator.friction_nominal_std / settings.estimator.friction_nominal
    shares = []
    for seed in SEEDS:
        recording = run(pulled_then_braked(pull_mps2, demand), settings, seed)
        judged = Judged.of(recording, play(settings, recording.frames))
        braking = judged.during(judged.time_s[(judged.truth.pressing_force_n > 5e3).any(axis=1)][0], 1e9)
        braking.assert_honest()
        shares.append(braking.rmse / braking.truth.adhesion.max())
    assert np.sqrt(np.mean(np.square(shares))) <= known  # while d may be anything, pads alone tell of adhesion
