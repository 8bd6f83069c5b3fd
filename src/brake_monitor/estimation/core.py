"""What the estimator does with every ordinary sample, on numbers that stay in their places.

`Core` and what it consists of hold nothing but numbers, vectors of them, and objects of such: the same methods run as
they stand, sample by sample, and compiled, over thousands of samples at once (`compiled_core`). Whatever is not
ordinary they leave untouched and say so: then the `Estimator` looks at it at leisure.
"""

from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass
from math import inf, isnan, sqrt
from typing import Any

from brake_monitor.estimation.brake_work import CRAWLING_MPS, SLIDING_SLIP
from brake_monitor.estimation.estimate import SLOWEST_MPS, slip_of
from brake_monitor.estimation.moment import Now, Readings, Told, Wheel
from brake_monitor.estimation.slide_protection import PERIOD_S
from brake_monitor.estimation.wagon import GRAVITY_MPS2
from brake_monitor.samples import Quantity

LONGEST_STEP_S = 1.0  # a longer gap between readings says nothing of what happened in it
UNSETTLED_S = 2.0  # after a slide
SPACING_SHARE = 0.05  # of the newest reading in the mean spacing of a wheelset's
QUICK_SLIP = 0.01  # from here on adhesion may change within hundredths of a second
LOCKED_FRACTION = 0.03  # circumferential over vehicle speed of a wheelset that does not turn
LEAST_JUMP_S = 0.01  # wheel speeds in frames that a gateway bunches are not as close as their times
UNKNOWN_TORQUE_DENSITY = 40.0  # (rad/s)²/s, for a wheelset whose equation cannot be used
SURPRISE_NIS = 10.0  # beyond about three sigma of a wheel speed its adhesion is taken to have jumped
OUTLIER_SIGMA = 6.0
OUTLIERS_BELIEVED = 3  # as many in a row are no outliers but the truth
BELIEFS_EXPLAINED = 3  # outliers that are believed as often in a row tell of a prediction that is wrong
DOUBTED_ADHESION_STD = 0.05
FASTEST_WHEEL_RADPS2 = 80.0  # brake torque or re-adhesion over inertia; a faster change is a bad reading
FASTEST_WAGON_MPS2 = 3.0  # beyond the model's own prediction
LARGEST_FRICTION = 0.6  # no pad has more: a force that acts is not measured
ROLLING_AGAIN_S = 3.0  # after the last contact of any pad, every wheelset has found back to rolling
PAUSE_S = 1.0  # without any contact for longer, the next contact is a new brake application
LOADED = 0.05  # relative; who weighs so much more or less was loaded or unloaded
LOAD_READINGS = 50  # whose mean counts: a mass that flickers shakes the wheel loads, see `load_transfer`
LARGEST_LOAD_RATIO = 8.0  # a wagon's weight over the configured one, or the other way round

# What a channel tells.
SPEED, AXLE_SPEED, PRESSING_FORCE, WHEEL_TORQUE, WSP_ACTIVE, LOAD_FORCE, GRADIENT, ELSE = range(8)
TELLS = {
    Quantity.SPEED: SPEED,
    Quantity.AXLE_SPEED: AXLE_SPEED,
    Quantity.PRESSING_FORCE: PRESSING_FORCE,
    Quantity.WHEEL_TORQUE: WHEEL_TORQUE,
    Quantity.WSP_ACTIVE: WSP_ACTIVE,
    Quantity.LOAD_FORCE: LOAD_FORCE,
    Quantity.GRADIENT: GRADIENT,
}

# What became of a sample.
TAKEN, FUSED, ASIDE, FROZEN, CONTRADICTED, UNSOUND, NOT_ORDINARY = range(7)


@dataclass
class Densities:
    """Spectral densities of the process noise that depend on what a wheelset or the wagon does, as in `Tuning`."""

    omega: float
    adhesion_own: float
    adhesion_sliding: float
    deceleration: float
    deceleration_braking: float
    deceleration_doubted: float
    friction_doubted: float


@dataclass(slots=True)
class Core:
    """The estimator's numbers, and the steps that it takes with them."""

    now: Now
    wheelset_count: int  # N
    wheels: Sequence[Wheel]  # N
    readings: Sequence[Readings]  # N + 1: of the wheelsets' speeds and the vehicle's
    channels: Sequence[Told]  # one for each mapped signal
    load_n: MutableSequence[float]  # what each load signal says; NaN before it has said anything
    densities: Densities
    largest_deceleration_mps2: float
    converged_adhesion_std: float  # below them estimates are `valid`
    converged_friction_std: float
    one_wsp_signal: bool  # it tells of all wheelsets
    tells_torque: bool  # any signal does
    literal: bool  # the covariances of (20)
    filter: Any  # a BrakeFilter, or its numbers

    # -- samples in --------------------------------------------------------------------------------------------

    def take(self, channel: int, time_s: float, value: float) -> int:
        """Take a good sample of a mapped signal; what became of it."""
        told = self.channels[channel]
        tells, largest = told.tells, told.largest
        if told.lost or not -largest <= value <= largest:
            return NOT_ORDINARY
        if tells == AXLE_SPEED:
            return self.measure(told.wheelset, time_s, value, told.variance)
        if tells == SPEED:
            return self.measure(self.wheelset_count, time_s, value, told.variance)
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
            self.wheels[wheelset].torque_is_told = True
        elif tells == LOAD_FORCE:
            self.take_load(wheelset, value)
        elif tells == GRADIENT:
            self.now.gradient = value
        else:
            return ASIDE
        return TAKEN

    def take_force(self, i: int, time_s: float, pressing_force_n: float) -> int:
        """Take a pressing force that air can have moved to."""
        if not self.wheels[i].gate.passes(time_s, pressing_force_n):
            return NOT_ORDINARY
        self.believe_force(i, time_s, pressing_force_n)
        self.note_force(i, time_s)
        return TAKEN

    def believe_force(self, i: int, time_s: float, pressing_force_n: float) -> None:
        """Let it act from its own time on, so that taking it needs no prediction."""
        wheel = self.wheels[i]
        wheel.force.sample(time_s, pressing_force_n, LONGEST_STEP_S)
        if wheel.contact.see(time_s, pressing_force_n):
            self.now.pressed = self.any_pressed()

    def note_force(self, i: int, time_s: float) -> None:
        """Hold the pressing force against what its wheelset does."""
        wheel = self.wheels[i]
        self.now.consistency.see_force(time_s, wheel.checks, wheel.force.value, self.slip(i))

    def set_flag(self, wheelset: int, acts: bool) -> None:
        """Take what the WSP signal of a place says, of all wheelsets if there is no other."""
        if self.wheels[wheelset].wsp_active == acts:
            return
        if self.one_wsp_signal:
            for wheel in self.wheels:
                wheel.wsp_active = acts
        else:
            self.wheels[wheelset].wsp_active = acts
        any_active = False
        for wheel in self.wheels:
            any_active = any_active or wheel.wsp_active
        self.now.wsp_active = any_active

    def take_load(self, signal: int, load_n: float) -> None:
        """Take what a load signal says unless the wagon cannot weigh that: a broken one says nothing or all."""
        now = self.now
        self.load_n[signal] = load_n
        total_n = 0.0
        for i in range(len(self.load_n)):
            total_n += self.load_n[i]
        mass_kg = total_n / GRAVITY_MPS2
        if isnan(mass_kg):
            return
        if not now.configured_kg / LARGEST_LOAD_RATIO <= mass_kg <= now.configured_kg * LARGEST_LOAD_RATIO:
            return
        is_same = abs(mass_kg - now.mass_kg) <= LOADED * now.mass_kg
        now.weighed = min(now.weighed, LOAD_READINGS - 1) + 1 if is_same else 1
        now.mass_kg += (mass_kg - now.mass_kg) / now.weighed

    def measure(self, index: int, time_s: float, value: float, variance: float) -> int:
        """Take a reading of the measured state `index`, in order of time."""
        now = self.now
        step_s = time_s - now.time_s
        if not 0.0 <= step_s <= LONGEST_STEP_S or self.readings[index].fused_s == -inf:
            return NOT_ORDINARY
        if step_s > 0.0 and now.pressed and self.begins_application(time_s):
            return NOT_ORDINARY
        if self.is_frozen(index, time_s, value):
            return FROZEN
        if step_s > 0.0:
            self.advance(time_s, step_s)
            self.move(step_s)
        return self.fuse(index, abs(value), variance)  # a reversing wagon brakes by the same equations

    def is_frozen(self, index: int, time_s: float, value: float) -> bool:
        """Whether a speed repeats itself while the vehicle's, or for the vehicle's that of the wheelsets, moves on."""
        x, n, metres = self.filter.x, self.wheelset_count, 1.0
        if index < n:
            metres = self.wheels[index].radius.radius_m
            reference = x[n] / metres
        else:
            reference = self.fastest_mps()
        if not self.readings[index].frozen.see(time_s, value, reference):
            return False
        moves = metres * max(reference, abs(value)) > SLOWEST_MPS  # one of them does; both stand at a standstill
        is_locked = index < n and value == 0.0
        return moves and not is_locked

    def fastest_mps(self) -> float:
        """The largest circumferential speed of the wheelsets that are not locked; 0 if all are."""
        x, fastest_mps, turns = self.filter.x, 0.0, False
        for i in range(self.wheelset_count):
            wheel = self.wheels[i]
            if wheel.turns:
                rolling_mps = x[i] * wheel.radius.radius_m
                if rolling_mps > fastest_mps or not turns:
                    fastest_mps, turns = rolling_mps, True
        return fastest_mps

    # -- prediction --------------------------------------------------------------------------------------------

    def any_pressed(self) -> bool:
        """Whether any pad of the wagon touches its disc."""
        pressed = False
        for i in range(self.wheelset_count):
            pressed = pressed or self.wheels[i].contact.pressed
        return pressed

    def begins_application(self, time_s: float) -> bool:
        """Whether a pad has come into contact after a pause."""
        return self.now.pressed and time_s - self.now.pressed_s > PAUSE_S

    def advance(self, time_s: float, step_s: float) -> None:
        """Take the inputs' means over the step that ends at time_s, and what the forces did beside them."""
        now, braked = self.now, False
        for wheel in self.wheels:
            force = wheel.force
            wheel.impulse_std_ns = force.impulse_std_until(time_s)
            wheel.pressing_force_n = force.mean_until(time_s, step_s)
            braked = braked or wheel.pressing_force_n != 0.0 or wheel.impulse_std_ns != 0.0
            if self.tells_torque:
                wheel.wheel_torque_nm = wheel.torque.mean_until(time_s, step_s)
            wheel.begin_n = wheel.end_n
            wheel.end_n = force.value
            braked = braked or wheel.begin_n != 0.0 or wheel.end_n != 0.0
            wheel.wheel_load_n = wheel.next_wheel_load_n
        now.braked = braked
        now.time_s = time_s
        if now.pressed:
            now.pressed_s = time_s

    def move(self, step_s: float) -> None:
        """Carry the estimate over the step."""
        self.enter_regime()
        self.filter.carry(self.now, self.wheels, step_s)
        self.calibrate_radii(step_s)
        self.add_work(step_s)

    def enter_regime(self) -> None:
        """See what the wagon is doing: which states may move now, how fast, and which are held."""
        now, x, n = self.now, self.filter.x, self.wheelset_count
        speed_mps, rolled, rolls = x[n], now.rolls, True
        now.slow = slow = speed_mps < SLOWEST_MPS
        for i in range(n):
            wheel = self.wheels[i]
            slip = 0.0 if slow else 1.0 - x[i] * wheel.radius.radius_m / speed_mps
            known = wheel.torque_is_told and not wheel.force_lost
            if not (rolled and known and -QUICK_SLIP <= slip <= QUICK_SLIP):  # else all is as it was
                rolls = self.enter_slip(wheel, slip, known) and rolls
        now.rolls = rolls
        if now.pressed or now.shows:
            self.see_friction()
        self.follow_line()

    def enter_slip(self, wheel: Wheel, slip: float, known: bool) -> bool:
        """See what a wheelset is doing; whether it rolls and has for a while. `known`: whether its torque is."""
        q, time_s = self.densities, self.now.time_s
        quick = abs(slip) > QUICK_SLIP
        if quick:
            wheel.slid_s = time_s
        turns = slip < 1.0 - LOCKED_FRACTION
        settled = not time_s - wheel.slid_s < UNSETTLED_S
        wheel.turns = turns
        wheel.turning = 1.0 if turns and known else 0.0
        wheel.rolls = 1.0 if turns and not quick else 0.0
        wheel.omega_density = q.omega if turns and known else UNKNOWN_TORQUE_DENSITY
        wheel.adhesion_density = q.adhesion_sliding if quick or not known else q.adhesion_own
        wheel.unsettled = 0.0 if settled else 1.0
        wheel.unseen_std_ns = 0.0 if settled else wheel.force.unseen_std_until(time_s)
        return known and turns and settled

    def see_friction(self) -> None:
        """See which mu_b,i show: only while the pad presses and its wheel speed and every force are measured (17).

        A wheelset whose brake torque is unknown may bear any part of what brakes the wagon. So may one whose slide
        protection works faster than its pressing force is told: then no friction shows.
        """
        now, known, settled, prompt = self.now, True, True, True
        for wheel in self.wheels:
            known = known and wheel.torque_is_told and not wheel.force_lost
            settled = settled and wheel.unsettled == 0.0
            prompt = prompt and wheel.force.is_prompt
        may_show = not now.slow and known and (settled or prompt)
        now.shows = False
        for wheel in self.wheels:
            shows = may_show and wheel.turns and wheel.contact.is_settled(now.time_s) and not wheel.axle_speed_lost
            wheel.observed = 1.0 if shows else 0.0
            now.shows = now.shows or shows

    def follow_line(self) -> None:
        """See how fast d may change."""
        now, q = self.now, self.densities
        density = q.deceleration_braking if now.pressed else q.deceleration
        if density > 0.0 and now.consistency.bias.is_doubtful:
            density += q.deceleration_doubted
        now.deceleration_density = density

    def calibrate_radii(self, step_s: float) -> None:
        """A wheelset long without brake and torque rolls: its speed then tells its radius.

        Released by its WSP in a slide it does not roll yet.
        """
        now = self.now
        if now.time_s - now.pressed_s < ROLLING_AGAIN_S or now.speed_lost or now.wsp_active:
            return
        x, n = self.filter.x, self.wheelset_count
        for i in range(n):
            wheel = self.wheels[i]
            is_free = wheel.torque_is_told and wheel.torque.value == 0.0
            if is_free and not wheel.axle_speed_lost:
                wheel.radius.see_rolling(x[n], x[i], step_s)

    def add_work(self, step_s: float) -> None:
        """Note what brakes and wheels did in the step that has just been predicted; what crawls may stand."""
        now, x, n = self.now, self.filter.x, self.wheelset_count
        speed_mps = x[n]
        distance_m = speed_mps * step_s if speed_mps > CRAWLING_MPS else 0.0
        now.distance_m += distance_m
        now.protections_due = not 0.0 <= now.time_s - now.protections_s < PERIOD_S
        if now.protections_due:
            now.protections_s, now.protections_speed_mps = now.time_s, speed_mps
        for i in range(n):
            wheel = self.wheels[i]
            force_n, rolling_mps = wheel.pressing_force_n, x[i] * wheel.radius.radius_m
            slip = 0.0 if speed_mps < SLOWEST_MPS else 1.0 - rolling_mps / speed_mps
            if now.protections_due:
                wheel.slip = slip
            if force_n != 0.0 and rolling_mps > CRAWLING_MPS:
                wheel.work.rub(force_n * wheel.brake_radius_m * x[i] * step_s, x[n + 1 + i])
            if slip > SLIDING_SLIP:
                wheel.work.slide(slip, distance_m)
            wheel.departure.see(step_s, force_n, wheel.observed)

    @property
    def glance_size(self) -> int:
        """How many numbers `glance` gives."""
        return 2 + 3 * self.wheelset_count

    def glance(self, numbers: MutableSequence[float]) -> None:
        """What slide protections are to see now: time and speed, and slip, pressing force and flag of each wheelset."""
        self.now.protections_due = False
        numbers[0], numbers[1] = self.now.protections_s, self.now.protections_speed_mps
        for i in range(self.wheelset_count):
            wheel, place = self.wheels[i], 2 + 3 * i
            numbers[place], numbers[place + 1] = wheel.slip, self.wheels[i].force.value
            numbers[place + 2] = 1.0 if wheel.wsp_active else 0.0

    def speed_mps(self) -> float:
        """The estimated vehicle speed v."""
        speed_mps: float = self.filter.x[self.wheelset_count]
        return speed_mps

    def slip(self, i: int) -> float:
        """(v - omega r_W) / v of a wheelset with its calibrated radius; 0 near standstill."""
        x = self.filter.x
        return slip_of(x[i], self.wheels[i].radius.radius_m, x[self.wheelset_count])

    # -- correction --------------------------------------------------------------------------------------------

    def fuse(self, index: int, value: float, variance: float) -> int:
        """Correct the estimate by a reading of the measured state `index` at the filter's time."""
        brakes, reading, time_s = self.filter, self.readings[index], self.now.time_s
        since_s, passed_s = time_s - reading.fused_s, time_s - reading.came_s
        reading.came_s = time_s
        if since_s == inf:
            brakes.forget(index, value, sqrt(variance))
            outcome = FUSED if brakes.is_sound() else UNSOUND
        else:
            residual = value - brakes.x[index]
            total_variance = brakes.covariance[index][index] + variance  # S = H P H' + R
            gate = OUTLIER_SIGMA * sqrt(total_variance)
            is_strange = abs(residual) > gate  # as nearly none is
            if is_strange and self.is_outlier(index, residual, gate, min(since_s, max(passed_s, reading.spacing_s))):
                if not self.takes_outlier(index, value, variance):
                    return TAKEN
                outcome = FUSED if brakes.is_sound() else UNSOUND
            else:
                outcome = self.correct(index, since_s, variance, residual, total_variance)
                if outcome == CONTRADICTED:
                    return CONTRADICTED
        reading.rejected = 0
        reading.fused_s = time_s
        return outcome

    def takes_outlier(self, index: int, value: float, variance: float) -> bool:
        """Reject a reading, or believe it against the prediction: whether it was one too many in a row."""
        reading = self.readings[index]
        self.now.outlier_count += 1
        reading.rejected += 1
        if reading.rejected < OUTLIERS_BELIEVED:
            return False
        self.filter.forget(index, value, sqrt(variance))
        reading.believed += 1
        if index < self.wheelset_count and reading.believed >= BELIEFS_EXPLAINED:
            self.doubt_adhesion(index)
        return True

    def correct(self, index: int, since_s: float, variance: float, residual: float, foretold_variance: float) -> int:
        """Correct the estimate by a reading that is no outlier: FUSED, CONTRADICTED or UNSOUND."""
        now, brakes, reading, n = self.now, self.filter, self.readings[index], self.wheelset_count
        total_variance, nis = foretold_variance, residual * residual / foretold_variance
        if index < n and nis > SURPRISE_NIS and since_s > 0.0:
            self.admit_jump(index, residual, max(since_s, LEAST_JUMP_S))
            total_variance = brakes.covariance[index][index] + variance
            nis = residual * residual / total_variance
        is_sound = brakes.fuse(now, self.wheels, index, residual, total_variance)
        now.nis = nis
        reading.believed = 0
        mean_s = reading.spacing_s or since_s
        reading.spacing_s = mean_s + SPACING_SHARE * (since_s - mean_s)
        if index < n:
            wheel, brake_radps2 = self.wheels[index], self.brake_radps2(index)
            now.consistency.see_wheel(now.time_s, wheel.checks, residual, foretold_variance, brake_radps2)
        elif self.contradicts(residual, total_variance):
            return CONTRADICTED
        return FUSED if is_sound else UNSOUND

    def admit_jump(self, i: int, residual: float, since_s: float) -> None:
        """The speed of a wheelset surprises: its adhesion may have jumped."""
        wheel = self.wheels[i]
        per_torque = (1.0 if wheel.turns else 0.0) / wheel.inertia_kgm2
        spin_per_adhesion = wheel.wheel_radius_m * wheel.wheel_load_n * per_torque * since_s
        if spin_per_adhesion > 0.0:
            self.filter.admit_adhesion_jump(i, residual, spin_per_adhesion)

    def doubt_adhesion(self, i: int) -> None:
        """The speed of a wheelset runs away from its prediction: what predicts it is wrong."""
        place = 2 * self.wheelset_count + 1 + i
        self.filter.forget(place, self.filter.x[place], DOUBTED_ADHESION_STD)

    def brake_radps2(self, i: int) -> float:
        """What the brake adds to the wheelset's angular acceleration (6)."""
        wheel, friction = self.wheels[i], self.filter.x[self.wheelset_count + 1 + i]
        brake_radps2: float = wheel.brake_radps2_per_n * friction * wheel.force.value
        return brake_radps2

    def contradicts(self, residual: float, total_variance: float) -> bool:
        """Whether speeds and pressing forces no longer fit together."""
        if self.literal:  # the paper's covariances (20) cannot tell
            return False
        now, x, n = self.now, self.filter.x, self.wheelset_count
        now.consistency.see_deceleration(now.time_s, x[3 * n + 1], self.largest_deceleration_mps2)
        contradicts = now.consistency.see_speed(now.time_s, residual, total_variance)
        if now.pressed and now.deceleration_density > 0.0 and now.consistency.bias.is_doubtful:
            self.doubt_friction()
        for i in range(n):
            contradicts = contradicts or x[n + 1 + i] > LARGEST_FRICTION
        return contradicts

    def doubt_friction(self) -> None:
        """What seems to be friction may be the line, which has the same effect as long as the forces stay as they are.

        Along that direction of the state, mu_b and mu_w of what rolls against d, no reading tells: see `observability`.
        """
        along, n, unmodelled_mps2 = self.filter.along, self.wheelset_count, 0.0
        for i in range(n):
            wheel = self.wheels[i]
            shows = wheel.observed * wheel.rolls
            asked_n = shows * wheel.force.value * wheel.brake_radius_m / wheel.wheel_radius_m
            along[n + 1 + i] = shows
            along[2 * n + 1 + i] = asked_n / wheel.wheel_load_n
            unmodelled_mps2 -= asked_n / self.now.mass_kg
        along[3 * n + 1] = unmodelled_mps2
        self.filter.admit_along(self.densities.friction_doubted * self.readings[n].spacing_s)

    def is_outlier(self, index: int, residual: float, gate: float, unseen_s: float) -> bool:
        """A reading that neither noise, as far as to the gate, nor physics explains; physics explains a sliding wheel.

        `unseen_s`: since the last reading, be it a rejected one: two spikes in a row are not twice as possible.
        """
        fastest = FASTEST_WAGON_MPS2 if index == self.wheelset_count else FASTEST_WHEEL_RADPS2
        return abs(residual) > gate + fastest * unseen_s
