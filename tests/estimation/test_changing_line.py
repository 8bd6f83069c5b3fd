"""Gradients that change while the wagon brakes: nothing tells them from friction at once, so estimates have to say so.

A filter that takes the line for as constant as it was when the brake came on puts each change of gradient into friction
and adhesion, and is sure of it.
"""

from functools import cache

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.simulator.scenarios import Profile, Scenario, Track, steps
from brake_monitor.validation.cases import DISHONEST_S, LARGE_ERROR_S, Case
from brake_monitor.validation.runs import Task
from brake_monitor.validation.scores import Score
from drives import Judged, drive, play

SEEDS = 4  # of lines as well
STEEP = 8  # a line that falls by 21 per mille and then rises by 14 under the full brake

WHILE_STEADY = 13  # a line that gets steeper by 9 per mille within a second, two seconds after the brake came on
WITH_THE_BRAKE = 8  # a line that begins to fall as the brake is put on for the second time


@cache
def on_lines(scenario: str) -> Score:
    case = Case("wagon", scenario, "line", "wagon")
    return Score.together(outcome.score for seed in range(SEEDS) for outcome in Task((case,), seed).judge(()))


@pytest.mark.parametrize("scenario", ["dry", "leaf"])
def test_what_is_published_as_valid_is_never_far_off_for_long(scenario: str) -> None:
    assert on_lines(scenario).longest_dishonest_s <= DISHONEST_S


def test_steep_stretches_that_meet_leave_friction_in_doubt() -> None:
    """What was learned until the change is noticed may have been the line: nothing tells before the brake lets go."""
    (outcome,) = Task((Case("single", "leaf", "line", "wagon"),), STEEP).judge(())
    score = outcome.score
    assert score.longest_dishonest_s <= DISHONEST_S
    assert score.friction.nees <= 2.0


def test_a_gradient_that_begins_with_the_brake_is_not_taken_for_a_late_speed() -> None:
    """It looks like one at first, but what the first braking has taught of the lag speaks against it."""
    (outcome,) = Task((Case("single", "dry", "line", "wagon"),), WITH_THE_BRAKE).judge(())
    assert outcome.score.longest_large_s <= LARGE_ERROR_S
    assert outcome.score.longest_dishonest_s <= DISHONEST_S


@pytest.mark.parametrize("scenario", ["dry", "leaf"])
def test_the_intervals_hold_the_truth(scenario: str) -> None:
    score = on_lines(scenario)
    assert score.adhesion.coverage >= 0.9
    assert score.friction.coverage >= 0.9
    assert score.adhesion.rmse <= 0.003
    assert score.friction.rmse <= 0.02


def test_a_line_that_begins_to_fall_in_steady_braking_is_not_taken_for_better_pads_for_long() -> None:
    """The deceleration changes by more than line and pads are believed to: P alone takes that for noise."""
    (outcome,) = Task((Case("single", "dry", "line", "wagon"),), WHILE_STEADY).judge(())
    assert outcome.score.longest_dishonest_s <= DISHONEST_S


def crest(fall: float) -> Scenario:
    """At 20 m/s a light brake is put on within the fifty metres in which the line begins to fall."""
    return Scenario(
        name=f"brake put on at a crest of {1000 * fall:.0f} per mille",
        summary="coast, a light brake from 12 s to 40 s, coast",
        initial_speed_mps=20.0,
        duration_s=50.0,
        demand=steps((12.0, 0.25), (40.0, 0.0)),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=Track(
            gradient=Profile(((0.0, 0.0), (225.0, 0.0), (275.0, -fall), (1e4, -fall))),
            curvature_pm=Profile(((0.0, 0.0),)),
        ),
    )


@pytest.mark.parametrize("fall", [0.006, 0.01, 0.015])
def test_a_light_brake_put_on_at_a_crest_is_not_taken_for_pads_that_have_faded(fall: float) -> None:
    """What it takes from the speed the descent gives back: nothing tells that from weak pads before it lets go."""
    recording = drive(crest(fall))
    seen = Judged.of(recording, play(recording.settings, list(recording.frames))).during(14.0, 40.0)
    seen.assert_honest()
    deviations = np.abs(seen.friction_error) / [[own.friction_std for own in e.wheelsets] for e in seen.told]
    assert np.mean(deviations < 1.96) > 0.9


def steepens(before: float, after: float, later_m: float) -> Scenario:
    """A light brake gets firmer within 3 s, as the line gets steeper: what it takes from the speed that gives back."""
    speed_mps, from_s, light, firm = 24.0, 14.0, 0.1, 0.3
    from_m = speed_mps * from_s + later_m
    return Scenario(
        name=f"from {1000 * before:.0f} to {1000 * after:.0f} per mille",
        summary="coast, brake lightly from 6 s on and more firmly from 14 s on",
        initial_speed_mps=speed_mps,
        duration_s=45.0,
        demand=Profile(((0.0, 0.0), (6.0, 0.0), (6.4, light), (from_s, light), (from_s + 3.0, firm))),
        rail_over_time=Profile(((0.0, 0.45),)),
        track=Track(
            gradient=Profile(((0.0, before), (from_m, before), (from_m + 80.0, after))),
            curvature_pm=Profile(((0.0, 0.0),)),
        ),
    )


@pytest.mark.parametrize("scenario", [steepens(-0.005, -0.03, 0.0), steepens(-0.01, -0.03, 12.0)], ids=lambda s: s.name)
def test_a_brake_that_follows_a_line_that_steepens_may_have_pads_that_rub_half_as_much(scenario: Scenario) -> None:
    """Nothing tells which it is as long as it lasts; the interval holds both."""
    recording = drive(scenario)
    judged = Judged.of(recording, play(recording.settings, list(recording.frames)))
    judged.assert_honest()
    after = judged.during(20.0, 45.0)
    stds = np.array([[own.friction_std for own in estimate.wheelsets] for estimate in after.told])
    assert (np.abs(after.friction_error) < 1.96 * stds).all()
    assert Status.VALID not in after.friction_statuses(0)


@pytest.mark.parametrize("scenario", [steepens(-0.01, -0.06, 12.0)], ids=lambda s: s.name)
def test_a_brake_that_follows_a_line_that_steepens_has_no_pads_that_hardly_rub(scenario: Scenario) -> None:
    """It reads so at first. But wet pads are dry again within ten seconds: then it was the line."""
    recording = drive(scenario)
    judged = Judged.of(recording, play(recording.settings, list(recording.frames)))
    judged.assert_honest()
    known, after = recording.settings.estimator.friction_nominal_std, judged.during(33.0, 45.0)
    assert np.abs(after.friction_error).max() < 2.0 * known
