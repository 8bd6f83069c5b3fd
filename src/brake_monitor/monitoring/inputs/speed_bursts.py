"""Whether a wheel speed falls as nothing stops a wheelset, and stays there: teeth or ice in the gap of its sensor.

A brake takes some tenths of a second to slow a wheelset down. A sensor that misses teeth tells less from one reading
to the next, and for more than one reading; single ones that are off are spikes, which the estimator sorts out.
"""

from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats

SHORTEST_S = 0.1  # frames may be bunched, so that readings are this much older than they say
LASTS_S = 30.0  # after a burst another one is to be expected


class SpeedBursts:
    """Sees the circumferential speeds of one wheelset that turns."""

    def __init__(self) -> None:
        self._middle_mps = -inf  # between the last reading, which fell so, and the one before it; else -inf
        self._burst_s = -inf  # when the last burst began

    def see(self, time_s: float, rolling_mps: float, before: tuple[float, float] | None, hardest_mps2: float) -> None:
        """Take a reading, after the one `before`: (time, speed); None for the first one, and for one that stands.

        Brakes slow the wheelset by no more than `hardest_mps2`.
        """
        if before is None:
            self._middle_mps = -inf
            return
        if rolling_mps < self._middle_mps:
            self._burst_s = time_s
        before_s, before_mps = before
        fell = before_mps - rolling_mps > hardest_mps2 * max(time_s - before_s, SHORTEST_S)
        self._middle_mps = (before_mps + rolling_mps) / 2.0 if fell else -inf

    @property
    def awaits(self) -> bool:
        """Whether the next reading will show if this is one."""
        return self._middle_mps > -inf

    def is_on(self, time_s: float) -> bool:
        """Whether its readings are not to be believed."""
        return 0.0 <= time_s - self._burst_s < LASTS_S


def fall_hard(time_s: Floats, rolling_mps: Floats, hardest_mps2: float) -> Bools:
    """At which of a wheelset's speeds, in order of time, `SpeedBursts` sees it fall so; shapes (K,)."""
    fallen_mps = -np.diff(rolling_mps, prepend=rolling_mps[:1])
    are_falls: Bools = fallen_mps > hardest_mps2 * np.maximum(np.diff(time_s, prepend=time_s[:1]), SHORTEST_S)
    return are_falls
