"""How the speed of a wheelset falls from rolling to standstill: as what has mass falls, or as a sensor does that dies.

A sensor falls from one reading to the next, and one behind a filter falls the more slowly the less is left. What stops
a wheelset, as a bearing that seizes or pads that stick, overcomes the rail, which gives the less the more it slides: it
falls ever more quickly, within some tenths of a second to some seconds.
"""

from math import inf

ROLLS = 0.9  # circumferential over vehicle speed
HALF = 0.5
RISES = 0.05  # of the vehicle's speed: more than noise
LEAST_S = 0.4  # from ROLLS to standstill: a filter that takes the mean of half a second falls as evenly
MOST_S = 5.0
SLOWER_TOWARDS_THE_END = 1.5  # times as long for the second half: by a filter of the first order it is 2.7
LEAST_READINGS = 8


class Descent:
    """Sees the readings of one wheelset since it rolled last."""

    def __init__(self) -> None:
        self._rolled_s = self._half_s = -inf
        self._least_share = inf
        self._falls_steadily = False
        self._readings = 0

    def rolls(self, time_s: float) -> None:
        """Note that it turns with the wagon."""
        self._rolled_s = self._half_s = time_s
        self._least_share, self._falls_steadily, self._readings = inf, True, 0

    def see(self, time_s: float, share: float) -> None:
        """Take its circumferential speed over the vehicle's, which is less than `ROLLS`."""
        self._falls_steadily &= share < self._least_share + RISES
        self._least_share = min(self._least_share, share)
        self._readings += 1
        if share > HALF:
            self._half_s = time_s

    def is_a_wheels(self, time_s: float) -> bool:
        """Whether it has come to stand by now as nothing but a wheelset does."""
        first_s, second_s = self._half_s - self._rolled_s, time_s - self._half_s
        is_even = self._falls_steadily and second_s <= SLOWER_TOWARDS_THE_END * first_s
        return is_even and self._readings >= LEAST_READINGS and LEAST_S <= first_s + second_s <= MOST_S
