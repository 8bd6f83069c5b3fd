"""A driver who holds the deceleration presses the harder the more the line falls: that tells nothing of the pads."""

import numpy as np
import pytest

from brake_monitor.simulator.scenarios import Profile, Scenario, Track
from drives import Judged, drive, play

GRAVITY_MPS2 = 9.80665
COAST_MPS, BEGIN_S, SETTLED_S, END_S = 27.0, 5.0, 8.0, 38.0
HELD_MPS2, FULL_MPS2 = 0.6, 1.1  # deceleration that is held, and that of the full brake on level track
FALLS = ((0.0, 0.0), (260.0, 0.0), (420.0, -0.016), (1e4, -0.016))
RISES_THEN_FALLS = ((0.0, 0.014), (230.0, 0.014), (600.0, -0.008), (1e4, -0.008))


def held(gradient: Profile) -> Scenario:
    """A stop whose deceleration is held: the demand makes up for the line."""
    demand, position_m, speed_mps = [(0.0, 0.0), (BEGIN_S, 0.0)], COAST_MPS * BEGIN_S, COAST_MPS
    for time_s in np.arange(BEGIN_S + 0.5, END_S, 0.25):
        demand.append((float(time_s), (HELD_MPS2 - GRAVITY_MPS2 * gradient.at(position_m)) / FULL_MPS2))
        position_m += 0.25 * speed_mps
        speed_mps -= 0.25 * HELD_MPS2
    return Scenario(
        name="a stop whose deceleration is held",
        summary="coast, brake from 5 s until the end as the line asks for; nothing slides",
        initial_speed_mps=COAST_MPS,
        duration_s=END_S,
        demand=Profile(tuple(demand)),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=Track(gradient=gradient, curvature_pm=Profile(((0.0, 0.0),))),
    )


@pytest.mark.parametrize("line", [FALLS, RISES_THEN_FALLS], ids=["falls", "rises, then falls"])
def test_a_force_that_follows_the_line_is_not_taken_for_pads_that_change(line: tuple[tuple[float, float], ...]) -> None:
    recording = drive(held(Profile(line)))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames))).during(SETTLED_S, END_S)
    seen.assert_honest()
    assert np.sqrt(np.mean(seen.adhesion_error**2)) < 0.002
    assert seen.worst_friction() < 0.03
