"""A brake that drags although its pressing force says released: by what speed and wheels do after a release.

Neither of its two traces is enough. The wagon decelerates by F / m more than before the brake application, but so it
does on a steeper gradient. The wheelset creeps by F / c against the others, but so it does in a curve, whose rolling
radii differ. Both together, of one force F, with the creep stiffness c that the brake application itself has shown,
lasting from the very release, while the wheelsets' speeds kept their ratios during the application: that is a brake.
Where they did not, a brake may have begun to drag meanwhile, or a curve: the brake still shows after the next release.
So does one that was found, but not told before the wagon was braked anew. It drags until the wagon rolls again without
either trace, in whatever curve or gradient it was before: a brake that sticks at each release is found at the first, as
the others then begin with it.
"""

from collections import deque
from collections.abc import Sequence
from functools import cached_property
from math import hypot, inf, log
from statistics import fmean
from typing import NamedTuple

from msgspec import Struct

from brake_monitor.estimation.core.regime_watch import ROLLING_AGAIN_S
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.rolling.line_roughness import PULLED_MPS2
from brake_monitor.monitoring.rules.block_means import BLOCK, block_means, mean_and_std, moved, std_between
from brake_monitor.monitoring.rules.rolled_way import LEAST_SPEED_MPS, log_turns, turns_apart

BEFORE_S = 12.0  # of free rolling before the application, at most ...
LEAST_BEFORE_S = 4.0
LEAST_BRAKING_S = 3.0
MOST_BRAKING = 600  # observations; what comes later in a long application is left out
LEAST_AFTER_S = 9.0
LONGEST_AFTER_S = 30.0  # after the release; from then on the track may have changed
SIGNIFICANT_SIGMAS = 3.5
LEAST_SHIFT = 1e-4  # relative; tyres and curves do as much
SEEN_AGAIN_S = 4.0  # of free rolling after the next release, by when both traces have to show again
STIFFNESS_RATIO = 1.8  # the creep stiffness by drag over that by braking, or the other way round
CLEAR_SIGMAS = 3.0  # of what the vehicle's speed errs by: with less the creep by braking is not known
TURNED = 1e-3  # more than a drag shifts, or any curve: tyres were turned meanwhile, or wheelsets changed
STEADY = 0.5  # of force and shift: the most by which they, or anything else, may move


class HiddenDrag(NamedTuple):
    """What was found; the numbers by their names in an alarm's evidence."""

    wheelset: int  # from 0
    retarding_force_n: float  # at the rail
    slip_shift: float  # relative slip against the other wheelsets
    slip_shift_std: float
    rolled_deceleration_mps2: float  # of the wagon before the application, beside what the model knows ...
    rolled_apart: float  # ... and how much faster this wheelset turned than the others: logarithm


class _Moment(Struct, frozen=True, dict=True):
    """An estimate, and its logarithms, which are seldom asked for."""

    now: Estimate

    @cached_property
    def log_turns(self) -> tuple[float, ...]:
        """Of each wheelset, ln omega."""
        return log_turns(self.now)

    @cached_property
    def apart(self) -> tuple[float, ...]:
        """Of each wheelset, ln omega less the others' mean."""
        return turns_apart(self.log_turns)

    @property
    def log_speed(self) -> float:
        return log(self.now.speed_mps)


class HiddenDragSearch:
    """Sees each estimate, in order of time."""

    def __init__(self, contact_force_n: float, least_force_n: float) -> None:
        """`least_force_n`: at the rail; a smaller one is not looked for."""
        self._contact_force_n = contact_force_n
        self._least_force_n = least_force_n
        self._time_s = -inf
        self.lasting: dict[int, HiddenDrag] = {}  # by wheelset, found after some release, and not known to be gone
        self._forget()

    def _forget(self) -> None:
        self._lately: deque[_Moment] = deque()  # of free rolling
        self._before: list[_Moment] = []
        self._braking: list[_Moment] = []
        self._after: list[_Moment] = []
        self._released_s = inf
        self._by_motors = False  # did any brake in this application
        self._suspected: HiddenDrag | None = None  # after the last release
        self._awaited: HiddenDrag | None = None  # after an earlier one; it has to show after each
        self._found: HiddenDrag | None = None

    def see(self, now: Estimate, inputs_are_good: bool) -> HiddenDrag | None:
        """Take an estimate; what the last release, or one before it as well, has told so far."""
        was_set_back, self._time_s = now.time_s < self._time_s, now.time_s
        is_alone = len(now.wheelsets) == 1
        if now.speed_mps < LEAST_SPEED_MPS or now.saturated or not inputs_are_good or is_alone or was_set_back:
            self._forget()
            return None
        by_motors = True in now.motors_brake
        forces_n = now.forces_n
        if by_motors or max(forces_n) >= self._contact_force_n:
            self._brake(now, min(forces_n) >= self._contact_force_n, by_motors)
        elif now.a_motor_acts:  # it does not roll freely
            self._forget()
        else:
            self._roll(now)
        return self._found

    def _brake(self, now: Estimate, all_press: bool, by_motors: bool) -> None:
        self._released_s = inf
        if self._lately:  # a new application, not one that was eased for a moment
            self._before, self._braking, self._after = list(self._lately), [], []
            self._awaited, self._suspected = self._suspected or self._awaited, None
            self._lately, self._found, self._by_motors = deque(), None, False
        self._by_motors |= by_motors
        if (all_press or by_motors) and len(self._braking) < MOST_BRAKING:
            self._braking.append(_Moment(now))

    def _roll(self, now: Estimate) -> None:
        self._released_s = min(self._released_s, now.time_s)
        rolled_s = now.time_s - self._released_s
        if rolled_s < ROLLING_AGAIN_S:
            return
        moment = _Moment(now)
        self._lately.append(moment)
        while now.time_s - self._lately[0].now.time_s >= BEFORE_S:
            self._lately.popleft()
        if now.time_s - self._lately[0].now.time_s >= LEAST_AFTER_S:
            self._see_what_lasts(now.mass_kg)
        if rolled_s < LONGEST_AFTER_S:
            self._after.append(moment)
            if len(self._after) % BLOCK == 0:
                self._suspected = self._judged(now.mass_kg)
        self._found = self._certain(now)
        if self._found is not None:
            self.lasting.setdefault(self._found.wheelset, self._found)

    def _certain(self, now: Estimate) -> HiddenDrag | None:
        """What is no curve that began while braking, or did not end as one."""
        if self._suspected is not None and self._was_steady(self._suspected):
            return self._suspected
        awaited = self._awaited
        if awaited is None or now.time_s - self._lately[0].now.time_s < SEEN_AGAIN_S:
            return None
        more_n, shift = self._traces(awaited, now.mass_kg)
        least_n, least_shift = (1.0 - STEADY) * awaited.retarding_force_n, (1.0 - STEADY) * awaited.slip_shift
        self._awaited = awaited if more_n > least_n and shift > least_shift else None
        return self._awaited

    def _see_what_lasts(self, mass_kg: float) -> None:
        """Forget the drags of which neither trace is left, and those whose traces are of other tyres."""
        for i, drag in list(self.lasting.items()):
            more_n, shift = self._traces(drag, mass_kg)
            is_gone = more_n < STEADY * drag.retarding_force_n and shift < STEADY * drag.slip_shift
            if is_gone or shift > drag.slip_shift + TURNED:
                del self.lasting[i]

    def _traces(self, drag: HiddenDrag, mass_kg: float) -> tuple[float, float]:
        """What is left of its force and its shift."""
        more_n = mass_kg * (_mean_d(self._lately) - drag.rolled_deceleration_mps2)
        return more_n, drag.rolled_apart - fmean([m.apart[drag.wheelset] for m in self._lately])

    def _judged(self, mass_kg: float) -> HiddenDrag | None:
        spans = ((self._before, LEAST_BEFORE_S), (self._braking, LEAST_BRAKING_S), (self._after, LEAST_AFTER_S))
        if any(not part or part[-1].now.time_s - part[0].now.time_s < least_s for part, least_s in spans):
            return None
        shortly_before = self._before[len(self._before) // 2 :]
        if min([m.now.deceleration_mps2 for m in shortly_before]) < -PULLED_MPS2:
            return None  # as it brakes the pull ends, and the wagon retards by as much
        rolled_mps2 = _mean_d(shortly_before)
        force_n, *at_ends_n = [mass_kg * (_mean_d(m) - rolled_mps2) for m in (self._after, *_ends(self._after))]
        if force_n < self._least_force_n or min(at_ends_n) < (1.0 - STEADY) * force_n:
            return None
        shifts = [_shift(i, self._before, self._after) for i in range(len(self._after[0].log_turns))]
        i = max(range(len(shifts)), key=lambda k: shifts[k][0])
        shift, std = shifts[i]
        significant = shift > max(SIGNIFICANT_SIGMAS * std, LEAST_SHIFT)
        if significant and self._fits(shift, force_n, mass_kg) and self._is_alone(i, shift):
            apart = fmean([m.apart[i] for m in self._before])
            return HiddenDrag(i, force_n, shift, std, rolled_mps2, apart)
        return None

    def _fits(self, shift: float, force_n: float, mass_kg: float) -> bool:
        """Whether this force makes this creep, as the brakes made theirs."""
        count = len(self._before[0].log_turns)
        rolled = [fmean(m.log_turns) - m.log_speed for m in self._before]
        creep = fmean(rolled) - fmean(fmean(m.log_turns) - m.log_speed for m in self._braking)
        adhesion = fmean(m.now.adhesion for m in self._braking)
        if adhesion <= 0.0 or creep <= CLEAR_SIGMAS * std_between(block_means(rolled), len(self._braking) / BLOCK):
            return False
        stiffness_n = adhesion * mass_kg * GRAVITY_MPS2 / count / creep
        return 1.0 / STIFFNESS_RATIO <= force_n / shift / stiffness_n <= STIFFNESS_RATIO

    def _was_steady(self, drag: HiddenDrag) -> bool:
        """Whether the wheelset kept its ratio to the others while braking; motors and pads hand over to each other."""
        halves = _in_halves([m.apart[drag.wheelset] for m in self._braking])
        return self._by_motors or moved(*halves) <= STEADY * drag.slip_shift

    def _is_alone(self, i: int, shift: float) -> bool:
        """Whether nothing else moved beyond its scatter: the ratios since the application, and the others."""
        alike = [_in_halves([m.apart[i] for m in self._after])]
        before_others, after_others = [_without(i, m) for m in self._before], [_without(i, m) for m in self._after]
        alike += zip(zip(*before_others, strict=True), zip(*after_others, strict=True), strict=True)
        return all(moved(early, late) <= STEADY * shift for early, late in alike)


def _shift(i: int, before: Sequence[_Moment], after: Sequence[_Moment]) -> tuple[float, float]:
    """By how much wheelset i turns more slowly against the others than before, and the deviation of that."""
    before_mean, before_std = mean_and_std([m.apart[i] for m in before])
    after_mean, after_std = mean_and_std([m.apart[i] for m in after])
    return before_mean - after_mean, hypot(before_std, after_std)


def _without(i: int, moment: _Moment) -> tuple[float, ...]:
    """Logarithms of omega of the other wheelsets, less their mean."""
    others = moment.log_turns[:i] + moment.log_turns[i + 1 :]
    mean = fmean(others)
    return tuple([own - mean for own in others])


def _mean_d(moments: Sequence[_Moment]) -> float:
    return fmean([m.now.deceleration_mps2 for m in moments])


def _ends(after: Sequence[_Moment]) -> tuple[list[_Moment], list[_Moment]]:
    """The first and the last LEAST_AFTER_S."""
    until_s, from_s = after[0].now.time_s + LEAST_AFTER_S, after[-1].now.time_s - LEAST_AFTER_S
    return [m for m in after if m.now.time_s <= until_s], [m for m in after if m.now.time_s >= from_s]


def _in_halves(values: Sequence[float]) -> tuple[Sequence[float], Sequence[float]]:
    half = len(values) // 2
    return values[:half], values[half:]
