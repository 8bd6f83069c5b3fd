"""Whether a wheelset slows down as no rolling one does: reading by reading, or over many readings at once."""

from collections import deque
from collections.abc import Sequence
from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.monitoring.inputs.vehicle_speed import HARDEST_RETARDATION_MPS2

FALL_SPAN_S = 0.3
SHORTEST_FALL_SPAN_S = 0.5 * FALL_SPAN_S
ROUNDING_S = 1e-6  # more than Unix times are rounded by as floats


class SpeedFalls:
    """The circumferential speeds of one wheelset in the last FALL_SPAN_S."""

    def __init__(self) -> None:
        self.speeds: deque[tuple[float, float]] = deque()  # (time, circumferential speed)
        self.fell_s = -inf  # when it last slowed down so

    def see(self, time_s: float, rolling_mps: float) -> None:
        """Take a good reading."""
        self.speeds.append((time_s, rolling_mps))
        self._forget(time_s)
        from_s, from_mps = self.speeds[0]
        span_s = time_s - from_s
        if from_mps - rolling_mps > HARDEST_RETARDATION_MPS2 * span_s and span_s >= SHORTEST_FALL_SPAN_S:
            self.fell_s = time_s

    def remember(self, times_s: Sequence[float], rolling_mps: Sequence[float]) -> None:
        """Remember several that were taken together."""
        if len(times_s) > 2 and times_s[-1] - times_s[1] >= FALL_SPAN_S:  # nothing before them counts any more
            self.speeds.clear()
        self.speeds.extend(zip(times_s, rolling_mps, strict=True))
        self._forget(times_s[-1])

    def _forget(self, time_s: float) -> None:
        speeds = self.speeds
        if time_s < self.fell_s - FALL_SPAN_S:  # the clock was set back
            self.fell_s = -inf
        while len(speeds) > 2 and not 0.0 <= time_s - speeds[1][0] < FALL_SPAN_S:
            speeds.popleft()


def falls(time_s: Floats, rolling_mps: Floats) -> Bools:
    """At which of a wheelset's speeds, in order of time, `SpeedFalls` sees it fall; shapes (K,)."""
    within = np.searchsorted(time_s, time_s - FALL_SPAN_S - ROUNDING_S)  # the first one within the span before each
    while (not_yet := time_s - time_s[within] >= FALL_SPAN_S).any():
        within[not_yet] += 1
    begins = np.maximum(np.minimum(within, np.arange(len(time_s))) - 1, 0)
    span_s = time_s - time_s[begins]
    fallen_mps = rolling_mps[begins] - rolling_mps
    are_falls: Bools = (fallen_mps > HARDEST_RETARDATION_MPS2 * span_s) & (span_s >= SHORTEST_FALL_SPAN_S)
    return are_falls
