"""What is thought of one pressing force, by shares of its brake that are given by hand."""

from math import pi, sin

import pytest

from brake_monitor.monitoring.inputs.watched_force import ForceState, ShownShare, WatchedForce

CREEP_PER_N = 2e-8


@pytest.mark.parametrize("seconds", [20, 24, 28])
def test_a_vehicle_speed_that_errs_for_seconds_hardly_changes_what_is_learned_of_creep(seconds: int) -> None:
    """It makes a wheelset seem to creep by one and a half times of what it does, more or less, up and down in 8 s."""
    force = WatchedForce()
    for k in range(10 * seconds):
        force.learn(CREEP_PER_N * (1.0 + 1.5 * sin(2.0 * pi * k / 80.0)))
    assert force.creep_per_n == pytest.approx(CREEP_PER_N, rel=0.2)


@pytest.mark.parametrize(("noise_std", "after_s"), [(0.05, 1.0), (0.3, 5.0)])
def test_the_noisier_the_wheel_speeds_the_longer_it_takes_to_contradict(noise_std: float, after_s: float) -> None:
    """Three deviations of a mean over so long: of 0.3 in a second they are half of a brake after 3.2 s."""
    force = WatchedForce()
    for _ in range(round(after_s * 10) // 2):
        force.see(ShownShare(1.0, noise_std=noise_std), None, presses=False)
    early = force.state
    for _ in range(round(after_s * 10) // 2):
        force.see(ShownShare(1.0, noise_std=noise_std), None, presses=False)
    assert force.state is ForceState.CONTRADICTED
    assert early is (ForceState.UNKNOWN if noise_std > 0.1 else ForceState.CONTRADICTED)
