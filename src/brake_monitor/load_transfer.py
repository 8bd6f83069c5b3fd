"""The wheel loads F_z,i (4), which follow what the rail does as slowly as the suspension lets the wagon pitch.

To the filter they are known from one step to the next. Taken as functions of the state, as (12) has them, they make the
wheel equations bilinear in an estimate that is noisy: the gain then moves with the noise, and minutes of steady braking
seem to tell that mu_b is nothing (`tests/test_long_braking.py`).
"""

from collections.abc import Sequence
from math import exp

from brake_monitor.wagon import Inputs, Wagon

PITCH_S = 0.3  # bodies pitch with one or two hertz


class LoadTransfer:
    """Those of one wagon."""

    def __init__(self, wagon: Wagon) -> None:
        """At rest."""
        self._wagon = wagon
        self._pitching_mps2 = 0.0
        self.wheel_load_n = wagon.wheel_load_n(0.0, wagon.mass_kg)  # now, N numbers

    def follow(self, x: Sequence[float], u: Inputs, step_s: float) -> None:
        """Take the estimate after a step."""
        self._pitching_mps2 += (self._wagon.pitching_mps2(x, u) - self._pitching_mps2) * (1.0 - exp(-step_s / PITCH_S))
        self.wheel_load_n = self._wagon.wheel_load_n(self._pitching_mps2, u.mass_kg)

    def restart(self) -> None:
        """Nothing is known of the time before."""
        self._pitching_mps2 = 0.0
