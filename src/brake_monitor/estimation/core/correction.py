"""What the core does with a reading: it rejects it, or corrects the estimate by it, and may doubt the model."""

from math import inf, sqrt

from brake_monitor.estimation.core.change_doubt import ChangeDoubt
from brake_monitor.estimation.core.regime_watch import LOCKED_FRACTION, QUICK_SLIP, ROLLING_AGAIN_S
from brake_monitor.estimation.doubts.consistency import BIASED
from brake_monitor.estimation.estimate import SLOWEST_MPS
from brake_monitor.estimation.filter.physical import LARGEST_DECELERATION_MPS2
from brake_monitor.estimation.kalman.foretold import STRANGE_STD_MPS
from brake_monitor.estimation.model.wheelset import brake_radps2, rail_radps2
from brake_monitor.settings.bounds import LARGEST_FRICTION

SPACING_SHARE = 0.05  # of the newest reading in the mean spacing of its sensor's
LONGEST_SPACING = 10.0  # times the mean; what is longer was an outage
LEAST_JUMP_S = 0.01  # wheel speeds in frames that a gateway bunches are not as close as their times
SURPRISE_NIS = 10.0  # beyond about three sigma of a wheel speed its adhesion is taken to have jumped
OUTLIER_SIGMA = 6.0
OUTLIERS_BELIEVED = 3  # this many in a row are no outliers but the truth
BELIEFS_IN_A_ROW = 3  # after this many outliers that had to be believed the prediction is wrong
DOUBTED_ADHESION_STD = 0.05
LEFT_STD = 0.3  # of what is taken from an adhesion as its wheelset is found back to rolling
LEAST_TURNED_UP = 0.02  # of its speed between two readings: less may still go on
FASTEST_AMONG_SPIKES_RADPS2 = 80.0  # of a wheel speed that spikes lately: few brakes and rails are quicker
LARGEST_ADHESION = 0.5  # of a dry rail
UNBRAKED_RADPS2 = 10.0  # what else turns a wheelset that no brake slows down, or that the rail has brought to rolling
ROLLING_STD = 3e-3  # of the speed of a wheelset that rolls freely: what its radius is not known by, and curves
CREEPING_STD = 2e-2  # ... and of one under a brake
LONGEST_TOOTH_RAD = 0.1  # of a pole wheel, which has 60 teeth and more

# What became of a sample.
TAKEN, FUSED, ASIDE, FROZEN, CONTRADICTED, UNSOUND, NOT_ORDINARY = range(7)


class Correction(ChangeDoubt):
    """The steps with one reading, at its own time."""

    __slots__ = ()

    def fuse(self, index: int, value: float, variance: float) -> int:
        """Correct the estimate by a reading of the measured state `index` at the filter's time."""
        reading, time_s = self.readings[index], self.now.time_s
        since_s, passed_s = time_s - reading.fused_s, time_s - reading.came_s
        reading.came_s = time_s
        if index < self.wheelset_count and self.is_slow(index, value):
            variance += self.tooth_variance(index, value)
        residual, total_variance = self.innovation(index, value, variance)
        if self.foretold.is_asked:
            self.foretell(index, since_s, residual, total_variance)
        if since_s == inf:
            return self.begin_with(index, value, variance)
        if reading.spikes.awaits and reading.spikes.see_next(time_s, value, residual):
            return self.take_back_jump(index, value, variance)
        gate = OUTLIER_SIGMA * sqrt(total_variance)
        if abs(residual) > gate:  # as nearly none is
            unseen_s = min(since_s, max(passed_s, reading.spacing_s))
            if self.is_outlier(index, residual, gate, unseen_s, since_s):
                return self.meet_outlier(index, value, variance, residual, gate)
            if index < self.wheelset_count and self.hold_back(index, value, residual):
                return TAKEN
        if index < self.wheelset_count and self.reads_locked(index, value):
            return self.begin_with(index, value, variance)
        return self.correct(index, since_s, variance, residual, total_variance)

    def is_slow(self, i: int, value: float) -> bool:
        """Whether a wheelset turns so slowly that a tooth of its pole wheel takes longer than readings are apart.

        To the letter of (20) this does not count.
        """
        return 0.0 < value * self.readings[i].spacing_s < LONGEST_TOOTH_RAD and not self.tuning.literal

    def awaits_tooth(self, index: int, time_s: float, value: float) -> bool:
        """Whether a reading says what the one before said since no tooth has passed: it is not new."""
        reading = self.readings[index]
        if index == self.wheelset_count or not reading.frozen.repeats or reading.fused_s == -inf:
            return False
        return self.is_slow(index, value) and value * (time_s - reading.frozen.since_s) < LONGEST_TOOTH_RAD

    def tooth_variance(self, i: int, value: float) -> float:
        """The variance of a new one: it is as old as its tooth, and a wheelset that slows down may stand by now.

        One that is turned up passes its next tooth the sooner.
        """
        late_s = LONGEST_TOOTH_RAD / value - self.readings[i].spacing_s
        lost_radps = min(max(-self.foretold_radps2(i), 0.0) * late_s, value)
        return lost_radps * lost_radps

    def foretell(self, index: int, since_s: float, residual: float, total_variance: float) -> None:
        """Add up how probable a reading was that has just come."""
        strange_std = STRANGE_STD_MPS
        if index < self.wheelset_count:
            strange_std /= self.wheels[index].wheel_radius_m
        if since_s == inf:
            self.foretold.see_first(strange_std)
        else:
            self.foretold.see(residual, total_variance, strange_std)

    def begin_with(self, index: int, value: float, variance: float) -> int:
        """Set a speed to its reading, as to the first one after a start."""
        self.filter.forget(index, value, sqrt(variance))
        if index == self.wheelset_count:
            self.now.near_standstill = value < SLOWEST_MPS
        elif self.now.speed_lost and self.now.near_standstill:
            self.follow_rolling(index, value, variance)
        return self.accept(index, self.filter.is_sound())

    def reads_locked(self, i: int, value: float) -> bool:
        """Whether a wheel speed reads as that of a locked wheelset: it is then taken over, and tells of no force.

        Below some speed a sensor says 0, at once: no torque has made the wheelset lose that speed. To the letter of
        (20) it is fused as any other.
        """
        stands = value * self.wheels[i].radius.radius_m < LOCKED_FRACTION * self.speed_mps()
        return stands and not self.tuning.literal

    def accept(self, index: int, is_sound: bool) -> int:
        """Note that a reading was taken over; FUSED, or UNSOUND where x and P are not sound any more."""
        self.readings[index].rejected_in_a_row = 0
        self.readings[index].fused_s = self.now.time_s
        return FUSED if is_sound else UNSOUND

    def hold_back(self, i: int, value: float, residual: float) -> bool:
        """Hold a surprising reading back, if its wheel speed spikes lately, until the next one bears it out.

        Either way it is noted, with what was known of mu_w,i and v before it: `take_back_jump` may need that.
        """
        reading, time_s = self.readings[i], self.now.time_s
        holds = reading.rejected_in_a_row == 0 and reading.spikes.is_on(time_s)
        reading.spikes.note(time_s, value, residual, not holds)
        surprise, place, speed = self.wheels[i].surprise, self.adhesion_place + i, self.wheelset_count
        surprise.adhesion = self.filter.x[place]
        surprise.adhesion_variance = max(self.filter.covariance[place][place], 0.0)
        surprise.speed_variance = max(self.filter.covariance[speed][speed], 0.0)
        if holds:
            self.now.outlier_count += 1
            reading.rejected_in_a_row = 1
        return holds

    def meet_outlier(self, index: int, value: float, variance: float, residual: float, gate: float) -> int:
        """Reject an outlier, or believe it against the prediction where too many came in a row."""
        reading, is_wheel = self.readings[index], index < self.wheelset_count
        self.now.outlier_count += 1
        reading.rejected_in_a_row += 1
        if not is_wheel:
            self.now.consistency.see_outlying_speed()
        if reading.rejected_in_a_row < OUTLIERS_BELIEVED:
            if is_wheel and abs(residual) <= gate + self.by_dry_rail_radps2(index) * reading.spacing_s:
                reading.spikes.note(self.now.time_s, value, residual, False)
            return TAKEN
        self.filter.forget(index, value, sqrt(variance))
        reading.believed_in_a_row += 1
        if is_wheel and reading.believed_in_a_row >= BELIEFS_IN_A_ROW:
            self.doubt_adhesion(index)
        return self.accept(index, self.filter.is_sound())

    def correct(self, index: int, since_s: float, variance: float, residual: float, foretold_variance: float) -> int:
        """Correct the estimate by a reading that is no outlier: FUSED, CONTRADICTED or UNSOUND."""
        now, brakes, reading, n = self.now, self.filter, self.readings[index], self.wheelset_count
        total_variance, nis = foretold_variance, residual * residual / foretold_variance
        foretold_nis = nis
        if index < n and nis > SURPRISE_NIS and since_s > 0.0:
            self.admit_jump(index, residual, max(since_s, LEAST_JUMP_S))
            total_variance = brakes.covariance[index][index] + variance
            nis = residual * residual / total_variance
        value, before_mps = brakes.x[index] + residual, brakes.x[n]
        is_sound = brakes.fuse(now, self.wheels, index, residual, total_variance)
        now.nis = nis
        reading.believed_in_a_row = 0
        mean_s = reading.spacing_s or since_s
        reading.spacing_s = mean_s + SPACING_SHARE * (min(since_s, LONGEST_SPACING * mean_s) - mean_s)
        if index < n:
            wheel = self.wheels[index]
            wheel.surprise.moved_mps = brakes.x[n] - before_mps
            self.end_acceleration(index)
            slides = wheel.slides if wheel.force.is_prompt else 0.0
            now.consistency.see_wheel(now.time_s, wheel.checks, foretold_nis, value, slides)
            if now.speed_lost:
                is_sound = self.follow_rolling(index, value, variance) and is_sound
        elif self.see_speed(residual, total_variance):
            return CONTRADICTED
        return self.accept(index, is_sound)

    def follow_rolling(self, i: int, value: float, variance: float) -> bool:
        """Let a wheelset that rolls tell the vehicle's speed, which is lost; whether x and P are sound then.

        Under a brake it creeps, and only the fastest one may tell. Not one that seizes or slides: no wagon loses speed
        as quickly. What is lost stays so, but v and its integral stay right. What was never told is not lost.
        """
        now, radius_m, n = self.now, self.wheels[i].radius.radius_m, self.wheelset_count
        if now.wsp_active or self.tuning.literal or self.readings[n].came_s == -inf:
            return True
        rolling_mps, std = value * radius_m, ROLLING_STD
        if now.time_s - now.pressed_s < ROLLING_AGAIN_S or not self.is_left_free(i):
            std = CREEPING_STD
            if self.filter.x[i] * radius_m < self.fastest_mps():
                return True
        own_variance = radius_m * radius_m * variance
        residual, total_variance = self.innovation(n, rolling_mps, own_variance)
        gate = OUTLIER_SIGMA * sqrt(total_variance) + LARGEST_DECELERATION_MPS2 * self.readings[i].spacing_s
        total_variance += std * std * rolling_mps * rolling_mps
        return abs(residual) > gate or self.filter.fuse(now, self.wheels, n, residual, total_variance)

    def is_outlier(self, index: int, residual: float, gate: float, unseen_s: float, since_s: float) -> bool:
        """Whether neither noise, up to the gate, nor physics explains a reading; physics explains a sliding wheel.

        `unseen_s`: time since the last reading, even a rejected one: the second of two spikes gets no more room.
        `since_s`: since the last one that was used.
        """
        n = self.wheelset_count
        fastest = LARGEST_DECELERATION_MPS2 if index == n else self.fastest_radps2(index, residual, gate)
        if abs(residual) <= gate + fastest * unseen_s:
            return False
        return index == n or not self.has_acceleration_ended(index, residual, gate, since_s)

    def fastest_radps2(self, i: int, residual: float, gate: float) -> float:
        """The largest angular acceleration away from the prediction: brakes slow a wheelset, the rail turns it up."""
        wheel, x, n, most_radps2 = self.wheels[i], self.filter.x, self.wheelset_count, self.by_dry_rail_radps2(i)
        if self.readings[i].spikes.is_on(self.now.time_s):
            most_radps2 = min(most_radps2, FASTEST_AMONG_SPIKES_RADPS2)
        if wheel.force_lost or self.has_torque_signal:
            return most_radps2
        if residual < 0.0:
            hardest_radps2 = LARGEST_FRICTION * brake_radps2(wheel, wheel.force.most_lately, 1.0)
            return min(UNBRAKED_RADPS2 + hardest_radps2, most_radps2)
        rolling_radps = max(x[n] / wheel.radius.radius_m, x[i])
        return most_radps2 if x[i] + residual <= rolling_radps + gate else UNBRAKED_RADPS2

    def by_dry_rail_radps2(self, i: int) -> float:
        """The largest angular acceleration that a dry rail gives; nothing turns a wheelset down faster."""
        return LARGEST_ADHESION * rail_radps2(self.wheels[i], self.wheels[i].wheel_load_n, 1.0)

    def has_acceleration_ended(self, i: int, residual: float, gate: float, since_s: float) -> bool:
        """Whether a reading is explained by the end of the acceleration that the prediction has gone on with.

        A rail that is dry again accelerates a wheelset more than any brake, and suddenly no more once it rolls.
        """
        foretold_radps = self.foretold_radps2(i) * since_s
        return residual * foretold_radps < 0.0 and abs(residual) <= gate + abs(foretold_radps)

    def foretold_radps2(self, i: int) -> float:
        """The angular acceleration with which the prediction goes on, but for that of a motor."""
        wheel, x = self.wheels[i], self.filter.x
        by_rail = x[self.adhesion_place + i] * rail_radps2(wheel, wheel.wheel_load_n, 1.0)
        return by_rail - x[self.friction_place + i] * brake_radps2(wheel, wheel.force.value, 1.0)

    def admit_jump(self, i: int, residual: float, since_s: float) -> None:
        """Admit a jump of mu_w,i that explains the surprising residual of a wheel speed, and what v has lost by it."""
        wheel = self.wheels[i]
        if wheel.turns:
            spin_per_adhesion = rail_radps2(wheel, wheel.wheel_load_n, 1.0) * since_s
            lost_mps = wheel.wheel_load_n / self.now.mass_kg * since_s
            jump = residual / spin_per_adhesion
            self.filter.admit_jump(self.adhesion_place + i, jump * jump, i, spin_per_adhesion, lost_mps)

    def end_acceleration(self, i: int) -> None:
        """Take from mu_w,i what has turned a wheelset up that was found back to rolling: no more than is asked for.

        Until its reading the rail gave more. On the rising flank of the creep curve that ends as slip does: what is
        left of it is in proportion to slip. To the letter of (20) adhesion is what it was.
        """
        wheel, place = self.wheels[i], self.adhesion_place + i
        if wheel.rolls != 0.0 or self.tuning.literal:
            return
        slip, asked = max(self.slip(i), 0.0), self.adhesion_demand(i)
        excess = self.filter.x[place] - asked
        turned_up_radps2 = excess * rail_radps2(wheel, wheel.wheel_load_n, wheel.has_equation)
        turned_up_radps = turned_up_radps2 * self.readings[i].spacing_s
        if slip <= QUICK_SLIP and turned_up_radps > LEAST_TURNED_UP * self.filter.x[i]:
            left = slip / QUICK_SLIP
            self.filter.scale(place, left, asked)
            left_std = LEFT_STD * (1.0 - left) * excess
            self.filter.widen(place, left_std * left_std)

    def take_back_jump(self, i: int, value: float, variance: float) -> int:
        """Set mu_w,i and v back to before a reading that was taken for a jump of adhesion, and was a spike."""
        surprise, brakes, speed = self.wheels[i].surprise, self.filter, self.wheelset_count
        brakes.forget(speed, brakes.x[speed] - surprise.moved_mps, sqrt(surprise.speed_variance))
        brakes.forget(self.adhesion_place + i, surprise.adhesion, sqrt(surprise.adhesion_variance))
        brakes.forget(i, value, sqrt(variance))
        return self.accept(i, brakes.is_sound())

    def see_speed(self, residual: float, total_variance: float) -> bool:
        """Take a fused vehicle speed, and widen friction in doubt; True where speeds and forces exclude each other."""
        if self.tuning.literal:  # the paper's covariances (20) cannot tell
            return False
        now, x = self.now, self.filter.x
        now.consistency.see_deceleration(now.time_s, x[self.deceleration_place], self.largest_deceleration_mps2)
        if self.tuning.friction_doubted > 0.0:  # else d is what pulls the wagon as well
            self.see_line_change()
            self.hold_on_to_unexplained()
        contradicts = now.consistency.see_speed(now.time_s, residual, total_variance)
        is_doubtful = self.is_speed_doubtful()
        if is_doubtful or (now.lag_observable and self.is_lag_at_limit()):
            now.consistency.raised_s[BIASED] = now.time_s
        if now.pressed and now.deceleration_density > 0.0:
            if self.tuning.friction_doubted > 0.0 and now.any_friction_observable:
                self.see_changes()
            self.judge_friction(is_doubtful)
        for i in range(self.wheelset_count):  # a force that acts is not measured
            contradicts = contradicts or x[self.friction_place + i] > LARGEST_FRICTION
        return contradicts

    def doubt_adhesion(self, i: int) -> None:
        """Widen mu_w,i: a wheel speed has left its prediction again and again, so what predicts it is wrong."""
        place = self.adhesion_place + i
        self.filter.forget(place, self.filter.x[place], DOUBTED_ADHESION_STD)
