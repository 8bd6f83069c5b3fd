"""Sensors that are late together: a receiver that filters, pressures that a gateway polls. L tells by how much."""

from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.simulator.scenarios import Scenario
from drives import DRY, SLIDE, Judged, drive, play, play_to
from faults import lagging

END_S = 26.0
PRIOR_STD_S = 0.07
BRAKED_S, STEADY_S, RELEASED_S = 5.5, (9.0, 12.5), (13.0, 14.0)  # in the first braking of DRY
AGAIN_S = 20.0, 26.0  # in the second
LAGS_S = (0.0, 0.05, 0.1, 0.15)


def settings(*, learns: bool) -> Settings:
    given = drive(DRY).settings
    tuning = replace(given.estimator.tuning, speed_lag_std=None if learns else 0.0)
    return replace(given, estimator=replace(given.estimator, tuning=tuning))


@cache
def played(scenario: Scenario, lag_s: float, *, learns: bool) -> tuple[Judged, BrakeFilter]:
    """What is said of a drive, and what is known at its end."""
    recording, pipeline = drive(scenario), Pipeline.from_settings(settings(learns=learns))
    seen = Judged.of(recording, play_to(pipeline, lagging("GNSS", lag_s)(list(recording.frames))))
    seen.assert_sound()
    return seen, pipeline.estimator.filter


def judged(scenario: Scenario, lag_s: float, *, learns: bool) -> Judged:
    return played(scenario, lag_s, learns=learns)[0]


@pytest.mark.parametrize("lag_s", [*LAGS_S, 0.2])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_the_lag_is_learned(scenario: Scenario, lag_s: float) -> None:
    _, brakes = played(scenario, lag_s, learns=True)
    learned_s, std_s = brakes.x[brakes.layout.lag], brakes.std(brakes.layout.lag)
    assert std_s < 0.5 * PRIOR_STD_S
    assert learned_s == pytest.approx(lag_s, abs=0.04)


@pytest.mark.parametrize("lag_s", LAGS_S)
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_an_estimate_stays_as_good_as_without_a_lag(scenario: Scenario, lag_s: float) -> None:
    seen, in_time = judged(scenario, lag_s, learns=True), judged(scenario, 0.0, learns=False)
    seen.assert_honest()
    assert seen.during(4.0).rmse < 1.5 * in_time.during(4.0).rmse
    assert seen.during(4.0).worst_friction() < 0.05


def test_left_unlearned_a_lag_goes_into_friction_and_adhesion() -> None:
    """What there is to gain: the same drives, and the same readings."""
    for scenario in (DRY, SLIDE):
        left, learned = (judged(scenario, 0.15, learns=learns).during(4.0) for learns in (False, True))
        assert learned.rmse < 0.7 * left.rmse
        assert np.abs(learned.friction_error).mean() < np.abs(left.friction_error).mean()


def test_where_not_wanted_the_speed_is_taken_as_it_is_told() -> None:
    _, brakes = played(DRY, 0.1, learns=False)
    assert brakes.x[brakes.layout.lag] == 0.0
    assert brakes.std(brakes.layout.lag) == 0.0


@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_a_receiver_that_is_late_by_several_tenths_is_known_or_doubted(scenario: Scenario) -> None:
    """All wheelsets seem to slip, and what that tells of their pads is as doubtful as if they rolled."""
    judged(scenario, 0.3, learns=True).assert_honest()


def test_a_speed_that_is_later_than_any_is_doubted() -> None:
    """Half a second is no receiver's: what L cannot explain contradicts the forces."""
    seen = judged(DRY, 0.5, learns=True).during(6.0, 12.0)
    assert Doubt.BIASED in seen.reasons
    assert np.mean([e.status is Status.VALID for e in seen.told]) < 0.5


@pytest.mark.parametrize("lag_s", [0.05, 0.1])
def test_forces_that_all_come_late_are_told_from_friction(lag_s: float) -> None:
    """While a brake is put on they are too low by what they change in the lag, as if pads had more friction."""
    frames = lagging("BCU", lag_s)(list(drive(DRY).frames))
    seen = Judged.of(drive(DRY), play(settings(learns=True), frames)).during(BRAKED_S)
    seen.assert_honest()
    deviations = np.abs(seen.friction_error) / [[w.friction_std for w in e.wheelsets] for e in seen.told]
    assert deviations.max() < 3.0
    assert seen.worst_friction() < 0.05


def test_what_late_forces_have_not_told_yet_widens_the_adhesion() -> None:
    """As the brake lets go, mu_w falls by 0.1 within a second: 0.1 s of it is many deviations of a steady braking."""
    frames = lagging("BCU", 0.1)(list(drive(DRY).frames))
    seen = Judged.of(drive(DRY), play(settings(learns=True), frames))
    steady, letting_go = (
        np.array([e.adhesion_std for e in seen.during(*when).told]) for when in (STEADY_S, RELEASED_S)
    )
    assert letting_go.max() > 2.0 * steady.max()


def test_a_lag_that_is_not_proven_does_not_move_the_speed_that_is_told() -> None:
    """Creep tells brakes apart by less than a per mille of it; nothing is late here."""
    left, learned = (np.array([e.speed_mps for e in judged(DRY, 0.0, learns=learns).told]) for learns in (False, True))
    assert np.abs(learned - left).max() < 0.01


def test_a_lag_that_is_proven_is_taken_out_of_the_speed_that_is_told() -> None:
    """Read 0.1 s late while the wagon loses half a metre per second and second, the speed is 0.05 m/s too high."""
    left, learned = (judged(DRY, 0.1, learns=learns).during(*AGAIN_S) for learns in (False, True))
    left_mps, learned_mps = (
        np.mean([e.speed_mps for e in seen.told] - seen.truth.speed_mps) for seen in (left, learned)
    )
    assert abs(learned_mps) < 0.6 * abs(left_mps)
