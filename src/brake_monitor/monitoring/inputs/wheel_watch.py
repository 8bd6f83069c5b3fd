"""Whether each wheelset rolls, slides or stands, and whether a reading of standstill is to be believed.

What tells a wheelset that is stopped while the wagon moves from a wheel-speed sensor that has died:

- **How it came to stop**, see `WatchedWheelset`.
- **What follows.** A stopped wheelset drags: the wagon retards more than its pressing forces explain.
- **What all say.** If no wheelset turns, and none was seen to be stopped, it is the vehicle's speed that is wrong
  (`SpeedDoubt`). If all fell together at a crawl, their sensors have cut out, as many do below some km/h.
"""

from collections.abc import Callable, Sequence
from math import inf

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.inputs.speed_doubt import SpeedDoubt
from brake_monitor.monitoring.inputs.turning import RELEASED_S, ROLLING_SLIP, WATCHED_FROM_MPS
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.wagon_past import DRAG_MPS2, WAIT_S, WagonPast
from brake_monitor.monitoring.inputs.watched_wheelset import CUTS_OUT_BELOW_MPS, NOT_TURNED, Origin, WatchedWheelset
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.passing_time import LastTime
from brake_monitor.samples import Measurand, Quantity
from brake_monitor.settings.config import Vehicle

TOGETHER_S = 1.0  # sensors of one kind cut out at about one speed, and the wheelsets of a wagon roll alike
UNCOMPARED_DRAG_MPS2 = 0.3  # retardation without brakes where nothing is known of before: a gradient of 30 ‰ is rare
LATE_DRAG_S = 8.0  # so long, of one that was not believed to stand: longer than a shove, or a train's pull that ends


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
        self._past = WagonPast(vehicle, contact_force_n)
        self._doubt = SpeedDoubt(speed, self._past, vehicle.wheelset_count)
        self._contact_force_n = contact_force_n
        self._pressed = LastTime()  # any brake did
        self._demanded = LastTime()  # ... or slide protection acted

    def judge(self, now: Estimate, measured: Sequence[bool]) -> tuple[WheelState, ...]:
        """What each wheelset does; `measured`: whether its own speed and the vehicle's are good."""
        self._note(now)
        told = [wheel for wheel, is_good in zip(self.wheels, measured, strict=True) if is_good]
        self._doubt.see(now.time_s, told, is_free=self._rolls_freely(now))
        is_doubted = self._doubt.is_doubted
        demanded = now.time_s - self._demanded.time_s < RELEASED_S
        alike = _slip_alike([own.slip for own, is_good in zip(now.wheelsets, measured, strict=True) if is_good])
        cut_out = _have_cut_out(now, told)
        states = []
        for i, wheel in enumerate(self.wheels):
            if is_doubted or not measured[i]:
                wheel.drags_since_s = inf
                states.append(WheelState.UNKNOWN)
            elif cut_out:
                states.append(WheelState.DOUBTFUL)
            elif wheel.stands_since_s < inf:
                states.append(self._judge_standing(wheel, now))
            else:
                turning, own = wheel.turning, now.wheelsets[i]
                states.append(turning.judge(now, own, wheel.rolling_mps, demanded=demanded, all_slip_alike=alike))
        return tuple(states)

    @property
    def speed_is_contradicted(self) -> bool:
        """Whether the vehicle's speed is not to be believed beside its wheelsets'."""
        return self._doubt.is_contradicted

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
        time_s, wheels = now.time_s, self.wheels
        for wheel in wheels:
            wheel.note(now)
        forces_n = [now.wheelsets[i].pressing_force_n + wheel.holding.motor_force_n for i, wheel in enumerate(wheels)]
        self._past.note(now, sum(forces_n))
        pressed = max(forces_n) > self._contact_force_n
        self._pressed.see(time_s, pressed)
        self._demanded.see(time_s, pressed or now.protection_acts)

    def _rolls_freely(self, now: Estimate) -> bool:
        """Whether neither brake nor motor has acted on any wheelset for a while."""
        acted_s = max(self._demanded.time_s, *(wheel.holding.driven_s for wheel in self.wheels))
        return now.time_s - acted_s >= RELEASED_S

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
        wheel.may_drag, wheel.drags_since_s = False, inf
        if wheel.origin is Origin.STOPPED:
            wheel.decided = WheelState.STOPPED
        elif now.time_s - wheel.stands_since_s < WAIT_S:
            return WheelState.DOUBTFUL
        else:
            not_turned = wheel.origin in NOT_TURNED
            stands = wheel.holding.suffices if not_turned else self._past.drags_since(wheel.stands_since_s, now.time_s)
            drags = (self._past.unbraked_mps2(now) or 0.0) > UNCOMPARED_DRAG_MPS2
            wheel.decided = WheelState.STOPPED if stands or drags else WheelState.CONTRADICTED
        return wheel.decided

    def _is_released(self, wheel: WatchedWheelset, now: Estimate) -> bool:
        """Whether all brakes say that they are, and have for longer than the rail needs to turn the wheelset again."""
        released_s = now.time_s - max(self._pressed.time_s, wheel.stands_since_s)
        is_told = now.time_s - wheel.holding.told_s < RELEASED_S
        return is_told and released_s > RELEASED_S + wheel.turns_within_s(now.speed_mps)

    def _see_drag(self, wheel: WatchedWheelset, now: Estimate) -> None:
        """See, of one that is not believed to stand, whether the wagon retards without its brakes as if it did.

        One that has not turned yet was judged as the wagon was pulled. It is believed later, when it drags for long.
        """
        unbraked_mps2 = self._past.unbraked_mps2(now)
        if unbraked_mps2 is None or now.speed_mps <= WATCHED_FROM_MPS:
            wheel.drags_since_s = inf
            return
        wheel.may_drag = unbraked_mps2 > DRAG_MPS2
        wheel.drags_since_s = min(wheel.drags_since_s, now.time_s) if unbraked_mps2 > UNCOMPARED_DRAG_MPS2 else inf
        drags_for_long = now.time_s - wheel.drags_since_s >= LATE_DRAG_S
        if drags_for_long and wheel.origin in NOT_TURNED and not self._is_in_train:
            wheel.decided = WheelState.STOPPED


def _slip_alike(slips: Sequence[float]) -> bool:
    """Whether all slip, and no two so differently that it cannot be a vehicle speed that comes late."""
    return not slips or (min(map(abs, slips)) >= ROLLING_SLIP and max(slips) - min(slips) < SLIDING_SLIP)


def _have_cut_out(now: Estimate, told: Sequence[WatchedWheelset]) -> bool:
    """Whether the sensors have cut out in a stop; of that one that falls first is not believed before the next."""
    if now.speed_mps > CUTS_OUT_BELOW_MPS:
        return False
    fell_s = [wheel.stands_since_s for wheel in told if wheel.fell_at_a_crawl]
    if not fell_s or max(fell_s) - min(fell_s) > TOGETHER_S:
        return False
    return len(fell_s) == len(told) or now.time_s - min(fell_s) < TOGETHER_S
