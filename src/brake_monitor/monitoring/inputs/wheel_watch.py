"""Whether each wheelset rolls, slides or stands, and whether a reading of standstill is to be believed.

What tells a wheelset that is stopped while the wagon moves from a wheel-speed sensor that has died:

- **How it came to stop**, see `WatchedWheelset`.
- **What follows.** A stopped wheelset drags: the wagon retards more than its pressing forces explain.
- **What all say.** If no wheelset turns, and none was seen to be stopped, it is the vehicle's speed that is wrong. If
  all fell together at a crawl, their sensors have cut out, as many do below some km/h.
"""

from collections import deque
from collections.abc import Callable, Sequence
from math import inf

from msgspec import Struct

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.inputs.retardation import mean_retardation_mps2
from brake_monitor.monitoring.inputs.speed_scale import SpeedScale
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.watched_wheelset import (
    CUTS_OUT_BELOW_MPS,
    RELEASED_S,
    ROLLING_SLIP,
    WATCHED_FROM_MPS,
    Origin,
    WatchedWheelset,
)
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.last_time import LastTime
from brake_monitor.samples import Measurand, Quantity
from brake_monitor.settings.config import Vehicle

WAIT_S = 1.3  # until a wheelset that stands is judged by its drag ...
FALLING_S = 0.3  # ... of which the time of the fall itself says nothing
SOONER_S = 0.2  # the vehicle's speed is doubted this long before all its wheelsets are said to stand
BEFORE_S = 2.0
PAST_S = BEFORE_S + WAIT_S + 1.0
TOGETHER_S = 1.0  # sensors of one kind cut out at about one speed, and the wheelsets of a wagon roll alike
DRAG_MPS2 = 0.15  # rise of the retardation at the fall
UNCOMPARED_DRAG_MPS2 = 0.3  # retardation without brakes where nothing is known of before: a gradient of 30 ‰ is rare
LATE_DRAG_S = 8.0  # so long, of one that was not believed to stand: longer than a shove, or a train's pull that ends
FORCE_ROSE_N = 4000.0  # then the retardation may be the brakes'
ALL_STOPPED_MPS2 = 0.1  # no wheelset turns and yet the wagon hardly slows down: its speed is wrong
SPEED_DIFFERS = 0.2
SPEED_DIFFERS_MPS = 1.5  # wheel-speed sensors cut out as late
SPEED_DOUBT_S = 0.5
SPEED_AGREES = 0.05  # one that was not believed is believed again when it agrees as well with a wheelset ...
SPEED_AGREES_S = 3.0  # ... for so long, at a speed where that says something
NOT_TURNED = {Origin.UNSEEN, Origin.STOOD}  # of a wheelset that has not been seen to turn since it could


class _Moment(Struct, frozen=True, gc=False):  # only numbers
    time_s: float
    speed_mps: float
    forces_n: float  # with which all brakes press, motors included


class WheelWatch:
    """Sees the raw speeds and pressing forces, and the wagon at each observation."""

    def __init__(self, vehicle: Vehicle, contact_force_n: float, *, is_in_train: bool = False) -> None:
        """A wagon that `is_in_train` is retarded by others as well."""
        self._is_in_train = is_in_train
        self.speed = speed = VehicleSpeed()
        self.wheels = [WatchedWheelset(vehicle, i, contact_force_n, speed) for i in range(vehicle.wheelset_count)]
        self.watchers: dict[Measurand, Callable[[float, float], None]] = {(Quantity.SPEED, 0): speed.see}
        for i, wheel in enumerate(self.wheels):
            self.watchers[Quantity.AXLE_SPEED, i] = wheel.see_speed
            self.watchers[Quantity.PRESSING_FORCE, i] = wheel.holding.see_force
            self.watchers[Quantity.WHEEL_TORQUE, i] = wheel.holding.see_torque
        self._vehicle = vehicle
        self._mass_kg = vehicle.mass_kg
        self._contact_force_n = contact_force_n
        self._doubt_since_s = self._agrees_since_s = inf
        self._past: deque[_Moment] = deque()
        self._pressed = LastTime()  # any brake did
        self._demanded_s = -inf
        self._stands_alone = False  # the vehicle's speed does
        self._scale = SpeedScale()

    def judge(self, now: Estimate, measured: Sequence[bool]) -> tuple[WheelState, ...]:
        """What each wheelset does; `measured`: whether its own speed and the vehicle's are good."""
        self._note(now)
        self._judge_speed(now, measured)
        if len(self.wheels) > 1 and all(measured) and self.speed.mps is not None:
            rolling_mps = [wheel.rolling_mps for wheel in self.wheels]
            self._scale.see(now.time_s, self.speed.mps, rolling_mps, is_free=self._rolls_freely(now))
        if self.speed_is_contradicted or self._doubt_since_s < inf:
            return (WheelState.UNKNOWN,) * len(self.wheels)
        demanded = now.time_s - self._demanded_s < RELEASED_S
        rolls = [is_good and abs(own.slip) < ROLLING_SLIP for own, is_good in zip(now.wheelsets, measured, strict=True)]
        cut_out = self._cut_out(now, measured)
        states = []
        for i, wheel in enumerate(self.wheels):
            if not measured[i]:
                states.append(WheelState.UNKNOWN)
            elif cut_out:
                states.append(WheelState.DOUBTFUL)
            elif wheel.stands_since_s < inf:
                states.append(self._judge_standing(wheel, now))
            else:
                states.append(wheel.judge_turning(now, now.wheelsets[i], demanded=demanded, any_rolls=True in rolls))
        return tuple(states)

    @property
    def speed_is_contradicted(self) -> bool:
        """Whether the vehicle's speed is not to be believed beside its wheelsets'."""
        return self._stands_alone or self._scale.is_off

    @property
    def drops(self) -> int:
        """How often wheel speeds have fallen to 0 as no brake stops a wheelset."""
        return sum(wheel.drops for wheel in self.wheels)

    @property
    def any_is_blocked(self) -> bool:
        """Whether a wheelset stands that no brake says to hold."""
        return WheelState.BLOCKED in [wheel.decided for wheel in self.wheels]

    @property
    def may_be_locked(self) -> bool:
        """Whether a wheelset that its sensor says to stand, and is not believed for want of a drag, stands after all.

        It has not been seen to turn, or the wagon, once it is released, is retarded as if it dragged, or by the line.
        """
        return any(
            wheel.decided is WheelState.CONTRADICTED and (wheel.origin in NOT_TURNED or wheel.may_drag)
            for wheel in self.wheels
        )

    def _note(self, now: Estimate) -> None:
        time_s, past = now.time_s, self._past
        wheels = self.wheels
        if now.mass_kg != self._mass_kg:
            self._mass_kg = now.mass_kg
            for wheel in wheels:
                wheel.holding.bear(now.mass_kg)
        forces_n = [now.wheelsets[i].pressing_force_n + wheel.holding.motor_force_n for i, wheel in enumerate(wheels)]
        past.append(_Moment(time_s, now.speed_mps, sum(forces_n)))
        while time_s - past[0].time_s > PAST_S or past[0].time_s > time_s:
            past.popleft()
        pressed = max(forces_n) > self._contact_force_n
        self._pressed.see(time_s, pressed)
        if pressed or now.protection_acts:
            self._demanded_s = time_s
        elif self._demanded_s > time_s:
            self._demanded_s = -inf

    def _rolls_freely(self, now: Estimate) -> bool:
        """Whether neither brake nor motor has acted on any wheelset for a while."""
        acted_s = max(self._pressed.time_s, self._demanded_s, *(wheel.holding.driven_s for wheel in self.wheels))
        return now.time_s - acted_s >= RELEASED_S

    def _judge_speed(self, now: Estimate, measured: Sequence[bool]) -> None:
        """Whether the vehicle's speed stands alone against its wheelsets."""
        speed_mps = self.speed.mps or 0.0
        wheels = self._told_of(measured)
        rolling = [wheel.rolling_mps for wheel in wheels]
        if self._stands_alone:
            self._believe_speed_again(now.time_s, speed_mps, rolling)
            return
        several = len(wheels) > 1
        left_all = several and _have_all_been_left(wheels, speed_mps)
        if not rolling or (any(_agree(own_mps, speed_mps) for own_mps in rolling) and not left_all):
            self.speed.jumped, self._doubt_since_s = False, inf
            return
        rolling.sort()
        together = rolling[-1] - rolling[0] < SPEED_DIFFERS * rolling[-1] + SPEED_DIFFERS_MPS
        alone = together and (self.speed.jumped or left_all or (several and all(wheel.is_odd for wheel in wheels)))
        if all(wheel.stands_since_s < inf for wheel in wheels) and speed_mps > WATCHED_FROM_MPS:
            origins = {wheel.origin for wheel in wheels}
            slows = (self._retardation(now.time_s - WAIT_S, now.time_s) or 0.0) > ALL_STOPPED_MPS2
            pressed = all(wheel.holding.suffices for wheel in wheels)
            waited = now.time_s - max(wheel.stands_since_s for wheel in wheels) >= WAIT_S - SOONER_S
            if origins == {Origin.STOOD}:
                alone |= speed_mps > CUTS_OUT_BELOW_MPS
            else:
                alone |= waited and origins <= NOT_TURNED and not (slows and pressed)
        self._doubt_since_s = min(self._doubt_since_s, now.time_s) if alone else inf
        self._stands_alone |= now.time_s - self._doubt_since_s >= SPEED_DOUBT_S

    def _believe_speed_again(self, time_s: float, speed_mps: float, rolling: list[float]) -> None:
        agrees = any(abs(own - speed_mps) < SPEED_AGREES * own for own in rolling if own > WATCHED_FROM_MPS)
        self._agrees_since_s = min(self._agrees_since_s, time_s) if agrees else inf
        if time_s - self._agrees_since_s >= SPEED_AGREES_S:
            self._stands_alone, self.speed.jumped = False, False
            self._doubt_since_s = self._agrees_since_s = inf

    def _cut_out(self, now: Estimate, measured: Sequence[bool]) -> bool:
        """Whether the sensors have cut out in a stop; of that one that falls first is not believed before the next."""
        if now.speed_mps > CUTS_OUT_BELOW_MPS:
            return False
        wheels = self._told_of(measured)
        fell_s = [wheel.stands_since_s for wheel in wheels if wheel.fell_at_a_crawl]
        if not fell_s or max(fell_s) - min(fell_s) > TOGETHER_S:
            return False
        return len(fell_s) == len(wheels) or now.time_s - min(fell_s) < TOGETHER_S

    def _told_of(self, measured: Sequence[bool]) -> list[WatchedWheelset]:
        return [wheel for wheel, good in zip(self.wheels, measured, strict=True) if good]

    def _judge_standing(self, wheel: WatchedWheelset, now: Estimate) -> WheelState:
        """Decide once; what is decided holds until the wheelset turns again."""
        if now.speed_mps <= WATCHED_FROM_MPS and wheel.decided is not WheelState.CONTRADICTED:
            return WheelState.DOUBTFUL
        if wheel.decided is WheelState.STOPPED and self._is_released(wheel, now):
            wheel.decided = WheelState.BLOCKED
        if wheel.decided is WheelState.CONTRADICTED:
            self._see_drag(wheel, now)
        if wheel.decided is not None:
            return wheel.decided
        wheel.may_drag = False
        if wheel.origin is Origin.STOPPED:
            wheel.decided = WheelState.STOPPED
        elif now.time_s - wheel.stands_since_s < WAIT_S:
            return WheelState.DOUBTFUL
        else:
            not_turned = wheel.origin in NOT_TURNED
            stands = wheel.holding.suffices if not_turned else self._drags_since(wheel.stands_since_s, now.time_s)
            wheel.decided = WheelState.STOPPED if stands or self._drags_unbraked(now) else WheelState.CONTRADICTED
        return wheel.decided

    def _is_released(self, wheel: WatchedWheelset, now: Estimate) -> bool:
        """Whether all brakes say that they are, and have for longer than the rail needs to turn the wheelset again."""
        released_s = now.time_s - max(self._pressed.time_s, wheel.stands_since_s)
        is_told = now.time_s - wheel.holding.noted_s < RELEASED_S
        return is_told and released_s > RELEASED_S + wheel.turns_within_s(now.speed_mps)

    def _see_drag(self, wheel: WatchedWheelset, now: Estimate) -> None:
        """See, of one that is not believed to stand, whether the wagon retards without its brakes as if it did.

        One that has not turned yet was judged as the wagon was pulled. It is believed later, when it drags for long.
        """
        unbraked_mps2 = self._unbraked_mps2(now)
        if unbraked_mps2 is None or now.speed_mps <= WATCHED_FROM_MPS:
            wheel.drags_since_s = inf
            return
        wheel.may_drag = unbraked_mps2 > DRAG_MPS2
        wheel.drags_since_s = min(wheel.drags_since_s, now.time_s) if unbraked_mps2 > UNCOMPARED_DRAG_MPS2 else inf
        drags_for_long = now.time_s - wheel.drags_since_s >= LATE_DRAG_S
        if drags_for_long and wheel.origin in NOT_TURNED and not self._is_in_train:
            wheel.decided = WheelState.STOPPED

    def _drags_unbraked(self, now: Estimate) -> bool:
        unbraked_mps2 = self._unbraked_mps2(now)
        return unbraked_mps2 is not None and unbraked_mps2 > UNCOMPARED_DRAG_MPS2

    def _unbraked_mps2(self, now: Estimate) -> float | None:
        """By how much the wagon retards with no pad pressing, beyond what the track takes; None while one presses."""
        forces_n = [past.forces_n for past in self._past if past.time_s >= now.time_s - WAIT_S]
        retardation = self._retardation(now.time_s - WAIT_S, now.time_s)
        if retardation is None or max(forces_n) > self._contact_force_n:
            return None
        return retardation - self._vehicle.resistance_n(now.speed_mps) / now.mass_kg

    def _drags_since(self, fell_s: float, time_s: float) -> bool:
        """Whether the wagon retards more since the fall, although the pads do not press more."""
        before = self._retardation(fell_s - BEFORE_S, fell_s)
        after = self._retardation(fell_s + FALLING_S, time_s)
        if before is None or after is None:
            return False
        forces_before = [past.forces_n for past in self._past if fell_s - BEFORE_S <= past.time_s < fell_s]
        forces_after = [past.forces_n for past in self._past if past.time_s >= fell_s]
        rose = max(forces_after) > sum(forces_before) / len(forces_before) + FORCE_ROSE_N
        return not rose and after - before > DRAG_MPS2

    def _retardation(self, from_s: float, to_s: float) -> float | None:
        span = [past for past in self._past if from_s <= past.time_s <= to_s]
        return mean_retardation_mps2([past.time_s for past in span], [past.speed_mps for past in span])


def _have_all_been_left(wheels: Sequence[WatchedWheelset], speed_mps: float) -> bool:
    """Whether the vehicle's speed has left all of these wheelsets, though it agrees with them by half.

    One of them then turns as nothing can make it turn, and none as it rolled before.
    """
    return any(wheel.is_odd for wheel in wheels) and all(wheel.was_left_by(speed_mps) for wheel in wheels)


def _agree(rolling_mps: float, speed_mps: float) -> bool:
    """Whether the vehicle's speed may be as a wheelset says."""
    return abs(rolling_mps - speed_mps) < SPEED_DIFFERS * max(rolling_mps, speed_mps) + SPEED_DIFFERS_MPS
