"""One pressing force: whether it is to be believed, by what shows of its brake and by how its wheelset slides."""

from enum import StrEnum
from math import hypot, sqrt
from typing import NamedTuple

from brake_monitor.estimation.core.regime_watch import PRESSES_N
from brake_monitor.estimation.doubts.still_force import moves
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.passing_time import LastTime

LEAST_COUNT = 5  # observations
INDEPENDENT = 10.0  # observations count as one independent value: creep and retardation are means of a second
SURE_SIGMAS = 3.0
LEANS_SIGMAS = 1.0
LEAST_SCATTER = 0.1
WORKS = 0.5  # share of the creep or retardation that is to be expected, from which on a brake works
SLIDES_ANEW = 3  # slides anew at a force that presses and stands still, though slide protection acts: one may happen
PROTECTED = 2  # acts by which slide protection is known to be there; a driver's release looks like one of them
LATELY_S = 60.0  # a brake that has not pressed for longer and drags may stick; no sensor of it has failed


class ForceState(StrEnum):
    """What is thought of a pressing force."""

    UNKNOWN = "unknown"  # nothing speaks for it or against it
    BORNE_OUT = "borne out"  # its brake does as it says
    CONTRADICTED = "contradicted"


class ShownShare(NamedTuple):
    """What shows of a brake over what is expected of it: 1 where it works, 0 where it does not."""

    value: float
    lasting_std: float = 0.0  # of what is wrong in all of an application alike
    noise_std: float = 0.0  # of a second's mean


class WatchedForce:
    """What is thought of one pressing force so far."""

    def __init__(self) -> None:
        self.state = ForceState.UNKNOWN
        self._pressed = LastTime()  # its sensor said that it presses
        self.may_press_unseen = False  # its sensor says released, the wagon retards rather as if it pressed ...
        self.may_be_idle = False  # ... or the other way round
        self._stood_n: float | None = None  # the force that stood still while its wheelset slid anew
        self._by_creep, self._by_retardation = _Mean(), _Mean()  # shares of the brake that was expected

    def forget(self) -> None:
        """Its sensor says something else now."""
        self.state, self.may_press_unseen, self.may_be_idle = ForceState.UNKNOWN, False, False
        self._by_creep, self._by_retardation = _Mean(), _Mean()

    def see_slides(self, now: Estimate, i: int, *, presses: bool) -> None:
        """Note what its wheelset does: to slide anew it takes a force that moves, or at least one that presses.

        Without slide protection it may slide anew at any force, on a rail that changes.
        """
        time_s, own = now.time_s, now.wheelsets[i]
        if self._stood_n is not None and moves(self._stood_n, own.pressing_force_n):  # it moves again
            self._stood_n, self.state = None, ForceState.UNKNOWN
        self._pressed.see(time_s, own.pressing_force_n >= PRESSES_N)
        if own.renewed_slides < (SLIDES_ANEW if presses else 1) or time_s - self._pressed.time_s >= LATELY_S:
            return
        if max([wheelset.work.wsp_actions for wheelset in now.wheelsets]) >= PROTECTED:
            self._stood_n, self.state = own.pressing_force_n, ForceState.CONTRADICTED

    def see(self, by_creep: ShownShare | None, by_retardation: ShownShare | None, *, presses: bool) -> None:
        """Note what share of the brake shows, and whether its sensor says that it presses; decide when it is clear.

        A train may retard the wagon as well, told or not, and so may the line. So the retardation decides alone only
        where there is no creep to be seen. Where that is in doubt it decides if creep at least leans to the same side.
        """
        self._by_creep.see(by_creep)
        self._by_retardation.see(by_retardation)
        works, retards = self._by_creep.works(SURE_SIGMAS), self._by_retardation.works(SURE_SIGMAS)
        if works is None and (not self._by_creep.is_seen or self._by_creep.works(LEANS_SIGMAS) is retards):
            works = retards
        if works is not None and retards in {works, None}:
            self.state = ForceState.BORNE_OUT if works is presses else ForceState.CONTRADICTED
        seems_to_work, is_known = self._by_retardation.works(LEANS_SIGMAS), self.state is not ForceState.UNKNOWN
        may_work = seems_to_work is not False and self._by_retardation.is_seen
        self.may_press_unseen = not (presses or is_known) and may_work
        self.may_be_idle = presses and not is_known and seems_to_work is False


class _Mean:
    """Mean of the shares of one brake application."""

    def __init__(self) -> None:
        self._count = 0
        self._mean = self._squares = 0.0
        self._lasting_std = self._noise_std = 0.0

    @property
    def is_seen(self) -> bool:
        """Whether there was any."""
        return self._count > 0

    def see(self, share: ShownShare | None) -> None:
        """Take the next, if it can be told."""
        if share is not None:
            self._count += 1
            off = share.value - self._mean
            self._mean += off / self._count
            self._squares += off * (share.value - self._mean)
            self._lasting_std, self._noise_std = share.lasting_std, share.noise_std

    def works(self, sigmas: float) -> bool | None:
        """Whether the brake works, None while that is closer than so many standard deviations."""
        if self._count < LEAST_COUNT:
            return None
        scatter = max(sqrt(self._squares / self._count), LEAST_SCATTER, self._noise_std)
        std = scatter / sqrt(max(self._count / INDEPENDENT, 1.0))
        is_clear = abs(self._mean - WORKS) > sigmas * hypot(std, self._lasting_std)
        return self._mean > WORKS if is_clear else None
