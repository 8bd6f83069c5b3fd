"""Whether a wheel speed falls as nothing stops a wheelset, and stays there: teeth or ice in the gap of its sensor.

A brake takes some tenths of a second to slow a wheelset down. A sensor that misses teeth tells less from one moment to
the next, and for a while. Readings that are off a few at a time are spikes, which the estimator sorts out. Where the
vehicle's speed falls as low as well, a gateway had told again what it was told last.
"""

from collections import deque
from math import inf

from brake_monitor.monitoring.inputs.descent import STANDS

SHORTEST_S = 0.1  # frames may be bunched, so that readings are this much older than they say
IN_A_ROW = 3  # observations
RISES = 0.25  # of the fall, at the most, until they end; after a spike up and one down they are back by half of it
WITHDRAWN_S = 1.0  # later the wagon may have slowed down by itself
LASTS_S = 30.0  # after a burst another one is to be expected
STAYS_BELOW = 0.96  # of the vehicle's speed: what has not come back by then goes on, however long


class SpeedBursts:
    """Sees one wheelset at each observation."""

    def __init__(self) -> None:
        self._lately: deque[tuple[float, float]] = deque(maxlen=3)  # the last readings: what falls to them was a spike
        self._low_mps = -inf  # a quarter of the last fall above its end, while readings stay below that; else -inf
        self._low = 0  # readings that have
        self._seen_s = self._burst_s = -inf  # when the last burst was first seen, and last
        self._burst_low_mps = -inf  # what its readings stayed below, ...
        self._burst_share = 0.0  # ... and of the vehicle's speed

    def see(self, time_s: float, rolling_mps: float, vehicle_mps: float, hardest_mps2: float) -> None:
        """Take the last reading, its time and the speed of the tread, which may have been taken before.

        `vehicle_mps` is the vehicle's speed as read last, 0 while it stands. Brakes slow the wheelset by no more than
        `hardest_mps2`.
        """
        before_s, before_mps = self._lately[-1] if self._lately else (time_s - SHORTEST_S, rolling_mps)
        if time_s == before_s:
            return
        fallen_mps = before_mps - rolling_mps
        if rolling_mps <= STANDS * vehicle_mps:
            self._low_mps, self._low = -inf, 0
        elif fallen_mps > hardest_mps2 * max(time_s - before_s, SHORTEST_S):
            low_mps = rolling_mps + RISES * fallen_mps
            is_new = min([mps for _, mps in self._lately]) > low_mps
            self._low_mps, self._low = (low_mps, 1) if is_new else (-inf, 0)
        elif rolling_mps < self._low_mps:
            self._low += 1
        else:
            self._low_mps, self._low = -inf, 0
        if self._low == IN_A_ROW:
            self._seen_s = self._burst_s = time_s
            self._burst_low_mps = self._low_mps
            self._burst_share = min(self._low_mps / vehicle_mps, STAYS_BELOW) if vehicle_mps > 0.0 else 0.0
            self._low_mps, self._low = -inf, 0
        if 0.0 <= time_s - self._seen_s < WITHDRAWN_S and vehicle_mps < self._burst_low_mps:
            self._seen_s = self._burst_s = -inf
        elif self.is_on(time_s) and rolling_mps < self._burst_share * vehicle_mps:
            self._burst_s = time_s
        self._lately.append((time_s, rolling_mps))

    def is_on(self, time_s: float) -> bool:
        """Whether its readings are not to be believed."""
        return abs(time_s - self._burst_s) < LASTS_S  # a delay_s makes the estimate's time the earlier one
