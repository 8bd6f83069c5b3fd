"""The filter's equations as straight-line code (see `straight_line`), made once for all filters of like wagons.

There is one function for each combination of flags: what a flag makes 0 is left out of its code.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from brake_monitor.estimation.filter.physical import is_physical, physical_range
from brake_monitor.estimation.kalman import ekf
from brake_monitor.estimation.kalman.ekf import Innovation, Matrix, Measured, Vector, zeros
from brake_monitor.estimation.kalman.straight_line import Named, flat_source, straight_line
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.brake_step import Conditions, Predicted, StepLength, coupled_step, literal_step
from brake_monitor.estimation.model.regime import FixedDensities, free_states
from brake_monitor.estimation.model.state_layout import StateLayout
from brake_monitor.estimation.model.wagon import Wagon

LINES_KEPT = 128  # functions of each kind, those used last; a filter uses a few dozen
# Fields of `Acting` that are 0 on every wheelset while no brake acts, no motor acts, none has slid; and all roll.
PRESSING = ("pressing_force_n", "begin_force_n", "end_force_n", "impulse_std_ns", "unseen_std_ns")
DRIVING = ("wheel_torque_nm", "begin_torque_nm", "end_torque_nm")
CREEPING = ("slides", "force_effect_observable", "slip_change_mps", "small_slip", "medium_slip", "large_slip")
ROLLING = {
    "has_equation": 1.0,
    "rolls": 1.0,
    "unsettled": 0.0,
    "stuck_lately": 0.0,
    "unseen_std_ns": 0.0,
    **dict.fromkeys(CREEPING, 0.0),
}


class Equations(NamedTuple):
    """What a prediction depends on beside x, P and what acts on the wagon."""

    wagon: Wagon
    densities: FixedDensities
    literal: bool  # see `Tuning`


class StepFlags(NamedTuple):
    """The flags of a prediction, as in `WagonMoment`."""

    braked: bool
    driven: bool
    all_roll: bool
    has_slid: bool
    lag_observable: bool
    is_taped: bool  # the step's matrices are wanted, for a tape


class CorrectionFlags(NamedTuple):
    """The flags of a correction, as in `WagonMoment`."""

    near_standstill: bool  # all but the speeds are held
    any_friction_observable: bool  # else all mu_b,i are held
    has_slid: bool
    lag_observable: bool


@lru_cache(LINES_KEPT)
def step_line(equations: Equations, flags: StepFlags) -> Callable[..., Any]:
    """The prediction of x and P, and the wheel loads after it."""
    wagon = equations.wagon
    fixed = {} if flags.braked else dict.fromkeys(PRESSING, 0.0)
    fixed |= {} if flags.driven else dict.fromkeys(DRIVING, 0.0)
    fixed |= {} if flags.has_slid else dict.fromkeys(CREEPING, 0.0)
    fixed |= ROLLING if flags.all_roll else {}

    def step(
        x: Vector, covariance: Matrix, length: StepLength, now: ActingOnWagon, acting: Sequence[Acting]
    ) -> tuple[Vector, Matrix, Sequence[Matrix], float, Vector]:
        state = x, _tied(wagon.layout, covariance, flags)
        moved = _predicted(equations, state, length, now, [one._replace(**fixed) for one in acting])
        pitching_mps2, loads_n = wagon.loads_after_step(moved.x, now, length.settling_share)
        return moved.x, moved.covariance, (moved.step, moved.noise) if flags.is_taped else (), pitching_mps2, loads_n

    acting = [Named(Acting)] * wagon.layout.wheelset_count
    return straight_line(step, *_state(wagon.layout), StepLength(0.0, 0.0, 0.0), Named(ActingOnWagon), acting)


@lru_cache(LINES_KEPT)
def loads_line(wagon: Wagon) -> Callable[..., tuple[float, Vector]]:
    """The wheel loads after a step near standstill, in which nothing is predicted."""
    return straight_line(wagon.loads_after_step, [0.0] * wagon.layout.size, Named(ActingOnWagon), 0.0)


@lru_cache(LINES_KEPT)
def correction_line(
    layout: StateLayout, index: int, flags: CorrectionFlags
) -> Callable[..., tuple[Vector, Matrix, bool]]:
    """The correction by a reading of state `index`, and whether x and P are physical then."""
    least, most = physical_range(layout)

    def correct(
        x: Vector, covariance: Matrix, seen: Innovation, speed_per_lag_mps2: float, wheels: Sequence[Acting]
    ) -> tuple[Vector, Matrix, bool]:
        observable = [wheel.friction_observable if flags.any_friction_observable else 0.0 for wheel in wheels]
        free = free_states(layout, flags.near_standstill, observable)
        covariance = _tied(layout, covariance, flags)
        measured = measured_of(layout, index, speed_per_lag_mps2 if flags.lag_observable else 0.0)
        x, covariance = ekf.update(x, covariance, measured, seen, free)
        return x, covariance, is_physical(x, covariance, least, most)

    wheels = [Named(Acting)] * layout.wheelset_count
    return straight_line(correct, *_state(layout), Innovation(0.0, 0.0), 0.0, wheels)


def flat_sources(equations: Equations) -> tuple[str, str]:
    """The source, by `flat_source`, of the prediction for any densities, and that of the wheel loads after it."""
    wagon, densities, _ = equations
    now = ActingOnWagon(*[0.0] * len(ActingOnWagon._fields))
    acting = [Acting(*[0.0] * len(Acting._fields)) for _ in range(wagon.layout.wheelset_count)]
    given = _state(wagon.layout), StepLength(0.0, 0.0, 0.0), now, acting, densities

    def step(*given: Any) -> tuple[Vector, Matrix]:
        *others, densities = given
        return _predicted(equations._replace(densities=densities), *others)[:2]

    def loads(state: tuple[Vector, Matrix], length: StepLength, now: ActingOnWagon, *_: Any) -> tuple[float, Vector]:
        return wagon.loads_after_step(state[0], now, length.settling_share)

    return flat_source(step, *given), flat_source(loads, *given)


def measured_of(layout: StateLayout, index: int, speed_per_lag_mps2: float) -> Measured:
    """The row of H of a reading (15): omega_i, or the vehicle's speed as it was L ago."""
    return Measured(index, layout.lag, speed_per_lag_mps2 if index == layout.speed else 0.0)


def _state(layout: StateLayout) -> tuple[Vector, Matrix]:
    """Examples of x and P: zeros of their shapes."""
    return [0.0] * layout.size, zeros(layout.size)


def _predicted(
    equations: Equations,
    state: tuple[Vector, Matrix],
    length: StepLength,
    now: ActingOnWagon,
    acting: Sequence[Acting],
) -> Predicted:
    wagon, densities, literal = equations
    return (literal_step if literal else coupled_step)(wagon, *state, Conditions(length, now, acting, densities))


def _tied(layout: StateLayout, covariance: Matrix, flags: StepFlags | CorrectionFlags) -> Matrix:
    """P with constant zeros for the covariances of E, B, C_k and L while these are not observable.

    `RegimeWatch.untie` has made them 0 by then. As constants they let all their products vanish from the code.
    """
    creep = range(layout.creep.start, layout.creep.stop)
    loose = {**dict.fromkeys(creep, not flags.has_slid), layout.lag: not flags.lag_observable}
    return [
        [0.0 if i != j and (loose.get(i) or loose.get(j)) else value for j, value in enumerate(row)]
        for i, row in enumerate(covariance)
    ]
