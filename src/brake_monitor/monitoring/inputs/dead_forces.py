"""Pressing forces whose sensors died: what one says of the next brake application tells nothing of its brake.

A force that falls to 0 from one reading to the next, while another brake presses on, is its sensor's doing
(`ForceGate`). As the brakes are released 0 is right again; it is as wrong as before when they come on.
"""

from collections.abc import Collection, Sequence
from math import inf
from statistics import median

from brake_monitor.estimation.known_inputs import RELEASED_N

DIED_S = 1.0  # what says something impossible for less may be a wire that touches another
NOBODY = frozenset[int]()


class DeadForces:
    """Remembers them until they press again. Sees the wagon at each observation."""

    def __init__(self, contact_force_n: float) -> None:
        self._contact_force_n = contact_force_n
        self._since_s: dict[int, float] = {}  # of those that say something impossible now, since when
        self._died: set[int] = set()  # in this brake application
        self._dead: set[int] = set()  # in an earlier one, and have not pressed since

    def resume(self, i: int) -> None:
        """Go on with one that an earlier run of the program has found to be wrong."""
        self._dead.add(i)

    def see(self, time_s: float, forces_n: Sequence[float], impossible: Collection[int]) -> frozenset[int]:
        """Those that say that their brake does not press while the others do; `impossible`: what is thought of each."""
        if not (impossible or self._since_s or self._died or self._dead):  # the usual case
            return NOBODY
        self._since_s = {i: min(self._since_s.get(i, inf), time_s) for i in impossible}
        self._died.update([i for i, since_s in self._since_s.items() if time_s - since_s >= DIED_S])
        if max(forces_n) < self._contact_force_n:
            self._dead |= self._died - set(impossible)
        alive = {i for i, force_n in enumerate(forces_n) if force_n >= self._contact_force_n} - set(impossible)
        self._died -= alive
        self._dead -= alive
        others_n = [force_n for i, force_n in enumerate(forces_n) if i not in self._dead]
        return frozenset(self._dead) if others_n and median(others_n) >= RELEASED_N else NOBODY
