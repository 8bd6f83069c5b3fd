"""Who took part in the present brake application: what tells a brake that stays from one that never came."""

from collections.abc import Sequence
from math import inf

RELEASED = 0.8  # of the contact force, a hysteresis


class BrakeApplication:
    """Sees the pressing forces, in order of time. An application ends when all brakes are released."""

    def __init__(self, contact_force_n: float, wheelset_count: int) -> None:
        self._contact_force_n = contact_force_n
        self._released = False  # all brakes were seen released before it
        self.begun_s = inf  # inf: none goes on
        self.took_part = [False] * wheelset_count

    @property
    def begin_was_seen(self) -> bool:
        """Whether what is known of it is all of it."""
        return self._released

    def see(self, time_s: float, forces_n: Sequence[float]) -> None:
        """Take the pressing forces of all wheelsets."""
        if max(forces_n) < RELEASED * self._contact_force_n:
            self._released, self.begun_s = True, inf
            self.took_part = [False] * len(forces_n)
        elif max(forces_n) >= self._contact_force_n:
            self.begun_s = min(self.begun_s, time_s)
        self.took_part = [
            took_part or force_n >= self._contact_force_n
            for took_part, force_n in zip(self.took_part, forces_n, strict=True)
        ]
