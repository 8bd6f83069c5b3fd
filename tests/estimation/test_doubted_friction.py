"""Friction is doubted along the one direction of the state that no reading tells: what brakes may be pads or the line.

Written down by hand: J d(omega)/dt = r N mu_w - r_B F mu_b, and m dv/dt = -Σ N mu_w - F_TR - m d.
"""

import numpy as np
import pytest

from brake_monitor.estimation.core.change_doubt import MISPLACED
from brake_monitor.estimation.core.friction_doubt import MISTIMED_FRICTION_STD, STRAYS_S
from brake_monitor.estimation.doubts.consistency import DOUBT_S, STILL, UNEXPLAINED
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.state_layout import StateLayout
from brake_monitor.settings.config import EstimatorSettings
from test_estimator import AXLES, BRAKE_RADIUS_M, GRAVITY_MPS2, RADIUS_M, Run, channels, vehicle

BRAKING_S = 12.0
VARIANCE = 1e-4  # by which friction is doubted


def braking(n: int) -> Estimator:
    """In the midst of an even brake."""
    estimator = Estimator(vehicle(n), EstimatorSettings(), channels(n))
    for sample in Run(n=n).samples():
        if sample.time_s >= BRAKING_S:
            break
        estimator.take(sample)
    return estimator


def doubted(estimator: Estimator) -> np.ndarray:
    """By what the covariance grows."""
    before = np.array(estimator.core.filter.covariance)
    estimator.core.doubt_friction(VARIANCE)
    return np.array(estimator.core.filter.covariance) - before


def loads_n(estimator: Estimator) -> np.ndarray:
    return np.array([wheel.wheel_load_n for wheel in estimator.core.wheels])


def accelerations(n: int, wheel_load_n: np.ndarray, force_n: float) -> np.ndarray:
    """What the state, and nothing else, does to m dv/dt and to each J d(omega)/dt; a row each."""
    friction, adhesion = slice(n + 1, 2 * n + 1), slice(2 * n + 1, 3 * n + 1)
    rows = np.zeros((n + 1, StateLayout(n).size))
    rows[:n, adhesion] = np.diag(RADIUS_M * wheel_load_n)
    rows[:n, friction] = np.diag([-BRAKE_RADIUS_M * force_n] * n)
    rows[n, adhesion] = -wheel_load_n
    rows[n, 3 * n + 1] = -vehicle(n).mass_kg
    return rows


def changes_no_acceleration(n: int, estimator: Estimator, grown: np.ndarray) -> bool:
    """Whether what the covariance grows by cancels in every equation, beside its parts."""
    rows = accelerations(n, loads_n(estimator), Run().pressing_force_n)
    seen, each = rows @ grown @ rows.T, np.abs(rows) @ np.abs(grown) @ np.abs(rows).T
    return float(np.abs(seen).max()) < 1e-9 * float(each.max())


@pytest.mark.parametrize("n", AXLES)
def test_what_is_doubted_changes_no_acceleration(n: int) -> None:
    estimator = braking(n)
    grown = doubted(estimator)
    assert np.linalg.matrix_rank(grown, tol=1e-9 * grown.max()) == 1
    friction_variance = np.diag(grown)[n + 1 : 2 * n + 1]
    assert friction_variance == pytest.approx([friction_variance[0]] * n)  # no more of one pad than of the others
    assert friction_variance[0] > 0.0
    assert loads_n(estimator).sum() == pytest.approx(vehicle(n).mass_kg * GRAVITY_MPS2)
    assert changes_no_acceleration(n, estimator, grown)


def test_one_that_slips_is_doubted_as_well() -> None:
    """It may be but the vehicle's speed that is late, of which all seem to slip."""
    estimator = braking(2)
    estimator.core.wheels[0].rolls = 0.0
    grown = doubted(estimator)
    assert grown[3, 3] == pytest.approx(VARIANCE)
    assert grown[4, 4] == pytest.approx(VARIANCE)
    assert changes_no_acceleration(2, estimator, grown)


def test_what_is_learned_since_takes_from_the_doubt_about_the_line_as_well() -> None:
    """What friction strays by is in doubt against the line; what is known better later is so of both alike."""
    estimator = braking(2)
    core, brakes = estimator.core, estimator.core.filter
    known_variance = core.mean_friction_variance()
    applied = core.now.application
    applied.friction, applied.friction_variance = core.mean_friction() - 0.1, known_variance
    applied.strays_s = core.now.time_s - STRAYS_S
    core.see_strayed_friction()
    line_variance = core.mean_friction_variance() - known_variance
    assert line_variance > 0.0
    for place in (3, 4):
        brakes.forget(place, brakes.x[place], 0.3 * line_variance**0.5)
    for own in estimator.estimate(None).wheelsets:
        pads_share = 1.0 - (own.line_friction_std / own.friction_std) ** 2
        assert pads_share == pytest.approx(known_variance / (known_variance + line_variance), rel=0.02)


def test_what_forces_have_followed_is_doubted_once_and_stays_so_when_they_follow_it_back() -> None:
    """What the line did until then may have been the pads'."""
    core = braking(2).core
    per_friction_mps2 = -core.point_friction_against_line()
    variances = [core.mean_friction_variance()]
    for share in (0.04, 0.04, 0.01, 0.0):  # of what the brakes give
        core.now.force_trend.followed_mps2 = share * per_friction_mps2 * core.mean_friction() / MISPLACED
        core.point_friction_against_line()
        core.see_followed(per_friction_mps2)
        variances.append(core.mean_friction_variance())
    before, *after = variances
    assert after == pytest.approx([before + (0.04 * core.mean_friction()) ** 2] * 4, rel=1e-3)


@pytest.mark.parametrize("n", [2, 4])
def test_what_inputs_in_doubt_have_taught_is_doubted_of_each_wheelset_by_itself_once_they_are_sound(n: int) -> None:
    """They may have told one wheelset's friction too high and another one's too low."""
    core = braking(n).core
    now, friction = core.now, slice(n + 1, 2 * n + 1)
    apart = np.eye(n)[0] - np.eye(n)[1]  # the first one's less the second one's

    def variance_apart() -> float:
        return float(apart @ np.array(core.filter.covariance)[friction, friction] @ apart)

    before = variance_apart()
    core.judge_friction(False)
    assert variance_apart() == pytest.approx(before)  # nothing was in doubt
    now.consistency.raised_s[STILL] = now.time_s - 1.1 * DOUBT_S
    core.judge_friction(False)
    assert variance_apart() - before == pytest.approx(2.0 * MISTIMED_FRICTION_STD**2, rel=0.01)
    core.judge_friction(False)
    assert variance_apart() - before == pytest.approx(2.0 * MISTIMED_FRICTION_STD**2, rel=0.01)  # once


@pytest.mark.parametrize("comes_back", [False, True])
def test_friction_is_doubted_that_strays_for_long_enough_at_a_stretch(comes_back: bool) -> None:
    """As a brake comes on, its timing lets it come and go."""
    core = braking(2).core
    applied, from_s, mean = core.now.application, core.now.time_s, core.mean_friction()
    applied.friction_variance = 0.02**2
    for after, off in ((0.0, 0.1), (0.6, 0.0 if comes_back else 0.1), (0.7, 0.1), (1.2, 0.1)):
        core.now.time_s, applied.friction = from_s + after * STRAYS_S, mean - off
        core.see_strayed_friction()
    assert (applied.line_friction_std == 0.0) is comes_back


@pytest.mark.parametrize(
    ("line_std", "off", "lasts"),
    [(0.1, 0.1, True), (0.1, 0.0, False), (0.0, 0.0, False)],
    ids=["strays", "has come back", "never strayed"],
)
def test_a_d_that_is_explained_again_is_no_news_while_friction_strays(line_std: float, off: float, lasts: bool) -> None:
    """On a steep line that gets steeper friction takes the rest of it: nothing tells before the brake lets go."""
    estimator = braking(2)
    now, applied = estimator.core.now, estimator.core.now.application
    applied.friction, applied.friction_variance = estimator.core.mean_friction() - off, 0.02**2
    applied.line_friction_std, now.consistency.raised_s[UNEXPLAINED] = line_std, now.time_s
    for sample in Run(n=2).samples():
        if BRAKING_S <= sample.time_s < BRAKING_S + 1.5 * DOUBT_S:
            estimator.take(sample)
    assert now.pressed
    assert now.consistency.is_on(UNEXPLAINED, now.time_s) is lasts
