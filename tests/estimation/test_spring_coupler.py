"""In a train the coupler takes up at once what slide protection does to the own brakes.

The wagon's speed then shows nothing of its brake force: taken at its word, it says that the pads hardly rub. What
shows friction all the same is each wheelset that slides, by its own equation (6).
"""

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.settings.config import OutputSettings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.physics.coupler import SpringToTrain
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import run
from brake_monitor.validation.runs import estimate
from brake_monitor.validation.scores import judged, pressed


@pytest.mark.parametrize("scenario", ["wsp", "leaf"])
@pytest.mark.parametrize("vehicle", ["rig", "wagon"])
def test_slides_tell_friction_and_adhesion(vehicle: str, scenario: str) -> None:
    """Bounds: those for a coupler whose force is given, of RMSE 0.005 and 0.03."""
    settings = replace(example_settings(vehicle), output=OutputSettings(rate_hz=0.0))
    series = estimate(run(scenario, settings, 1, Modifiers(train=SpringToTrain)), "train")
    adhesion_error = (series.adhesion - series.truth.adhesion)[judged(series)]
    friction_error = (series.friction - series.truth.friction)[pressed(series)]
    assert np.sqrt(np.mean(adhesion_error**2)) <= 0.005
    assert np.sqrt(np.mean(friction_error**2)) <= 0.03
    assert np.mean(np.abs(friction_error) < 1.96 * series.friction_std[pressed(series)]) >= 0.9
