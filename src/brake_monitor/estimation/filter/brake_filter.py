"""The filter of one wagon: state and covariance, carried from reading to reading. Knows no clock and no sensors."""

from collections.abc import Collection, Sequence
from functools import cache, partial
from math import hypot, sqrt
from typing import ClassVar

from brake_monitor.estimation.filter.belief import Belief
from brake_monitor.estimation.filter.filter_lines import (
    CorrectionFlags,
    Equations,
    StepFlags,
    correction_line,
    loads_line,
    step_line,
)
from brake_monitor.estimation.filter.physical import physical_range
from brake_monitor.estimation.kalman import ekf
from brake_monitor.estimation.kalman.ekf import Matrix, Vector, zeros
from brake_monitor.estimation.model.acting import Acting, acting_on_wheelset
from brake_monitor.estimation.model.brake_step import step_length
from brake_monitor.estimation.model.regime import FixedDensities
from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.estimation.model.wagon import Inputs, Wagon
from brake_monitor.estimation.moment import SNAPSHOTS, WagonMoment, WheelsetMoment

LAG_RENEWED_S = 0.03  # standard deviation


class BrakeFilter(Belief):
    """x and P of (13) for one wagon, with the steps that the estimator composes. Vectors and matrices are lists."""

    is_taped: ClassVar[bool] = False  # it notes the matrices of each step: see `TapedFilter`

    def __init__(self, wagon: Wagon, tuning: Tuning, friction: float, friction_std: float) -> None:
        self.wagon = wagon
        self.layout = wagon.layout
        self.tuning = tuning
        densities = FixedDensities(*[getattr(tuning, name) for name in FixedDensities._fields])
        equations = self.equations = Equations(wagon, densities, tuning.literal)
        self.speed_place = self.layout.speed
        self.adhesion_place = self.layout.adhesion.start
        self.adhesion_std = tuning.adhesion_std
        self.x = [0.0] * self.layout.size
        self.covariance = zeros(self.layout.size)
        self.direction = [0.0] * self.layout.size
        self.saved = [[0.0] * (self.layout.size + self.layout.size**2) for _ in range(SNAPSHOTS)]
        self._step = cache(lambda *flags: step_line(equations, StepFlags(*flags)))
        self._loads = cache(partial(loads_line, wagon))
        self._correction = cache(lambda index, *flags: correction_line(wagon.layout, index, CorrectionFlags(*flags)))
        self._prior_friction = (friction, friction_std)
        self.least, self.most = physical_range(wagon.layout)
        self.reset()

    # -- what is known beforehand, and doubt -------------------------------------------------------------------

    def reset(self) -> None:
        """Back to what is known before any frame."""
        self.forget_all(slice(0, self.layout.size), 0.0, 0.0)
        self.forget_parameters()

    def forget_parameters(self) -> None:
        """Nominal friction, no adhesion in use, nothing unmodelled, each with what is known of it beforehand."""
        s, tuning = self.layout, self.tuning
        friction, friction_std = self._prior_friction
        self.forget_all(s.friction, friction, 0.0)
        self.spread(friction_std**2, tuning.friction_own_std**2)
        self.forget_all(s.adhesion, 0.0, tuning.adhesion_std)
        self.forget(s.deceleration, 0.0, tuning.deceleration_std)
        self.forget(s.force_effect, 0.0, tuning.force_effect_std)
        self.forget(s.decay, 0.0, tuning.adhesion_decay_std)
        for place, first in zip(range(s.uptake.start, s.uptake.stop), tuning.first_uptake, strict=True):
            self.forget(place, first, tuning.uptake_std)
        self.forget(s.lag, 0.0, tuning.speed_lag_std)
        self.forget_all(s.torque_error, 0.0, tuning.torque_error_std)

    def restore_parameters(self, place: int) -> None:
        """Take friction, d, E, B and C_k, with their covariances, from a snapshot."""
        s, saved = self.layout, self.saved[place]
        parameters = [*range(s.friction.start, s.friction.stop), *range(s.deceleration, s.lag)]
        noise = zeros(s.size)
        for i in parameters:
            self.forget(i, saved[i], 0.0)
            for j in parameters:
                noise[i][j] = saved[s.size + i * s.size + j]
        self._admit(noise)

    def spread(self, common: float, own: float) -> None:
        """Add variance to friction that the wheelsets share and variance that each has for itself."""
        self._admit(self._spread(common, own))

    def _spread(self, common: float, own: float) -> Matrix:
        noise = zeros(self.layout.size)
        for i in range(self.layout.friction.start, self.layout.friction.stop):
            for j in range(self.layout.friction.start, self.layout.friction.stop):
                noise[i][j] = common + own * (i == j)
        return noise

    def recall_friction(self, friction: Sequence[float], known_variance: float, since_variance: float) -> None:
        """Take over friction, N numbers, from an earlier run, and add the variance of what it may have done since.

        Their sum does not exceed the variance of nominal friction, however often the program is restarted.
        """
        block, (_, nominal_std) = self.layout.friction, self._prior_friction
        variance = max(known_variance, min(known_variance + since_variance, nominal_std**2))
        own_variance = min(self.tuning.friction_own_std**2, variance)
        self.forget_all(block, 0.0, 0.0)
        self.x[block] = friction
        self.spread(variance - own_variance, own_variance)

    def renew_friction(self, common: float, own: float) -> None:
        """Add these variances to friction as pads are put on again, up to those from before anything was known.

        In a train what all pads share hardly shows, nor does how far one pad lies from the others while the wheelsets
        roll. Left alone, both variances would grow for as long as the program runs, though pads of a kind do not drift
        for ever: what exceeds the prior is drawn back, towards nominal friction and towards the pads' mean.
        """
        s, n = self.layout, self.layout.wheelset_count
        nominal, nominal_std = self._prior_friction
        common_prior, own_prior = nominal_std**2, self.tuning.friction_own_std**2
        pads = range(s.friction.start, s.friction.stop)
        total = sum(self.covariance[i][i] for i in pads)
        mean = sum(self.covariance[i][j] for i in pads for j in pads) / (n * n)
        own_known = (total - n * mean) / (n - 1) if n > 1 else own_prior
        common_known = mean - own_known / n
        to_nominal, to_mean = _drawn(common_known, common_prior), _drawn(own_known, own_prior)
        step = zeros(s.size)
        for i in pads:
            for j in pads:
                step[i][j] = to_mean * ((i == j) - 1.0 / n) + to_nominal / n
        common, own = min(common, max(common_prior - common_known, 0.0)), min(own, max(own_prior - own_known, 0.0))
        self._move(step, self._spread(common, own))
        for i in pads:
            self.x[i] -= to_nominal * nominal

    def infer_idle_friction(self, idle: Collection[int]) -> None:
        """Set friction of brakes that do nothing (`idle`, wheelsets) to the others' mean: pads are of a kind.

        Nothing shows their friction, and what was known of it while they rubbed is of another time. If its variance
        stayed, `renew_friction` would take that for pads that differ, and draw all of them to their mean.
        """
        s, own_variance = self.layout, self.tuning.friction_own_std**2
        unknown = [s.friction.start + i for i in idle]
        others = [i for i in range(s.friction.start, s.friction.stop) if i not in unknown]
        if not (unknown and others):
            return
        step, noise, share = zeros(s.size), zeros(s.size), 1.0 / len(others)
        for i in unknown:
            step[i][i] = -1.0
            for j in others:
                step[i][j] = share
            for j in unknown:
                noise[i][j] = own_variance * (share + (i == j))
        self._move(step, noise)

    def _move(self, change: Matrix, noise: Matrix) -> None:
        """Move x to (I + `change`) x, and by unknown amounts of this covariance, both of shape (n, n)."""
        moved = [sum([a * b for a, b in zip(row, self.x, strict=True)]) for row in change]
        self.x = [value + more for value, more in zip(self.x, moved, strict=True)]
        self.covariance = ekf.predict(self.covariance, change, noise)
        self.note_step(change, noise)

    def _admit(self, noise: Matrix) -> None:
        """Take the state to have moved by unknown amounts of this covariance, shape (n, n)."""
        for row, more in zip(self.covariance, noise, strict=True):
            row[:] = [a + b for a, b in zip(row, more, strict=True)]

    def forget_all(self, places: slice, value: float, std: float) -> None:
        """Give each of some states a new value that is unrelated to everything else."""
        for place in range(self.layout.size)[places]:
            self.forget(place, value, std)

    def doubt_lag(self) -> None:
        """Widen L as a brake application begins: readings of v may come with another delay than in the last one."""
        place = self.layout.lag
        known_std, prior_std = self.std(place), self.tuning.speed_lag_std
        self.forget(place, self.x[place], min(hypot(known_std, LAG_RENEWED_S), prior_std))

    def admit_deceleration_jump(self) -> None:
        """Widen d as a brake application begins: in a train the coupler force begins with it."""
        self.widen(self.layout.deceleration, self.tuning.deceleration_onset_std**2)

    def pull_variance(self, coasting_mps2: float) -> float:
        """The square of what pulls the wagon, less the variance of gradients that are to be expected, (m/s²)².

        What pulls is a negative d, beyond `coasting_mps2`: d as the wagon coasted after a release is the gradient's.
        """
        pull_mps2 = min(self.x[self.layout.deceleration] - min(coasting_mps2, 0.0), 0.0)
        return max(pull_mps2 * pull_mps2 - self.tuning.deceleration_std**2, 0.0)

    # -- prediction --------------------------------------------------------------------------------------------

    def predict(self, now: WagonMoment, wheels: Sequence[WheelsetMoment], step_s: float) -> None:
        """Predict x, P and the wheel loads over a step; near standstill x stays and P grows."""
        length = step_length(step_s)
        if now.near_standstill:
            self.admit_unseen(step_s)
            now.pitching_mps2, loads_n = self._loads()(self.x, now, length.settling_share)
        else:
            step = self._step(now.braked, now.driven, now.all_roll, now.has_slid, now.lag_observable, self.is_taped)
            predicted = step(self.x, self.covariance, length, now, wheels)
            self.x, self.covariance, matrices, now.pitching_mps2, loads_n = predicted
            if matrices:
                self.note_step(*matrices)
        for i, wheel in enumerate(wheels):
            wheel.next_wheel_load_n = loads_n[i]

    def note_step(self, change: Matrix, noise: Matrix) -> None:
        """Nothing: `TapedFilter` notes here that x moved to (I + `change`) x + w with w ~ N(0, `noise`)."""

    def rate(self, now: WagonMoment, wheels: Sequence[WheelsetMoment], place: int) -> float:
        """How fast a state changes under what acts on the wagon now, per second."""
        u = Inputs(now.mass_kg, now.gradient, [Acting(*acting_on_wheelset(wheel)) for wheel in wheels])
        return self.wagon.linearise(self.x, u)[0][place]

    # -- correction --------------------------------------------------------------------------------------------

    def fuse(
        self, now: WagonMoment, wheels: Sequence[WheelsetMoment], index: int, residual: float, variance: float
    ) -> bool:
        """Correct x and P by an innovation, keep x within physical bounds; whether both are sound then."""
        correct = self._correction(
            index, now.near_standstill, now.any_friction_observable, now.has_slid, now.lag_observable
        )
        corrected = correct(self.x, self.covariance, (residual, variance), now.speed_per_lag_mps2, wheels)
        self.x, self.covariance, is_physical = corrected
        if not is_physical:
            self.x = self.confined(self.x)
        return is_physical or self.is_sound()

    def confined(self, x: Vector) -> Vector:
        """A state with each number put back within its bounds."""
        return [min(max(value, low), high) for value, low, high in zip(x, self.least, self.most, strict=True)]

    def std(self, place: int) -> float:
        """Standard deviation of one state."""
        return sqrt(max(self.covariance[place][place], 0.0))


def _drawn(known: float, prior: float) -> float:
    """The relative change of a deviation, 0 or below, that brings its variance from `known` down to `prior`."""
    return sqrt(prior / known) - 1.0 if known > prior else 0.0
