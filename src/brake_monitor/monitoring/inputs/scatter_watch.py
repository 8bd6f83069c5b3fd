"""Whether one wheel speed scatters: a loose pole wheel, too wide a gap, a wire beside the motor's.

Where all of them scatter, their configuration, their times or the vehicle's speed are to blame, and no sensor alone.
"""

from math import inf

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate

TOLD_S = 10.0  # of rolling: a slide, or what a curve or a bridge does, is over sooner
MOST_S = 20.0  # it is told for as long again after the last scatter, however long that lasted
WATCHED_FROM_MPS = 3.0
LONGEST_STEP_S = 1.0  # nobody knows what happened in a longer one
NONE = frozenset[int]()


class ScatterWatch:
    """Sees the wagon at each observation."""

    def __init__(self, wheelset_count: int) -> None:
        self._for_s = [0.0] * wheelset_count  # how long each has scattered, less how long it has not since
        self._scatters = False  # any of them, lately
        self._told = NONE
        self._seen_s = -inf

    def judge(self, now: Estimate) -> frozenset[int]:
        """The wheelsets whose speeds scatter."""
        step_s, self._seen_s = now.time_s - self._seen_s, now.time_s
        if not (self._scatters or Doubt.SCATTERED in now.reasons):  # the usual case
            return NONE
        rolls = now.speed_mps >= WATCHED_FROM_MPS and not now.saturated
        if rolls and 0.0 < step_s <= LONGEST_STEP_S:
            self._go_on([own.speed_scatters for own in now.wheelsets], step_s)
        return self._told

    def _go_on(self, scatters: list[bool], step_s: float) -> None:
        alone = not all(scatters)
        for i, own in enumerate(scatters):
            self._for_s[i] += step_s if own and alone else -step_s
            self._for_s[i] = min(max(self._for_s[i], 0.0), MOST_S)
        self._scatters = any(self._for_s)
        told = {i for i, for_s in enumerate(self._for_s) if for_s >= TOLD_S or (i in self._told and for_s > 0.0)}
        self._told = frozenset(told)
