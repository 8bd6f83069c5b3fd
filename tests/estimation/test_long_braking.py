"""Minutes of steady braking downhill: what does not change tells nothing of friction, and must not seem to.

In preset `train` the unmodelled deceleration is as restless as a coupler, and only what brakes do quickly is news. An
estimate that wanders off while its deviation stays small hides hot discs and accuses sound pads.
"""

from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.physics.pad import AMBIENT_C
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario
from brake_monitor.simulator.simulate import EPOCH_S, Recording, run

END_S, STEP_S, ROW_S = 300.0, 1.0, 0.01
DOWNHILL = Scenario(
    name="descent",
    summary="34 per mille downhill, the speed held by the brake",
    initial_speed_mps=20.0,
    duration_s=END_S,
    demand=LegJourney((Leg(Act.HOLD, 20.0, lasts_s=END_S, demand=0.7),), 30e3),
    rail_over_time=Profile(((0.0, 0.45),)),
)


@cache
def downhill() -> Recording:
    return run(DOWNHILL, example_settings("wagon"), 1, Modifiers(gradient=-0.034), row_s=ROW_S)


@cache
def descent(preset: str) -> tuple[np.ndarray, np.ndarray]:
    """Each second of braking: friction, its deviation and the truth; and each second, disc temperature and truth."""
    settings = example_settings("wagon")
    settings = replace(settings, estimator=replace(settings.estimator, preset=preset))
    recording = downhill()
    pipeline, frictions, temperatures, next_s = Pipeline.from_settings(settings), [], [], 10.0
    friction, temperature_c = (recording.trace.wheelset(0, name) for name in ("friction", "disc_temperature_c"))
    for frame in recording.frames:
        now = pipeline.step(frame).estimate
        if now is None or now.time_s - EPOCH_S < next_s:
            continue
        row, next_s, own = int((now.time_s - EPOCH_S) / ROW_S), next_s + STEP_S, now.wheelsets[0]
        if own.pressing_force_n > 5e3:
            frictions.append((own.friction, own.friction_std, friction[row]))
        temperatures.append((pipeline.brake_book.brakes.units[0].disc_temperature_c, temperature_c[row]))
    return np.array(frictions), np.array(temperatures)


@pytest.mark.parametrize("preset", ["wagon", "train"])
def test_friction_does_not_wander_off(preset: str) -> None:
    estimated, std, truth = descent(preset)[0].T
    assert len(truth) > 120
    assert np.all(np.abs(estimated - truth) < 3.0 * std)
    is_known = std < 0.045
    assert np.mean(is_known) > 0.8
    assert np.abs(estimated - truth)[is_known].max() < 0.06


@pytest.mark.parametrize("preset", ["wagon", "train"])
def test_the_heat_of_the_discs_is_known(preset: str) -> None:
    """As far as friction is: what it is wrong by warms the discs that much more or less."""
    frictions, temperatures = descent(preset)
    (estimated_c, truth_c), (estimated, _, truth) = temperatures[-1], frictions.mean(axis=0)
    assert truth_c > 200.0
    warmed_c = (truth_c - AMBIENT_C) * estimated / truth
    assert estimated_c == pytest.approx(AMBIENT_C + warmed_c, rel=0.1)
