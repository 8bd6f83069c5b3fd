"""How fast the brakes come to press harder or less, where that may be because they follow the line.

A driver, or a control, that holds a speed or a deceleration presses the harder the more the line falls. Speeds then do
not change as the forces do: read as tests of the pads, such forces say that friction does nothing. Forces that change
for another reason, as those of a brake that fills, leaks or is let go slowly, show in the speed: they do test the pads.
"""

SMOOTHED_S = 0.2  # noise of pressures is shorter
RECENT_S = 0.6  # the change is that over as long
QUICK = 0.07  # of the brakes' effect: what changes by more is put on, let go, or vented by slide protection, ...
SETTLING_S = 3.0  # ... and goes on to change for a while
REMEMBERED_S = 8.0  # a control that follows the line goes on to do so for about as long


class ForceTrend:
    """Follows what the brakes of a wagon give per unit of friction, and how much of its changes the speed shows."""

    def __init__(self) -> None:
        self._smooth_mps2 = 0.0
        self._earlier_mps2 = 0.0
        self._rate_mps3 = 0.0
        self._slow_for_s = 0.0  # since it has changed quickly
        self._earlier_mps = 0.0  # as long ago as what the brakes gave earlier
        self._compared_mps2 = 0.0
        self._compared_slowing_mps2 = 0.0
        self._shown = 0.0  # (m/s²)², mean of what forces and the wagon's deceleration change by, multiplied
        self._changed = 0.0  # (m/s²)², mean square of what the forces change by
        self.hidden_rate_mps3 = 0.0  # what the brakes give changes by so much that the speed has not shown lately
        self.followed_mps2 = 0.0  # ... and has by so much in this brake application

    def begin(self) -> None:
        """Begin anew with a brake application, or after a restart."""
        self.rest()
        self._smooth_mps2 = self._earlier_mps2 = self._rate_mps3 = self._earlier_mps = self.followed_mps2 = 0.0

    def see(self, step_s: float, per_friction_mps2: float, rolling_mps: float, friction: float) -> None:
        """Take what brakes give per unit of friction over a step, the mean speed of rims at its end, and friction."""
        share = min(step_s / RECENT_S, 1.0)
        self._smooth_mps2 += (per_friction_mps2 - self._smooth_mps2) * min(step_s / SMOOTHED_S, 1.0)
        self._earlier_mps2 += (self._smooth_mps2 - self._earlier_mps2) * share
        changed_mps2 = self._smooth_mps2 - self._earlier_mps2
        self._rate_mps3 += (changed_mps2 / RECENT_S - self._rate_mps3) * share  # what is quick begins slowly
        self._slow_for_s = 0.0 if abs(changed_mps2) > QUICK * self._smooth_mps2 else self._slow_for_s + step_s
        self._earlier_mps = rolling_mps if self._earlier_mps == 0.0 else self._earlier_mps
        self._earlier_mps += (rolling_mps - self._earlier_mps) * share
        slowing_mps2 = (self._earlier_mps - rolling_mps) / RECENT_S
        if self._slow_for_s > SETTLING_S:
            self._compare(step_s, slowing_mps2)
            self.hidden_rate_mps3 = self._hidden_share(friction) * friction * self._rate_mps3
            self.followed_mps2 += self.hidden_rate_mps3 * step_s
        else:
            self._compared_mps2, self._compared_slowing_mps2 = self._earlier_mps2, slowing_mps2
            self.hidden_rate_mps3 = 0.0

    def _compare(self, step_s: float, slowing_mps2: float) -> None:
        """Take what the deceleration has changed by beside what the forces, smoothed as long, have."""
        pressed_mps2 = self._earlier_mps2 - self._compared_mps2
        slowed_mps2 = slowing_mps2 - self._compared_slowing_mps2
        share = min(step_s / RECENT_S, 1.0)
        self._compared_mps2 += pressed_mps2 * share
        self._compared_slowing_mps2 += slowed_mps2 * share
        remembered = step_s / REMEMBERED_S
        self._shown += (pressed_mps2 * slowed_mps2 - self._shown) * remembered
        self._changed += (pressed_mps2 * pressed_mps2 - self._changed) * remembered

    def _hidden_share(self, friction: float) -> float:
        """The share of what such friction makes of the forces' changes that the deceleration has not shown lately."""
        given = friction * self._changed
        return min(max(1.0 - self._shown / given, 0.0), 1.0) if given > 0.0 else 0.0

    def rest(self) -> None:
        """Begin anew: nothing presses, or wheelsets slide, whose speeds are not the wagon's."""
        self._slow_for_s = self._shown = self._changed = self.hidden_rate_mps3 = 0.0
