"""Estimates that know the future: a fixed-interval smoother over what the filter did, for replay at a desk.

The filter's belief at an instant is joined with all that the readings after it say, as Mayne (Automatica 4 (1966)
73-92) and Fraser and Potter (IEEE Trans. Autom. Control 14 (1969) 387-390) do; where the filter is optimal this is the
smoother of Rauch, Tung and Striebel. Preferred to their form because it inverts no covariance (`rig` has states
without variance), and because the future side does not depend on how the filter came by its belief: held states,
admitted jumps and values that were confined need no special case. It goes over a filter of its own, beside the one that
a pipeline has, with freedoms of its own: see FRICTION_FREEDOM.

A filter lets d go only once the speed contradicts the forces. A smoother that took d to have stood still until then
would find a pull that follows a braking in the braking, and friction to make up for it. The tape tells of such moves
(`TapedFilter`); what it does not tell of is seen here, by AT_ONCE_SIGMAS.

What comes after is kept as a quadratic in e, the deviation of the true state from the filter's:
    - log p(later readings | e) = ½ e' Y e - y' e + const.
"""

from math import hypot, sqrt
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from brake_monitor.arrays import Floats
from brake_monitor.estimation.core.readout import load_share, unseen_adhesion_std, unseen_friction_variance
from brake_monitor.estimation.estimate import Estimate, WheelsetEstimate, slip_of
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.filter.tape import Reading, Step, TapedFilter
from brake_monitor.estimation.model.tuning import resolve
from brake_monitor.processing.pipeline import Pipeline

LOOK_AHEAD_S = 60.0  # the next brake application still tells of friction; what comes later hardly does
WINDOW_S = 60.0  # smoothed at one go; memory holds a window and its look-ahead, however long the recording

# A live filter is quiet only if friction moves little. A smoother sees past and future and is quiet anyway: it can let
# friction follow heat and pressure, whose effect would else end up in d, and so in adhesion, for a whole braking.
# Nor must it choose between following a change of gradient late and taking noise for one.
FRICTION_FREEDOM = 2.0  # of these densities, multiples of the live filter's
SLIDING_FREEDOM = 2.0
DECELERATION_FREEDOM = 0.2

AT_ONCE_SIGMAS = 3.0  # of what later readings can tell of d: one that they want to be off by more has moved just there


class Future:
    """What later readings say of the state: the information matrix Y, shape (n, n), and vector y, shape (n,)."""

    def __init__(self, size: int) -> None:
        """Nothing yet."""
        self._matrix = np.zeros((size, size))
        self._vector = np.zeros(size)
        self._identity = np.eye(size)

    def precede(self, event: Step | Reading) -> None:
        """Go back before an event."""
        if isinstance(event, Step):
            self._precede_step(event)
        else:
            self._precede_reading(event)

    def _precede_step(self, step: Step) -> None:
        """Y ← F' (I + Y Q)^-1 Y F, y ← F' (I + Y Q)^-1 y; I + Y Q is never singular."""
        known = np.linalg.solve(
            self._identity + self._matrix @ step.noise, np.column_stack((self._matrix, self._vector))
        )
        transition = self._identity + step.change
        moved = transition.T @ known
        self._matrix = moved[:, :-1] @ transition
        self._matrix += self._matrix.T.copy()  # rounding must not let the halves drift apart
        self._matrix *= 0.5
        self._vector = moved[:, -1]

    def _precede_reading(self, reading: Reading) -> None:
        """Count the deviation from the state as predicted, and add the reading's own information."""
        self._vector = self._vector + self._matrix @ reading.correction
        state, other, weight = reading.measured
        for row, share in ((state, 1.0), (other, weight)):
            self._vector[row] += share * reading.residual / reading.variance
            self._matrix[row, state] += share / reading.variance
            self._matrix[row, other] += share * weight / reading.variance

    def join(self, x: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        """State and covariance given past and future: P_s = (I + P Y)^-1 P, x_s = x + P_s y."""
        smoothed = np.linalg.solve(self._identity + covariance @ self._matrix, covariance)
        smoothed = 0.5 * (smoothed + smoothed.T)
        return x + smoothed @ self._vector, smoothed


class _TapedEstimator(Estimator):
    """One whose filter notes whatever it does."""

    filter_type = TapedFilter


class Row(NamedTuple):
    """An estimate that waits for its future, and the belief at its time."""

    estimate: Estimate
    x: Floats
    covariance: Floats
    load_share: Floats  # F_z,i / (m g), shape (N,)
    wheel_radius_m: tuple[float, ...]
    unseen_friction_variance: tuple[float, ...]  # published beside the belief's own, ...
    unseen_adhesion_std: tuple[float, ...]  # ... and so is this
    position: int  # events on the tape before it


class Smoother:
    """Gives a pipeline's estimates again, smoothed, once enough of their future is known."""

    def __init__(self, pipeline: Pipeline) -> None:
        """Listen to the samples of a pipeline that has seen nothing yet."""
        settings = pipeline.settings
        tuning = resolve(settings.estimator)
        freer = replace(
            tuning,
            friction=FRICTION_FREEDOM * tuning.friction,
            adhesion_sliding=SLIDING_FREEDOM * tuning.adhesion_sliding,
            deceleration=DECELERATION_FREEDOM * tuning.deceleration,
        )
        self._estimator = _TapedEstimator(settings.vehicle, settings.estimator, pipeline.decoder.channels, freer)
        pipeline.shadows.append(self._estimator)
        assert isinstance(self._estimator.filter, TapedFilter)
        self._filter = self._estimator.filter
        self._layout = self._filter.layout
        self._tape = self._filter.tape
        self._rows: list[Row] = []

    def take(self, estimate: Estimate) -> list[Estimate]:
        """Take what the pipeline just gave out; give the smoothed estimates that are settled, in order, often none."""
        self._rows.append(self._row(estimate))
        if self._age_s(self._rows[0]) < WINDOW_S + LOOK_AHEAD_S:
            return []
        waiting = next(i for i, row in enumerate(self._rows) if self._age_s(row) < LOOK_AHEAD_S)
        return self._smooth(waiting)

    def finish(self) -> list[Estimate]:
        """The rest, at the end of the recording."""
        return self._smooth(len(self._rows))

    def _row(self, estimate: Estimate) -> Row:
        core, wheelsets = self._estimator.core, range(self._layout.wheelset_count)
        return Row(
            estimate=estimate,
            x=np.array(self._filter.x),
            covariance=np.array(self._filter.covariance),
            load_share=np.array([load_share(core, i) for i in wheelsets]),
            wheel_radius_m=self._estimator.wheel_radius_m,
            unseen_friction_variance=tuple([unseen_friction_variance(core, i) for i in wheelsets]),
            unseen_adhesion_std=tuple([unseen_adhesion_std(core, i) for i in wheelsets]),
            position=len(self._tape.events),
        )

    def _age_s(self, row: Row) -> float:
        """Distance from the newest row, whichever way time jumped."""
        return abs(self._rows[-1].estimate.time_s - row.estimate.time_s)

    def _smooth(self, count: int) -> list[Estimate]:
        """Go back over the tape and give the oldest `count` rows, which leave together with their events."""
        smoothed = []
        future = Future(self._layout.size)
        end = len(self._tape.events)
        for i in reversed(range(len(self._rows))):
            row = self._rows[i]
            for event in reversed(self._tape.events[row.position : end]):
                future.precede(event)
            end = row.position
            belief = self._looked_back(row, future)
            if i < count:
                smoothed.append(self._joined(row, *belief))
        smoothed.reverse()
        gone = self._rows[count - 1].position if count else 0
        self._tape.cut(gone)
        self._rows = [row._replace(position=row.position - gone) for row in self._rows[count:]]
        return smoothed

    def _looked_back(self, row: Row, future: Future) -> tuple[Floats, Floats]:
        """State and covariance at a row; if d has moved there at once, `future` knows of that from then on."""
        place = self._layout.deceleration
        x, covariance = future.join(row.x, row.covariance)
        moved_mps2, told_variance = x[place] - row.x[place], row.covariance[place, place] - covariance[place, place]
        if moved_mps2**2 <= AT_ONCE_SIGMAS**2 * max(told_variance, 0.0):
            return x, covariance
        noise = np.zeros_like(covariance)
        noise[place, place] = moved_mps2**2
        future.precede(Step(np.zeros_like(noise), noise))
        return future.join(row.x, row.covariance)

    def _joined(self, row: Row, x: Floats, covariance: Floats) -> Estimate:
        """The row's estimate with its numbers smoothed; status, reasons and what was measured stay the filter's."""
        s = self._layout
        x = np.array(self._filter.confined(x.tolist()))
        std = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
        adhesion_variance = float(row.load_share @ covariance[s.adhesion, s.adhesion] @ row.load_share)
        return replace(
            row.estimate,
            speed_mps=float(x[s.speed]),
            adhesion=float(row.load_share @ x[s.adhesion]),
            adhesion_std=sqrt(max(adhesion_variance, 0.0)),
            deceleration_mps2=float(x[s.deceleration]),
            deceleration_std_mps2=float(std[s.deceleration]),
            wheelsets=tuple(self._wheelset(i, row, x, std) for i in range(s.wheelset_count)),
        )

    def _wheelset(self, i: int, row: Row, x: Floats, std: Floats) -> WheelsetEstimate:
        s = self._layout
        friction, adhesion = s.friction.start + i, s.adhesion.start + i
        return replace(
            row.estimate.wheelsets[i],
            omega_radps=float(x[i]),
            slip=slip_of(float(x[i]), row.wheel_radius_m[i], float(x[s.speed])),
            friction=float(x[friction]),
            friction_std=hypot(float(std[friction]), sqrt(row.unseen_friction_variance[i])),
            adhesion=float(x[adhesion]),
            adhesion_std=hypot(float(std[adhesion]), row.unseen_adhesion_std[i]),
        )
