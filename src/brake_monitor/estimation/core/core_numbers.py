"""The estimator's numbers, and what follows from them at once.

`CoreNumbers` and its members hold nothing but numbers, vectors of numbers, and objects of these. So the methods of
`Core` run as they stand, sample by sample, and compiled, over thousands of samples at once (`compiled_core`).
"""

from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass
from math import inf

from brake_monitor.estimation.estimate import MOTOR_ACTS_MPS2, slip_of
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.estimation.kalman.foretold import Foretold
from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.model.wheelset import braking_ratio, motor_demand
from brake_monitor.estimation.moment import ChannelState, Readings, WagonMoment, WheelsetMoment

STRAYED_SIGMAS = 2.0  # of L, as it was known when the brake application began
LINE_CHANGE_MPS2 = 0.05  # standard deviation of what a line changes by as a brake or a motor comes on: 5 per mille


@dataclass(slots=True)
class CoreNumbers:
    """The numbers of one estimator."""

    now: WagonMoment
    wheelset_count: int  # N
    friction_place: int  # where mu_b begins in x ...
    adhesion_place: int  # ... and mu_w
    deceleration_place: int  # where d is
    force_effect_place: int  # where E is, ...
    decay_place: int  # ... B, ...
    uptake_place: int  # ... the first C_k; they end ...
    lag_place: int  # ... where L is
    torque_error_place: int  # where K is, if torques are mapped
    wheels: Sequence[WheelsetMoment]  # N
    readings: Sequence[Readings]  # N + 1: of the wheelsets' speeds and the vehicle's
    channels: Sequence[ChannelState]  # one for each mapped signal
    load_n: MutableSequence[float]  # what each load signal says; NaN before it has said anything
    tuning: Tuning
    foretold: Foretold
    largest_deceleration_mps2: float
    one_wsp_signal: bool  # at most one is mapped: it stands for all wheelsets
    has_torque_signal: bool  # any motor's torque is mapped
    learns_lag: bool  # L is a state
    learns_torque_error: bool  # K is
    filter: BrakeFilter  # or its numbers

    def speed_mps(self) -> float:
        """The estimated vehicle speed v."""
        return self.filter.x[self.wheelset_count]

    def motor_acts(self, i: int) -> bool:
        """Whether the motor of wheelset i brakes or drives."""
        wheel = self.wheels[i]
        least_n = MOTOR_ACTS_MPS2 / GRAVITY_MPS2 * wheel.next_wheel_load_n
        return abs(wheel.torque.value) >= least_n * wheel.wheel_radius_m

    def is_left_free(self, i: int) -> bool:
        """Whether no motor acts on wheelset i, and, by its pressing force, no pad: that much is known."""
        wheel = self.wheels[i]
        return wheel.motor_torque_known and not self.motor_acts(i) and not wheel.force_lost

    def adhesion_demand(self, i: int) -> float:
        """The mu_w,i that brake and motor of wheelset i ask for if it rolls."""
        wheel, load_n = self.wheels[i], self.wheels[i].next_wheel_load_n
        by_brake = self.filter.x[self.friction_place + i] * braking_ratio(wheel, wheel.end_force_n, load_n)
        by_motor = motor_demand(wheel, wheel.end_torque_nm, load_n)
        if self.learns_torque_error:
            by_motor *= 1.0 + self.filter.x[self.torque_error_place]
        return by_brake + by_motor

    def slip(self, i: int) -> float:
        """(v - omega r_W) / v of wheelset i by its calibrated radius; 0 near standstill and while its speed is lost."""
        x, wheel = self.filter.x, self.wheels[i]
        return 0.0 if wheel.axle_speed_lost else slip_of(x[i], wheel.radius.radius_m, x[self.wheelset_count])

    def innovation(self, index: int, value: float, variance: float) -> tuple[float, float]:
        """The residual of a reading (15) and its variance S; a reading of the vehicle's speed is v as it was L ago."""
        x, covariance, lag = self.filter.x, self.filter.covariance, self.lag_place
        residual, total_variance = value - x[index], covariance[index][index] + variance  # S = H P H' + R
        weight = self.now.speed_per_lag_mps2
        if index == self.wheelset_count and weight != 0.0:
            residual -= weight * x[lag]
            total_variance += weight * (2.0 * covariance[index][lag] + weight * covariance[lag][lag])
        return residual, total_variance

    def is_speed_doubtful(self) -> bool:
        """Whether the vehicle's speed contradicts the model, or fits it only with an L that has strayed.

        A gradient that changes as the brake is put on looks like a lag. But a sensor's lag stays what it was: where L
        leaves what earlier brake applications have taught of it, the gradient has more likely changed.
        """
        now = self.now
        if now.consistency.bias.is_doubtful or not now.lag_observable:
            return now.consistency.bias.is_doubtful
        return self.has_lag_strayed()

    def has_lag_strayed(self) -> bool:
        """Whether L has left what was known of it as the brake application began."""
        applied = self.now.application
        strayed_s = self.filter.x[self.lag_place] - applied.lag_s
        return strayed_s * strayed_s > STRAYED_SIGMAS * STRAYED_SIGMAS * applied.lag_variance

    def is_lag_at_limit(self) -> bool:
        """Whether L is at a bound: no possible lag explains how speeds and forces follow each other."""
        brakes, lag = self.filter, self.lag_place
        return not brakes.least[lag] < brakes.x[lag] < brakes.most[lag]

    def friction_comes_back(self) -> bool:
        """Whether what contradicts the speed is taken for friction that comes back to what it was, and not for d."""
        return self.now.pressed and self.now.application.back_from != 0.0

    def is_deceleration_unknown(self) -> bool:
        """Whether d's deviation has reached the largest d that is explained: a lasting doubt widens it no further."""
        place = self.deceleration_place
        return self.filter.covariance[place][place] >= self.largest_deceleration_mps2**2

    def mean_friction(self) -> float:
        """The mean friction of all pads."""
        friction = 0.0
        for i in range(self.wheelset_count):
            friction += self.filter.x[self.friction_place + i]
        return friction / self.wheelset_count

    def mean_friction_variance(self) -> float:
        """The variance of `mean_friction`."""
        n, variance = self.wheelset_count, 0.0
        for i in range(n):
            for j in range(n):
                variance += self.filter.covariance[self.friction_place + i][self.friction_place + j]
        return variance / (n * n)

    def knows_friction(self) -> bool:
        """Whether the pads' mean friction is known: in slides, where forces fall and rise, it is learned of both then.

        Of rising forces alone it would come out too low, by what forces are late.
        """
        known_std = self.tuning.converged_friction_std
        return self.mean_friction_variance() < known_std * known_std

    def fastest_mps(self) -> float:
        """The largest circumferential speed of the wheelsets that are not locked; 0 if all are."""
        x, fastest_mps = self.filter.x, 0.0
        for i, wheel in enumerate(self.wheels):
            if wheel.turns:
                fastest_mps = max(fastest_mps, x[i] * wheel.radius.radius_m)
        return fastest_mps

    def any_wheel_speed_is_known(self) -> bool:
        """Whether wheel speeds have come since the filter started, from all wheelsets that give any."""
        is_known = False
        for i in range(self.wheelset_count):
            if self.readings[i].fused_s > -inf:
                is_known = True
            elif not self.wheels[i].axle_speed_lost:
                return False
        return is_known

    def any_pressed(self) -> bool:
        """Whether any pad of the wagon touches its disc."""
        pressed = False
        for wheel in self.wheels:
            pressed = pressed or wheel.contact.pressed
        return pressed
