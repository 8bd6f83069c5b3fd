"""Pressing forces whose sensors are frozen: they repeat themselves while other brakes move."""

from collections import defaultdict, deque
from collections.abc import Iterable, Sequence
from functools import partial
from math import inf
from statistics import median

from brake_monitor.estimation.core.regime_watch import SHOWN_S
from brake_monitor.estimation.doubts.dead_force import DeadForce
from brake_monitor.monitoring.inputs.force_watch import SETTLED_S
from brake_monitor.monitoring.passing_time import LastTime
from brake_monitor.samples import Channel, Quantity

PRESSING_FORCE = Quantity.PRESSING_FORCE
FORCE_FROZEN_S = 5.0
FORCE_FROZEN_READINGS = 20
FOLLOWED_S = 3.0  # for so long others that still fall say nothing: a brake that keeps some air came down with them
MOVED_N = 8000.0  # another brake's force has moved this much meanwhile: far beyond what gear and sensors differ by
DEAD_MOVED_N = 3000.0  # ... where the sensor trembled before: that it does no longer has been seen already
SHOWN_FROM_MPS = 2.0  # at standstill neither shows anything


ForceReading = tuple[int, float, float]  # a good one of a pressing force: wheelset, time in s, force in N


class FrozenForces:
    """Sees the good readings of all pressing forces.

    Nothing is said of a force of zero: where all are, which is the usual case, more of them tell nothing.
    """

    def __init__(self, channels: Iterable[Channel], contact_force_n: float) -> None:
        wheelsets = [channel.wheelset for channel in channels if channel.quantity is PRESSING_FORCE]
        self.wheelsets = wheelsets  # whose pressing forces are mapped
        self._forces = {wheelset: _RepeatedForce(contact_force_n) for wheelset in wheelsets}
        self._others = {i: [force for k, force in self._forces.items() if k != i] for i in wheelsets}
        self.watchers = {(PRESSING_FORCE, wheelset): partial(self.see, wheelset) for wheelset in wheelsets}
        self.all_are_zero = False
        self._slid = LastTime()  # any wheelset did

    def see(self, wheelset: int, time_s: float, force_n: float) -> None:
        """Take a reading."""
        if force_n <= 0.0 and self.all_are_zero:
            return
        self._forces[wheelset].see(time_s, force_n)
        for other in self._others[wheelset]:
            if not other.is_zero:
                other.see_other(wheelset, time_s, force_n)
        self.all_are_zero = force_n <= 0.0 and all(force.is_zero for force in self._forces.values())

    def frozen(self, time_s: float, speed_mps: float, believed: Sequence[bool], *, slides: bool) -> frozenset[int]:
        """The wheelsets whose pressing forces are frozen.

        `believed`: which forces may speak against others; `slides`: whether any wheelset does.
        """
        self._slid.see(time_s, slides)
        if self.all_are_zero:
            return frozenset()
        for force in self._forces.values():
            if time_s - self._slid.time_s < SETTLED_S:
                force.forget_others()
            if force.stands(time_s):
                sure = {k for k, other in self._forces.items() if believed[k] and not other.is_frozen}
                force.judge(time_s, sure, rolls=speed_mps >= SHOWN_FROM_MPS)
        return frozenset([i for i, force in self._forces.items() if force.is_frozen])


class _Span:
    """How far another brake's force moved, by the middle one of five readings: one or two may be spikes."""

    def __init__(self) -> None:
        self._lately: deque[float] = deque(maxlen=5)
        self.least, self._most = inf, -inf
        self.rose = self._fell = 0.0

    def see(self, value: float, *, may_fall: bool) -> None:
        self._lately.append(value)
        if len(self._lately) == self._lately.maxlen:
            middle = median(self._lately)
            self.least = min(self.least, middle)
            self._most = max(self._most, middle) if may_fall else middle
            self.rose, self._fell = max(self.rose, middle - self.least), max(self._fell, self._most - middle)

    def has_moved(self, least_n: float) -> bool:
        return max(self.rose, self._fell) > least_n


class _RepeatedForce:
    """Notices a force that repeats itself to the last bit while other brakes fill or empty.

    Air that is held stands still by right, and a coarse sensor shows it so. What the driver does, all brakes do; what
    one brake does by itself says nothing of another: so more brakes must have moved than have stayed. At standstill air
    leaks for hours, here more and there less, but no leak fills brakes, nor empties most of them altogether beside one
    that is tight. Where as many have done so as have stayed each side may be at fault: wheelset and wagon are given
    time to show which. Nothing is said of a force of zero: that a brake does not fill is a fault of the brake.
    """

    def __init__(self, contact_force_n: float) -> None:
        self._contact_force_n = contact_force_n
        self._value = inf
        self._since_s = 0.0
        self._repeated = 0
        self._others: defaultdict[int, _Span] = defaultdict(_Span)  # by wheelset, what they did meanwhile
        self._life = DeadForce()
        self._moved_s = inf  # since when as many have moved as have stayed
        self.is_zero = self.is_frozen = False

    def see(self, time_s: float, force_n: float) -> None:
        """Take its next reading."""
        self._life.see(time_s, force_n)
        if force_n != self._value:
            self._value, self._since_s, self._repeated = force_n, time_s, 0
            self.is_zero, self.is_frozen = force_n <= 0.0, False
            self.forget_others()
        self._repeated += 1

    def see_other(self, wheelset: int, time_s: float, force_n: float) -> None:
        """Take the next reading of another one."""
        self._others[wheelset].see(force_n, may_fall=time_s - self._since_s >= FOLLOWED_S)

    def forget_others(self) -> None:
        """What they did until now was no common filling nor emptying."""
        self._others.clear()
        self._moved_s = inf

    def stands(self, time_s: float) -> bool:
        """Whether it has been the same for long, and something may be said of it."""
        since_s, self._since_s = self._since_s, min(self._since_s, time_s)  # the clock may be set back
        return self._repeated > FORCE_FROZEN_READINGS and time_s - since_s >= FORCE_FROZEN_S and not self.is_zero

    def judge(self, time_s: float, sure: set[int], *, rolls: bool) -> None:
        """Judge one that stands by the `sure` ones among the others; what is said holds until the value changes."""
        least_n = DEAD_MOVED_N if self._life.is_dead else MOVED_N
        spans = [span for wheelset, span in self._others.items() if wheelset in sure]
        others = [span for span in spans if span.has_moved(least_n)]
        moved = len(others)
        stayed = 1 + sum(span not in others and span.least >= self._contact_force_n for span in spans)
        is_whole = all(span.rose > least_n or span.least < self._contact_force_n for span in others)
        is_tie = moved == stayed and is_whole and rolls
        self._moved_s = min(self._moved_s, time_s) if is_tie else inf
        self.is_frozen |= moved > stayed and (is_whole or rolls)
        self.is_frozen |= time_s - self._moved_s >= SHOWN_S
