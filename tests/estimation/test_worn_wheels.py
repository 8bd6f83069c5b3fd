"""A wheel that is worn, or new where a worn one is configured, is another lever of the rail against the brake."""

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Scenario
from drives import DRY, SLIDE, Judged, drive, play


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
