"""A brake that drags although its pressing force says released: by creep alone, over a long way.

In a train the speed does not tell of such a brake: couplers do more to it. What is left is that its wheelset has turned
more slowly against the others ever since a release. So does a wheelset in a curve, whose rolling radii differ, and one
whose tread the brake has warmed. But a curve ends: one that makes wheelsets differ by e has turned the line by 180°
after HALF_TURN_M / e. And treads grow warm while they are braked, not from the release on.
"""

from collections import deque
from collections.abc import Sequence
from math import inf, isfinite
from statistics import fmean, median
from typing import NamedTuple

from brake_monitor.estimation.estimate import LONGEST_STEP_S, Estimate
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.rolling.radius_calibration import TURNED_S
from brake_monitor.monitoring.contact_stiffness import SOFT, USUAL_STIFFNESS
from brake_monitor.monitoring.rules.rolled_way import LEAST_SPEED_MPS, RolledWay, Stretch, log_turns, turns_apart

AFTER_S = 3.0  # of the release, or of a motor's torque: speeds still settle
BLOCK_S = 5.0  # of free rolling, whose mean is one value
LEAST_SUSPECTED_M = 250.0  # of it before the release, and after it
LEAST_ALONE_M = 1000.0  # ... where there are more than two wheelsets, and only one moves
LEAST_WAY_M = 1500.0  # ... where there are two
MOST_WAY_M = 8000.0  # of free rolling are remembered before it, and since
HALF_TURN_M = 1.0  # R = 500 m makes leading and trailing wheelsets differ by 6e-4; none but a spiral turns so far
LEAST_SHIFT = 1.5e-4  # treads that some blocks warm more than others do as much
MOST_SHIFT = 0.3 / SOFT  # by a drag that takes 0.3 of its wheel load; more is no drag's
NO_CURVES = 1.5e-3  # R = 200 m makes leading and trailing wheelsets differ by 1.4e-3
WARMEST = 3e-3  # by a tread 250 K warmer than the others
TURNED = 2e-3  # more than a drag changes by: a wheelset was turned, or changed
SLOWER_BEFORE = 0.25  # so much of the way before may have been curves that slow this wheelset down as well ...
FASTER_SINCE = 0.1  # ... and so much of the way since curves that let it run ahead
STEADY = 0.5  # of the shift: the most by which anything else may move
STILL_THERE = 7e-4  # or half of the shift it was found with: pads that drag grow hot and rub less
BRAKING = 100  # observations, 10 s, of an application ...
EASED = 0.8  # ... before its force falls to this: in a release, pads that stick already press more than is told
LEAST_BRAKING = 10


class CreepDrag(NamedTuple):
    """What was found; the numbers by their names in an alarm's evidence."""

    wheelset: int  # from 0
    slip_shift: float  # relative slip against the other wheelsets, more than before
    rolled_apart: float  # how much faster than the others it turned before: logarithm
    shown_over_m: float  # of free rolling

    def retarding_force_n(self, now: Estimate) -> float:
        """At the rail, within a factor of two to three."""
        load_n = now.wheelsets[self.wheelset].relative_load * now.mass_kg * GRAVITY_MPS2 / len(now.wheelsets)
        return USUAL_STIFFNESS * self.slip_shift * load_n


class LastingCreepSearch:
    """Sees each estimate, in order of time."""

    def __init__(self, contact_force_n: float, least_force_n: float) -> None:
        """`least_force_n`: at the rail; a smaller one is not looked for."""
        self._contact_force_n = contact_force_n
        self._least_force_n = least_force_n
        self._time_s = self._rolled_s = -inf  # of the last estimate, and of the last one at speed
        self._held_s = -inf  # when it last did not roll freely
        self.lasting: dict[int, CreepDrag] = {}  # by wheelset, found and not known to be gone
        self._forget()

    def _forget(self) -> None:
        self._before = RolledWay()  # of free rolling, as far as is known without a drag
        self._since = RolledWay()  # ... since the release after which one may have begun
        self._braking: deque[tuple[float, ...]] = deque(maxlen=BRAKING)  # of the application before it, not yet eased
        self._is_braked = False
        self._most_n = 0.0  # force of all brakes in this application
        self.suspected: CreepDrag | None = None  # so far; it may yet be a curve
        self._begin_block()

    def _begin_block(self) -> None:
        self._turns: list[tuple[float, ...]] = []
        self._block_s = self._block_m = 0.0

    def see(self, now: Estimate, inputs_are_good: bool) -> CreepDrag | None:
        """Take an estimate; what has been found, while it shows."""
        step_s, self._time_s = now.time_s - self._time_s, now.time_s
        if step_s < 0.0:
            self._held_s = self._rolled_s = now.time_s
        if len(now.wheelsets) == 1 or now.speed_mps < LEAST_SPEED_MPS or now.saturated or not inputs_are_good:
            self._held_s = now.time_s
            return None
        if now.time_s - self._rolled_s > TURNED_S:
            self._forget()
            if isfinite(self._rolled_s):  # else the program has begun, and it may have stood for a moment
                self.lasting.clear()
        self._rolled_s = now.time_s
        forces_n = now.forces_n
        is_braked = max(forces_n) >= self._contact_force_n
        if is_braked or now.a_motor_acts:
            self._held_s = now.time_s
            if is_braked:
                self._brake(now, forces_n)
            return None
        self._is_braked = False
        if now.time_s - self._held_s >= AFTER_S and 0.0 < step_s <= LONGEST_STEP_S:
            self._roll(now, step_s)
        return self._shown()

    def _brake(self, now: Estimate, forces_n: Sequence[float]) -> None:
        if not self._is_braked:
            self._is_braked, self._most_n = True, 0.0
            self._begin_block()
            if not self.lasting and self.suspected is None and self._was_free_of_drags():
                self._begin_anew()
        self._most_n = max(self._most_n, sum(forces_n))
        is_eased = sum(forces_n) < EASED * self._most_n
        if not self._since and not is_eased:  # whoever presses: a wheelset that brakes alone turns more slowly, then
            self._braking.append(log_turns(now))

    def _was_free_of_drags(self) -> bool:
        """Whether nothing can have dragged since the last release; a short way has to show it."""
        if self._since.length_m >= LEAST_SUSPECTED_M or not self._before:
            return True
        return len(self._since) > 0 and self._most_shifted().slip_shift < LEAST_SHIFT

    def _begin_anew(self) -> None:
        """What was rolled since the last release was free of any drag."""
        self._before.extend(self._since)
        self._since.clear()
        self._braking.clear()

    def _roll(self, now: Estimate, step_s: float) -> None:
        self._turns.append(log_turns(now))
        self._block_s += step_s
        self._block_m += step_s * now.speed_mps
        if self._block_s < BLOCK_S:
            return
        self._since.append(Stretch(self._block_m, _mean_apart(self._turns)))
        self._begin_block()
        self._see_onset()
        passed = self._since.shorten(MOST_WAY_M)
        if self.lasting:
            self._see_what_lasts()
            return
        self._before.extend(passed)
        if passed and self.suspected is not None:  # nor will a longer way tell: too little is known from before
            self._begin_anew()
        self._before.shorten(MOST_WAY_M)
        self.suspected = self._suspect(now)
        if self.suspected is not None and self._is_no_curve(self.suspected, len(now.wheelsets)):
            self.lasting[self.suspected.wheelset], self.suspected = self.suspected, None

    def _see_onset(self) -> None:
        """See whether a strong drag has begun as the wagon rolled: what was rolled until then was free of it."""
        early, late = self._since.parted(LEAST_SUSPECTED_M)
        if min(early.length_m, late.length_m) < LEAST_SUSPECTED_M:
            return
        for i in range(late.wheelset_count):
            shift = min(early.apart(i)) - max(late.apart(i))
            others = zip(early.others(i), late.others(i), strict=True)
            if shift >= NO_CURVES and all(abs(was - now) <= STEADY * shift for was, now in others):
                self._before.extend(early)
                self._since = late
                self._braking.clear()
                return

    def _suspect(self, now: Estimate) -> CreepDrag | None:
        """The wheelset that has turned more slowly all along, if any."""
        if min(self._since.length_m, self._before.length_m) < LEAST_SUSPECTED_M:
            return None
        drag = self._most_shifted()
        is_possible = LEAST_SHIFT <= drag.slip_shift <= MOST_SHIFT and self._stands_apart(drag)
        return drag if is_possible and drag.retarding_force_n(now) >= self._least_force_n else None

    def _is_no_curve(self, drag: CreepDrag, wheelset_count: int) -> bool:
        """Whether it shows for longer than any curve before or after; of more than two wheelsets that moves several."""
        shown_m = min(drag.shown_over_m, self._before.length_m)
        if wheelset_count > 2:
            return shown_m >= LEAST_ALONE_M
        return shown_m >= LEAST_WAY_M and drag.slip_shift * shown_m >= HALF_TURN_M

    def _most_shifted(self) -> CreepDrag:
        return max([self._shifted(i) for i in range(self._since.wheelset_count)], key=lambda one: one.slip_shift)

    def _shifted(self, i: int) -> CreepDrag:
        before = median(self._before.apart(i))
        return CreepDrag(i, before - median(self._since.apart(i)), before, self._since.length_m)

    def _stands_apart(self, drag: CreepDrag) -> bool:
        """Whether it was so all along, from the release on, and nothing else has moved."""
        i, most = drag.wheelset, STEADY * drag.slip_shift
        before, since = sorted(self._before.apart(i)), sorted(self._since.apart(i))
        slowest_before = before[int(SLOWER_BEFORE * len(before))]
        fastest_since = since[-1 - int(FASTER_SINCE * len(since))]
        if slowest_before - fastest_since < most:
            return False
        may_be_warm = drag.slip_shift < WARMEST and len(self._braking) >= LEAST_BRAKING
        if may_be_warm and _mean_apart(self._braking)[i] - median(since) < most:
            return False
        others = zip(self._before.others(i), self._since.others(i), strict=True)
        return all(abs(was - now) <= most for was, now in others)

    def _see_what_lasts(self) -> None:
        """Forget a drag of which nothing has shown on most of a way that is longer than curves."""
        lately = self._since.last(LEAST_WAY_M)
        if lately.length_m < LEAST_WAY_M:
            return
        for i, drag in list(self.lasting.items()):
            if sum([_is_slower(drag, stretch) for stretch in lately]) <= SLOWER_BEFORE * len(lately):
                del self.lasting[i]
        if not self.lasting:
            self._since.clear()
            self._before = lately

    def _shown(self) -> CreepDrag | None:
        """One that was found and is there now."""
        return next((drag for drag in self.lasting.values() if self._since and _is_slower(drag, self._since[-1])), None)


def _is_slower(drag: CreepDrag, stretch: Stretch) -> bool:
    shift = drag.rolled_apart - stretch.apart[drag.wheelset]
    return min(STEADY * drag.slip_shift, STILL_THERE) <= shift <= drag.slip_shift + TURNED


def _mean_apart(turns: Sequence[Sequence[float]]) -> tuple[float, ...]:
    return turns_apart([fmean(own) for own in zip(*turns, strict=True)])
