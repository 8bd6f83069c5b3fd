"""Whether all speeds repeat themselves while the wagon rolls, as a gateway does that tells what it was told last.

No speed contradicts another then. But noise makes successive readings of a live sensor rise and fall in turn, the more
often the larger it is beside the sensor's steps. How seldom they do so while the wagon coasts is learned: speeds that
repeat themselves for many times as many readings are not live. Coarse sensors without noise hardly ever turn back, and
may stand still for long.
"""

from math import inf

TURNS_SEEN = 300  # readings that turned back, from which on it is known how seldom they do
MANY_TIMES = 10.0  # the longest run of readings without one is hardly ever exceeded so many times
STILL_S = 1.0


class StillSpeeds:
    """Counts readings of all speeds of a wagon: those that repeat their sensor's last one, and those that turn back."""

    def __init__(self) -> None:
        self._repeated = 0.0  # readings in a row that repeated themselves
        self._moved_s = -inf  # when a reading was last a new one
        self._turns = 0
        self._unturned = 0.0  # readings since the last that turned back, while the wagon coasted, ...
        self._most = 0.0  # ... and the most there were between two

    def see(self, time_s: float, repeats: bool, turns: bool, coasts: bool) -> bool:
        """Take a reading of a wagon that rolls; True while all speeds have stood still for too long.

        `repeats`: it is its sensor's last reading again; `turns`: it turns back where that came from.
        """
        if coasts:
            self._unturned += 1.0
            if turns:
                self._turns += 1
                self._most, self._unturned = max(self._most, self._unturned), 0.0
        if not repeats or time_s < self._moved_s:  # or the clock was set back
            self._repeated, self._moved_s = 0.0, time_s
            return False
        self._repeated += 1.0
        is_known = self._turns >= TURNS_SEEN
        return is_known and self._repeated > MANY_TIMES * self._most and time_s - self._moved_s >= STILL_S
