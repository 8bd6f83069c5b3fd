"""Pads that were wet or snowy rub again within seconds: that is no line that gets steeper as quickly, just so."""

import numpy as np
import pytest

from brake_monitor.estimation.core.core_numbers import LINE_CHANGE_MPS2
from brake_monitor.estimation.core.friction_doubt import STRAYS_S, STRAYS_SIGMAS
from brake_monitor.estimation.doubts.consistency import BIASED, BIASED_SIGMAS, LEAST_BIAS_STD_MPS, UNEXPLAINED, Doubt
from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.settings.config import EstimatorSettings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from drives import Judged, drive, play
from test_doubted_friction import braking, changes_no_acceleration
from test_estimator import Run, channels, vehicle

END_S = 30.0
STOP = Scenario(
    name="a long stop",
    summary="coast, brake from 5 s until the end; nothing slides",
    initial_speed_mps=33.0,
    duration_s=END_S,
    demand=steps((5.0, 0.8)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
WET = ((0.0, 0.62), (6.5, 0.62), (10.5, 1.0))  # friction over that of dry pads, over time
SNOWY = ((0.0, 0.14), (9.0, 0.14), (19.0, 1.0))
KNOWN_STD = 0.02
COASTING_S = 3.0


def stopped(friction: tuple[tuple[float, float], ...]) -> Judged:
    recording = drive(STOP, Modifiers(brake_faults=(BrakeFault(friction=Profile(friction)),)))
    return Judged.of(recording, play(recording.settings, list(recording.frames)))


@pytest.mark.parametrize(("pads", "dry_s"), [(WET, 10.5), (SNOWY, 19.0)], ids=["wet", "snowy"])
def test_pads_that_dry_are_not_taken_for_a_line(pads: tuple[tuple[float, float], ...], dry_s: float) -> None:
    seen = stopped(pads)
    drying, dry = seen.during(dry_s - 3.0, dry_s), seen.during(dry_s + 2.0, END_S)
    assert Doubt.BIASED in drying.reasons
    assert np.sqrt(np.mean(drying.adhesion_error**2)) < 0.006
    assert np.sqrt(np.mean(dry.adhesion_error**2)) < 0.004
    assert dry.worst_friction() < 0.04
    assert max(abs(e.deceleration_mps2) for e in dry.told) < LINE_CHANGE_MPS2
    seen.during(dry_s, END_S).assert_honest()


def test_wet_pads_that_are_dry_again_are_in_doubt_no_more() -> None:
    assert all(e.status is Status.VALID for e in stopped(WET).during(17.0, END_S).told)


def strayed(by: float, of_line_mps2: float = 0.0) -> Estimator:
    """In the midst of a brake: friction is so far off what was known of it, and d that much more than the line's."""
    estimator = braking(2)
    core = estimator.core
    applied = core.now.application
    applied.friction, applied.friction_variance = core.mean_friction() - by, KNOWN_STD**2
    applied.line_mps2 = core.filter.x[core.deceleration_place] - of_line_mps2
    return estimator


def slows_down(estimator: Estimator, *, more: bool) -> None:
    """The vehicle's speed falls more, or less, than the model says, until that is in doubt."""
    bias = estimator.core.now.consistency.bias
    while not bias.is_doubtful:
        bias.see(LEAST_BIAS_STD_MPS * 2.0 * BIASED_SIGMAS * (-1.0 if more else 1.0), LEAST_BIAS_STD_MPS**2)


@pytest.mark.parametrize("by", [-0.1, 0.1])
@pytest.mark.parametrize("more", [True, False])
def test_friction_comes_back_only_towards_what_was_known(by: float, more: bool) -> None:
    estimator = strayed(by)
    slows_down(estimator, more=more)
    estimator.core.see_friction_come_back()
    assert estimator.core.friction_comes_back() is (more is (by < 0.0))


def test_friction_that_has_not_strayed_does_not_come_back() -> None:
    estimator = strayed(-0.9 * STRAYS_SIGMAS * KNOWN_STD)
    slows_down(estimator, more=True)
    estimator.core.see_friction_come_back()
    assert not estimator.core.friction_comes_back()


@pytest.mark.parametrize("steep_mps2", [0.1, 0.6])
def test_d_gives_back_what_friction_has_strayed_by_and_no_more(steep_mps2: float) -> None:
    estimator = strayed(-0.05, steep_mps2)
    core, brakes = estimator.core, estimator.core.filter
    core.doubt_friction(0.1**2)
    known, before_mps2 = core.now.application.friction, brakes.x[core.deceleration_place]
    covariance = np.array(brakes.covariance)
    slows_down(estimator, more=True)
    core.see_friction_come_back()
    assert core.friction_comes_back()
    assert known - 0.03 < core.mean_friction() < known + 0.01
    assert before_mps2 - brakes.x[core.deceleration_place] > 0.5 * min(steep_mps2, LINE_CHANGE_MPS2)
    assert (np.diag(brakes.covariance) <= np.diag(covariance) + 1e-12).all()


@pytest.mark.parametrize(
    ("sigmas", "after_s", "is_on"), [(-0.9, 1.0, False), (0.9, 1.0, False), (0.9, 0.9, True), (1.1, 1.0, True)]
)
def test_friction_that_strays_no_more_for_a_while_comes_back_no_more(
    sigmas: float, after_s: float, is_on: bool
) -> None:
    """What contradicts the speed next may be the line's again; on its way back friction may be there for a moment."""
    estimator = strayed(-0.1)
    core = estimator.core
    slows_down(estimator, more=True)
    core.now.consistency.raised_s[BIASED] = core.now.time_s
    core.see_friction_come_back()
    core.now.application.friction = core.mean_friction() + sigmas * STRAYS_SIGMAS * KNOWN_STD
    core.now.time_s += after_s * STRAYS_S
    core.see_friction_come_back()
    assert core.friction_comes_back() is is_on


@pytest.mark.parametrize("loss", [-1.0, 1.0])
def test_a_d_that_has_taken_part_of_what_friction_lost_gives_back_all_of_it(loss: float) -> None:
    taken_mps2 = loss * 6.0 * LINE_CHANGE_MPS2
    estimator = strayed(loss * 0.05, taken_mps2)
    core, brakes = estimator.core, estimator.core.filter
    core.doubt_friction(0.3**2)
    core.give_back_to_friction(loss * 0.05)
    assert brakes.x[core.deceleration_place] == pytest.approx(core.now.application.line_mps2, abs=LINE_CHANGE_MPS2 / 2)


@pytest.mark.parametrize("loss", [-0.15, 0.15])
def test_a_d_that_has_taken_more_than_friction_lost_gives_back_what_friction_did(loss: float) -> None:
    """The rest is the line's, or a pull."""
    estimator = strayed(loss, -12.0 * loss / 0.15 * LINE_CHANGE_MPS2)
    core, brakes = estimator.core, estimator.core.filter
    core.doubt_friction(0.3**2)
    before_mps2, braked_mps2 = brakes.x[core.deceleration_place], loss * abs(core.point_friction_against_line())
    core.give_back_to_friction(loss)
    assert abs(braked_mps2) > 2.0 * LINE_CHANGE_MPS2
    assert brakes.x[core.deceleration_place] - before_mps2 == pytest.approx(braked_mps2, abs=0.5 * LINE_CHANGE_MPS2)


@pytest.mark.parametrize(("of_line_change", "comes_back"), [(0.9, False), (1.1, True)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_friction_that_moves_the_wagon_no_more_than_lines_do_does_not_come_back(
    side: float, of_line_change: float, comes_back: bool
) -> None:
    estimator = strayed(0.0)
    core = estimator.core
    by = side * of_line_change * LINE_CHANGE_MPS2 / abs(core.point_friction_against_line())
    core.now.application.friction -= by
    core.now.application.friction_variance = (by / STRAYS_SIGMAS / 2.0) ** 2
    slows_down(estimator, more=side < 0.0)
    core.see_friction_come_back()
    assert core.friction_comes_back() is comes_back


def test_only_friction_and_the_adhesion_it_asks_for_are_in_doubt_while_it_comes_back() -> None:
    estimator = strayed(-0.1)
    before = np.array(estimator.core.filter.covariance)
    estimator.core.doubt_friction_alone(1e-4)
    grown = np.array(estimator.core.filter.covariance) - before
    d = estimator.core.deceleration_place
    assert not grown[d].any()
    assert grown[3, 3] == pytest.approx(1e-4)
    assert not changes_no_acceleration(2, estimator, grown)  # of the wagon; the wheels' it leaves alone


@pytest.mark.parametrize(
    ("by", "of_line_mps2", "unexplained", "follows"),
    [
        (-0.1, 0.08, False, True),
        (0.1, -0.08, False, True),
        (-0.1, -0.08, False, False),  # d has not taken what friction would give
        (-0.05, 0.08, False, False),  # friction is not that far off
        (-0.1, 0.04, False, False),  # lines differ by as much
        (-0.1, 0.08, True, False),  # something else is at work
    ],
)
def test_a_d_that_follows_slowly_is_given_back_where_friction_is_far_off(
    by: float, of_line_mps2: float, unexplained: bool, follows: bool
) -> None:
    estimator = strayed(by, of_line_mps2)
    now = estimator.core.now
    assert not now.consistency.bias.is_doubtful
    if unexplained:
        now.consistency.raised_s[UNEXPLAINED] = now.time_s
    assert estimator.core.is_friction_on_its_way() is follows


@pytest.mark.parametrize("known", [True, False])
def test_what_pulled_until_the_brake_is_no_line_once_d_is_known_again(known: bool) -> None:
    """The speed contradicts the model as the pull ends; a brake put on within seconds must not find it in the line."""
    estimator = Estimator(vehicle(2), EstimatorSettings(), channels(2))
    core, pull_mps2 = estimator.core, -0.25
    for sample in Run(n=2).samples():
        if sample.time_s >= COASTING_S:
            break
        estimator.take(sample)
    assert not core.now.pressed
    now, d = core.now, core.deceleration_place
    now.application.line_mps2, now.consistency.raised_s[BIASED] = pull_mps2, now.time_s
    if not known:
        core.filter.covariance[d][d] = (2.0 * LINE_CHANGE_MPS2) ** 2
    core.see_line_change()
    assert now.application.line_mps2 == (core.filter.x[d] if known else pull_mps2)
