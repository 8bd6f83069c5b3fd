"""The filter's equations as straight-line code (see `straight_line`), made once for all filters of like wagons.

There is one function for each combination of flags: what a flag makes 0 is left out of its code.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any, NamedTuple

from brake_monitor.estimation import ekf
from brake_monitor.estimation.ekf import Innovation, Matrix, Measured, Vector, zeros
from brake_monitor.estimation.filter.physical import is_physical, physical_range
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.brake_step import Conditions, Predicted, coupled_step, literal_step
from brake_monitor.estimation.model.load_transfer import loads_after_step
from brake_monitor.estimation.model.regime import FixedDensities, free_states
from brake_monitor.estimation.model.state_layout import StateLayout
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.estimation.straight_line import Named, flat_source, straight_line

LINES_KEPT = 128  # functions of each kind, those used last; a filter uses a few dozen
# Fields of `Acting` that are 0 on every wheelset while no brake acts, no motor acts, none has slid; and all roll.
PRESSING = (
    "pressing_force_n",
    "begin_force_n",
    "end_force_n",
    "impulse_std_ns",
    "unseen_std_ns",
)  # of what acts on a wheelset
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


@lru_cache(LINES_KEPT)
def step_line(
    equations: Equations, acts: tuple[bool, bool], rolls: bool, shown: tuple[bool, bool], taped: bool
) -> Callable[..., Any]:
    """The prediction of x and P, and the wheel loads after it; flags as in `WagonMoment`.

    `acts`: `braked` and `driven`; `rolls`: `all_roll`; `shown`: `has_slid` and `lag_observable`; `taped`: with the
    step's matrices, for a tape.
    """
    wagon, densities, _ = equations
    (braked, driven), (has_slid, _) = acts, shown
    fixed = {} if braked else dict.fromkeys(PRESSING, 0.0)
    fixed |= {} if driven else dict.fromkeys(DRIVING, 0.0)
    fixed |= {} if has_slid else dict.fromkeys(CREEPING, 0.0)
    fixed |= ROLLING if rolls else {}

    def step(
        x: Vector, covariance: Matrix, lengths: Sequence[float], now: ActingOnWagon, acting: Sequence[Acting]
    ) -> tuple[Vector, Matrix, Sequence[Matrix], float, Vector]:
        step_s, memory, share = lengths
        given = (step_s, memory, now.mass_kg, now.gradient, now.deceleration_density)
        state = x, _tied(wagon.layout, covariance, shown)
        moved = _predicted(equations, state, given, [one._replace(**fixed) for one in acting], densities)
        pitching_mps2, loads_n = loads_after_step(wagon, moved.x, now, share)
        return moved.x, moved.covariance, (moved.step, moved.noise) if taped else (), pitching_mps2, loads_n

    acting = [Named(Acting)] * wagon.layout.wheelset_count
    return straight_line(step, *_state(wagon.layout), (0.0,) * 3, Named(ActingOnWagon), acting)


@lru_cache(LINES_KEPT)
def loads_line(wagon: Wagon) -> Callable[..., tuple[float, Vector]]:
    """The wheel loads after a step near standstill, in which nothing is predicted."""
    return straight_line(partial(loads_after_step, wagon), [0.0] * wagon.layout.size, Named(ActingOnWagon), 0.0)


@lru_cache(LINES_KEPT)
def correction_line(
    layout: StateLayout, index: int, near_standstill: bool, any_observable: bool, shown: tuple[bool, bool]
) -> Callable[..., tuple[Vector, Matrix, bool]]:
    """The correction by a reading of state `index`, and whether x and P are physical then; flags as in `WagonMoment`.

    `near_standstill`: all but the speeds are held; `any_observable`: any mu_b,i is, else all are held; `shown`: see
    `step_line`.
    """
    least, most = physical_range(layout)
    _, lag_observable = shown

    def correct(
        x: Vector, covariance: Matrix, seen: Sequence[float], wheels: Sequence[Acting]
    ) -> tuple[Vector, Matrix, bool]:
        residual, variance, speed_per_lag_mps2 = seen
        free = free_states(
            layout, near_standstill, [wheel.friction_observable if any_observable else 0.0 for wheel in wheels]
        )
        covariance = _tied(layout, covariance, shown)
        measured = measured_of(layout, index, speed_per_lag_mps2 if lag_observable else 0.0)
        x, covariance = ekf.update(x, covariance, measured, Innovation(residual, variance), free)
        return x, covariance, is_physical(x, covariance, least, most)

    acting = [Named(Acting)] * layout.wheelset_count
    return straight_line(correct, *_state(layout), (0.0,) * 3, acting)


def flat_sources(equations: Equations) -> tuple[str, str]:
    """The source, by `flat_source`, of the prediction for any densities, and that of the wheel loads after it."""
    wagon, densities, _ = equations
    x, covariance = _state(wagon.layout)
    acting = [Acting(*[0.0] * len(Acting._fields)) for _ in range(wagon.layout.wheelset_count)]
    step = flat_source(
        lambda x, covariance, *others: _predicted(equations, (x, covariance), *others)[:2],
        *(x, covariance, (0.0,) * 5, acting, densities),
    )
    return step, flat_source(partial(loads_after_step, wagon), x, ActingOnWagon(*(0.0,) * 5), 0.0)


def measured_of(layout: StateLayout, index: int, speed_per_lag_mps2: float) -> Measured:
    """The row of H of a reading (15): omega_i, or the vehicle's speed as it was L ago."""
    return Measured(index, layout.lag, speed_per_lag_mps2 if index == layout.speed else 0.0)


def _state(layout: StateLayout) -> tuple[Vector, Matrix]:
    """Examples of x and P: zeros of their shapes."""
    return [0.0] * layout.size, zeros(layout.size)


def _predicted(
    equations: Equations,
    state: tuple[Vector, Matrix],
    step: Sequence[float],
    acting: Sequence[Acting],
    densities: FixedDensities,
) -> Predicted:
    now = Conditions.of(step, acting, densities, state[0][equations.wagon.layout.speed])
    return (literal_step if equations.literal else coupled_step)(equations.wagon, *state, now)


def _tied(layout: StateLayout, covariance: Matrix, shown: tuple[bool, bool]) -> Matrix:
    """P with constant zeros for the covariances of E, B, C_k and L while these are not observable.

    `RegimeWatch.untie` has made them 0 by then. As constants they let all their products vanish from the code.
    """
    has_slid, lag_observable = shown
    creep = range(layout.creep.start, layout.creep.stop)
    loose = {**dict.fromkeys(creep, not has_slid), layout.lag: not lag_observable}
    return [
        [0.0 if i != j and (loose.get(i) or loose.get(j)) else value for j, value in enumerate(row)]
        for i, row in enumerate(covariance)
    ]
