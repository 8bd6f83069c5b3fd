"""Speeds that all repeat themselves to the last bit while the wagon rolls: a gateway tells what it was told last.

None contradicts another then. But noise makes the readings of a live sensor go to and fro, the more often the more of
it there is beside the sensor's steps. How seldom they do as the wagon coasts is learned; coarse ones hardly ever do.
"""

from math import inf

TURNS_SEEN = 300  # from so many on it is known how seldom readings go to and fro
MANY_TIMES = 10.0  # hardly ever as many as this times what was most pass by without
STILL_S = 1.0


class StillSpeeds:
    """Counts readings of all speeds: those that repeat what the same sensor said before, and those that turn back."""

    def __init__(self) -> None:
        self._repeated = 0.0  # in a row
        self._moved_s = -inf  # when any said something new last
        self._turns = 0
        self._unturned = 0.0  # readings since the last that turned back, while the wagon coasted
        self._most = 0.0  # ... so far

    def see(self, time_s: float, repeats: bool, turns: bool, coasts: bool) -> bool:
        """Take a reading by what it does, of a wagon that rolls; True as all have stood still for too long."""
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
