"""The wheel loads F_z,i (4), which follow the braking as slowly as the suspension lets the wagon pitch.

The filter takes them as known inputs of each step. As functions of the state, as (12) has them, they would make the
wheel equations bilinear in a noisy estimate: the gain would move with the noise, and minutes of steady braking would
draw mu_b to nothing (`tests/estimation/test_long_braking.py`).
"""

from collections.abc import Sequence

from brake_monitor.estimation.kalman.ekf import Vector
from brake_monitor.estimation.model.acting import ActingOnWagon
from brake_monitor.estimation.model.wagon import Wagon


def loads_after_step(wagon: Wagon, x: Sequence[float], now: ActingOnWagon, share: float) -> tuple[float, Vector]:
    """The part of v̇ that pitches the wagon, after a step, and the N wheel loads; `share`: see `StepLength`."""
    settled_mps2 = wagon.pitching_mps2(x, now.mass_kg, now.heading)
    pitching_mps2 = now.pitching_mps2 + (settled_mps2 - now.pitching_mps2) * share
    return pitching_mps2, wagon.wheel_load_n(pitching_mps2, now.mass_kg)
