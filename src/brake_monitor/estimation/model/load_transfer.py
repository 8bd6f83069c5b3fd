"""The wheel loads F_z,i (4), which follow what the rail does as slowly as the suspension lets the wagon pitch.

To the filter they are known from one step to the next. Taken as functions of the state, as (12) has them, they make the
wheel equations bilinear in an estimate that is noisy: the gain then moves with the noise, and minutes of steady braking
seem to tell that mu_b is nothing (`tests/estimation/test_long_braking.py`).
"""

from collections.abc import Sequence
from math import exp

from brake_monitor.estimation.ekf import Vector
from brake_monitor.estimation.model.wagon import Wagon

PITCH_S = 0.3  # bodies pitch with one or two hertz


def loads_after_step(
    wagon: Wagon, x: Sequence[float], mass_kg: float, pitching_mps2: float, share: float
) -> tuple[float, Vector]:
    """What pitches the wagon after a step, and its N wheel loads; `share`: of the way to where they settle."""
    pitching_mps2 += (wagon.pitching_mps2(x, mass_kg) - pitching_mps2) * share
    return pitching_mps2, wagon.wheel_load_n(pitching_mps2, mass_kg)


def settling_share(step_s: float) -> float:
    """Of the way to where wheel loads settle, in a step."""
    return 1.0 - exp(-step_s / PITCH_S)
