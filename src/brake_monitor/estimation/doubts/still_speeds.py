"""Whether all speeds repeat themselves while the wagon rolls, as a gateway does that tells what it was told last.

No speed contradicts another then. But noise makes successive readings of a live sensor rise and fall in turn, the more
often the larger it is beside the sensor's steps. How seldom any of them turns back while the wagon coasts is learned:
speeds that stand still for many times as long are dead. Coarse sensors without noise hardly ever turn back, and may
stand still for long.
"""

from math import inf

TURNS_SEEN = 300  # so many turns tell how seldom they are
MANY_TIMES = 10.0  # the longest time between two of them is hardly ever exceeded so many times
STILL_S = 1.0


class StillSpeeds:
    """Knows how long the speeds of a wagon may stand still while it rolls."""

    def __init__(self) -> None:
        self.moved_s = inf  # when any speed was last told anew
        self._turns = 0
        self._turned_s = -inf  # when any speed last turned back
        self._longest_s = 0.0  # between two turns while the wagon coasted

    def begin(self, time_s: float) -> None:
        """Begin anew: speeds may stand still from here on at the earliest."""
        self.moved_s, self._turned_s = time_s, -inf

    def see_turn(self, time_s: float, coasts_since_s: float) -> None:
        """Take a reading that turns back; what comes before the wagon coasts says nothing of noise."""
        if self._turned_s > coasts_since_s:
            self._turns += 1
            self._longest_s = max(self._longest_s, time_s - self._turned_s)
        self._turned_s = time_s

    def are_dead(self, time_s: float) -> bool:
        """Whether all speeds have stood still for too long, as one of them repeats itself."""
        return self._turns >= TURNS_SEEN and time_s - self.moved_s >= max(STILL_S, MANY_TIMES * self._longest_s)
