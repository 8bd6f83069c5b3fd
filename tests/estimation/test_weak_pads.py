"""Pads of all wheelsets that rub far less than they should: oily, glazed, of another kind."""

import numpy as np
import pytest

from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from drives import Judged, drive, play

FIRST_S, RELEASED_S, SECOND_S, END_S = 5.0, 35.0, 45.0, 75.0
BRAKINGS = Scenario(
    name="two long brakings",
    summary="coast, brake for half a minute, coast, brake again",
    initial_speed_mps=33.0,
    duration_s=END_S,
    demand=steps((FIRST_S, 0.35), (RELEASED_S, 0.0), (SECOND_S, 0.35)),
    rail_over_time=Profile(((0.0, 0.45),)),
)


@pytest.mark.parametrize("share", [0.6, 0.5, 0.4, 0.3])
def test_pads_of_half_the_usual_friction_are_not_taken_for_a_descent_that_comes_with_the_brake(share: float) -> None:
    """However long they are on. As they come on, for the first time, it takes two seconds to know."""
    pads = BrakeFault(friction=Profile(((0.0, share),)))
    recording = drive(BRAKINGS, Modifiers(brake_faults=(pads,)))
    judged = Judged.of(recording, play(recording.settings, list(recording.frames)))
    judged.during(FIRST_S + 2.0, END_S).assert_honest()
    for after in (judged.during(FIRST_S + 20.0, RELEASED_S), judged.during(SECOND_S + 5.0, END_S)):
        assert np.abs(after.friction_error).max() < 0.05
        assert np.abs(after.adhesion_error).max() < 0.005
