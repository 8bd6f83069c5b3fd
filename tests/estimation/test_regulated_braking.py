"""A driver who holds the deceleration presses the harder the more the line falls: that tells nothing of the pads.

Forces that change as slowly for another reason show in the speed, and do test the pads.
"""

import numpy as np
import pytest

from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, Track
from drives import Judged, drive, play
from test_changed_deceleration import share_within

GRAVITY_MPS2 = 9.80665
COAST_MPS, BEGIN_S, SETTLED_S, END_S = 27.0, 5.0, 8.0, 38.0
HELD_MPS2, FULL_MPS2 = 0.6, 1.1  # deceleration that is held, and that of the full brake on level track
FALLS = ((0.0, 0.0), (260.0, 0.0), (420.0, -0.016), (1e4, -0.016))
FALLS_MORE = ((0.0, 0.012), (260.0, 0.012), (420.0, -0.015), (1e4, -0.015))  # the force doubles within 9 s
RISES_THEN_FALLS = ((0.0, 0.014), (230.0, 0.014), (600.0, -0.008), (1e4, -0.008))

LIGHT = 0.35  # demand
CREEPS = tuple((float(t_s), LIGHT + 0.06 * float(np.sin(t_s / 5.0))) for t_s in np.arange(10.0, END_S, 0.5))
FALLS_AS_IT_BRAKES = ((0.0, 0.0), (COAST_MPS * BEGIN_S, 0.0), (COAST_MPS * BEGIN_S + 80.0, -0.015), (1e4, -0.015))
LEVEL = ((0.0, 0.0),)
FADES = ((0.0, 1.0), (12.0, 1.0), (24.0, 0.85))  # friction over that of cold pads, over time


def braked(demand: tuple[tuple[float, float], ...], gradient: Profile) -> Scenario:
    """A stop from 27 m/s in which nothing slides."""
    return Scenario(
        name="a stop on a line that changes",
        summary="coast, brake from 5 s until the end; nothing slides",
        initial_speed_mps=COAST_MPS,
        duration_s=END_S,
        demand=Profile(demand),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=Track(gradient=gradient, curvature_pm=Profile(((0.0, 0.0),))),
    )


def held(gradient: Profile) -> Scenario:
    """A stop whose deceleration is held: the demand makes up for the line."""
    demand, position_m, speed_mps = [(0.0, 0.0), (BEGIN_S, 0.0)], COAST_MPS * BEGIN_S, COAST_MPS
    for time_s in np.arange(BEGIN_S + 0.5, END_S, 0.25):
        demand.append((float(time_s), (HELD_MPS2 - GRAVITY_MPS2 * gradient.at(position_m)) / FULL_MPS2))
        position_m += 0.25 * speed_mps
        speed_mps -= 0.25 * HELD_MPS2
    return braked(tuple(demand), gradient)


@pytest.mark.parametrize(
    "line", [FALLS, FALLS_MORE, RISES_THEN_FALLS], ids=["falls", "falls more", "rises, then falls"]
)
def test_a_force_that_follows_the_line_is_not_taken_for_pads_that_change(line: tuple[tuple[float, float], ...]) -> None:
    recording = drive(held(Profile(line)))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames))).during(SETTLED_S, END_S)
    seen.assert_honest()
    assert np.sqrt(np.mean(seen.adhesion_error**2)) < 0.002
    assert seen.worst_friction() < 0.03


def test_a_force_that_creeps_by_itself_does_teach_friction() -> None:
    """What a line falls by as the brake comes on is taken for weaker pads, until forces test them."""
    demand = ((0.0, 0.0), (BEGIN_S, 0.0), (BEGIN_S + 0.2, LIGHT), *CREEPS)
    recording = drive(braked(demand, Profile(FALLS_AS_IT_BRAKES)))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames)))
    seen.assert_honest()
    taught, left = seen.during(9.0, 10.0).friction_error, seen.during(END_S - 2.0, END_S).friction_error
    assert abs(left.mean()) < 0.5 * abs(taught.mean())


def test_a_force_that_makes_up_for_pads_that_fade_leaves_the_truth_in_the_interval() -> None:
    """To the speeds they are a line that falls."""
    friction = Profile(FADES)
    times_s = np.arange(BEGIN_S + 0.5, END_S, 0.25)
    demand = ((0.0, 0.0), (BEGIN_S, 0.0), *((float(t), HELD_MPS2 / FULL_MPS2 / friction.at(t)) for t in times_s))
    recording = drive(braked(demand, Profile(LEVEL)), Modifiers(brake_faults=(BrakeFault(friction=friction),)))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames))).during(SETTLED_S, END_S)
    adhesion, of_friction = share_within(seen)
    assert adhesion >= 0.9
    assert of_friction >= 0.9
