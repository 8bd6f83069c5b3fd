"""How the speed of a wheelset falls from rolling to standstill: as what has mass falls, or as a sensor does that dies.

A sensor falls from one reading to the next, and one behind a filter falls the more slowly the less is left. What stops
a wheelset, as a bearing that seizes or pads that stick, overcomes the rail, which gives the less the more it slides: it
falls ever more quickly, within some tenths of a second to some seconds. It begins softly: until the rail gives its most
a wheelset hardly slips. The mean of a span, which falls as evenly, begins at once.
"""

from math import inf

WHOLE = 0.97  # circumferential over vehicle speed: it rolls
ROLLS = 0.9  # it may have begun to fall
HALF = 0.5
STANDS = 0.1  # below it does not turn; noise and a creeping wheel stay below
RISES = 0.05  # of the vehicle's speed: more than noise
LEAST_S = 0.4  # from ROLLS to standstill: a filter that takes the mean of half a second falls as evenly ...
LEAST_SOFT_S = 0.2  # ... but does not begin softly
SOFT = 2.0  # times as long from WHOLE to ROLLS as on to HALF, by share ...
SOFT_READINGS = 1.5  # ... and by more readings than these times may be off by
QUICKER_TOWARDS_THE_END = 0.85  # times as long for the second half: means of two spans, one of the other, end softly
LONGEST_ONSET = 2.0  # times as long as from ROLLS to HALF; what turns more slowly for longer was not falling yet
MOST_S = 5.0
SLOWER_TOWARDS_THE_END = 1.5  # times as long for the second half: by a filter of the first order it is 2.7
LEAST_READINGS = 8


class Descent:
    """Sees the readings of one wheelset since it rolled last."""

    def __init__(self) -> None:
        self._whole_s = self._rolled_s = self._half_s = -inf
        self._least_share = inf
        self._share = 1.0  # at the last reading
        self._stood_s = inf
        self._falls_steadily = False
        self._readings = 0

    def rolls(self, time_s: float, whole_s: float | None) -> None:
        """Note that it turns with the wagon, and when its share was last `WHOLE`, if it was since the last call."""
        self._whole_s = self._whole_s if whole_s is None else whole_s
        self._rolled_s = self._half_s = time_s
        self._least_share, self._falls_steadily, self._readings = inf, True, 0
        self._share, self._stood_s = 1.0, inf

    def see(self, time_s: float, share: float) -> None:
        """Take its circumferential speed over the vehicle's, which is less than `ROLLS`."""
        self._falls_steadily &= share < self._least_share + RISES
        self._least_share = min(self._least_share, share)
        self._readings += 1
        if max(share, self._share) > HALF:
            self._half_s = time_s
        if share < STANDS:
            self._stood_s = min(self._stood_s, time_s)
        self._share = share

    def is_a_wheels(self) -> bool:
        """Whether it has come to stand as nothing but a wheelset does."""
        first_s, second_s = self._half_s - self._rolled_s, self._stood_s - self._half_s
        is_even = self._falls_steadily and second_s <= SLOWER_TOWARDS_THE_END * first_s
        if not is_even or self._readings < LEAST_READINGS or first_s + second_s > MOST_S:
            return False
        return first_s + second_s >= LEAST_S or self._begins_softly(first_s, second_s)

    def _begins_softly(self, first_s: float, second_s: float) -> bool:
        """Whether it fell ever more quickly from the beginning on."""
        spacing_s = (first_s + second_s) / self._readings
        first_s -= 0.5 * spacing_s  # it rolled still for some part of one
        if first_s + second_s < LEAST_SOFT_S or second_s > QUICKER_TOWARDS_THE_END * first_s:
            return False
        onset_s = self._rolled_s - self._whole_s
        at_once_s = first_s * (WHOLE - ROLLS) / (ROLLS - HALF)
        return max(SOFT * at_once_s, at_once_s + SOFT_READINGS * spacing_s) <= onset_s <= LONGEST_ONSET * first_s
