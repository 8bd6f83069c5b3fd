"""How fast the brakes come to press harder or less, where that is as slow as when they follow the line.

A driver, or a control, that holds a speed or a deceleration presses the harder the more the line falls. Speeds then do
not change as the forces do: read as tests of the pads, such forces say that friction does nothing.
"""

SMOOTHED_S = 0.2  # noise of pressures is shorter
RECENT_S = 0.6  # the change is that over as long
QUICK = 0.035  # of the brakes' effect: what changes by more is put on, let go, or vented by slide protection, ...
SETTLING_S = 3.0  # ... and goes on to change for a while


class ForceTrend:
    """Follows what the brakes of a wagon give per unit of friction."""

    def __init__(self) -> None:
        self._smooth_mps2 = 0.0
        self._earlier_mps2 = 0.0
        self._rate_mps3 = 0.0
        self._slow_for_s = 0.0  # since it has changed quickly

    def see(self, step_s: float, per_friction_mps2: float) -> None:
        """Take what the brakes give per unit of friction over a step."""
        share = min(step_s / RECENT_S, 1.0)
        self._smooth_mps2 += (per_friction_mps2 - self._smooth_mps2) * min(step_s / SMOOTHED_S, 1.0)
        self._earlier_mps2 += (self._smooth_mps2 - self._earlier_mps2) * share
        changed_mps2 = self._smooth_mps2 - self._earlier_mps2
        self._rate_mps3 += (changed_mps2 / RECENT_S - self._rate_mps3) * share  # what is quick begins slowly
        self._slow_for_s += step_s
        if abs(changed_mps2) > QUICK * self._smooth_mps2:
            self._slow_for_s = 0.0

    @property
    def slow_rate_mps3(self) -> float:
        """By how much per second it changes, per unit of friction; 0 where it changes quickly, or has just."""
        return self._rate_mps3 if self._slow_for_s > SETTLING_S else 0.0
