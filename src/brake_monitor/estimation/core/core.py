"""What the estimator does with every ordinary sample.

A sample that is not ordinary is left untouched and reported, for the `Estimator` to deal with.
"""

from math import inf, isnan

from brake_monitor.estimation.core.correction import ASIDE, FROZEN, NOT_ORDINARY, TAKEN, Correction
from brake_monitor.estimation.core.prediction import Prediction
from brake_monitor.estimation.doubts.consistency import DEAD, REPEATED
from brake_monitor.estimation.doubts.frozen_reading import HABIT_ABOVE_MPS
from brake_monitor.estimation.estimate import LONGEST_STEP_S, SLOWEST_MPS
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.samples import Quantity

LOADED = 0.05  # relative; a wagon that weighs so much more or less was loaded or unloaded
OTHER_SPEED = 0.5  # of the expected speed: a reading so far from it does not tell which way the wagon runs
LOAD_READINGS = 50  # in the mean that counts as mass: one that flickers would shake the wheel loads
LARGEST_LOAD_RATIO = 8.0  # a wagon's weight over the configured one, or the other way round

# What a channel tells; ELSE is nothing to the filter.
SPEED, PRESSING_FORCE, WHEEL_TORQUE, WSP_ACTIVE, LOAD_FORCE, GRADIENT, ELSE = range(7)
TELLS = {
    Quantity.SPEED: SPEED,
    Quantity.AXLE_SPEED: SPEED,
    Quantity.PRESSING_FORCE: PRESSING_FORCE,
    Quantity.WHEEL_TORQUE: WHEEL_TORQUE,
    Quantity.WSP_ACTIVE: WSP_ACTIVE,
    Quantity.LOAD_FORCE: LOAD_FORCE,
    Quantity.GRADIENT: GRADIENT,
}


class Core(Prediction, Correction):
    """Takes samples one by one."""

    __slots__ = ()

    def take(self, channel: int, time_s: float, value: float) -> int:
        """Take a good sample of a mapped signal; returns what became of it: TAKEN, FUSED, ..."""
        told = self.channels[channel]
        tells, largest = told.tells, told.largest
        if told.lost or not -largest <= value <= largest:
            return NOT_ORDINARY
        if tells == SPEED:
            return self.measure(told.measures, time_s, value, told.variance)
        if not -inf < time_s < inf:
            return NOT_ORDINARY
        if tells == PRESSING_FORCE:
            return self.take_force(told.wheelset, time_s, value if value >= 0.0 else 0.0)
        return self.take_told(channel, time_s, value)

    def take_told(self, channel: int, time_s: float, value: float) -> int:
        """Take what a signal tells beside speeds and pressing forces; ASIDE where that is nothing to the filter."""
        told = self.channels[channel]
        tells, wheelset = told.tells, told.wheelset
        if tells == WSP_ACTIVE:
            self.set_flag(wheelset, value != 0.0)
        elif tells == WHEEL_TORQUE:
            self.wheels[wheelset].torque.sample(time_s, value, LONGEST_STEP_S)
            self.wheels[wheelset].motor_torque_known = True
            self.wheels[wheelset].motor_has_acted |= self.motor_acts(wheelset)
        elif tells == LOAD_FORCE:
            if not self.can_weigh(value):
                return NOT_ORDINARY
            self.take_load(wheelset, value)
        elif tells == GRADIENT:
            self.now.gradient = value
        else:
            return ASIDE
        return TAKEN

    def take_force(self, i: int, time_s: float, pressing_force_n: float) -> int:
        """Take a pressing force, unless it has changed faster than air can move; FROZEN if its sensor is."""
        wheel = self.wheels[i]
        if not wheel.gate.passes(time_s, pressing_force_n, wheel.unsettled == 0.0):
            return NOT_ORDINARY
        self.believe_force(i, time_s, pressing_force_n)
        self.note_force(i, time_s)
        return FROZEN if wheel.checks.dead.is_dead and not self.now.near_standstill else TAKEN

    def believe_force(self, i: int, time_s: float, pressing_force_n: float) -> None:
        """Let a pressing force act from its own time on: the filter need not be predicted to that time before."""
        wheel = self.wheels[i]
        wheel.force.sample(time_s, pressing_force_n, LONGEST_STEP_S)
        if (wheel.axle_speed_lost or wheel.silent) and wheel.gate.has_jumped():
            wheel.end_force_n = pressing_force_n  # the brake has not jumped: v has shown what the rail gives
        if wheel.contact.see(time_s, pressing_force_n):
            self.now.pressed = self.any_pressed()
            self.now.application.ends_at_once = not self.now.pressed and wheel.gate.bears_out

    def note_force(self, i: int, time_s: float) -> None:
        """Check whether the pressing force lives, and with a motor's against the wheelset's slip (`StillForce`)."""
        wheel = self.wheels[i]
        wheel.checks.dead.see(time_s, wheel.force.value)
        if wheel.checks.dead.is_dead:
            self.now.consistency.raised_s[DEAD] = time_s
        braking_n = wheel.force.value
        if self.has_torque_signal:  # slides are the motor's as well
            braking_n += abs(wheel.torque.value) / wheel.brake_radius_m
        self.now.consistency.see_force(time_s, wheel.checks, braking_n, self.slip(i), self.speed_mps())

    def set_flag(self, wheelset: int, acts: bool) -> None:
        """Take what the WSP signal of a wheelset says; where only one is mapped it stands for all wheelsets."""
        if self.wheels[wheelset].wsp_active == acts:
            return
        any_active = False
        for i, wheel in enumerate(self.wheels):
            if self.one_wsp_signal or i == wheelset:
                wheel.wsp_active = acts
            any_active = any_active or wheel.wsp_active
        self.now.wsp_active = any_active

    def can_weigh(self, load_n: float) -> bool:
        """Whether as much may rest where a load is measured: a broken sensor says zero or full scale."""
        share_n = self.now.configured_kg * GRAVITY_MPS2 / len(self.load_n)
        return share_n / LARGEST_LOAD_RATIO <= load_n <= share_n * LARGEST_LOAD_RATIO

    def take_load(self, signal: int, load_n: float) -> None:
        """Take a load signal; mass is known once all have told."""
        now = self.now
        self.load_n[signal] = load_n
        total_n = 0.0
        for own_n in self.load_n:
            total_n += own_n
        mass_kg = total_n / GRAVITY_MPS2
        if isnan(mass_kg):
            return
        is_same = abs(mass_kg - now.mass_kg) <= LOADED * now.mass_kg
        now.weighed = min(now.weighed, LOAD_READINGS - 1) + 1 if is_same else 1
        now.mass_kg += (mass_kg - now.mass_kg) / now.weighed

    def measure(self, index: int, time_s: float, value: float, variance: float) -> int:
        """Predict to the time of a reading of the measured state `index`, and fuse it."""
        now = self.now
        step_s = time_s - now.time_s
        if not 0.0 <= step_s <= LONGEST_STEP_S or self.readings[index].fused_s == -inf:
            return NOT_ORDINARY
        if step_s > 0.0 and self.begins_application(time_s):
            return NOT_ORDINARY
        if self.see_repeats(index, time_s, value):
            return FROZEN
        if self.awaits_tooth(index, time_s, abs(value)):
            return TAKEN
        if step_s > 0.0:
            self.take_inputs(time_s, step_s)
            self.predict(step_s)
        if value < 0.0 or now.heading < 0.0:
            self.see_heading(index, value)
        return self.fuse(index, abs(value), variance)  # a reversing wagon brakes by the same equations

    def see_heading(self, index: int, value: float) -> None:
        """Follow which way the wagon runs by a speed that has a sign, unless that stands or is a spike."""
        now, expected = self.now, self.filter.x[index]
        if now.near_standstill or abs(abs(value) - expected) > OTHER_SPEED * expected:
            return
        if value < 0.0:
            now.heading, now.heading_told_by = -1.0, index
        elif index == now.heading_told_by:
            now.heading = 1.0

    def see_repeats(self, index: int, time_s: float, value: float) -> bool:
        """Take a reading of a speed; whether it is frozen: it repeats itself while its reference moves on.

        The reference of a wheelset is the vehicle's speed, that of the vehicle the fastest wheelset. Either may come
        first after a start or a gap: nothing counts as frozen until its reference is known.
        """
        x, n, metres = self.filter.x, self.wheelset_count, 1.0
        if index < n:
            metres = self.wheels[index].radius.radius_m
            reference = x[n] / metres
            is_known = self.readings[n].fused_s > -inf
        else:
            reference = self.fastest_mps()
            is_known = self.any_wheel_speed_is_known()
        is_known = is_known and time_s - self.now.time_s <= LONGEST_STEP_S  # else the filter starts anew
        frozen = self.readings[index].frozen
        is_frozen = frozen.see(time_s, value, reference, is_known, index == n and reference > HABIT_ABOVE_MPS)
        if index < n and value == 0.0:  # locked: it stands still, rightly
            return False
        self.see_still_speeds(time_s, frozen.repeats, frozen.turns)
        moves = metres * max(reference, abs(value)) > SLOWEST_MPS  # at a standstill both are frozen, rightly
        return is_frozen and moves

    def see_still_speeds(self, time_s: float, repeats: bool, turns: bool) -> None:
        """Doubt speeds that all stand still; of a reading: whether it repeats the one before, or turns back."""
        now, speeds = self.now, self.now.consistency.speeds
        if now.near_standstill or time_s - now.time_s > LONGEST_STEP_S:  # what they did in a gap is not known
            speeds.begin(time_s)
        elif repeats:
            if speeds.are_dead(time_s):
                now.consistency.raised_s[REPEATED] = time_s
        else:
            speeds.moved_s = time_s
            if turns:
                speeds.see_turn(time_s, max(now.pressed_s, now.started_s))
