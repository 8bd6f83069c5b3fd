"""Whether a wheel speed falls as nothing stops a wheelset, and stays there: teeth or ice in the gap of its sensor.

A brake takes some tenths of a second to slow a wheelset down. A sensor that misses teeth tells less from one reading
to the next, and for a while. Readings that are off a few at a time are spikes, which the estimator sorts out. Where
the vehicle's speed falls as low as well, a gateway had told again what it was told last.
"""

from collections import deque
from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats

SHORTEST_S = 0.1  # frames may be bunched, so that readings are this much older than they say
READINGS = 5  # in a row
BEFORE_S = 0.3  # what falls back to what was told so shortly before was a spike
ROUNDING_S = 1e-6  # more than Unix times are rounded by as floats
RISES = 0.25  # of the fall, at the most, until they end; after a spike up and one down they are back by half of it
WITHDRAWN_S = 1.0  # later the wagon may have slowed down by itself
LASTS_S = 30.0  # after a burst another one is to be expected
STAYS_BELOW = 0.96  # of the vehicle's speed: what has not come back by then goes on, however long

Reading = tuple[float, float]  # time in s, circumferential speed in m/s


class SpeedBursts:
    """Sees the speeds of one wheelset that turns."""

    def __init__(self) -> None:
        self.lately: deque[Reading] = deque()  # of the last BEFORE_S
        self._low_mps = -inf  # a quarter of the last fall above its end, while readings stay below that; else -inf
        self._low = 0  # readings that have
        self._seen_s = self._burst_s = -inf  # when the last burst was first seen, and last
        self._burst_low_mps = -inf  # what its readings stayed below, ...
        self._burst_share = 0.0  # ... and of the vehicle's speed

    def see(self, now: Reading, vehicle_mps: float, hardest_mps2: float) -> None:
        """Take a reading, before it is remembered.

        `vehicle_mps` is the vehicle's speed as read last, 0 while it stands. Brakes slow the wheelset by no more than
        `hardest_mps2`.
        """
        (before_s, before_mps), (time_s, rolling_mps) = self.lately[-1], now
        fallen_mps = before_mps - rolling_mps
        if fallen_mps > hardest_mps2 * max(time_s - before_s, SHORTEST_S):
            self.forget()
            low_mps = rolling_mps + RISES * fallen_mps
            if min([mps for _, mps in self.lately]) > low_mps:
                self._low_mps, self._low = low_mps, 1
        elif rolling_mps < self._low_mps:
            self._low += 1
        else:
            self.forget()
        if self._low == READINGS:
            self._seen_s = self._burst_s = time_s
            self._burst_low_mps = self._low_mps
            self._burst_share = min(self._low_mps / vehicle_mps, STAYS_BELOW) if vehicle_mps > 0.0 else 0.0
            self.forget()
        if 0.0 <= time_s - self._seen_s < WITHDRAWN_S and vehicle_mps < self._burst_low_mps:
            self._seen_s = self._burst_s = -inf
        elif self.is_on(time_s) and rolling_mps < self._burst_share * vehicle_mps:
            self._burst_s = time_s

    def remember(self, *readings: Reading) -> None:
        """Remember one, or several that were taken together, in order of time."""
        lately, last_s = self.lately, readings[-1][0]
        if len(readings) > 2 and last_s - readings[1][0] >= BEFORE_S:  # nothing before them counts any more
            lately.clear()
        lately.extend(readings)
        while len(lately) > 2 and not 0.0 <= last_s - lately[1][0] < BEFORE_S:
            lately.popleft()

    def forget(self) -> None:
        """What comes next does not go on with what came last."""
        self._low_mps, self._low = -inf, 0

    def awaits(self, time_s: Floats) -> int:
        """How many of the readings that come next, at these times, tell more of a fall."""
        return _awaits(time_s, 0) if self._low else int(np.searchsorted(time_s, self._seen_s + WITHDRAWN_S))

    def goes_on_below(self, time_s: Floats) -> float:
        """Below which share of the vehicle's speed the readings that come next go on with a burst; 0: with none."""
        return self._burst_share if len(time_s) and self.is_on(float(time_s[0])) else 0.0

    def is_on(self, time_s: float) -> bool:
        """Whether its readings are not to be believed."""
        return abs(time_s - self._burst_s) < LASTS_S  # a delay_s makes the estimate's time the earlier one


def may_be_bursts(
    time_s: Floats, rolling_mps: Floats, vehicle_mps: Floats, hardest_mps2: float, goes_on_below: float
) -> Bools:
    """Which of a wheelset's speeds, in order of time, fall so, come while it shows what that was, or go on with it.

    Shapes (K,). Below this share of the vehicle's speed a burst that was before them goes on.
    """
    fallen_mps = -np.diff(rolling_mps, prepend=rolling_mps[:1])
    falls = fallen_mps > hardest_mps2 * np.maximum(np.diff(time_s, prepend=time_s[:1]), SHORTEST_S)
    may_be: Bools = rolling_mps < (STAYS_BELOW if falls.any() else goes_on_below) * vehicle_mps
    for fall in np.flatnonzero(falls).tolist():
        may_be[fall : _awaits(time_s, fall)] = True
    return may_be


def _awaits(time_s: Floats, fall: int) -> int:
    """The place of the first reading that tells nothing more of a fall in this place."""
    known_s = time_s[fall : fall + READINGS]
    return int(np.searchsorted(time_s, known_s[-1] + WITHDRAWN_S)) if len(known_s) else fall
