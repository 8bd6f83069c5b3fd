"""A wheel that is worn, or new where a worn one is configured, is another lever of the rail against the brake."""

import msgspec
import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.acting import Acting, acting_on_wheelset
from brake_monitor.estimation.model.wheelset import brake_radps2, braking_ratio, rail_radps2
from brake_monitor.estimation.rolling.radius_calibration import LEAST_SPEED_MPS, RadiusCalibration
from brake_monitor.settings.config import EstimatorSettings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Scenario
from drives import DRY, SLIDE, Judged, drive, play
from test_estimator import channels


def judged(scenario: Scenario, factors: tuple[float, ...]) -> Judged:
    recording = drive(scenario, Modifiers(wheel_radius_factor=factors))
    return Judged.of(recording, play(recording.settings, recording.frames))


def mean_error(of: Judged) -> np.ndarray:
    """Of friction that is said to be valid; shape (N,)."""
    valid = np.array([[w.friction_status is Status.VALID for w in e.wheelsets] for e in of.told])
    return np.array(np.mean(of.friction_error, axis=0, where=valid))


@pytest.mark.parametrize("factors", [(0.92,), (1.08,), (0.92, 1.0)], ids=["worn", "new", "one of two worn"])
@pytest.mark.parametrize("scenario", [DRY, SLIDE], ids=["rolling", "sliding"])
def test_friction_is_that_of_the_pads_whatever_the_wheels_are_like(
    scenario: Scenario, factors: tuple[float, ...]
) -> None:
    """mu_w F_z r_W = mu_b F r_B (6): with the configured r_W, 8 % off, friction would be off by 0.027."""
    worn = judged(scenario, factors)
    worn.assert_honest()
    assert mean_error(worn) == pytest.approx(mean_error(judged(scenario, (1.0,))), abs=0.008)


@pytest.mark.parametrize(("speed_mps", "learned_m"), [(LEAST_SPEED_MPS - 0.1, 0.445), (20.0, 0.43)])
def test_a_wagon_that_crawls_teaches_no_radius(speed_mps: float, learned_m: float) -> None:
    """Steps and noise of its speeds are a larger share of them than wheels are worn by."""
    radius = RadiusCalibration(0.445)
    for _ in range(10_000):
        radius.see_rolling(speed_mps, speed_mps / 0.43, 0.02)
    assert radius.radius_m == pytest.approx(learned_m, abs=1e-4)


@pytest.mark.parametrize(("brake_m", "asks_more"), [(0.247, 1.0 / 0.93), (0.445, 1.0)], ids=["disc", "tread"])
def test_blocks_on_the_tread_wear_with_the_wheel_and_discs_do_not(brake_m: float, asks_more: float) -> None:
    """A block rubs where the rail does: what it asks of the rail is mu_b F, however worn the wheel is."""
    vehicle = msgspec.structs.replace(example_settings("wagon").vehicle, brake_radius_m=(brake_m, brake_m))
    wheel = Estimator(vehicle, EstimatorSettings(), channels(2)).core.wheels[0]
    asked, ratio = braking_ratio(wheel, 30e3, 170e3), brake_radps2(wheel, 1.0, 1.0) / rail_radps2(wheel, 1.0, 1.0)
    wheel.radius.radius_m = 0.93 * 0.445
    assert braking_ratio(wheel, 30e3, 170e3) == pytest.approx(asks_more * asked)
    assert brake_radps2(wheel, 1.0, 1.0) / rail_radps2(wheel, 1.0, 1.0) == pytest.approx(asks_more * ratio)
    acting = Acting(*acting_on_wheelset(wheel))
    assert acting.brake_radius_m / acting.wheel_radius_m == pytest.approx(asks_more * brake_m / 0.445)
