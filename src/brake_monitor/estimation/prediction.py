"""What the core does to let time go on: it sees what the wagon is doing, and carries the estimate over a step."""

from collections.abc import MutableSequence
from math import exp, hypot, inf, log, sqrt

from brake_monitor.estimation.brake_work import CRAWLING_MPS, SLIDING_SLIP
from brake_monitor.estimation.core_numbers import CoreNumbers
from brake_monitor.estimation.earlier import KEPT_S
from brake_monitor.estimation.estimate import SLOWEST_MPS
from brake_monitor.estimation.model.load_transfer import PITCH_S
from brake_monitor.estimation.model.regime import STOOD_FRICTION_STD
from brake_monitor.estimation.moment import WheelsetMoment
from brake_monitor.estimation.slide_protection import PERIOD_S

UNSETTLED_S = 2.0  # after a slide
LOADS_SETTLE_S = 4.0 * PITCH_S  # after a start
TIMING_STD_S = 0.008  # of a pressing force against its wheel speed: gateways hand on as late as their cycle
RELEASING = 0.8  # of the largest force: how quickly it falls says more of its timing than of a friction in doubt
QUICK_SIGMAS = 3.0  # of v
QUICK_SLIP = 0.01  # from here on adhesion may change within hundredths of a second
LOCKED_FRACTION = 0.03  # circumferential over vehicle speed of a wheelset that does not turn
LOCKED_ADHESION_DENSITY = 5e-3  # 1/s, of one while v contradicts the model: more likely its rail does than the line
LOCKED_LINE_DENSITY = 1e-5  # (m/s²)²/m, 10 per mille in a kilometre: no change of the line contradicts anything then
UNTOLD_ADHESION_STD = 0.1  # about half of what full braking asks for
UNKNOWN_TORQUE_DENSITY = 40.0  # (rad/s)²/s, for a wheelset whose equation cannot be used
UPTAKE_SLIPS = (0.015, 0.04, 0.10)  # where C_1, C_2 and C_3 hold; in between by the logarithm of slip
ROLLING_AGAIN_S = 3.0  # after the last contact of any pad, every wheelset has found back to rolling
PAUSE_S = 1.0  # without any contact for longer, the next contact is a new brake application
PULL_CUT_S = 1.0  # so quickly traction may be cut ...
PULL_ENDS_S = 3.0  # ... until so long after the brake has come on
LEAST_SLOWING_MPS2 = 0.2  # with less, late forces hardly show, and minutes of it teach what the model leaves out


class Prediction(CoreNumbers):
    """The steps from one reading's time to the next one's."""

    __slots__ = ()

    def begins_application(self, time_s: float) -> bool:
        """Whether a pad has come into contact after a pause."""
        return self.now.pressed and time_s - self.now.pressed_s > PAUSE_S

    def advance(self, time_s: float, step_s: float) -> None:
        """Take the inputs' means over the step that ends at time_s, and what the forces did beside them."""
        now, braked, driven = self.now, False, False
        for wheel in self.wheels:
            force = wheel.force
            wheel.impulse_std_ns = force.impulse_std_until(time_s)
            wheel.pressing_force_n = force.mean_until(time_s, step_s)
            braked = braked or wheel.pressing_force_n != 0.0 or wheel.impulse_std_ns != 0.0
            if self.tells_torque:
                wheel.wheel_torque_nm = wheel.torque.mean_until(time_s, step_s)
                wheel.begin_nm, wheel.end_nm = wheel.end_nm, wheel.torque.value
                driven = driven or wheel.wheel_torque_nm != 0.0 or wheel.begin_nm != 0.0 or wheel.end_nm != 0.0
            wheel.begin_n = wheel.end_n
            wheel.end_n = force.value
            if wheel.slides != 0.0:
                mistimed_ns = TIMING_STD_S * (wheel.end_n - wheel.begin_n)
                wheel.impulse_std_ns = hypot(wheel.impulse_std_ns, mistimed_ns)
            braked = braked or wheel.begin_n != 0.0 or wheel.end_n != 0.0
            wheel.wheel_load_n = wheel.next_wheel_load_n
        now.braked, now.driven = braked, driven
        now.time_s = time_s
        if now.pressed:
            now.pressed_s = time_s

    def begin_lag(self) -> None:
        """Note what is known of L as a brake application, or the estimate, begins."""
        lag = self.lag_place
        self.now.lag_begun_s, self.now.lag_begun_variance = self.filter.x[lag], self.filter.covariance[lag][lag]

    def begin_friction(self) -> None:
        """Note what is known of the pads' mean friction as a brake application, or the estimate, begins."""
        self.now.friction_begun, self.now.friction_begun_variance = self.mean_friction(), self.mean_friction_variance()
        self.now.strays_s, self.now.line_friction_std, self.now.line_friction_share = inf, 0.0, 0.0
        self.now.friction_is_doubted = self.now.pull_variance > 0.0

    def move(self, step_s: float) -> None:
        """Carry the estimate over the step."""
        self.enter_regime()
        now, before_mps = self.now, self.filter.x[self.wheelset_count]
        self.filter.carry(now, self.wheels, step_s)
        if now.time_s - now.started_s < LOADS_SETTLE_S:
            self.keep_rail_forces()
        if now.lag_shows:
            self.see_lag(before_mps, step_s)
        self.let_unmeasured_roll()
        if not (now.all_roll or now.slow):
            self.draw_untold(step_s)
        self.calibrate_radii(step_s)
        self.add_work(step_s)
        if not 0.0 <= now.time_s - now.kept_s < KEPT_S:
            self.keep()

    def keep_rail_forces(self) -> None:
        """Let the rail act on rolling wheelsets as before while their loads change.

        Who starts under a brake finds the wagon pitched, and learns most before the loads that it knows of are as well.
        Later they change slowly, by what is itself an estimate: adhesion that follows would drift with it.
        """
        for i in range(self.wheelset_count):
            wheel = self.wheels[i]
            if wheel.rolls != 0.0:
                self.filter.scale(self.adhesion_place + i, wheel.wheel_load_n / wheel.next_wheel_load_n, 0.0)

    def keep(self) -> None:
        """Keep what is known now in the place of what was known longest ago."""
        oldest = 0
        for k in range(len(self.earlier)):
            if self.earlier[k].time_s < self.earlier[oldest].time_s:
                oldest = k
        self.now.kept_s = self.now.time_s
        self.earlier[oldest].keep(self.now.time_s, self.filter.x, self.filter.covariance)

    def let_unmeasured_roll(self) -> None:
        """Take a wheelset whose speed is not measured to roll: left to its equation, it would drift into a slide."""
        for i in range(self.wheelset_count):
            wheel = self.wheels[i]
            if wheel.axle_speed_lost and not self.now.slow:
                rolling_radps = self.filter.x[self.wheelset_count] / wheel.radius.radius_m
                self.filter.forget(i, rolling_radps, SLIDING_SLIP * rolling_radps)

    def draw_untold(self, step_s: float) -> None:
        """Draw adhesion of a wheelset whose torque or speed nobody tells to what its brake asks for, if that is told.

        With its walk alone it would in minutes be beyond what any rail gives; so it is off by `UNTOLD_ADHESION_STD`.
        """
        for i in range(self.wheelset_count):
            wheel = self.wheels[i]
            tells_torque = wheel.torque_is_told and not wheel.force_lost
            if not tells_torque or wheel.axle_speed_lost:
                asked = self.asked(i) if tells_torque else 0.0
                drawn = step_s * wheel.adhesion_density / (2.0 * UNTOLD_ADHESION_STD * UNTOLD_ADHESION_STD)
                self.filter.scale(self.adhesion_place + i, exp(-drawn), asked)

    def asked(self, i: int) -> float:
        """The adhesion that brake and motor of a wheelset that rolls ask for."""
        wheel = self.wheels[i]
        torque_nm = self.filter.x[self.friction_place + i] * wheel.end_n * wheel.brake_radius_m - wheel.end_nm
        asked: float = torque_nm / (wheel.radius.radius_m * wheel.next_wheel_load_n)
        return asked

    def enter_regime(self) -> None:
        """See what the wagon is doing: which states may move now, how fast, and which are held."""
        now, x, n = self.now, self.filter.x, self.wheelset_count
        speed_mps, rolled, rolls = x[n], now.all_roll, True
        now.slow = slow = speed_mps < SLOWEST_MPS
        quick = self.quick_slip_squared()
        for i in range(n):
            wheel = self.wheels[i]
            slip = 0.0 if slow else 1.0 - x[i] * wheel.radius.radius_m / speed_mps
            known = wheel.torque_is_told and not (wheel.force_lost or wheel.axle_speed_lost)
            wheel.slip_change_mps = 0.0
            if not (rolled and known and slip * slip <= quick):  # else all is as it was
                rolls = self.enter_slip(i, slip, slip * slip > quick, known) and rolls
        now.all_roll = rolls
        if rolls and now.has_slid:
            self.end_slides()
        if now.pressed or now.shows:
            self.see_friction()
        if self.learns_lag:
            self.follow_lag()
        self.follow_line()

    def quick_slip_squared(self) -> float:
        """From which slip on adhesion is quick, squared: not from one that v itself may be off by."""
        if self.now.slow:
            return QUICK_SLIP * QUICK_SLIP
        n = self.wheelset_count
        speed_mps, variance = self.filter.x[n], self.filter.covariance[n][n]
        unsure: float = QUICK_SIGMAS * QUICK_SIGMAS * variance / (speed_mps * speed_mps)
        return QUICK_SLIP * QUICK_SLIP + unsure

    def enter_slip(self, i: int, slip: float, quick: bool, known: bool) -> bool:
        """See what a wheelset is doing; whether it rolls and has for a while. `known`: its torque and its speed."""
        q, now, wheel, time_s = self.densities, self.now, self.wheels[i], self.now.time_s
        if quick:
            wheel.slid_s = time_s
        turns = slip < 1.0 - LOCKED_FRACTION
        settled = not time_s - wheel.slid_s < UNSETTLED_S
        wheel.turns = turns
        wheel.turning = 1.0 if turns and known else 0.0
        wheel.slides = wheel.turning if slip > SLIDING_SLIP else 0.0
        wheel.rolls = 1.0 if turns and not quick else 0.0
        wheel.omega_density = q.omega if turns and known else UNKNOWN_TORQUE_DENSITY
        wheel.adhesion_density = q.adhesion_sliding if quick or not known else q.adhesion_own
        wheel.unsettled = 0.0 if settled else 1.0
        wheel.unseen_std_ns = 0.0 if settled else wheel.force.unseen_std_until(time_s)
        creeps = quick and slip > 0.0 and wheel.turning != 0.0 and self.uptake_std > 0.0  # else no shares are
        now.has_slid = now.has_slid or creeps or wheel.slides != 0.0
        wheel.effect_shows = wheel.unsettled if now.has_slid else 0.0
        self.enter_creep(wheel, slip, creeps)
        self.see_stand(i)
        now.braked = now.braked or wheel.unseen_std_ns != 0.0
        return known and turns and settled

    def see_stand(self, i: int) -> None:
        """See whether a brake holds its wheelset fast, or did: nothing tells what friction becomes meanwhile.

        Pads that do not slide rub otherwise, and are on their way back for a while once they do.
        """
        wheel, time_s, place = self.wheels[i], self.now.time_s, self.friction_place + i
        if not wheel.turns:
            wheel.stood_s = time_s
        moves = self.stood_lately(wheel) and wheel.contact.pressed and not self.literal
        variance = self.filter.covariance[place][place]
        wheel.stood = 1.0 if moves and variance < STOOD_FRICTION_STD * STOOD_FRICTION_STD else 0.0

    def stood_lately(self, wheel: WheelsetMoment) -> bool:
        """Whether it stands, or its pads are on their way back: the pull that lets it turn tells nothing of them."""
        lately: bool = self.now.time_s - wheel.stood_s < UNSETTLED_S
        return lately

    def enter_creep(self, wheel: WheelsetMoment, slip: float, creeps: bool) -> None:
        """See where on the creep curve a wheelset is, and which way it has gone since it was looked at last.

        What the rail gives falls less and less, to 1/e: dmu_w/dw = - B mu_w e^{-B w}. B that was learned at small slip
        would have it fall to nothing on the way to a lock, where it falls to A mu_0 (Polach: A is about 0.4).
        """
        slip_mps = slip * self.speed_mps()
        still_falls = exp(-max(self.filter.x[self.creep_place + 1] * slip_mps, 0.0))
        wheel.slip_change_mps = still_falls * (slip_mps - wheel.slip_mps)
        wheel.slip_mps = slip_mps
        wheel.small_slip = wheel.medium_slip = wheel.large_slip = 0.0
        if not creeps:
            return
        small, medium, large = UPTAKE_SLIPS
        if slip < medium:
            wheel.medium_slip = max(log(slip / small) / log(medium / small), 0.0)
            wheel.small_slip = 1.0 - wheel.medium_slip
        else:
            wheel.large_slip = min(log(slip / medium) / log(large / medium), 1.0)
            wheel.medium_slip = 1.0 - wheel.large_slip

    def end_slides(self) -> None:
        """What slides have taught of E, B and C stays; what ties it to the rest of it is not worth carrying on."""
        for place in range(self.creep_place, self.lag_place):
            self.untie(place, inf if place < self.creep_place + 2 else self.uptake_std)
        self.now.has_slid = False

    def untie(self, place: int, largest_std: float = inf) -> None:
        """Keep what is known of a state by itself, and no longer what ties it to others."""
        brakes = self.filter
        brakes.forget(place, brakes.x[place], min(sqrt(max(brakes.covariance[place][place], 0.0)), largest_std))

    def see_lag(self, before_mps: float, step_s: float) -> None:
        """See by how much v has changed in the last L: late readings are those of v(t - L) (15).

        The deceleration is remembered for half of L: its mean over L, wherever it changes steadily. No reading comes
        early: L below 0 says that the forces come late, and so does the estimate that follows them. In a slide their
        timing shows by itself (`ForceTiming`), and such an L is but what the model leaves out.
        """
        now, lag_s = self.now, self.filter.x[self.lag_place]
        slowing_mps2 = (before_mps - self.filter.x[self.wheelset_count]) / step_s
        now.slowed_mps2 += (slowing_mps2 - now.slowed_mps2) * step_s / max(0.5 * lag_s, -lag_s, step_s)
        now.lagged_mps2 = now.overdue_mps2 = 0.0
        if now.slow:
            return
        if lag_s > 0.0:
            now.lagged_mps2 = now.slowed_mps2
        elif abs(now.slowed_mps2) > LEAST_SLOWING_MPS2 and not now.has_slid:
            now.lagged_mps2 = slowing_mps2
            now.overdue_mps2 = slowing_mps2 - now.slowed_mps2

    def follow_lag(self) -> None:
        """See whether L shows: a wagon that does not brake loses so little speed in the meantime that it does not."""
        now = self.now
        shows = now.time_s - now.pressed_s < ROLLING_AGAIN_S
        if now.lag_shows and not shows:
            self.untie(self.lag_place)
            now.slowed_mps2 = now.lagged_mps2 = now.overdue_mps2 = 0.0
        now.lag_shows = shows

    def see_friction(self) -> None:
        """See which mu_b,i show: only while the pad presses and its wheel speed and every force are measured (17).

        A wheelset whose brake torque is unknown may bear any part of what brakes the wagon. So may one that stands, or
        did lately, and one whose slide protection works faster than its pressing force is told, or that is told late:
        then no friction shows.
        """
        now, known, settled, prompt = self.now, True, True, True
        for wheel in self.wheels:
            known = known and wheel.torque_is_told and not wheel.force_lost
            known = known and (self.literal or not self.stood_lately(wheel))
            settled = settled and wheel.unsettled == 0.0
            prompt = prompt and wheel.force.is_prompt
        in_step = self.literal or not now.consistency.is_out_of_step(now.time_s)  # (20) doubts nothing
        may_show = not now.slow and known and (settled or prompt) and in_step and self.knows_speed()
        now.shows = False
        for wheel in self.wheels:
            shows = may_show and wheel.turns and wheel.contact.is_settled(now.time_s) and not wheel.axle_speed_lost
            shows = shows and not (now.friction_is_doubted and wheel.force.value < RELEASING * wheel.force.most_lately)
            wheel.observed = 1.0 if shows else 0.0
            now.shows = now.shows or shows

    def knows_speed(self) -> bool:
        """Whether v is known well enough to tell who slides."""
        if not self.now.speed_lost:
            return True
        speed, quick_mps = self.wheelset_count, QUICK_SLIP * self.filter.x[self.wheelset_count]
        is_known: bool = self.filter.covariance[speed][speed] < quick_mps * quick_mps
        return is_known

    def follow_line(self) -> None:
        """See how fast d may change."""
        now, q = self.now, self.densities
        density = q.deceleration
        if now.pressed:
            density = q.deceleration_sliding if now.has_slid else q.deceleration_braking
            if now.time_s - now.applied_s < PULL_ENDS_S:
                density += now.pull_variance / PULL_CUT_S
        elif now.time_s - now.pressed_s < ROLLING_AGAIN_S:
            now.coasting_mps2 = self.filter.x[self.deceleration_place]
        if density > 0.0 and self.any_stands():
            density += LOCKED_LINE_DENSITY * self.speed_mps()
            if self.is_speed_doubtful():
                self.doubt_locked()
        elif density > 0.0 and self.is_speed_doubtful() and not self.line_is_unknown():
            density += q.deceleration_doubted
        now.deceleration_density = density

    def any_stands(self) -> bool:
        """Whether a wheelset is locked: only v tells of its rail, and of the line, so that it tells of neither."""
        any_stands = False
        for wheel in self.wheels:
            any_stands = any_stands or not wheel.turns
        return any_stands

    def doubt_locked(self) -> None:
        """Let mu_w of wheelsets that stand change quickly."""
        for wheel in self.wheels:
            if not wheel.turns:
                wheel.adhesion_density = LOCKED_ADHESION_DENSITY

    def calibrate_radii(self, step_s: float) -> None:
        """A wheelset long without brake and torque rolls: its speed then tells its radius.

        Released by its WSP in a slide it does not roll yet; one whose pressing force is lost may be braked.
        """
        now = self.now
        if now.time_s - now.pressed_s < ROLLING_AGAIN_S or now.speed_lost or now.wsp_active:
            return
        x, n = self.filter.x, self.wheelset_count
        for i in range(n):
            wheel = self.wheels[i]
            is_free = wheel.torque_is_told and not self.motor_acts(i)
            if is_free and not (wheel.force_lost or wheel.axle_speed_lost):
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
                wheel.work.rub(force_n * wheel.brake_radius_m * x[i] * step_s, x[self.friction_place + i])
            if slip > SLIDING_SLIP:
                wheel.work.slide(slip, distance_m)
            if wheel.unsettled != 0.0:
                as_pads_n = -wheel.wheel_torque_nm / (wheel.brake_radius_m * x[self.friction_place + i])
                wheel.checks.timing.press((force_n + as_pads_n) * step_s)
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
