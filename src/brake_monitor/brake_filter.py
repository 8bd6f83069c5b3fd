"""The filter of one wagon: state and covariance, carried from reading to reading. Knows no clock and no sensors."""

from functools import lru_cache, partial
from math import sqrt
from typing import NamedTuple

import numpy as np

from brake_monitor import ekf
from brake_monitor.regime import Regime, density, free_states
from brake_monitor.tape import Tape
from brake_monitor.tuning import Tuning
from brake_monitor.wagon import GRAVITY_MPS2, Array, Inputs, Wagon

SURPRISE_NIS = 10.0  # beyond about three sigma of a wheel speed its adhesion is taken to have jumped
FRICTION_RANGE = (0.02, 1.0)
ADHESION_RANGE = (-0.8, 0.8)
SHARE_MEMORY_S = 0.01  # how long the share of a changing brake torque that the rail takes up stays the same
SHORTEST_STEP_S = 0.005
LEAST_JUMP_S = 0.01  # wheel speeds in frames that a gateway bunches are not as close as their times
IMPULSE_DOUBT = 2.0  # variance, as a multiple of the estimated error's square
REGIMES_KEPT = 256  # few of the possible ones occur


class PadForces(NamedTuple):
    """What the pressing forces did over a step beside their mean, arrays of shape (N,)."""

    begin_n: Array  # at the end of the last step: mu_w agrees with them
    end_n: Array  # at the end of this one
    impulse_std_ns: Array  # how far ∫F dt over the step may be off


class BrakeFilter:
    """x and P of (13) for one wagon, with the steps that the estimator composes."""

    def __init__(self, wagon: Wagon, tuning: Tuning, friction: float, friction_std: float) -> None:
        self.wagon = wagon
        self.layout = wagon.layout
        self.tuning = tuning
        self.x = np.zeros(self.layout.size)
        self.covariance = np.zeros((self.layout.size, self.layout.size))
        self._density = lru_cache(REGIMES_KEPT)(partial(density, tuning=tuning, layout=self.layout))
        self._free = lru_cache(REGIMES_KEPT)(partial(free_states, layout=self.layout))
        self._prior_friction = (friction, friction_std)
        self._lower, self._upper = self._physical_range()
        self._own = np.eye(self.layout.wheelset_count)
        self._wheels = np.arange(self.layout.wheelset_count)
        self.tape: Tape | None = None  # where to note what is done, if anyone wants to know
        self.reset()

    def _physical_range(self) -> tuple[Array, Array]:
        s = self.layout
        lower, upper = np.full(s.size, -np.inf), np.full(s.size, np.inf)
        lower[s.kinematic] = 0.0
        lower[s.friction], upper[s.friction] = FRICTION_RANGE
        lower[s.adhesion], upper[s.adhesion] = ADHESION_RANGE
        return lower, upper

    def reset(self) -> None:
        """Back to what is known before any frame."""
        self.forget(slice(None), 0.0, 0.0)
        self.forget_parameters()

    def forget_parameters(self) -> None:
        """Nominal friction, no adhesion in use, nothing unmodelled, each with what is known of it beforehand."""
        s, tuning = self.layout, self.tuning
        friction, friction_std = self._prior_friction
        self.forget(s.friction, friction, 0.0)
        self.spread(s.friction, friction_std**2, tuning.friction_own_std**2)
        self.forget(s.adhesion, 0.0, 0.0)
        self.spread(s.adhesion, 0.0, tuning.adhesion_std**2)
        self.forget(s.deceleration, 0.0, tuning.deceleration_std)

    def spread(self, block: slice, common: float, own: float) -> None:
        """Add variance that the wheelsets share and variance that each has for itself."""
        noise = np.zeros_like(self.covariance)
        noise[block, block] = common + own * self._own
        self._admit(noise)

    def _admit(self, noise: Array) -> None:
        """Take the state to have moved by unknown amounts of this covariance, shape (n, n)."""
        self.covariance += noise
        if self.tape is not None:
            self.tape.step(np.zeros_like(noise), noise)

    def forget(self, place: int | slice, value: float, std: float) -> None:
        """Give states a new value that is unrelated to everything else."""
        self.x[place] = value
        self.covariance[place, :] = 0.0
        self.covariance[:, place] = 0.0
        indices = np.arange(self.layout.size)[place]
        self.covariance[indices, indices] = std**2
        if self.tape is not None:
            change, noise = np.zeros_like(self.covariance), np.zeros_like(self.covariance)
            change[indices, indices] = -1.0
            noise[indices, indices] = std**2
            self.tape.step(change, noise)

    def predict(self, step_s: float, u: Inputs, regime: Regime, forces: PadForces) -> None:
        """Carry the estimate over a step with the mean inputs `u`."""
        q = self._density(regime)
        if regime.slow:
            self._admit(q * step_s)
            return
        s, rolls = self.layout, np.logical_and(regime.turning, np.logical_not(regime.quick))
        asked_per_n = self._asked_adhesion_per_n(u)
        follow_per_n = np.zeros_like(asked_per_n) if self.tuning.literal else asked_per_n * rolls
        follow_mean = follow_per_n * (u.pressing_force_n - forces.begin_n)
        follow = follow_per_n * (forces.end_n - forces.begin_n)
        meanwhile = self.x.copy()
        meanwhile[s.adhesion] += follow_mean * self.x[s.friction]
        derivative, jacobian = self.wagon.linearise(meanwhile, u)
        noise = q * step_s if self.tuning.literal else ekf.process_noise(jacobian, q, step_s)
        step = jacobian  # nobody else needs it: reuse it for F - I
        step *= step_s
        if not self.tuning.literal:
            asked = asked_per_n * (forces.end_n - forces.begin_n)
            noise += self._torque_doubt(asked * regime.unsettled, u, forces, step_s)
            step[s.kinematic, s.friction] += step[s.kinematic, s.adhesion] * follow_mean
            step[s.adhesion.start + self._wheels, s.friction.start + self._wheels] = follow
            self.x[s.adhesion] += follow * self.x[s.friction]
        self.x += derivative * step_s
        ekf.predict(self.covariance, step, noise)
        if self.tape is not None:
            self.tape.step(step, noise)

    def _asked_adhesion_per_n(self, u: Inputs) -> Array:
        """mu_w,i that the brake asks for, per newton of pressing force and unit of friction, shape (N,).

        mu_w,i of a rolling wheelset follows its brake torque. Without this, a brake application looks like a random
        walk of mu_w to the filter: it lags, and puts the difference into mu_b. For the same reason the mean force of
        a step has to meet the mu_w of its middle, not of its beginning. A sliding wheelset turns a change of brake
        torque into rotation instead.
        """
        wagon = self.wagon
        load_torque_nm = u.mass_kg * GRAVITY_MPS2 * wagon.static_load_share * wagon.wheel_radius_m
        per_n: Array = wagon.brake_radius_m / load_torque_nm
        return per_n

    def _torque_doubt(self, asked: Array, u: Inputs, forces: PadForces, step_s: float) -> Array:
        """Noise from a changing brake torque, shape (n, n).

        Between rolling and sliding nobody knows which share of it the rail takes up, and the force is only known at
        its samples. Left out, both would pull mu_b down, as errors of a regressor do.
        """
        s, wagon = self.layout, self.wagon
        share_std = asked * self.x[s.friction]
        omega_std = wagon.brake_radius_m * self.x[s.friction] * forces.impulse_std_ns / wagon.wheelset_inertia_kgm2
        doubt = np.zeros(s.size)
        doubt[s.adhesion] = share_std * share_std * (SHARE_MEMORY_S / max(step_s, SHORTEST_STEP_S))
        doubt[s.omega] = IMPULSE_DOUBT * omega_std * omega_std * u.turning
        return np.diag(doubt)

    def innovation(self, index: int, value: float, variance: float) -> ekf.Innovation:
        """Compare a reading of the measured state `index` with the prediction."""
        return ekf.innovation(self.x, self.covariance, index, value, variance)

    def fuse(self, index: int, seen: ekf.Innovation, regime: Regime) -> None:
        """Correct the estimate by what was seen, within what is physical."""
        predicted, measurement_variance = self.x.copy(), seen.variance - float(self.covariance[index, index])
        ekf.update(self.x, self.covariance, index, seen, self._free(regime))
        self.confine(self.x)
        if self.tape is not None:
            self.tape.reading(index, seen.residual, measurement_variance, self.x - predicted)

    def confine(self, x: Array) -> None:
        """Put a state back to what is physical, in place."""
        np.maximum(x, self._lower, out=x)
        np.minimum(x, self._upper, out=x)

    def admit_adhesion_jump(self, wheelset: int, residual: float, since_s: float, u: Inputs) -> None:
        """Widen the adhesion of a wheelset whose speed surprises, as if it had jumped since its last reading."""
        s = self.layout
        place = s.adhesion.start + wheelset
        per_adhesion = self.wagon.jacobian(self.x, u)[wheelset, place] * max(since_s, LEAST_JUMP_S)
        if per_adhesion <= 0.0:
            return
        direction = np.zeros(s.size)
        direction[wheelset] = per_adhesion
        direction[place] = 1.0
        self._admit((residual / per_adhesion) ** 2 * (direction[:, None] * direction))

    def admit_deceleration_jump(self) -> None:
        """Widen d as a brake application begins: in a train the coupler force begins with it."""
        noise = np.zeros_like(self.covariance)
        noise[self.layout.deceleration, self.layout.deceleration] = self.tuning.deceleration_onset_std**2
        self._admit(noise)

    def is_sound(self) -> bool:
        """Whether state and covariance are finite and possible."""
        return ekf.is_sound(self.x, self.covariance)

    def std(self, place: int) -> float:
        """Standard deviation of one state."""
        return sqrt(max(float(self.covariance[place, place]), 0.0))
