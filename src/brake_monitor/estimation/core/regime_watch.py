"""What the wagon does, and what follows: which states are observable now, which are held, and how fast they move."""

from math import exp, inf, log, sqrt

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.core.motor_watch import MotorWatch
from brake_monitor.estimation.doubts.consistency import DEAD, OUT_OF_STEP, SEIZES
from brake_monitor.estimation.estimate import SLOWEST_MPS
from brake_monitor.estimation.model.regime import STUCK_FRICTION_STD
from brake_monitor.estimation.moment import WheelsetMoment

UNSETTLED_S = 2.0  # after a slide
UNKNOWN_ADHESION_STD = 0.1  # of a wheelset of unknown torque or speed: about half of what full braking asks for
RELEASING = 0.8  # of the largest force lately: while it falls, its timing counts for more than a friction in doubt
QUICK_SIGMAS = 4.0  # of v, that are no slip yet: v is looked at hundreds of times in a braking
QUICK_SLIP = 0.01  # from here on adhesion may change within hundredths of a second
LOCKED_FRACTION = 0.03  # circumferential over vehicle speed of a wheelset that does not turn
UNTOLD_ADHESION_DENSITY = 5e-3  # 1/s, where one is locked or its force lost, and v contradicts the model: not d alone
LOCKED_LINE_DENSITY = 1e-5  # (m/s²)²/m, 10 per mille in a kilometre: no change of d contradicts anything then
UNKNOWN_TORQUE_DENSITY = 40.0  # (rad/s)²/s, for a wheelset whose equation cannot be used
UPTAKE_SLIPS = (0.015, 0.04, 0.10)  # where C_1, C_2 and C_3 hold; in between by the logarithm of slip
ROLLING_AGAIN_S = 3.0  # after the last contact of any pad, every wheelset has found back to rolling
PRESSES_N = 8000.0  # a brake that works shows with this force
TOGETHER_S = 0.3  # after the first of a wagon's brakes the others have come on, ...
SHOWN_S = 4.0  # ... and by then it shows, if it ever does, whether a brake works whose sensor says released
FOLLOWS_S = 8.0  # for so long, brakes that follow the line do so alike
PULL_CUT_S = 1.0  # so quickly traction may be cut ...
STEEP, STEEPER = 0.01, 0.05  # a line that is told to climb by more than so much has curves: by so much more than that
CURVES_DENSITY = 5e-5  # (m/s²)²/m, ... of 150 m, whose 7 per mille (Roeckl) come and go within 100 m
PULL_ENDS_S = 3.0  # ... within so long after the brake has come on


class RegimeWatch(MotorWatch):
    """Sets flags and densities before each step, by what is estimated so far."""

    __slots__ = ()

    def enter_regime(self) -> None:
        """Set, for the step to come, what wagon and wheelsets do, which states are observable, and all densities."""
        now, x, n = self.now, self.filter.x, self.wheelset_count
        speed_mps, rolled, rolls = x[n], now.all_roll, True
        now.near_standstill = near_standstill = speed_mps < SLOWEST_MPS
        quick = self.quick_slip_squared()
        self.set_known_torques()
        for i, wheel in enumerate(self.wheels):
            slip = 0.0 if near_standstill else 1.0 - x[i] * wheel.radius.radius_m / speed_mps
            known = wheel.torque_known and not wheel.axle_speed_lost
            wheel.slip_change_mps = 0.0
            if not (rolled and known and slip * slip <= quick):  # else it rolls as before: its flags stay
                rolls = self.enter_slip(i, slip, slip * slip > quick, known) and rolls
        now.all_roll = rolls
        if rolls and now.has_slid:
            self.end_slides()
        if now.pressed or now.any_friction_observable:
            self.set_friction_observability()
        if self.learns_lag:
            self.see_lag_observability()
        if now.pressed:
            now.stands_pressed = near_standstill
        elif now.time_s - now.pressed_s < ROLLING_AGAIN_S:  # of one that has stood, d is what pulls it away
            now.coasting_mps2 = 0.0 if now.stands_pressed else self.filter.x[self.deceleration_place]
        self.set_deceleration_density()
        if self.learns_torque_error:
            self.see_motors()

    def set_known_torques(self) -> None:
        """Set of which wheelsets the torques are known, and which brakes are `silent`.

        Those have not come on with the others: until it has shown whether they work, their torques are not known.
        """
        now, most_n = self.now, 0.0
        if now.pressed and TOGETHER_S <= now.time_s - now.application.began_s < SHOWN_S:
            for wheel in self.wheels:
                most_n = max(most_n, wheel.force.value)
        for wheel in self.wheels:
            wheel.silent = most_n >= PRESSES_N and not (wheel.contact.has_pressed or wheel.contact.is_idle)
            is_told = not (wheel.force_lost or wheel.silent or wheel.seizing.is_on)
            wheel.torque_known = wheel.motor_torque_known and is_told
            if not wheel.silent:
                wheel.silent_adhesion = 0.0

    def quick_slip_squared(self) -> float:
        """The square of the slip from which on adhesion may change quickly; what v may be off by is no slip."""
        if self.now.near_standstill:
            return QUICK_SLIP * QUICK_SLIP
        n = self.wheelset_count
        speed_mps, variance = self.filter.x[n], self.filter.covariance[n][n]
        unsure = QUICK_SIGMAS * QUICK_SIGMAS * variance / (speed_mps * speed_mps)
        return QUICK_SLIP * QUICK_SLIP + unsure

    def enter_slip(self, i: int, slip: float, quick: bool, known: bool) -> bool:
        """Set flags and densities of a wheelset; True if it rolls and has for UNSETTLED_S.

        `quick`: its slip is beyond creep; `known`: its torque and its speed are.
        """
        q, now, wheel, time_s = self.tuning, self.now, self.wheels[i], self.now.time_s
        if quick:
            wheel.slid_s = time_s
        known = not self.see_seizing(i, slip, quick, known) and known
        turns = slip < 1.0 - LOCKED_FRACTION
        settled = not time_s - wheel.slid_s < UNSETTLED_S
        wheel.turns = turns
        wheel.has_equation = 1.0 if turns and known else 0.0
        wheel.slides = wheel.has_equation if quick and slip > SLIDING_SLIP else 0.0
        wheel.rolls = 1.0 if turns and not quick else 0.0
        wheel.omega_density = q.omega if turns and known else UNKNOWN_TORQUE_DENSITY
        wheel.adhesion_density = q.adhesion_sliding if quick or not known else q.adhesion_own
        wheel.unsettled = 0.0 if settled else 1.0
        wheel.unseen_std_ns = 0.0 if settled else wheel.force.unseen_std_until(time_s)
        creeps = quick and slip > 0.0 and wheel.has_equation != 0.0 and q.uptake_std > 0.0  # else no C_k are learned
        now.has_slid = now.has_slid or creeps or wheel.slides != 0.0
        wheel.force_effect_observable = wheel.unsettled if now.has_slid else 0.0
        self.enter_creep(wheel, slip, creeps)
        self.see_lock(i)
        now.braked = now.braked or wheel.unseen_std_ns != 0.0
        return known and turns and settled

    def see_seizing(self, i: int, slip: float, quick: bool, known: bool) -> bool:
        """Whether a wheelset seizes: then its torque is unknown, and with it mu_w,i, until it rolls. (20) sees none."""
        wheel, place, time_s = self.wheels[i], self.adhesion_place + i, self.now.time_s
        if not quick or self.tuning.literal:
            wheel.seizing.rolls()
        elif known:  # else it does already, or nothing shows it
            std = sqrt(self.filter.covariance[place][place])
            if wheel.seizing.see(time_s, slip, self.filter.x[place], std):
                wheel.torque_known = False
                self.filter.forget(place, 0.0, UNKNOWN_ADHESION_STD)
        if wheel.seizing.is_on:
            self.now.consistency.raised_s[SEIZES] = time_s
        return wheel.seizing.is_on

    def see_lock(self, i: int) -> None:
        """Note whether a wheelset is locked, and let its friction walk while its pads are, or were lately, stuck.

        Pads that do not slide rub otherwise, which nothing shows, and take a while to rub as before once they slide.
        """
        wheel, time_s, place = self.wheels[i], self.now.time_s, self.friction_place + i
        if not wheel.turns:
            wheel.locked_s = time_s
        moves = self.locked_lately(wheel) and wheel.contact.pressed
        variance = self.filter.covariance[place][place]
        wheel.stuck_lately = 1.0 if moves and variance < STUCK_FRICTION_STD * STUCK_FRICTION_STD else 0.0

    def locked_lately(self, wheel: WheelsetMoment) -> bool:
        """Whether a wheelset is locked, or was within UNSETTLED_S: what turns it then tells nothing of its pads.

        To the letter of (20) this does not count.
        """
        return not self.tuning.literal and self.now.time_s - wheel.locked_s < UNSETTLED_S

    def enter_creep(self, wheel: WheelsetMoment, slip: float, creeps: bool) -> None:
        """Set the weights of C_k by the slip of a wheelset, and by how much its slip speed has changed since last time.

        Adhesion falls less and less with slip speed, to 1/e: dmu_w/dw = - B mu_w e^{-B w}. With a rate of B throughout,
        learned at small slip, it would fall to nothing on the way to a lock. There it is A mu_0 (Polach: A about 0.4).
        """
        slip_mps = slip * self.speed_mps()
        still_falls = exp(-max(self.filter.x[self.decay_place] * slip_mps, 0.0))
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
        """All wheelsets roll again: keep what slides taught of E, B and C_k, without covariances to other states."""
        self.untie(self.force_effect_place)
        self.untie(self.decay_place)
        for place in range(self.uptake_place, self.lag_place):
            self.untie(place, self.tuning.uptake_std)
        self.now.has_slid = False

    def untie(self, place: int, largest_std: float = inf) -> None:
        """Keep value and deviation (up to this one) of a state, and drop its covariances to other states."""
        brakes = self.filter
        brakes.forget(place, brakes.x[place], min(sqrt(max(brakes.covariance[place][place], 0.0)), largest_std))

    def see_lag_observability(self) -> None:
        """Set whether L is observable: within L, a wagon that does not brake loses too little speed for it."""
        now = self.now
        shows = now.time_s - now.pressed_s < ROLLING_AGAIN_S
        if now.lag_observable and not shows:
            self.untie(self.lag_place)
            now.mean_deceleration_mps2 = now.speed_per_lag_mps2 = now.missed_deceleration_mps2 = 0.0
        now.lag_observable = shows
        if now.has_slid:
            self.restore_strayed_lag()

    def restore_strayed_lag(self) -> None:
        """Set an L that has fallen below 0 in a slide back to what was known of it as the brake was put on.

        An L below 0, of late pressing forces, is not observable in slides (`follow_deceleration`). One that has strayed
        there would stay, and `is_speed_doubtful` with it, until the slides end.
        """
        place, applied = self.lag_place, self.now.application
        is_hidden = self.filter.x[place] < min(applied.lag_s, 0.0)
        if is_hidden and (self.has_lag_strayed() or self.is_lag_at_limit()):
            self.filter.forget(place, applied.lag_s, sqrt(applied.lag_variance))

    def set_friction_observability(self) -> None:
        """Set which mu_b,i are observable (17): those of pads that press and whose wheel speed is measured.

        None is while any wheelset may bear an unknown part of what brakes the wagon: its torque is unknown, it is or
        was lately locked, its slide protection works faster than its force is told, or forces are told out of step or
        repeat themselves.
        """
        now, known, settled, prompt = self.now, True, True, True
        for wheel in self.wheels:
            known = known and wheel.torque_known and not self.locked_lately(wheel)
            settled = settled and wheel.unsettled == 0.0
            prompt = prompt and wheel.force.is_prompt
        told = self.tuning.literal or not (  # (20) doubts nothing
            now.consistency.is_on(OUT_OF_STEP, now.time_s) or now.consistency.is_on(DEAD, now.time_s)
        )
        may_show = not now.near_standstill and known and (settled or prompt) and told and self.knows_speed()
        now.any_friction_observable = False
        releases_mislead = now.application.friction_is_doubted and not (now.has_slid and self.knows_friction())
        for wheel in self.wheels:
            shows = may_show and wheel.turns and wheel.contact.is_settled(now.time_s) and not wheel.axle_speed_lost
            shows = shows and not (releases_mislead and wheel.force.value < RELEASING * wheel.force.most_lately)
            wheel.friction_observable = 1.0 if shows else 0.0
            now.any_friction_observable = now.any_friction_observable or shows

    def knows_speed(self) -> bool:
        """Whether v is known well enough to tell which wheelsets slide."""
        if not self.now.speed_lost:
            return True
        speed, quick_mps = self.wheelset_count, QUICK_SLIP * self.filter.x[self.wheelset_count]
        return self.filter.covariance[speed][speed] < quick_mps * quick_mps

    def set_deceleration_density(self) -> None:
        """Set how fast d may change, and mu_w of wheelsets of which only v tells as well."""
        now, q = self.now, self.tuning
        density = q.deceleration
        if now.pressed:
            density = q.deceleration_sliding if now.has_slid else q.deceleration_braking
            if now.time_s - now.application.began_s < PULL_ENDS_S:
                density += now.application.pull_variance / PULL_CUT_S
        any_locked = any_lost = any_seizes = False
        for wheel in self.wheels:
            any_locked = any_locked or not wheel.turns
            any_lost = any_lost or wheel.force_lost
            any_seizes = any_seizes or wheel.seizing.is_on
        if any_seizes:  # a coupler takes that up at once
            density = max(density, q.deceleration_sliding)
        if density > 0.0 and (any_locked or any_lost):  # their adhesion and d show in v alone, which tells neither
            if any_locked:
                density += LOCKED_LINE_DENSITY * self.speed_mps()
            if self.is_speed_doubtful():
                for wheel in self.wheels:
                    if wheel.force_lost or not wheel.turns:
                        wheel.adhesion_density = UNTOLD_ADHESION_DENSITY
        elif (
            density > 0.0
            and self.is_speed_doubtful()
            and not (self.is_deceleration_unknown() or self.friction_comes_back())
        ):
            density += q.deceleration_doubted
        now.following_density, per_metre = 0.0, now.line.more
        if q.friction_doubted > 0.0:
            follows_mps3, steeper = now.force_trend.hidden_rate_mps3, max(abs(now.gradient) - STEEP, 0.0) / STEEPER
            now.following_density = FOLLOWS_S * follows_mps3 * follows_mps3
            per_metre += CURVES_DENSITY * steeper * steeper
        now.deceleration_density = density + now.following_density + per_metre * self.speed_mps()
