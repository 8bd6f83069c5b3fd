"""Which brakes press by their sensors, since when, and what they and the wagon did in the last seconds."""

from collections import deque
from collections.abc import Sequence
from math import inf

from msgspec import Struct

from brake_monitor.estimation.core.prediction import PAUSE_S
from brake_monitor.estimation.core.regime_watch import PRESSES_N
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.passing_time import LastTime

REMEMBERED_S = 2.7  # for so long, until the mean retardation tells of a force that fell: see `fallen_force`
STEADY_S = 1.8  # the same brakes have pressed for this long: speeds and creep have settled
STEADY = 0.1  # of the pressing force


class Moment(Struct, frozen=True):
    """One observation."""

    time_s: float
    forces_n: tuple[float, ...]
    told: Sequence[bool]  # whether each was measured then: else it is what was held
    total_mps2: float | None  # retardation, mean before; None while motors have a part in it


class PressedBrakes:
    """Sees the wagon at each observation, in order of time."""

    def __init__(self, contact_force_n: float, count: int) -> None:
        self.contact_force_n = contact_force_n
        self.past: deque[Moment] = deque()  # of the last seconds, the oldest first
        self.pressing: tuple[bool, ...] = ()
        self.changed = LastTime()  # one came to press, or ceased to
        self.slid = LastTime()  # any wheelset did
        self.applied_s = -inf  # when brakes came on after all had been released
        self.have_pressed = [False] * count  # since then
        self._pressed_s = -inf  # when any last pressed

    def note(self, now: Estimate, moment: Moment) -> list[int]:
        """Take an observation; the brakes that came to press, or ceased to."""
        if self.past and self.past[-1].time_s > now.time_s:  # the clock was set back
            self.past.clear()
        self.past.append(moment)
        while now.time_s - self.past[0].time_s > REMEMBERED_S:
            self.past.popleft()
        self.slid.see(now.time_s, now.saturated or now.protection_acts)
        pressing = tuple([force_n >= self.contact_force_n for force_n in moment.forces_n])
        if any(pressing):
            self._note_application(now.time_s, pressing)
        before, self.pressing = self.pressing, pressing
        self.changed.see(now.time_s, pressing != before)
        return [i for i, (was, presses) in enumerate(zip(before, pressing, strict=False)) if was is not presses]

    def _note_application(self, time_s: float, pressing: tuple[bool, ...]) -> None:
        begins = not 0.0 <= time_s - self._pressed_s <= PAUSE_S
        if begins:
            self.applied_s = time_s
        self._pressed_s = time_s
        before = zip(pressing, self.have_pressed, strict=True)
        self.have_pressed = [presses or (has and not begins) for presses, has in before]

    @property
    def are_the_same(self) -> bool:
        """Whether none has come to press, or ceased to, for so long that speeds and creep have settled."""
        return self.past[-1].time_s - self.changed.time_s >= STEADY_S

    @property
    def are_steady(self) -> bool:
        """Whether all press as they did a while ago, so that creep is theirs."""
        before_n, now_n = self.past[0].forces_n, self.past[-1].forces_n
        if not self.are_the_same or min(now_n) < PRESSES_N:
            return False
        return all(abs(now - before) < STEADY * before for before, now in zip(before_n, now_n, strict=True))

    @property
    def may_show(self) -> bool:
        """Whether there is anything to judge: nothing is said of brakes that all have been released for a while."""
        most_n, pressed_n = max(self.past[-1].forces_n), max(self.past[0].forces_n)
        return most_n >= min(self.contact_force_n, PRESSES_N) or pressed_n >= PRESSES_N
