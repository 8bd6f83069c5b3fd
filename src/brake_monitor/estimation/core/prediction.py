"""The core's prediction: inputs of a step, x and P after it, and what is followed from step to step."""

from math import exp, inf, sqrt

from brake_monitor.estimation.brake_work import CRAWLING_MPS, SLIDING_SLIP
from brake_monitor.estimation.core.regime_watch import ROLLING_AGAIN_S, UNKNOWN_ADHESION_STD, RegimeWatch
from brake_monitor.estimation.inputs.slide_protection import PERIOD_S
from brake_monitor.estimation.moment import SNAPSHOTS

TIMING_STD_S = 0.008  # of a pressing force against its wheel speed: gateways hand on as late as their cycle
SNAPSHOT_SPACING_S = 1.5
PAUSE_S = 1.0  # without any contact for longer, the next contact is a new brake application
LEAST_SLOWING_MPS2 = 0.2  # with less, late forces hardly show, and in minutes L takes up what the model leaves out


class Prediction(RegimeWatch):
    """The steps from one reading's time to the next one's."""

    __slots__ = ()

    def begins_application(self, time_s: float) -> bool:
        """Whether a pad has come into contact after a pause."""
        return self.now.pressed and time_s - self.now.pressed_s > PAUSE_S

    def take_inputs(self, time_s: float, step_s: float) -> None:
        """Take the inputs of the step that ends at time_s: means, values at both ends, and errors of the impulse."""
        now, braked, driven = self.now, False, False
        for wheel in self.wheels:
            force = wheel.force
            wheel.impulse_std_ns = force.impulse_std_until(time_s)
            wheel.pressing_force_n = force.use_until(time_s, step_s)
            braked = braked or wheel.pressing_force_n != 0.0 or wheel.impulse_std_ns != 0.0
            if self.has_torque_signal:
                wheel.wheel_torque_nm = wheel.torque.use_until(time_s, step_s)
                wheel.begin_torque_nm, wheel.end_torque_nm = wheel.end_torque_nm, wheel.torque.value
                driven = (
                    driven or wheel.wheel_torque_nm != 0.0 or wheel.begin_torque_nm != 0.0 or wheel.end_torque_nm != 0.0
                )
            wheel.begin_force_n = wheel.end_force_n
            wheel.end_force_n = force.value
            if wheel.slides != 0.0:
                mistimed_ns = TIMING_STD_S * (wheel.end_force_n - wheel.begin_force_n)
                wheel.impulse_std_ns = sqrt(wheel.impulse_std_ns * wheel.impulse_std_ns + mistimed_ns * mistimed_ns)
            braked = braked or wheel.begin_force_n != 0.0 or wheel.end_force_n != 0.0
            wheel.begin_load_n = wheel.wheel_load_n
            wheel.wheel_load_n = wheel.next_wheel_load_n
        now.braked, now.driven = braked, driven
        now.time_s = time_s
        if now.pressed:
            now.pressed_s = time_s

    def note_beginning(self) -> None:
        """Note L and the pads' mean friction, with their variances, as a brake application or the estimate begins."""
        applied, lag = self.now.application, self.lag_place
        applied.lag_s, applied.lag_variance = self.filter.x[lag], self.filter.covariance[lag][lag]
        applied.friction, applied.friction_variance = self.mean_friction(), self.mean_friction_variance()
        applied.strays_s = applied.impossible_s = inf
        applied.line_friction_std = applied.line_friction_share = 0.0
        applied.friction_is_doubted, applied.back_from = applied.pull_variance > 0.0, 0.0
        applied.followed = 0.0
        self.now.force_trend.begin()

    def predict(self, step_s: float) -> None:
        """Predict x and P over the step whose inputs were taken, and follow what depends on them."""
        self.enter_regime()
        now, before_mps = self.now, self.filter.x[self.wheelset_count]
        self.filter.predict(now, self.wheels, step_s)
        if now.lag_observable:
            self.follow_deceleration(before_mps, step_s)
        self.let_unmeasured_roll()
        if not (now.all_roll or now.near_standstill):
            self.draw_unknown_adhesion(step_s)
            self.let_silent_brakes_press()
        self.see_free_rolling(step_s)
        self.add_work(step_s)
        self.follow_forces(step_s)
        if not 0.0 <= now.time_s - now.protections_s < PERIOD_S:
            self.look_at_slide_protections()
        if now.time_s - now.saved_s[now.newest_snapshot] >= SNAPSHOT_SPACING_S:
            self.save_snapshot()

    def save_snapshot(self) -> None:
        """Save x and P in the place of the oldest snapshot."""
        now = self.now
        now.newest_snapshot = (now.newest_snapshot + 1) % SNAPSHOTS
        now.saved_s[now.newest_snapshot] = now.time_s
        self.filter.save(now.newest_snapshot)

    def let_unmeasured_roll(self) -> None:
        """Take a wheelset whose speed is not measured to roll: left to its equation, it would drift into a slide."""
        for i, wheel in enumerate(self.wheels):
            if wheel.axle_speed_lost and not self.now.near_standstill:
                rolling_radps = self.filter.x[self.wheelset_count] / wheel.radius.radius_m
                self.filter.forget(i, rolling_radps, SLIDING_SLIP * rolling_radps)

    def draw_unknown_adhesion(self, step_s: float) -> None:
        """Draw mu_w,i of a wheelset of unknown torque or speed to its adhesion demand, or to 0 if that is unknown.

        By its walk alone it would in minutes be beyond what any rail gives. Drawn so, its deviation settles at
        UNKNOWN_ADHESION_STD.
        """
        for i, wheel in enumerate(self.wheels):
            if not wheel.torque_known or wheel.axle_speed_lost:
                asked = self.adhesion_demand(i) if wheel.torque_known else 0.0
                drawn = step_s * wheel.adhesion_density / (2.0 * UNKNOWN_ADHESION_STD * UNKNOWN_ADHESION_STD)
                self.filter.scale(self.adhesion_place + i, exp(-drawn), asked)

    def let_silent_brakes_press(self) -> None:
        """Admit that mu_w,i of a silent brake has risen with the others': else these bear what it does, and friction.

        By its walk alone it would not follow a brake that comes on.
        """
        for i, wheel in enumerate(self.wheels):
            if not wheel.silent:
                continue
            most, before = self.largest_demand(), wheel.silent_adhesion
            if most > before:
                self.filter.widen(self.adhesion_place + i, most * most - before * before)
                wheel.silent_adhesion = most

    def largest_demand(self) -> float:
        """The largest mu_w,i that a brake asks for which is told to press; 0 if none is."""
        most = 0.0
        for i in range(self.wheelset_count):
            if not self.wheels[i].silent:
                most = max(most, self.adhesion_demand(i))
        return most

    def follow_deceleration(self, before_mps: float, step_s: float) -> None:
        """Follow the mean deceleration over the last L: a late reading is v(t - L) = v + L `speed_per_lag_mps2` (15).

        A low-pass of L / 2 gives it wherever the deceleration changes steadily. L below 0 says that the pressing forces
        come late by -L, and so does the estimate that follows them. In slides that does not count: there the forces'
        timing shows by itself (`ForceTiming`), and such an L would be but what the model leaves out.
        """
        now, lag_s = self.now, self.filter.x[self.lag_place]
        slowing_mps2 = (before_mps - self.filter.x[self.wheelset_count]) / step_s
        now.mean_deceleration_mps2 += (
            (slowing_mps2 - now.mean_deceleration_mps2) * step_s / max(0.5 * lag_s, -lag_s, step_s)
        )
        now.speed_per_lag_mps2 = now.missed_deceleration_mps2 = 0.0
        if now.near_standstill or now.speed_lost:
            return
        if lag_s > 0.0:
            now.speed_per_lag_mps2 = now.mean_deceleration_mps2
        elif abs(now.mean_deceleration_mps2) > LEAST_SLOWING_MPS2 and not now.has_slid:
            now.speed_per_lag_mps2 = slowing_mps2
            now.missed_deceleration_mps2 = slowing_mps2 - now.mean_deceleration_mps2

    def see_free_rolling(self, step_s: float) -> None:
        """Learn the radii of wheelsets that roll for certain, long without brake and torque: there r_W = v / omega.

        Released by its WSP in a slide it does not roll yet; one whose pressing force is lost may be braked. Where all
        wheelsets roll freely the line is what d is made of.
        """
        now = self.now
        if now.time_s - now.pressed_s < ROLLING_AGAIN_S or now.speed_lost or now.wsp_active:
            return
        x, n, all_free = self.filter.x, self.wheelset_count, not now.near_standstill
        for i, wheel in enumerate(self.wheels):
            is_free = self.is_left_free(i)
            all_free = all_free and is_free
            if is_free and not wheel.axle_speed_lost:
                wheel.radius.see_rolling(x[n], x[i], step_s)
        if all_free:
            d = self.deceleration_place
            now.line.see_rolling(now.distance_m, x[d], self.filter.covariance[d][d])

    def add_work(self, step_s: float) -> None:
        """Add up what brakes and wheels did in the step. What crawls may stand."""
        x, n = self.filter.x, self.wheelset_count
        speed_mps = x[n]
        distance_m = speed_mps * step_s if speed_mps > CRAWLING_MPS else 0.0
        self.now.distance_m += distance_m
        for i, wheel in enumerate(self.wheels):
            force_n, slip = wheel.pressing_force_n, self.slip(i)
            if force_n != 0.0 and x[i] * wheel.radius.radius_m > CRAWLING_MPS:
                wheel.work.rub(force_n * wheel.brake_radius_m * x[i] * step_s, x[self.friction_place + i])
            if slip > SLIDING_SLIP and not self.now.speed_lost:
                wheel.work.slide(slip, distance_m)

    def follow_forces(self, step_s: float) -> None:
        """Show the checks of pressing forces what acted on the wheelsets in the step."""
        for i, wheel in enumerate(self.wheels):
            if wheel.unsettled != 0.0:
                wheel.checks.timing.press(self.as_pads_n(i) * step_s)
            wheel.departure.see(step_s, wheel.pressing_force_n, wheel.friction_observable)
        if self.now.pressed and not self.now.has_slid:
            self.follow_trend(step_s)
        else:
            self.now.force_trend.rest()

    def follow_trend(self, step_s: float) -> None:
        """Show what the brakes gave in the step, and the speed after it, to what tells whether they follow the line."""
        per_friction_n, rolling_mps = 0.0, 0.0
        for i, wheel in enumerate(self.wheels):
            per_friction_n += wheel.brake_radius_m / wheel.wheel_radius_m * self.as_pads_n(i)
            rolling_mps += self.filter.x[i] * wheel.wheel_radius_m / self.wheelset_count
        self.now.force_trend.see(step_s, per_friction_n / self.now.mass_kg, rolling_mps, self.mean_friction())

    def as_pads_n(self, i: int) -> float:
        """The mean pressing force of wheelset i in the step, with that of pads which brake as its motor does."""
        wheel = self.wheels[i]
        pressing_force_n = wheel.pressing_force_n
        if self.has_torque_signal:
            friction = self.filter.x[self.friction_place + i]
            pressing_force_n -= wheel.wheel_torque_nm / (wheel.brake_radius_m * friction)
        return pressing_force_n

    def look_at_slide_protections(self) -> None:
        """Show slide protections what they do. A flag for all wheelsets is about the one that slid most as it rose."""
        now = self.now
        now.protections_s = now.time_s
        if not now.wsp_active:
            now.flagged = -1
        elif now.flagged < 0:
            now.flagged = 0
            for i in range(1, self.wheelset_count):
                if self.slip(i) > self.slip(now.flagged):
                    now.flagged = i
        for i, wheel in enumerate(self.wheels):
            flagged = i == now.flagged if self.one_wsp_signal else wheel.wsp_active
            if wheel.protection.see(now.time_s, self.slip(i), self.speed_mps(), wheel.force.value, flagged):
                wheel.work.wsp_actions += 1
