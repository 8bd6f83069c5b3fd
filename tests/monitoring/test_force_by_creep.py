"""What is learned of how far a wheelset creeps under its brake."""

from math import pi, sin

import pytest

from brake_monitor.monitoring.inputs.force_by_creep import LEARNED_FROM
from brake_monitor.monitoring.running_mean import RunningMean

CREEP_PER_N = 2e-8


@pytest.mark.parametrize("seconds", [20, 24, 28])
def test_a_vehicle_speed_that_errs_for_seconds_hardly_changes_what_is_learned_of_creep(seconds: int) -> None:
    """It makes a wheelset seem to creep by one and a half times of what it does, more or less, up and down in 8 s."""
    mean = RunningMean(LEARNED_FROM)
    for k in range(10 * seconds):
        mean.add(CREEP_PER_N * (1.0 + 1.5 * sin(2.0 * pi * k / 80.0)))
    assert mean.value == pytest.approx(CREEP_PER_N, rel=0.2)
