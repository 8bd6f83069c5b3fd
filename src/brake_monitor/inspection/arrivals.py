"""When the values of a signal came: how often, how regularly, and how long it was silent."""

from array import array
from dataclasses import dataclass, field
from math import inf

import numpy as np

from brake_monitor.arrays import Floats, indices

MOST_KEPT = 360_000  # an hour of values every 10 ms; how a sender sends shows by then, and memory stays bounded
LONGEST_PERIOD_S = 1.0  # a longer gap says nothing about how often a sender sends
CLOSE = 0.5  # of the time between two bunches, what lies between two values of one as a rule


@dataclass
class Arrivals:
    """The times of one channel's first values, and of all of them how many, from when to when, and the longest gap."""

    count: int = 0
    begun_s: float = inf
    ended_s: float = -inf
    _kept_s: "array[float]" = field(default_factory=lambda: array("d"))
    _last_s: float | None = None
    _longest_ahead_s: float = -inf
    _longest_back_s: float = -inf

    @property
    def times_s(self) -> Floats:
        """Of the first values."""
        return np.frombuffer(self._kept_s)

    @property
    def all_kept(self) -> bool:
        """Whether there are no more than these."""
        return self.count == len(self._kept_s)

    @property
    def gaps_s(self) -> Floats:
        """Between these, from the end where time runs backwards; one of 0 where there are not two."""
        gaps_s: Floats = np.diff(self.times_s) if self.count > 1 else np.zeros(1)
        return gaps_s if self._runs_ahead(gaps_s) else -gaps_s[::-1]

    @property
    def longest_gap_s(self) -> float:
        """Between any two successive values; 0 where there are not two."""
        if self.count < 2:
            return 0.0
        return self._longest_ahead_s if self._runs_ahead(np.diff(self.times_s)) else self._longest_back_s

    @property
    def period_s(self) -> float:
        """The gap that any instant usually lies in: where values come in bunches, the one between two bunches."""
        return usual_s(np.sort(self.gaps_s.clip(0.0, LONGEST_PERIOD_S)))

    @property
    def is_bunched(self) -> bool:
        """Whether most values come close to the one before."""
        return bool(np.median(self.gaps_s) < CLOSE * self.period_s)

    @property
    def comes_on_change(self) -> bool:
        """Whether values come close to each other for longer than a bunch can last: as there is more to tell."""
        gaps_s, period_s = self.gaps_s, self.period_s
        close = gaps_s < CLOSE * period_s
        lasting_s = np.bincount(indices(np.cumsum(~close)), np.where(close, gaps_s, 0.0))
        return bool(lasting_s.max() > period_s)

    def see(self, time_s: Floats) -> None:
        """Take the times of successive values, of one at least."""
        gaps_s = np.diff(time_s, prepend=() if self._last_s is None else self._last_s)
        if len(gaps_s):
            self._longest_ahead_s = max(self._longest_ahead_s, float(gaps_s.max()))
            self._longest_back_s = max(self._longest_back_s, -float(gaps_s.min()))
        self._last_s = float(time_s[-1])
        self.count += len(time_s)
        self.begun_s, self.ended_s = min(self.begun_s, float(time_s.min())), max(self.ended_s, float(time_s.max()))
        self._kept_s.frombytes(time_s[: MOST_KEPT - len(self._kept_s)].tobytes())

    @staticmethod
    def _runs_ahead(gaps_s: Floats) -> bool:
        return bool(np.median(gaps_s) >= 0.0)


def usual_s(gaps_s: Floats) -> float:
    """The one of these gaps, the shortest first, that any instant in them usually lies in."""
    passed_s = np.cumsum(gaps_s)
    return float(gaps_s[np.searchsorted(passed_s, 0.5 * passed_s[-1])])
