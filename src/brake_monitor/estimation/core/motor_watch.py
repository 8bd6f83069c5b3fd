"""By how much motors err, K: when it may change, and what it may not explain.

As motors come on, the wagon slows down by 1 + K times what their torque says, or gains as much speed, at once: so K is
learned, and friction of the pads that take over is not taken for it. A line that changes in the same seconds looks
alike; by more than K can be, it is the line.
"""

from brake_monitor.estimation.core.core_numbers import LINE_CHANGE_MPS2, CoreNumbers
from brake_monitor.estimation.model.wheelset import motor_demand

REMEMBERED = 0.8  # of K, as motors begin to drive or to brake: they err otherwise then ...
DENSITY = 1e-5  # 1/s, ... and otherwise at another speed and heat
REST_S = 1.0  # without any torque for longer, they begin anew
STRAYED_SIGMAS = 2.0  # of K, as it is known beforehand
LEAST_PER_ERROR_MPS2 = 0.01  # of motors that hardly act any more, to divide by


class MotorWatch(CoreNumbers):
    """Watches motors whose torque is told."""

    __slots__ = ()

    def see_motors(self) -> None:
        """Before a step: let K walk while motors act, widen it as they begin, and hold it to what it can be."""
        now, place, torque_nm, act = self.now, self.torque_error_place, 0.0, False
        for i, wheel in enumerate(self.wheels):
            torque_nm += wheel.torque.value
            act = act or self.motor_acts(i)
        now.torque_error_density = 0.0
        if not act:
            if not 0.0 <= now.time_s - now.motors_acted_s <= REST_S:  # or the clock was set back
                now.motor_direction = 0.0
            return
        now.motors_acted_s = now.time_s
        direction = 1.0 if torque_nm > 0.0 else -1.0
        if direction != now.motor_direction:
            now.motor_direction = direction
            self.renew_torque_error()
        elif self.filter.covariance[place][place] < self.tuning.torque_error_std * self.tuning.torque_error_std:
            now.torque_error_density = DENSITY
        if abs(self.filter.x[place]) > STRAYED_SIGMAS * self.tuning.torque_error_std:
            self.give_to_line()

    def renew_torque_error(self) -> None:
        """Draw K to 0 and its variance to that beforehand as motors begin to drive or to brake.

        Without end, and always by what came last, it would stray beyond what motors err.
        """
        brakes, place, prior = self.filter, self.torque_error_place, self.tuning.torque_error_std
        share = REMEMBERED * REMEMBERED
        brakes.scale(place, REMEMBERED, 0.0)
        brakes.widen(place, (1.0 - share) * prior * prior)

    def give_to_line(self) -> None:
        """Let d take of K what is more likely the line's, with the mu_w that the motors then have asked for.

        Both may be off so that v̇ stays as it is, d by what lines change by; what K is beforehand says the rest.
        """
        now, brakes, place, per_error_mps2 = self.now, self.filter, self.torque_error_place, 0.0
        for k in range(len(brakes.direction)):
            brakes.direction[k] = 0.0
        brakes.direction[place] = 1.0
        for i, wheel in enumerate(self.wheels):
            asked = motor_demand(wheel, wheel.torque.value, wheel.wheel_load_n)
            brakes.direction[self.adhesion_place + i] = asked
            per_error_mps2 += asked * wheel.wheel_load_n / now.mass_kg
        brakes.direction[self.deceleration_place] = -per_error_mps2
        std = LINE_CHANGE_MPS2 / max(abs(per_error_mps2), LEAST_PER_ERROR_MPS2)
        brakes.admit_along(std * std)
        brakes.learn(place, 0.0, self.tuning.torque_error_std * self.tuning.torque_error_std)
