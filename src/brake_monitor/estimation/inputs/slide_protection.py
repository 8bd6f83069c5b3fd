"""Whether a wheel-slide protection acts, told by what it does: it empties a brake whose wheelset slips, repeatedly.

A good one catches a wheelset within a tenth of a second, at a slip that by itself says nothing on a wet rail. If it
does so twice in a short time, the rail gives no more; a driver who releases does so once.
"""

from collections import deque
from collections.abc import Sequence
from math import inf

PERIOD_S = 0.1  # between two looks, often enough to see a brake being emptied
SLIP = 0.015  # beyond what a wheelset creeps on a good rail
SLIP_MPS = 0.3
SLIPPED_S = 0.6  # within it before the brake is emptied the wheelset slipped: valve and cylinder take their time
EMPTIED = 0.75  # of the greatest pressing force of the last SLIPPED_S
REFILLED_N = 2000.0  # above the least force since: the brake was filled again
LEAST_FORCE_N = 6000.0  # a brake with less is not worth emptying
AGAIN_S = 3.0  # a driver does not release twice within this time
ONE_ACT_S = 0.4  # flag and pressing force need not tell of the same act at once
ACTS_S = 1.5  # after its last act it may act again


class SlideProtection:
    """Sees one wheelset about ten times a second, in order of time."""

    def __init__(self) -> None:
        self.acts = 0  # so far
        self.is_acting = False  # it keeps its wheelset from sliding
        self._past: deque[tuple[float, float, bool]] = deque()  # (time, pressing force, slips)
        self._least_n: float | None = None  # least force since the brake was emptied; None: it was filled again
        self._was_flagged = False
        self._acts_s: deque[float] = deque(maxlen=2)
        self._loaded_s = -inf  # when the brake last pressed with LEAST_FORCE_N

    def see(self, time_s: float, slip: float, speed_mps: float, pressing_force_n: float, *, flagged: bool) -> None:
        """Take what its wheelset and its brake do; `flagged`: the protection says that it acts."""
        if self._past and self._past[-1][0] > time_s:  # the clock was set back
            self._past.clear()
            self._acts_s.clear()
            self._loaded_s = -inf
        slips = slip > SLIP and slip * speed_mps > SLIP_MPS
        self._past.append((time_s, pressing_force_n, slips))
        while time_s - self._past[0][0] > SLIPPED_S:
            self._past.popleft()
        if pressing_force_n >= LEAST_FORCE_N:
            self._loaded_s = time_s
        begins = self._is_emptied(time_s, pressing_force_n) or (flagged and not self._was_flagged)
        self._was_flagged = flagged
        if begins and self._slipped() and not (self._acts_s and time_s - self._acts_s[-1] < ONE_ACT_S):
            self._acts_s.append(time_s)
            self.acts += 1
        lately = len(self._acts_s) == 2 and time_s - self._acts_s[-1] <= ACTS_S
        self.is_acting = lately and self._acts_s[-1] - self._acts_s[0] <= AGAIN_S

    def _slipped(self) -> bool:
        return any(slips for _, _, slips in self._past)

    def _is_emptied(self, time_s: float, force_n: float) -> bool:
        """Whether the brake just begins to be emptied."""
        if self._least_n is not None:
            self._least_n = min(self._least_n, force_n)
            if force_n > self._least_n + REFILLED_N:
                self._least_n = None
            return False
        if time_s - self._loaded_s > SLIPPED_S:
            return False
        if force_n > EMPTIED * max(force for _, force, _ in self._past):
            return False
        self._least_n = force_n
        return True


class SlideProtections:
    """The slide protections of all wheelsets of one wagon."""

    def __init__(self, wheelset_count: int, *, one_flag: bool) -> None:
        """`one_flag`: one flag tells of all of them."""
        self.each = tuple(SlideProtection() for _ in range(wheelset_count))
        self._one_flag = one_flag
        self._flagged: int | None = None  # the wheelset that a flag for all of them is about

    def see(self, glance: Sequence[float]) -> None:
        """Take time and speed, and slip, pressing force and flag of every wheelset: ten times a second, in order."""
        time_s, speed_mps = glance[:2]
        slips, forces_n = glance[2::3], glance[3::3]
        flagged = self._own_flags(slips, glance[4::3])
        for i, protection in enumerate(self.each):
            protection.see(time_s, slips[i], speed_mps, forces_n[i], flagged=flagged[i])

    def _own_flags(self, slips: Sequence[float], flags: Sequence[float]) -> Sequence[bool]:
        """A flag for all is about the wheelset that slid most as it rose."""
        if not self._one_flag:
            return [flag != 0.0 for flag in flags]
        if not any(flags):
            self._flagged = None
        elif self._flagged is None:
            self._flagged = slips.index(max(slips))
        return [i == self._flagged for i in range(len(self.each))]
