"""A vehicle speed whose receiver filters: by how much it comes late is learned as the wagon brakes, where wanted."""

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimator import Estimator
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.simulator.scenarios import Scenario
from drives import DRY, SLIDE, Judged, drive, play
from faults import lagging

END_S = 26.0
LEARNS_STD_S = 0.07
LAGS_S = (0.0, 0.05, 0.1, 0.15)


def settings(*, learns: bool) -> Settings:
    given = drive(DRY).settings
    tuning = replace(given.estimator.tuning, speed_lag_std=LEARNS_STD_S if learns else None)
    return replace(given, estimator=replace(given.estimator, tuning=tuning))


def judged(scenario: Scenario, lag_s: float, *, learns: bool) -> Judged:
    recording = drive(scenario)
    seen = Judged.of(recording, play(settings(learns=learns), lagging("GNSS", lag_s)(list(recording.frames))))
    seen.assert_sound()
    return seen


def estimator_after(scenario: Scenario, lag_s: float, *, learns: bool) -> Estimator:
    pipeline = Pipeline.from_settings(settings(learns=learns))
    for frame in lagging("GNSS", lag_s)(list(drive(scenario).frames)):
        pipeline.step(frame)
    return pipeline.estimator


@pytest.mark.parametrize("lag_s", LAGS_S)
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=lambda scenario: scenario.name)
def test_the_lag_is_learned(scenario: Scenario, lag_s: float) -> None:
    brakes = estimator_after(scenario, lag_s, learns=True).filter
    learned_s, std_s = brakes.x[brakes.layout.lag], brakes.std(brakes.layout.lag)
    assert std_s < 0.5 * LEARNS_STD_S
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


def test_presets_take_the_speed_as_it_is_told() -> None:
    brakes = estimator_after(DRY, 0.1, learns=False).filter
    assert brakes.x[brakes.layout.lag] == 0.0
    assert brakes.std(brakes.layout.lag) == 0.0
