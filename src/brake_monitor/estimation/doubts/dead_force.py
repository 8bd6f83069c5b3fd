"""Whether a pressing force repeats itself to the last bit as no live sensor with its noise does.

Noise of about a step of the sensor and more shows while the force is steady: readings go to and fro over three values
and more. Such a sensor repeats one value a few times, and never for half a second. A sensor that is coarser than its
noise goes to and fro between two values at most, where the force happens to lie between them. That says nothing.
"""

from math import inf

from brake_monitor.estimation.doubts.still_force import moves
from brake_monitor.frame import MOST_LATE_S

WEIGHT = 0.02  # of the newest reading: the share is over about fifty
TREMBLES = 0.25  # share of readings that turn back to a third value; noise of half a step makes less, of a step more
DEAD_S = 0.5
DEAD_READINGS = 50  # noise that trembles so repeats one in three of them by chance


class DeadForce:
    """Knows whether a pressing force trembles, and notices when it does so no longer."""

    def __init__(self) -> None:
        self.is_dead = False  # the force, above 0, stands still to the last bit, though it trembled before
        self.since_s = inf  # since when it has said the same
        self._seen_s = -inf
        self._trembles = False
        self._share = 0.0  # of readings that turned back to a third value
        self._value = -inf
        self._before = -inf  # the last value but this one
        self._moved = 0.0  # the last change, if it was no more than noise
        self._repeated = 0

    def see(self, time_s: float, pressing_force_n: float) -> None:
        """Take a pressing force. One that comes late, after others, goes to and fro by that alone: it says nothing."""
        if 0.0 < self._seen_s - time_s <= MOST_LATE_S:
            return
        self._seen_s = time_s
        if pressing_force_n == self._value and time_s >= self.since_s:
            self._repeated += 1
            self._share -= WEIGHT * self._share
            is_still = self._repeated >= DEAD_READINGS and time_s - self.since_s >= DEAD_S
            self.is_dead = self._trembles and is_still and pressing_force_n > 0.0
            return
        moved = 0.0 if moves(self._value, pressing_force_n) else pressing_force_n - self._value
        turns = moved * self._moved < 0.0 and pressing_force_n != self._before
        self._share += WEIGHT * ((1.0 if turns else 0.0) - self._share)
        if self.is_dead:  # it was not, or is no longer: what it is like has to show anew
            self._trembles, self._share = False, 0.0
        self._trembles = self._trembles or self._share >= TREMBLES
        self._before, self._value, self._moved = self._value, pressing_force_n, moved
        self.since_s, self._repeated, self.is_dead = time_s, 0, False
