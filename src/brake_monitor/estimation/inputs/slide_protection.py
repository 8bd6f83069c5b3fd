"""Whether a wheel-slide protection acts, told by what it does: it empties a brake whose wheelset slips, repeatedly.

A good one catches a wheelset within a tenth of a second, at a slip that by itself says nothing on a wet rail. If it
does so twice in a short time, the rail gives no more; a driver who releases does so once.
"""

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
LOOKS = 8  # more than there are within SLIPPED_S


class SlideProtection:
    """Sees one wheelset about ten times a second, in order of time."""

    def __init__(self) -> None:
        self.is_acting = False  # it keeps its wheelset from sliding
        self._newest = 0  # of the last looks ...
        self._looked_s = [-inf] * LOOKS  # ... their times ...
        self._forces_n = [0.0] * LOOKS  # ... and pressing forces
        self._slipped_s = -inf  # when its wheelset last slipped
        self._loaded_s = -inf  # when the brake last pressed with LEAST_FORCE_N
        self._least_n = inf  # least force since the brake was emptied; inf: it was filled again
        self._was_flagged = False
        self._acted_s = self._acted_before_s = -inf  # its last two acts

    def see(self, time_s: float, slip: float, speed_mps: float, pressing_force_n: float, flagged: bool) -> bool:
        """Take what its wheelset and its brake do; `flagged`: it says that it acts. True as an act begins."""
        if time_s < self._looked_s[self._newest]:  # the clock was set back
            self._forget()
        self._newest = (self._newest + 1) % LOOKS
        self._looked_s[self._newest], self._forces_n[self._newest] = time_s, pressing_force_n
        if slip > SLIP and slip * speed_mps > SLIP_MPS:
            self._slipped_s = time_s
        if pressing_force_n >= LEAST_FORCE_N:
            self._loaded_s = time_s
        begins = self._is_emptied(time_s, pressing_force_n) or (flagged and not self._was_flagged)
        self._was_flagged = flagged
        acts = begins and time_s - self._slipped_s <= SLIPPED_S and time_s - self._acted_s >= ONE_ACT_S
        if acts:
            self._acted_before_s, self._acted_s = self._acted_s, time_s
        self.is_acting = time_s - self._acted_s <= ACTS_S and self._acted_s - self._acted_before_s <= AGAIN_S
        return acts

    def _forget(self) -> None:
        """Forget when all was."""
        for look in range(LOOKS):
            self._looked_s[look] = -inf
        self._slipped_s = self._loaded_s = self._acted_s = self._acted_before_s = -inf

    def _is_emptied(self, time_s: float, force_n: float) -> bool:
        """Whether the brake just begins to be emptied."""
        if self._least_n < inf:
            self._least_n = min(self._least_n, force_n)
            if force_n > self._least_n + REFILLED_N:
                self._least_n = inf
            return False
        most_n = 0.0
        for look in range(LOOKS):
            if time_s - self._looked_s[look] <= SLIPPED_S:
                most_n = max(most_n, self._forces_n[look])
        if time_s - self._loaded_s > SLIPPED_S or force_n > EMPTIED * most_n:
            return False
        self._least_n = force_n
        return True
