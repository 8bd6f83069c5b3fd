"""Whether a wheel speed falls as nothing stops a wheelset, and stays there: teeth or ice in the gap of its sensor.

A brake takes some tenths of a second to slow a wheelset down. A sensor that misses teeth tells less from one reading
to the next, and for a while. Readings that are off a few at a time are spikes, which the estimator sorts out.
"""

from collections.abc import Sequence
from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats

SHORTEST_S = 0.1  # frames may be bunched, so that readings are this much older than they say
READINGS = 5  # in a row
RISES = 0.25  # of the fall, at the most, until they end; after a spike up and one down they are back by half of it
LASTS_S = 30.0  # after a burst another one is to be expected

Reading = tuple[float, float]  # time in s, circumferential speed in m/s


class SpeedBursts:
    """Sees the speeds of one wheelset that turns."""

    def __init__(self) -> None:
        self._low_mps = -inf  # a quarter of the last fall above its end, while readings stay below that; else -inf
        self._low = 0  # readings that have
        self._burst_s = -inf  # when the last burst was seen

    def see(self, before: Sequence[Reading], now: Reading, hardest_mps2: float) -> None:
        """Take a reading, and those of the last tenths of a second before it: what falls back to them was a spike.

        Brakes slow the wheelset by no more than `hardest_mps2`.
        """
        (before_s, before_mps), (time_s, rolling_mps) = before[-1], now
        fallen_mps = before_mps - rolling_mps
        if fallen_mps > hardest_mps2 * max(time_s - before_s, SHORTEST_S):
            self.forget()
            low_mps = rolling_mps + RISES * fallen_mps
            if min([mps for _, mps in before]) > low_mps:
                self._low_mps, self._low = low_mps, 1
        elif rolling_mps < self._low_mps:
            self._low += 1
        else:
            self.forget()
        if self._low == READINGS:
            self._burst_s = time_s
            self.forget()

    def forget(self) -> None:
        """What comes next does not go on with what came last."""
        self._low_mps, self._low = -inf, 0

    @property
    def awaits(self) -> bool:
        """Whether the next readings tell more of a fall."""
        return self._low > 0

    def is_on(self, time_s: float) -> bool:
        """Whether its readings are not to be believed."""
        return 0.0 <= time_s - self._burst_s < LASTS_S


def may_be_bursts(time_s: Floats, rolling_mps: Floats, hardest_mps2: float) -> Bools:
    """Which of a wheelset's speeds, in order of time, fall so, or come right after one that does; shapes (K,)."""
    fallen_mps = -np.diff(rolling_mps, prepend=rolling_mps[:1])
    falls = fallen_mps > hardest_mps2 * np.maximum(np.diff(time_s, prepend=time_s[:1]), SHORTEST_S)
    may_be: Bools = falls.copy()
    for later in range(1, READINGS):
        may_be[later:] |= falls[:-later]
    return may_be
