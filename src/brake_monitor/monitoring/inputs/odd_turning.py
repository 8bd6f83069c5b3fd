"""Whether a wheelset turns as nothing can make it turn: far from rolling, with nothing that drives or brakes it."""

from math import inf

UNSEEN_SLIP = 0.12  # of a wheelset that was never seen to roll: below it its radius may be wrong
ODD_SLIP = 0.2  # no wheelset turns as much faster than it rolls without a motor, nor slower without a brake
ODD_S = 2.0
FINDS_BACK_SLIP = 0.005  # off by so much less, it is on its way: one that was locked may take half a minute to roll
OFF_S = 10.0  # nor is it off for this long by more than a wrong radius: a vehicle speed that lags catches up sooner
ODD_FROM_MPS = 4.0


class OddTurning:
    """Sees one wheelset that turns, at each observation."""

    def __init__(self) -> None:
        self.is_on = False  # once it is said, until it rolls
        self._odd_since_s = self._off_since_s = inf
        self._off_slip = inf  # absolute, since then

    def see(self, time_s: float, slip: float, speed_mps: float, *, is_moved: bool) -> bool:
        """Take its slip; `is_moved`: a motor may drive it that turns too fast, or a brake hold it that is too slow."""
        if abs(slip) < UNSEEN_SLIP:
            self.is_on, self._odd_since_s, self._off_since_s, self._off_slip = False, inf, inf, inf
            return False
        off = speed_mps > ODD_FROM_MPS and not is_moved
        if not off or abs(slip) < self._off_slip - FINDS_BACK_SLIP:
            self._odd_since_s = self._off_since_s = inf
            self._off_slip = abs(slip)
        self._off_since_s = min(self._off_since_s, time_s) if off else inf
        self._odd_since_s = min(self._odd_since_s, time_s) if off and abs(slip) > ODD_SLIP else inf
        self.is_on |= time_s - self._odd_since_s >= ODD_S or time_s - self._off_since_s >= OFF_S
        return self.is_on
