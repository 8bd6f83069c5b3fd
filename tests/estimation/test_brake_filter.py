"""What the filter takes to be known of pads from one stop to the next, and of sliding before any wheelset has."""

from collections.abc import Iterator
from math import hypot

import numpy as np
import pytest

from brake_monitor.estimation.core.correction import FROZEN
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.filter.brake_filter import LAG_RENEWED_S, BrakeFilter
from brake_monitor.estimation.filter.physical import ADHESION_RANGE
from brake_monitor.estimation.model.regime import SLOW_ADHESION_DENSITY, SLOW_SPEED_DENSITY
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.samples import Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Preset
from test_doubted_friction import braking
from test_estimator import Run, channels, vehicle

STOPS, BRAKED_S = 1000, 20.0
COMMON, OWN = 3e-4, 8e-5  # how far friction may have moved between two stops
STOPPED_AT = 0.08  # adhesion
PRIOR, PRIOR_OWN = 0.04**2, WAGON.friction_own_std**2


def filter_of(wheelset_count: int) -> BrakeFilter:
    return BrakeFilter(Wagon.from_vehicle(vehicle(wheelset_count)), WAGON, 0.35, 0.04)


@pytest.mark.parametrize("spoil", [np.nan, np.inf])
def test_an_unsound_filter_is_recognised(spoil: float) -> None:
    state, variance, sound = filter_of(2), filter_of(2), filter_of(2)
    state.x[1] = spoil
    variance.covariance[1][1] = -1e-3
    assert sound.is_sound()
    assert not state.is_sound()
    assert not variance.is_sound()


@pytest.mark.parametrize(("sign", "bound"), list(zip((-1.0, 1.0), ADHESION_RANGE, strict=True)))
def test_no_reading_moves_a_state_beyond_what_a_wagon_can_be(sign: float, bound: float) -> None:
    core = braking(2).core
    brakes, adhesion = core.filter, core.adhesion_place
    brakes.forget(0, brakes.x[0], 2.0)
    brakes.forget(adhesion, 0.1, 1.0)
    brakes.covariance[0][adhesion] = brakes.covariance[adhesion][0] = 1.0
    assert brakes.fuse(core.now, core.wheels, 0, sign * 10.0, 2.0**2 + 0.01)  # 2.5 of adhesion by its share
    assert brakes.x[adhesion] == bound


def test_what_is_learned_of_one_state_does_not_steer_what_is_admitted_along_others_later() -> None:
    brakes = filter_of(2)
    d, speed = brakes.layout.deceleration, brakes.layout.speed
    brakes.covariance[d][speed] = brakes.covariance[speed][d] = 1e-3
    brakes.learn(d, 0.02, 1e-4)
    known = brakes.covariance[speed][speed]
    brakes.direction[brakes.layout.friction.start] = 1.0
    brakes.admit_along(1.0)
    assert brakes.covariance[speed][speed] == known


def test_as_a_brake_is_put_on_the_lag_is_known_a_little_worse_and_never_worse_than_beforehand() -> None:
    brakes = filter_of(2)
    lag = brakes.layout.lag
    brakes.forget(lag, 0.1, 0.01)
    brakes.doubt_lag()
    assert (brakes.x[lag], brakes.std(lag)) == (0.1, pytest.approx(hypot(0.01, LAG_RENEWED_S)))
    for _ in range(50):
        brakes.doubt_lag()
    assert brakes.std(lag) == pytest.approx(WAGON.speed_lag_std)


def test_what_all_pads_share_is_no_less_known_than_beforehand_however_often_a_brake_is_put_on() -> None:
    brakes = filter_of(2)
    beforehand = np.array(brakes.covariance)
    brakes.renew_friction(3.0 * PRIOR, 0.0)
    assert np.array(brakes.covariance) == pytest.approx(beforehand, abs=1e-12)


@pytest.mark.parametrize(
    ("known", "since", "expected"),
    [
        (0.01**2, 0.02**2, 0.01**2 + 0.02**2),
        (0.01**2, 1.0, PRIOR),  # however long ago
        (4.0 * PRIOR, 1.0, 4.0 * PRIOR),  # it was known worse than nominal friction is, and has not got better
        (0.5 * PRIOR_OWN, 0.0, 0.5 * PRIOR_OWN),
    ],
)
def test_friction_of_an_earlier_run_is_known_as_it_was_and_a_little_worse(
    known: float, since: float, expected: float
) -> None:
    brakes = filter_of(2)
    brakes.recall_friction([0.33, 0.37], known, since)
    block = brakes.layout.friction
    own = min(PRIOR_OWN, expected)  # pads are of a kind: they share the rest
    assert brakes.x[block] == [0.33, 0.37]
    shared = np.full((2, 2), expected - own) + own * np.eye(2)
    assert np.array(brakes.covariance)[block, block] == pytest.approx(shared, abs=1e-15)


@pytest.mark.parametrize(
    ("unmodelled_mps2", "coasting_mps2", "pull_mps2"),
    [(-0.3, 0.0, 0.3), (0.3, 0.0, 0.0), (-0.3, -0.3, 0.0), (-0.3, 0.2, 0.3), (-0.05, 0.0, 0.0)],
    ids=["pulled", "held back", "downhill", "uphill before", "by a gradient as any"],
)
def test_what_pulls_makes_the_wagon_faster_than_its_line_does(
    unmodelled_mps2: float, coasting_mps2: float, pull_mps2: float
) -> None:
    brakes = filter_of(2)
    brakes.x[brakes.layout.deceleration] = unmodelled_mps2
    expected = pull_mps2**2 - WAGON.deceleration_std**2 if pull_mps2 else 0.0
    assert brakes.pull_variance(coasting_mps2) == pytest.approx(expected)


def test_near_standstill_an_adhesion_comes_to_be_as_unknown_as_it_was_beforehand_and_no_more() -> None:
    brakes, step_s = filter_of(2), 0.1
    first, second = brakes.adhesion_place, brakes.adhesion_place + 1
    brakes.forget(first, 0.05, 0.01)
    brakes.forget(second, 0.05, 2.0 * WAGON.adhesion_std)  # as a slide may have left it
    speed_variance = brakes.covariance[brakes.speed_place][brakes.speed_place]
    brakes.admit_unseen(step_s)
    assert brakes.std(first) ** 2 == pytest.approx(0.01**2 + SLOW_ADHESION_DENSITY * step_s)
    for _ in range(99):
        brakes.admit_unseen(step_s)
    assert brakes.std(first) == pytest.approx(WAGON.adhesion_std)
    assert brakes.std(second) == pytest.approx(2.0 * WAGON.adhesion_std)
    assert brakes.std(brakes.speed_place) ** 2 == pytest.approx(speed_variance + 100 * step_s * SLOW_SPEED_DENSITY)


@pytest.mark.parametrize("wheelset_count", [2, 4])
def test_the_brake_that_lets_go_at_a_stand_is_not_taken_for_pads_that_rub_less(wheelset_count: int) -> None:
    brakes = filter_of(wheelset_count)
    places = range(brakes.layout.size)
    adhesions, frictions = places[brakes.layout.adhesion], places[brakes.layout.friction]
    before_stop = np.array(brakes.covariance)
    ties = np.eye(len(places))
    for adhesion, friction in zip(adhesions, frictions, strict=True):
        brakes.x[adhesion] = STOPPED_AT
        before_stop[adhesion] = 0.0
        ties[adhesion, friction] = STOPPED_AT / brakes.x[friction]  # all that is not known of either is friction
    for place, row in enumerate(ties @ before_stop @ ties.T):
        brakes.covariance[place][:] = row.tolist()
    friction, known = brakes.x[frictions[0]], brakes.covariance[frictions[0]][frictions[0]]
    for _ in range(500):
        brakes.admit_unseen(0.02)
    for adhesion in adhesions:
        brakes.learn(adhesion, 0.0, 1e-6)  # by then it rolls, with the brake released
    assert brakes.x[frictions[0]] == pytest.approx(friction, abs=1e-3)
    assert brakes.covariance[frictions[0]][frictions[0]] == pytest.approx(known, rel=0.01)


@pytest.mark.parametrize("wheelset_count", [2, 4])
def test_pads_of_a_kind_do_not_drift_apart_for_ever(wheelset_count: int) -> None:
    brakes = filter_of(wheelset_count)
    friction = brakes.layout.friction
    for _ in range(STOPS):  # on dry rail: nothing shows one wheelset's friction apart from the others'
        brakes.spread(0.0, WAGON.friction_own * BRAKED_S)
        brakes.renew_friction(COMMON, OWN)
    covariance = np.array(brakes.covariance)[friction, friction]
    between = covariance[0, 0] + covariance[1, 1] - 2.0 * covariance[0, 1]
    assert 2.0 * PRIOR_OWN * 0.99 <= between <= 2.0 * (PRIOR_OWN + OWN)
    assert PRIOR * 0.99 <= covariance[0, 1] <= PRIOR + COMMON  # what they share is no less known than of new pads


def test_what_slides_have_told_of_one_pad_is_kept_between_stops() -> None:
    brakes = filter_of(2)
    friction = brakes.layout.friction
    brakes.forget_all(friction, 0.0, 0.0)
    brakes.x[friction] = 0.33, 0.37
    brakes.spread(1e-4, 1e-6)
    brakes.renew_friction(COMMON, 1e-5)
    assert brakes.x[friction] == pytest.approx([0.33, 0.37])
    assert np.diag(np.array(brakes.covariance))[friction] == pytest.approx(1e-4 + 1e-6 + COMMON + 1e-5)


def test_an_own_part_beyond_what_pads_have_is_drawn_to_their_mean() -> None:
    brakes = filter_of(2)
    friction = brakes.layout.friction
    brakes.spread(0.0, 3.0 * PRIOR_OWN)  # now twice the standard deviation
    brakes.x[friction] = 0.33, 0.37
    brakes.renew_friction(0.0, OWN)
    assert brakes.x[friction] == pytest.approx([0.34, 0.36])
    covariance = np.array(brakes.covariance)[friction, friction]
    assert covariance[0, 0] - covariance[0, 1] == pytest.approx(PRIOR_OWN)


def test_what_pads_share_is_drawn_to_nominal_where_it_is_known_no_better() -> None:
    """Twice the prior's deviation: half of the way from 0.25 to the nominal 0.35; a well-known 0.25 is kept.

    It is the pads' mean that is drawn; in it is half of what each of two has for itself.
    """
    unknown, known = filter_of(2), filter_of(2)
    friction = unknown.layout.friction
    unknown.spread(3.0 * PRIOR, 0.0)
    known.forget_all(friction, 0.0, 0.0)
    known.spread(0.1 * PRIOR, PRIOR_OWN)
    for brakes in (unknown, known):
        brakes.x[friction] = 0.24, 0.26
        brakes.renew_friction(0.0, 0.0)
    assert unknown.x[friction] == pytest.approx([0.29, 0.31])
    of_mean = np.mean(np.array(unknown.covariance)[friction, friction])
    assert of_mean == pytest.approx((4.0 * PRIOR + PRIOR_OWN / 2.0) / 4.0)
    assert known.x[friction] == pytest.approx([0.24, 0.26])


def test_a_pad_that_nothing_shows_is_known_by_the_others_and_draws_none_of_them() -> None:
    """Of pads of a kind three are known: the fourth is their mean, off by its own part and a third of theirs.

    It was known as badly as a pad that has not rubbed for long, which is no sign that pads differ so much.
    """
    brakes = filter_of(4)
    friction, common = brakes.layout.friction, 1e-4
    brakes.forget_all(friction, 0.0, 0.0)
    brakes.x[friction] = 0.31, 0.32, 0.36, 0.33
    brakes.spread(common, PRIOR_OWN)
    brakes.forget(friction.start + 2, 0.36, 0.05)
    brakes.infer_idle_friction({2})
    brakes.renew_friction(0.0, 0.0)
    assert brakes.x[friction] == pytest.approx([0.31, 0.32, 0.32, 0.33])
    covariance = np.array(brakes.covariance)[friction, friction]
    assert np.diag(covariance)[[0, 1, 3]] == pytest.approx(common + PRIOR_OWN)
    beside_others = np.array([-1.0, -1.0, 3.0, -1.0]) / 3.0
    assert beside_others @ covariance @ beside_others == pytest.approx(PRIOR_OWN * (1.0 + 1.0 / 3.0))
    assert covariance[2] @ beside_others > 0.0


def test_a_pad_is_likened_to_others_only_where_there_are_any() -> None:
    alone, all_idle = filter_of(1), filter_of(2)
    alone.infer_idle_friction({0})
    all_idle.infer_idle_friction({0, 1})
    assert alone.covariance == filter_of(1).covariance
    assert all_idle.covariance == filter_of(2).covariance


def sliding(run: Run, slides_from_s: float) -> Iterator[Sample]:
    """A run whose leading wheelset slides for a second."""
    for sample in run.samples():
        slides = sample[1:3] == (Quantity.AXLE_SPEED, 0) and slides_from_s <= sample.time_s < slides_from_s + 1.0
        yield sample._replace(value=0.85 * sample.value) if slides else sample


@pytest.mark.parametrize("preset", ["wagon", "train", "rig"])
@pytest.mark.parametrize("slides_from_s", [10.0, np.inf])
def test_what_sliding_teaches_is_left_out_while_no_wheelset_slides_and_changes_nothing(
    slides_from_s: float, preset: Preset
) -> None:
    run = Run(end_s=12.5)
    quick, whole = [Estimator(vehicle(run.n), EstimatorSettings(preset=preset), channels(run.n)) for _ in range(2)]
    for sample in sliding(run, slides_from_s):
        quick.take(sample)
        whole.core.now.has_slid = True
        whole.take(sample)
    assert quick.core.now.has_slid == (slides_from_s < run.end_s)
    assert quick.filter.x == whole.filter.x
    assert quick.filter.covariance == whole.filter.covariance
    tied = quick.filter.covariance[quick.filter.layout.decay][quick.filter.layout.friction]
    assert any(tied) == (quick.core.now.has_slid and preset != "rig")


def test_what_a_slide_has_taught_of_the_rail_outlasts_it() -> None:
    run = Run(end_s=16.0)
    estimator = Estimator(vehicle(run.n), EstimatorSettings(), channels(run.n))
    for sample in sliding(run, 10.0):
        estimator.take(sample)
    creep, covariance = estimator.filter.layout.creep, np.array(estimator.filter.covariance)
    assert not estimator.core.now.has_slid
    for place in range(creep.start, creep.stop):
        assert not np.delete(covariance[place], place).any()
    decay = estimator.filter.layout.decay
    assert covariance[decay][decay] < WAGON.adhesion_decay_std**2
    assert np.diag(covariance)[estimator.filter.layout.uptake].max() <= WAGON.uptake_std**2 * (1.0 + 1e-12)
    assert estimator.filter.x[decay] != 0.0


def test_a_snapshot_of_a_slide_brings_nothing_back_that_ended_with_it() -> None:
    """The straight lines leave these covariances out while all roll, the compiled core does not: both have to be 0."""
    run = Run(end_s=13.3)
    estimator = Estimator(vehicle(run.n), EstimatorSettings(), channels(run.n))
    for sample in sliding(run, 10.0):
        estimator.take(sample)
    core, brakes = estimator.core, estimator.filter
    assert not core.now.has_slid
    decay, friction = brakes.layout.decay, brakes.layout.friction.start
    place = len(brakes.x) + decay * len(brakes.x) + friction
    frozen_s = max(time_s for time_s, saved in zip(core.now.saved_s, brakes.saved, strict=True) if saved[place])
    core.readings[brakes.layout.speed].frozen.since_s = frozen_s + 0.1
    before = brakes.x[decay]
    estimator.conclude(FROZEN, Sample(run.end_s, Quantity.SPEED, 0, 20.0, Quality.GOOD))
    assert brakes.x[decay] != before
    for place in range(brakes.layout.creep.start, brakes.layout.creep.stop):
        assert not np.delete(np.array(brakes.covariance)[place], place).any()
