"""A way that the wagon has rolled freely, and how its wheelsets turned against each other on it.

The vehicle's speed, and what acts on all of them, has no part in that.
"""

from collections import deque
from collections.abc import Sequence
from itertools import islice
from math import log
from statistics import median
from typing import NamedTuple, Self

from brake_monitor.estimation.estimate import Estimate

LEAST_SPEED_MPS = 8.0  # below it the speeds' own noise counts too much


def log_turns(now: Estimate) -> tuple[float, ...]:
    """Of each wheelset, ln omega."""
    return tuple([log(max(own.omega_radps, 1.0)) for own in now.wheelsets])


def turns_apart(log_turns: Sequence[float]) -> tuple[float, ...]:
    """Of each wheelset, ln omega less the others' mean."""
    total, others = sum(log_turns), len(log_turns) - 1
    return tuple([own - (total - own) / others for own in log_turns])


class Stretch(NamedTuple):
    """Some seconds of it."""

    length_m: float
    apart: tuple[float, ...]  # of each wheelset, ln omega less the others' mean


class RolledWay(deque[Stretch]):
    """Its stretches, in order; brakings in between are left out."""

    @property
    def wheelset_count(self) -> int:
        """It must not be empty."""
        return len(self[0].apart)

    @property
    def length_m(self) -> float:
        """Of all of it."""
        return sum([stretch.length_m for stretch in self])

    def apart(self, i: int) -> list[float]:
        """How far wheelset i turned apart from the others, on each stretch."""
        return [stretch.apart[i] for stretch in self]

    def others(self, i: int) -> list[float]:
        """How far the others turned apart from each other, medians; empty where there is but one."""
        others = [stretch.apart[:i] + stretch.apart[i + 1 :] for stretch in self]
        return [median(own) for own in zip(*map(turns_apart, others), strict=True)] if len(others[0]) > 1 else []

    def last(self, length_m: float) -> Self:
        """The last stretches that are so long together, where there are as many."""
        taken, taken_m = type(self)(), 0.0
        for stretch in reversed(self):
            if taken_m >= length_m:
                break
            taken.appendleft(stretch)
            taken_m += stretch.length_m
        return taken

    def parted(self, last_m: float) -> tuple[Self, Self]:
        """What lies further back than so far, and the rest."""
        late = self.last(last_m)
        return type(self)(islice(self, len(self) - len(late))), late

    def shorten(self, most_m: float) -> list[Stretch]:
        """Take away what lies further back than so far."""
        return [self.popleft() for _ in range(len(self) - len(self.last(most_m)))]
