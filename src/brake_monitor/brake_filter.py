"""The filter of one wagon: state and covariance, carried from reading to reading. Knows no clock and no sensors."""

from functools import lru_cache, partial
from math import sqrt
from typing import NamedTuple

import numpy as np

from brake_monitor import ekf
from brake_monitor.regime import Regime, Terms, terms
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
    """What the N pressing forces did over a step beside their mean."""

    begin_n: list[float]  # at the end of the last step: mu_w agrees with them
    end_n: list[float]  # at the end of this one
    impulse_std_ns: list[float]  # how far ∫F dt over the step may be off


class PadStep(NamedTuple):
    """What the pressing force of one wheelset does to its adhesion over a step."""

    friction: float  # mu_b,i
    follows_mean: float  # change of mu_w,i until the middle of the step, per unit of mu_b,i
    follows: float  # and until its end
    share_std: float  # of the change of mu_w,i, where the rail may take up any share of the torque
    omega_std: float  # rad/s, by which the force's impulse may be off


class BrakeFilter:
    """x and P of (13) for one wagon, with the steps that the estimator composes."""

    def __init__(self, wagon: Wagon, tuning: Tuning, friction: float, friction_std: float) -> None:
        self.wagon = wagon
        self.layout = wagon.layout
        self.tuning = tuning
        self.x = np.zeros(self.layout.size)
        self.covariance = np.zeros((self.layout.size, self.layout.size))
        self._terms = lru_cache(REGIMES_KEPT)(partial(terms, tuning=tuning, layout=self.layout))
        self._prior_friction = (friction, friction_std)
        self._lower, self._upper = self._physical_range()
        self._own = np.eye(self.layout.wheelset_count)
        load_nm_per_kg = GRAVITY_MPS2 * wagon.static_load_share * wagon.wheel_radius_m
        self._asked_kg_per_n: list[float] = (wagon.brake_radius_m / load_nm_per_kg).tolist()
        self._spin_per_impulse: list[float] = (wagon.brake_radius_m / wagon.wheelset_inertia_kgm2).tolist()
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

    def renew_friction(self, common: float, own: float) -> None:
        """Doubt friction by these variances as pads are put on again, but no pad more than pads differ.

        How far the friction of one pad lies from the others' hardly shows while the wheelsets roll: left alone, its
        variance would grow for as long as the program runs, though pads of a kind do not drift apart for ever.
        """
        s, n = self.layout, self.layout.wheelset_count
        block, prior = self.covariance[s.friction, s.friction], self.tuning.friction_own_std**2
        known = (float(block.trace()) - n * float(block.mean())) / (n - 1) if n > 1 else prior
        step, noise = np.zeros_like(self.covariance), np.zeros_like(self.covariance)
        if known > prior:
            step[s.friction, s.friction] = (sqrt(prior / known) - 1.0) * (self._own - 1.0 / n)
        noise[s.friction, s.friction] = common + min(own, max(prior - known, 0.0)) * self._own
        self.x += step @ self.x
        ekf.predict(self.covariance, step, noise)
        if self.tape is not None:
            self.tape.step(step, noise)

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
        held = self._terms(regime)
        if regime.slow:
            self._admit(held.density * step_s)
            return
        if self.tuning.literal:
            derivative, jacobian = self.wagon.linearise(self.x, u)
            step, noise = jacobian * step_s, held.density * step_s
        else:
            derivative, step, noise = self._coupled_step(step_s, u, held, forces)
        derivative *= step_s
        self.x += derivative
        ekf.predict(self.covariance, step, noise)
        if self.tape is not None:
            self.tape.step(step, noise)

    def _coupled_step(self, step_s: float, u: Inputs, held: Terms, forces: PadForces) -> tuple[Array, Array, Array]:
        """Derivative of x, F - I and the noise of a step in which mu_w follows the brake torque of who rolls."""
        s, x = self.layout, self.x
        pads = self._pads(u, held, forces)
        meanwhile = x.copy()
        for i, pad in enumerate(pads):
            meanwhile[s.adhesion.start + i] += pad.follows_mean * pad.friction
        derivative, jacobian = self.wagon.linearise(meanwhile, u)
        noise = ekf.process_noise(jacobian, held.density, step_s)
        step = jacobian  # nobody else needs it: reuse it for F - I
        step *= step_s
        step[s.kinematic, s.friction] += step[s.kinematic, s.adhesion] * [pad.follows_mean for pad in pads]
        for i, pad in enumerate(pads):
            friction, adhesion = s.friction.start + i, s.adhesion.start + i
            step[adhesion, friction] = pad.follows
            x[adhesion] += pad.follows * pad.friction
            noise[adhesion, adhesion] += pad.share_std**2 * (SHARE_MEMORY_S / max(step_s, SHORTEST_STEP_S))
            noise[i, i] += IMPULSE_DOUBT * pad.omega_std**2
        return derivative, step, noise

    def _pads(self, u: Inputs, held: Terms, forces: PadForces) -> list[PadStep]:
        """What the pressing force of each wheelset does to its mu_w over a step.

        mu_w,i of a rolling wheelset follows its brake torque. Without this, a brake application looks like a random
        walk of mu_w to the filter: it lags, and puts the difference into mu_b. For the same reason the mean force of
        a step has to meet the mu_w of its middle, not of its beginning. A sliding wheelset turns a change of brake
        torque into rotation instead. Between rolling and sliding nobody knows which share of it the rail takes up,
        and the force is only known at its samples; left out, both would pull mu_b down, as errors of a regressor do.
        """
        pads = []
        mean_n, friction = u.pressing_force_n.tolist(), self.x[self.layout.friction].tolist()
        for i, (begin_n, end_n, impulse_std_ns) in enumerate(zip(*forces, strict=True)):
            asked_per_n = self._asked_kg_per_n[i] / u.mass_kg  # mu_w,i for a newton, per unit of friction
            follows_per_n = asked_per_n if held.rolls[i] else 0.0
            pads.append(
                PadStep(
                    friction[i],
                    follows_per_n * (mean_n[i] - begin_n),
                    follows_per_n * (end_n - begin_n),
                    asked_per_n * (end_n - begin_n) * friction[i] if held.unsettled[i] else 0.0,
                    self._spin_per_impulse[i] * friction[i] * impulse_std_ns if held.turns[i] else 0.0,
                )
            )
        return pads

    def innovation(self, index: int, value: float, variance: float) -> ekf.Innovation:
        """Compare a reading of the measured state `index` with the prediction."""
        return ekf.innovation(self.x, self.covariance, index, value, variance)

    def fuse(self, index: int, seen: ekf.Innovation, regime: Regime) -> None:
        """Correct the estimate by what was seen, within what is physical."""
        predicted, measurement_variance = self.x.copy(), seen.variance - float(self.covariance[index, index])
        ekf.update(self.x, self.covariance, index, seen, self._terms(regime).free)
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
