"""Whether each wheelset rolls, slides or stands, and whether a reading of standstill is to be believed.

A wheelset that is stopped while the wagon moves is the gravest thing there is to see, and a wheel-speed sensor that
has died reads the same. A motor that brakes counts as the pads that could do the same. What tells them apart:

- **How it came to stop.** Brake torque takes some tenths of a second to stop a wheelset, at most mu_b F r_B / J; a
  sensor falls from one reading to the next, also with no pad pressing.
- **What follows.** A stopped wheelset drags: the wagon retards more than its pressing forces explain.
- **What all say.** If no wheelset turns, and none was seen to be stopped, it is the vehicle's speed that is wrong.
"""

from collections import deque
from collections.abc import Callable, Sequence
from enum import StrEnum
from math import inf
from typing import TypeVar

from brake_monitor.estimation.estimate import Estimate, WheelsetEstimate
from brake_monitor.estimation.slide_protection import SlideProtection
from brake_monitor.frame_block import Floats
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Vehicle

Place = tuple[Quantity, int]  # wheelsets from 0

TURNS = 0.5  # circumferential over vehicle speed: from here on a wheelset turns beyond doubt
STANDS = 0.1  # below it does not; noise and a creeping wheel stay below
TURNS_AGAIN = 0.2
WATCHED_FROM_MPS = 1.39  # 5 km/h, below it speed sensors cut out
STANDSTILL_MPS = 0.5
LARGEST_FRICTION = 0.6  # no pad has more
FORCE_DOUBT = 1.5  # of the torque that stopped it: calibration of the force, lag, inertia
SHORTEST_FALL_S = 0.05  # frames may be bunched, so a fall is not taken for quicker
CAUSE_S = 1.5  # a brake that pressed so long ago may have stopped it
LEAST_ADHESION = 0.01  # the brake torque must overcome at least as much
WAIT_S = 1.3  # so long its drag is waited for ...
SOONER_S = 0.2  # the vehicle's speed is doubted before all its wheelsets are said to stand
FALLING_S = 0.3  # ... of which the fall itself says nothing
BEFORE_S = 2.0
PAST_S = BEFORE_S + WAIT_S + 1.0
DRAG_MPS2 = 0.15  # rise of the retardation at the fall
UNCOMPARED_DRAG_MPS2 = 0.3  # retardation without brakes where nothing is known of before: a gradient of 30 ‰ is rare
FORCE_ROSE_N = 4000.0  # then the retardation may be the brakes'
ALL_STOPPED_MPS2 = 0.1  # no wheelset turns and yet the wagon hardly slows down: its speed is wrong
SPEED_JUMP_MPS = 1.5  # between two readings, beyond what any wagon loses or gains meanwhile
SPEED_DIFFERS = 0.2
SPEED_DIFFERS_MPS = 1.5  # wheel-speed sensors cut out as late
SPEED_DOUBT_S = 0.5
SPEED_AGREES = 0.05  # one that was not believed is believed again when it agrees as well with a wheelset ...
SPEED_AGREES_S = 3.0  # ... for so long, at a speed where that says something
ODD_SLIP = 0.2  # no wheelset turns as much faster than it rolls without a motor, nor slower without a brake
ODD_S = 2.0
ODD_FROM_MPS = 4.0
SLIDING_SLIP = 0.05
UNSEEN_SLIP = 0.12  # of a wheelset that was never seen to roll: below it its radius may be wrong
SLIDING_MPS = 0.5  # below it a speed sensor that lags looks the same
SLIDES_IN_A_ROW = 3  # observations; noise alone does not slide as long
FASTEST_WAGON_MPS2 = 2.0  # no wagon retards as much; a wheelset that begins to slide slows down far quicker
FALL_SPAN_S = 0.3
SHORTEST_FALL_SPAN_S = 0.5 * FALL_SPAN_S
FALL_BEFORE_S = 1.0  # before its slip shows
FAR_MPS = 2.5  # more than a vehicle speed that lags by 1.5 s makes up
ROLLING_SLIP = 0.03
RELEASED_S = 3.0  # after the last braking or driving a wheelset may still slide or spin for so long


class WheelState(StrEnum):
    """What a wheelset does."""

    ROLLING = "rolling"
    SLIDING = "sliding"  # the brake asks for more than the rail gives
    PROTECTED = "protected"  # so it does time and again, and a wheel-slide protection keeps it from sliding far
    STOPPED = "stopped"  # does not rotate, and is believed
    DOUBTFUL = "doubtful"  # does not seem to rotate; what it is cannot be told yet
    CONTRADICTED = "contradicted"  # its sensor says standstill, and is not believed
    UNKNOWN = "unknown"  # not measured


ROLLING, UNKNOWN = WheelState.ROLLING, WheelState.UNKNOWN


class Origin(StrEnum):
    """How a wheelset came to stand."""

    UNSEEN = "unseen"  # it stood when the recording began
    STOOD = "stood"  # it has not turned since the wagon stood
    STOPPED = "stopped"  # as a brake stops it
    DROPPED = "dropped"  # as nothing but a sensor falls


class WheelWatch:
    """Sees the raw speeds and pressing forces, and the wagon at each observation."""

    def __init__(self, vehicle: Vehicle, contact_force_n: float) -> None:
        self.speed = speed = VehicleSpeed()
        self.wheels = [Wheel(vehicle, i, contact_force_n, speed) for i in range(vehicle.wheelset_count)]
        # Who is to see the good samples of a place, and who is to know that one is not good.
        self.watchers: dict[Place, Callable[[float, float], None]] = {(Quantity.SPEED, 0): speed.see}
        self.missers: dict[Place, Callable[[float], None]] = {}
        for i, wheel in enumerate(self.wheels):
            self.watchers[Quantity.AXLE_SPEED, i] = wheel.see_speed
            self.watchers[Quantity.PRESSING_FORCE, i] = wheel.see_force
            self.watchers[Quantity.WHEEL_TORQUE, i] = wheel.see_torque
            self.missers[Quantity.WHEEL_TORQUE, i] = wheel.miss_torque
        self._vehicle = vehicle
        self._contact_force_n = contact_force_n
        self._doubt_since_s = self._agrees_since_s = inf
        self._past: deque[tuple[float, float, float]] = deque()  # (time, speed, sum of braking forces)
        self._demanded_s = -inf
        self.speed_is_contradicted = False

    def judge(self, now: Estimate, measured: Sequence[bool]) -> tuple[WheelState, ...]:
        """What each wheelset does; `measured`: whether its own speed and the vehicle's are good."""
        self._note(now)
        self._judge_speed(now, measured)
        if self.speed_is_contradicted or self._doubt_since_s < inf:
            return (UNKNOWN,) * len(self.wheels)
        demanded = now.time_s - self._demanded_s < RELEASED_S
        states = []
        for i, wheel in enumerate(self.wheels):
            if not measured[i]:
                states.append(UNKNOWN)
            elif wheel.stands_since_s < inf:
                states.append(self._judge_standing(wheel, now))
            else:
                states.append(wheel.judge_turning(now, now.wheelsets[i], demanded))
        return tuple(states)

    def _note(self, now: Estimate) -> None:
        time_s, past = now.time_s, self._past
        pairs = zip(now.wheelsets, self.wheels, strict=True)
        forces_n = [wheelset.pressing_force_n + wheel.motor_force_n for wheelset, wheel in pairs]
        past.append((time_s, now.speed_mps, sum(forces_n)))
        while time_s - past[0][0] > PAST_S or past[0][0] > time_s:
            past.popleft()
        pressed = max(forces_n) > self._contact_force_n
        if pressed or any(wheelset.wsp_active for wheelset in now.wheelsets):
            self._demanded_s = time_s
        elif self._demanded_s > time_s:
            self._demanded_s = -inf

    def _judge_speed(self, now: Estimate, measured: Sequence[bool]) -> None:
        """Whether the vehicle's speed stands alone against its wheelsets."""
        speed_mps = self.speed.mps or 0.0
        rolling = [wheel.rolling_mps for wheel, good in zip(self.wheels, measured, strict=True) if good]
        if self.speed_is_contradicted:
            self._believe_speed_again(now.time_s, speed_mps, rolling)
            return
        if not rolling or any(_agree(own_mps, speed_mps) for own_mps in rolling):
            self.speed.jumped, self._doubt_since_s = False, inf
            return
        wheels = [wheel for wheel, good in zip(self.wheels, measured, strict=True) if good]
        rolling.sort()
        together = rolling[-1] - rolling[0] < SPEED_DIFFERS * rolling[-1] + SPEED_DIFFERS_MPS
        alone = together and (self.speed.jumped or (len(wheels) > 1 and all(wheel.is_odd for wheel in wheels)))
        if all(wheel.stands_since_s < inf for wheel in wheels) and speed_mps > WATCHED_FROM_MPS:
            origins = {wheel.origin for wheel in wheels}
            slows = (self._retardation(now.time_s - WAIT_S, now.time_s) or 0.0) > ALL_STOPPED_MPS2
            pressed = all(wheel.could_be_held for wheel in wheels)
            waited = now.time_s - max(wheel.stands_since_s for wheel in wheels) >= WAIT_S - SOONER_S
            alone |= origins == {Origin.STOOD}
            alone |= waited and origins <= {Origin.UNSEEN, Origin.STOOD} and not (slows and pressed)
        self._doubt_since_s = min(self._doubt_since_s, now.time_s) if alone else inf
        self.speed_is_contradicted |= now.time_s - self._doubt_since_s >= SPEED_DOUBT_S

    def _believe_speed_again(self, time_s: float, speed_mps: float, rolling: list[float]) -> None:
        agrees = any(abs(own - speed_mps) < SPEED_AGREES * own for own in rolling if own > WATCHED_FROM_MPS)
        self._agrees_since_s = min(self._agrees_since_s, time_s) if agrees else inf
        if time_s - self._agrees_since_s >= SPEED_AGREES_S:
            self.speed_is_contradicted, self.speed.jumped, self._doubt_since_s = False, False, inf

    def _judge_standing(self, wheel: "Wheel", now: Estimate) -> WheelState:
        """Decide once; what is decided holds until the wheelset turns again."""
        if now.speed_mps <= WATCHED_FROM_MPS and wheel.decided is not WheelState.CONTRADICTED:
            return WheelState.DOUBTFUL
        if wheel.decided is not None:
            return wheel.decided
        if wheel.origin is Origin.STOPPED:
            wheel.decided = WheelState.STOPPED
        elif now.time_s - wheel.stands_since_s < WAIT_S:
            return WheelState.DOUBTFUL
        elif wheel.origin in {Origin.UNSEEN, Origin.STOOD}:
            held = wheel.could_be_held or self._drags_unbraked(now)
            wheel.decided = WheelState.STOPPED if held else WheelState.CONTRADICTED
        else:
            drags = self._drags_since(wheel.stands_since_s, now.time_s) or self._drags_unbraked(now)
            wheel.decided = WheelState.STOPPED if drags else WheelState.CONTRADICTED
        return wheel.decided

    def _drags_unbraked(self, now: Estimate) -> bool:
        """Whether the wagon retards with no pad pressing, beyond what the track takes."""
        span = [past for past in self._past if past[0] >= now.time_s - WAIT_S]
        retardation = self._retardation(now.time_s - WAIT_S, now.time_s)
        if retardation is None or max(force_n for _, _, force_n in span) > self._contact_force_n:
            return False
        v = self._vehicle
        expected = (v.track_resistance_n + v.drag_n_per_mps2 * now.speed_mps**2) / now.mass_kg
        return retardation - expected > UNCOMPARED_DRAG_MPS2

    def _drags_since(self, fell_s: float, time_s: float) -> bool:
        """Whether the wagon retards more since the fall, although the pads do not press more."""
        before = self._retardation(fell_s - BEFORE_S, fell_s)
        after = self._retardation(fell_s + FALLING_S, time_s)
        if before is None or after is None:
            return False
        forces_before = [force_n for at_s, _, force_n in self._past if fell_s - BEFORE_S <= at_s < fell_s]
        forces_after = [force_n for at_s, _, force_n in self._past if at_s >= fell_s]
        rose = max(forces_after) > sum(forces_before) / len(forces_before) + FORCE_ROSE_N
        return not rose and after - before > DRAG_MPS2

    def _retardation(self, from_s: float, to_s: float) -> float | None:
        """Mean retardation in m/s², by least squares; None with too little to tell."""
        span = [(at_s - from_s, speed_mps) for at_s, speed_mps, _ in self._past if from_s <= at_s <= to_s]
        if len(span) < 8:  # 0.8 s
            return None
        mean_s = sum(t for t, _ in span) / len(span)
        mean_mps = sum(v for _, v in span) / len(span)
        spread = sum((t - mean_s) ** 2 for t, _ in span)
        return -sum((t - mean_s) * (v - mean_mps) for t, v in span) / spread if spread else None


def _agree(rolling_mps: float, speed_mps: float) -> bool:
    """Whether the vehicle's speed may be as a wheelset says."""
    return abs(rolling_mps - speed_mps) < SPEED_DIFFERS * max(rolling_mps, speed_mps) + SPEED_DIFFERS_MPS


# Of one reading, or of many in an array.
Number = TypeVar("Number", float, Floats)


def most_without_jump_mps(step_s: Number) -> Number:
    """By how much the vehicle's speed can change from one reading to the next."""
    return SPEED_JUMP_MPS + FASTEST_WAGON_MPS2 * step_s


class VehicleSpeed:
    """The vehicle's speed as it is read."""

    def __init__(self) -> None:
        self.mps: float | None = None
        self.time_s = -inf
        self.jumped = False

    def see(self, time_s: float, value: float) -> None:
        """Take a good reading."""
        speed_mps = abs(value)
        if self.mps is not None:
            self.jumped |= abs(speed_mps - self.mps) > most_without_jump_mps(max(time_s - self.time_s, 0.0))
        self.time_s, self.mps = time_s, speed_mps

    def go_on(self, time_s: float, speed_mps: float, *, jumped: bool) -> None:
        """Take several readings together: the last of them, and whether there is a jump among them."""
        self.jumped |= jumped
        self.time_s, self.mps = time_s, speed_mps


class Wheel:
    """One wheelset's readings: whether it turns, and how it last came to stop."""

    def __init__(self, vehicle: Vehicle, i: int, contact_force_n: float, vehicle_speed: VehicleSpeed) -> None:
        self._vehicle_speed = vehicle_speed
        self.radius_m = vehicle.wheel_radius_m[i]
        self._stop_radps2_per_n = (
            FORCE_DOUBT * LARGEST_FRICTION * vehicle.brake_radius_m[i] / vehicle.wheelset_inertia_kgm2[i]
        )
        load_n = vehicle.mass_kg * 9.81 / vehicle.wheelset_count
        holding_n = LEAST_ADHESION * load_n * self.radius_m / (LARGEST_FRICTION * vehicle.brake_radius_m[i])
        self._holding_n = max(holding_n, contact_force_n)
        self._force_per_nm = 1.0 / (LARGEST_FRICTION * vehicle.brake_radius_m[i])
        self._forces: deque[tuple[float, float]] = deque()  # (time, what pads and motor together press like)
        self.pressing_force_n = 0.0
        self.motor_force_n = 0.0  # with which pads would brake at the least as the motor does
        self._driven_s = -inf
        self._turned: tuple[float, float] | None = None  # (time, rad/s) of the last reading that turns beyond doubt
        self._has_rolled = False
        self._slides = 0  # observations in a row
        self._protection = SlideProtection()
        self.speeds: deque[tuple[float, float]] = deque()  # (time, circumferential speed) of the last FALL_SPAN_S
        self.fell_s = -inf  # when it last slowed down as no rolling wheelset does
        self._rolled_s = -inf
        self._odd_since_s = inf
        self.is_odd = False
        self._wagon_stood = False
        self.rolling_mps = 0.0
        self.stands_since_s = inf
        self.origin = Origin.UNSEEN
        self.decided: WheelState | None = None

    @property
    def could_be_held(self) -> bool:
        """Whether its brake presses enough to hold it on a rail that gives hardly anything."""
        return self.pressing_force_n + self.motor_force_n >= self._holding_n

    @property
    def force_noted_s(self) -> float:
        """When it last remembered one."""
        return self._forces[-1][0] if self._forces else -inf

    def see_force(self, time_s: float, pressing_force_n: float) -> None:
        """Take a good reading."""
        self.pressing_force_n = pressing_force_n
        self._note_force(time_s)

    def miss_torque(self, time_s: float) -> None:
        """One that is not known any more is none."""
        self.see_torque(time_s, 0.0)

    def see_torque(self, time_s: float, accelerating_nm: float) -> None:
        """Take a good reading."""
        self.motor_force_n = self._force_per_nm * max(-accelerating_nm, 0.0)
        if self._force_per_nm * accelerating_nm >= self._holding_n:
            self._driven_s = time_s
        self._note_force(time_s)

    def _note_force(self, time_s: float) -> None:
        self._forces.append((time_s, self.pressing_force_n + self.motor_force_n))
        self._forget_forces(time_s)

    def _forget_forces(self, time_s: float) -> None:
        forces = self._forces
        while time_s - forces[0][0] > CAUSE_S or forces[0][0] > time_s:
            forces.popleft()

    def see_speed(self, time_s: float, value: float) -> None:
        """Take a good reading, beside the vehicle's speed that was read last."""
        speed_mps = self._vehicle_speed.mps
        if speed_mps is None:
            return
        omega_radps = abs(value)
        self.rolling_mps = rolling_mps = omega_radps * self.radius_m
        self._note_fall(time_s, rolling_mps)
        if speed_mps < STANDSTILL_MPS:
            self._stand()
            return
        if rolling_mps > TURNS_AGAIN * speed_mps:
            self.stands_since_s, self.decided = inf, None
        if rolling_mps > TURNS * speed_mps:
            self._turned, self._wagon_stood = (time_s, omega_radps), False
        elif rolling_mps < STANDS * speed_mps and speed_mps > WATCHED_FROM_MPS and self.stands_since_s == inf:
            self.stands_since_s = time_s
            self.origin = self._how(time_s, omega_radps)

    def turn_on(self, time_s: float, omega_radps: float, rolling_mps: float) -> None:
        """Take several speeds together at which it turns beyond doubt, of which this is the last."""
        self.rolling_mps, self._turned = rolling_mps, (time_s, omega_radps)
        self._wagon_stood, self.stands_since_s, self.decided = False, inf, None

    def stand_on(self, rolling_mps: float) -> None:
        """Take several speeds together while the wagon stands, of which this is the last."""
        self.rolling_mps = rolling_mps
        self._stand()

    def remember_speeds(self, times_s: Sequence[float], rolling_mps: Sequence[float]) -> None:
        """Remember several that were taken together."""
        if len(times_s) > 2 and times_s[-1] - times_s[1] >= FALL_SPAN_S:  # nothing before them counts any more
            self.speeds.clear()
        self.speeds.extend(zip(times_s, rolling_mps, strict=True))
        self._forget_speeds(times_s[-1])

    def remember_forces(self, times_s: Sequence[float], pressing_forces_n: Sequence[float]) -> None:
        """Remember several, taken together while the motor did nothing new."""
        motor_force_n = self.motor_force_n
        if times_s[-1] - times_s[0] > CAUSE_S:  # nothing before them counts any more
            self._forces.clear()
        self._forces.extend(
            [(time_s, force_n + motor_force_n) for time_s, force_n in zip(times_s, pressing_forces_n, strict=True)]
        )
        self._forget_forces(times_s[-1])

    def judge_turning(self, now: Estimate, own: WheelsetEstimate, demanded: bool) -> WheelState:
        """Of a wheelset that turns."""
        slip, speed_mps = own.slip, now.speed_mps
        self._judge_oddness(now.time_s, speed_mps, demanded=demanded)
        if self.is_odd:
            return WheelState.CONTRADICTED
        if abs(slip) < ROLLING_SLIP and speed_mps > WATCHED_FROM_MPS:
            self._has_rolled, self._rolled_s = True, now.time_s
        needed = ROLLING_SLIP if own.wsp_active else SLIDING_SLIP if self._has_rolled else UNSEEN_SLIP
        slides = demanded and slip > needed and slip * speed_mps > SLIDING_MPS and self._may_slide(slip * speed_mps)
        self._slides = self._slides + 1 if slides else 0
        acts = self._protection.see(now.time_s, slip, speed_mps, own.pressing_force_n, flagged=own.wsp_active)
        acts &= self._has_rolled
        if self._slides >= SLIDES_IN_A_ROW:
            return WheelState.SLIDING
        return WheelState.PROTECTED if demanded and acts else ROLLING

    def _stand(self) -> None:
        self._wagon_stood = True
        if self.decided is None:
            self.stands_since_s = inf

    def _may_slide(self, slip_mps: float) -> bool:
        """Whether it is not the vehicle's speed that lags behind its wheelsets', which all slow down as it does."""
        return not self._has_rolled or slip_mps > FAR_MPS or self.fell_s > self._rolled_s - FALL_BEFORE_S

    def _note_fall(self, time_s: float, rolling_mps: float) -> None:
        self.speeds.append((time_s, rolling_mps))
        self._forget_speeds(time_s)
        from_s, from_mps = self.speeds[0]
        span_s = time_s - from_s
        if from_mps - rolling_mps > FASTEST_WAGON_MPS2 * span_s and span_s >= SHORTEST_FALL_SPAN_S:
            self.fell_s = time_s

    def _forget_speeds(self, time_s: float) -> None:
        speeds = self.speeds
        while len(speeds) > 2 and not 0.0 <= time_s - speeds[1][0] < FALL_SPAN_S:
            speeds.popleft()

    def _judge_oddness(self, time_s: float, speed_mps: float, *, demanded: bool) -> None:
        """Whether its readings say that it turns as nothing can make it turn; once it is said, until it rolls."""
        slip = 1.0 - self.rolling_mps / max(speed_mps, WATCHED_FROM_MPS)
        if abs(slip) < UNSEEN_SLIP:
            self.is_odd = False
        driven = 0.0 <= time_s - self._driven_s < RELEASED_S
        odd = (slip < -ODD_SLIP and not driven) or (slip > ODD_SLIP and not demanded)
        self._odd_since_s = min(self._odd_since_s, time_s) if odd and speed_mps > ODD_FROM_MPS else inf
        self.is_odd |= time_s - self._odd_since_s >= ODD_S

    def _how(self, time_s: float, omega_radps: float) -> Origin:
        if self._wagon_stood:
            return Origin.STOOD
        if self._turned is None:
            return Origin.UNSEEN
        turned_s, turned_radps = self._turned
        fall_radps2 = (turned_radps - omega_radps) / max(time_s - turned_s, SHORTEST_FALL_S)
        force_n = max((force for _, force in self._forces), default=0.0)
        possible = fall_radps2 <= self._stop_radps2_per_n * force_n and force_n >= self._holding_n
        return Origin.STOPPED if possible else Origin.DROPPED
