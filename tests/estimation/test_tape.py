"""Whatever a filter does to x and P, its tape tells: what is not on it a smoother would not undo."""

from collections.abc import Callable

import numpy as np
import pytest

from brake_monitor.arrays import Floats
from brake_monitor.estimation.doubts.consistency import BIASED
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.filter.tape import FOLLOWED_S, Reading, Step, Tape, TapedFilter
from brake_monitor.estimation.kalman.ekf import Measured
from brake_monitor.estimation.model.tuning import RIG, TRAIN
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.settings.config import EstimatorSettings
from test_estimator import Run, channels, vehicle
from test_motor_watch import COUNT, RAILCAR, TORQUES

SCALE = 0.01  # of the covariances that are made up


def made_up(seed: int) -> TapedFilter:
    """A filter that believes anything, with nothing on its tape; it has a snapshot of another belief."""
    rng = np.random.default_rng(seed)
    brakes = TapedFilter(Wagon.from_vehicle(vehicle(2)), TRAIN, 0.35, 0.04)
    size = brakes.layout.size
    for _ in range(2):
        brakes.save(0)
        root = SCALE * rng.standard_normal((size, size))
        brakes.x = rng.uniform(0.1, 0.5, size).tolist()
        brakes.covariance = (root @ root.T).tolist()
    brakes.direction = rng.standard_normal(size).tolist()
    brakes.tape.cut(len(brakes.tape.events))
    return brakes


def told(brakes: TapedFilter, covariance: Floats) -> Floats:
    """P after the steps on the tape."""
    for event in brakes.tape.events:
        assert isinstance(event, Step)
        transition = np.eye(len(covariance)) + event.change
        covariance = transition @ covariance @ transition.T + event.noise
    return covariance


ACTIONS: dict[str, Callable[[TapedFilter], object]] = {
    "forget": lambda brakes: brakes.forget(3, 0.3, 0.2),
    "forget all": lambda brakes: brakes.forget_all(brakes.layout.friction, 0.3, 0.2),
    "scale": lambda brakes: brakes.scale(6, 0.7, 0.1),
    "jump": lambda brakes: brakes.admit_jump(7, 0.04, 1, 1.5, 0.3),
    "along a direction": lambda brakes: brakes.admit_along(0.04),
    "near standstill": lambda brakes: brakes.admit_unseen(0.5),
    "spread": lambda brakes: brakes.spread(0.04, 0.01),
    "deceleration": lambda brakes: brakes.admit_deceleration_jump(),
    "lag": lambda brakes: brakes.doubt_lag(),
    "recalled friction": lambda brakes: brakes.recall_friction([0.3, 0.4], 1e-3, 1e-4),
    "renewed friction": lambda brakes: brakes.renew_friction(3e-4, 8e-5),
    "idle brake": lambda brakes: brakes.infer_idle_friction([1]),
    "snapshot": lambda brakes: brakes.restore_parameters(0),
    "reset": lambda brakes: brakes.reset(),
}


@pytest.mark.parametrize("action", ACTIONS.values(), ids=ACTIONS)
def test_the_tape_tells_what_became_of_the_covariance(action: Callable[[TapedFilter], object]) -> None:
    brakes = made_up(1)
    before = np.array(brakes.covariance)
    action(brakes)
    assert np.abs(np.array(brakes.covariance) - before).max() > 1e-6
    np.testing.assert_allclose(told(brakes, before), brakes.covariance, atol=1e-12)


class Taped(Estimator):
    """With a tape."""

    filter_type = TapedFilter


@pytest.mark.parametrize("standstill", [False, True])
def test_the_tape_tells_of_a_prediction_and_of_a_reading(standstill: bool) -> None:
    run = Run(brake_from_s=2.0, end_s=4.0)
    estimator = Taped(vehicle(run.n), EstimatorSettings(), channels(run.n))
    for sample in run.samples():
        estimator.take(sample)
    brakes, now, wheels = estimator.filter, estimator.core.now, estimator.core.wheels
    assert isinstance(brakes, TapedFilter)
    assert now.pressed
    now.near_standstill, now.speed_per_lag_mps2 = standstill, 0.9
    brakes.tape.cut(len(brakes.tape.events))
    before = np.array(brakes.covariance)
    brakes.predict(now, wheels, 0.02)
    np.testing.assert_allclose(told(brakes, before), brakes.covariance, rtol=1e-9, atol=1e-15)
    for index in (0, brakes.layout.speed):
        x, covariance, variance = np.array(brakes.x), np.array(brakes.covariance), 4e-4
        h = np.eye(len(x))[index]
        h[brakes.layout.lag] += now.speed_per_lag_mps2 * (index == brakes.layout.speed)
        assert brakes.fuse(now, wheels, index, 0.01, float(h @ covariance @ h) + variance)
        reading = brakes.tape.events[-1]
        assert isinstance(reading, Reading)
        assert [reading.measured.of(row) for row in np.eye(len(x))] == pytest.approx(h)
        assert (reading.residual, reading.variance) == pytest.approx((0.01, variance))
        assert reading.correction == pytest.approx(np.array(brakes.x) - x)
        assert abs(reading.correction[index]) > 1e-5
    assert len(brakes.tape.events) == 3


def test_the_tape_tells_that_motors_begin_anew() -> None:
    estimator = Taped(RAILCAR, EstimatorSettings(), [*channels(COUNT), *TORQUES])
    brakes = estimator.filter
    assert isinstance(brakes, TapedFilter)
    (place,) = range(brakes.layout.size)[brakes.layout.torque_error]
    brakes.covariance[place][place] = known = 1e-4
    brakes.tape.cut(len(brakes.tape.events))
    before = np.array(brakes.covariance)
    estimator.core.renew_torque_error()
    assert brakes.covariance[place][place] > 5.0 * known
    np.testing.assert_allclose(told(brakes, before), brakes.covariance, atol=1e-12)


def test_the_tape_tells_of_what_is_known_beside_all_readings() -> None:
    brakes = made_up(2)
    place, variance = brakes.layout.deceleration, 4e-4
    x, covariance = np.array(brakes.x), np.array(brakes.covariance)
    h = np.eye(len(x))[place]
    gain = covariance @ h / (h @ covariance @ h + variance)  # Kalman's, of a reading of this state alone
    brakes.learn(place, 0.25, variance)
    assert brakes.x == pytest.approx(x + gain * (0.25 - x[place]))
    np.testing.assert_allclose(brakes.covariance, covariance - np.outer(gain, h @ covariance), atol=1e-15)
    (reading,) = brakes.tape.events
    assert isinstance(reading, Reading)
    assert [reading.measured.of(row) for row in np.eye(len(x))] == pytest.approx(h)
    assert (reading.residual, reading.variance) == pytest.approx((0.25 - x[place], variance))
    assert reading.correction == pytest.approx(np.array(brakes.x) - x)


def test_what_moved_the_wagon_before_a_stop_tells_nothing_of_what_does_after_it() -> None:
    brakes = made_up(3)
    place, friction = brakes.layout.deceleration, brakes.layout.friction.start
    correlated = brakes.covariance[place][friction]
    brakes.admit_unseen(0.02)
    assert brakes.std(place) >= 5.0  # m/s²: more than brakes and engines give a wagon
    assert brakes.covariance[place][friction] == correlated  # of the brakes it goes on telling
    brakes.admit_unseen(0.02)
    assert brakes.std(place) == pytest.approx(5.0)  # nor does it grow for as long as the wagon stands


def test_a_preset_without_d_has_none_after_a_stop_either() -> None:
    brakes = TapedFilter(Wagon.from_vehicle(vehicle(2)), RIG, 0.35, 0.04)
    brakes.admit_unseen(0.02)
    assert brakes.std(brakes.layout.deceleration) == 0.0


def test_what_is_in_doubt_has_moved_before() -> None:
    """The steps of two seconds before share it; it is d's alone."""
    brakes = made_up(4)
    size, place = brakes.layout.size, brakes.layout.deceleration
    d_mps2 = [0.0, 0.0, 0.0, -0.1, -0.3, -0.5]
    for k, unmodelled_mps2 in enumerate(d_mps2):
        brakes.tape.step(Step(np.zeros((size, size)), np.zeros((size, size)), float(k), unmodelled_mps2))
        brakes.tape.reading(Measured(0), 0.1, 0.01, [0.0] * size)
    brakes.tape.move_earlier(place, -0.6, 1.5, 3.5)
    noise = [event.noise[place, place] for event in brakes.tape.events if isinstance(event, Step)]
    assert noise == pytest.approx([0.0, 0.0, 0.18, 0.18, 0.0, 0.0])  # from 0 to -0.6 in steps 2 and 3
    assert sum(event.noise.sum() for event in brakes.tape.events if isinstance(event, Step)) == pytest.approx(0.36)


def test_a_doubt_of_the_speed_moves_d_before_it_once_when_d_has_followed() -> None:
    estimator = Taped(vehicle(2), EstimatorSettings(), channels(2))
    brakes, now, wheels = estimator.filter, estimator.core.now, estimator.core.wheels
    assert isinstance(brakes, TapedFilter)
    place, doubted_s, lasts_s, step_s = brakes.layout.deceleration, 5.0, 4.0, 0.1
    now.near_standstill = False
    walked, added = [], []  # variance of d on the tape: as a step is noted, and what has come to it since
    for k in range(120):
        now.time_s = k * step_s
        if doubted_s <= now.time_s <= doubted_s + lasts_s:
            now.consistency.raised_s[BIASED] = now.time_s
            brakes.x[place] = 0.4
        brakes.predict(now, wheels, step_s)
        steps = [event for event in brakes.tape.events if isinstance(event, Step)]
        walked.append(steps[-1].noise[place, place])
        added.append(sum(step.noise[place, place] for step in steps[-len(walked) :]) - sum(walked))
    followed = round((doubted_s + FOLLOWED_S) / step_s)
    assert added[: followed - 1] == pytest.approx([0.0] * (followed - 1), abs=1e-12)
    assert added[followed + 1 :] == pytest.approx([0.4**2] * (120 - followed - 1))


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_what_is_not_finite_is_on_no_tape(number: float) -> None:
    """The filter is reset then; a smoother would spoil with it all that came before."""
    tape, zeros, odd = Tape(), np.zeros((2, 2)), np.full((2, 2), number)
    tape.step(Step(odd, zeros))
    tape.step(Step(zeros, odd))
    tape.reading(Measured(0), number, 1.0, [0.0, 0.0])
    tape.reading(Measured(0), 0.0, 1.0, [0.0, number])
    assert not tape.events
