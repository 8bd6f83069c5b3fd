"""Straight-line code is the function that it was made from, for numbers and for many numbers at once."""

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from brake_monitor.estimation.core.regime_watch import UNKNOWN_TORQUE_DENSITY
from brake_monitor.estimation.kalman import ekf
from brake_monitor.estimation.kalman.ekf import Matrix, Vector
from brake_monitor.estimation.kalman.straight_line import Named, straight_line
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.brake_step import Conditions, Predicted, StepLength, coupled_step, literal_step
from brake_monitor.estimation.model.regime import FixedDensities
from brake_monitor.estimation.model.tuning import RIG, WAGON
from brake_monitor.estimation.model.wagon import FrictionRelaxation, Wagon
from wagons import make_wagon

numbers = st.floats(-10.0, 10.0)


class Pair(NamedTuple):
    first: float
    others: list[float]


def shared(x: float, pair: Pair) -> tuple[float, list[float]]:
    twice = [2.0 * x * value for value in pair.others]
    return pair.first - sum(twice), [value / (1.0 + x * x) for value in twice]


@given(numbers, numbers, st.lists(numbers, min_size=3, max_size=3))
def test_it_computes_what_the_function_does(x: float, first: float, others: list[float]) -> None:
    straight = straight_line(shared, 0.0, Pair(0.0, [0.0] * 3))
    rest, parts = shared(x, Pair(first, others))
    # From Python 3.12 on `sum` rounds once, what it was written out as at each addition.
    assert straight(x, Pair(first, others)) == (pytest.approx(rest, rel=1e-14, abs=1e-12), parts)


def test_what_constants_decide_is_left_out() -> None:
    def function(x: float, y: float) -> list[float]:
        return [0.0 * x + 1.0 * y, x / 1.0 - 0.0, 0.0 / x, -y, 3.0 - x, 6.0 / x, y + 2.0]

    straight = straight_line(function, 0.0, 0.0)
    assert straight(2.0, 5.0) == [5.0, 2.0, 0.0, -5.0, 1.0, 3.0, 7.0]
    assert straight(float("nan"), 5.0)[0] == 5.0  # nothing is multiplied by zero


def test_what_a_number_differs_by_from_itself_is_left_out() -> None:
    straight = straight_line(lambda x, y: [x * y - y * x], 0.0, 0.0)
    assert straight(float("inf"), 2.0) == [0.0]


def test_an_argument_may_be_an_object_with_numbers() -> None:
    class Told:
        first, others = 3.0, -1.0

    straight = straight_line(lambda x, pair: pair.first * pair.first - x * pair.others, 0.0, Named(Pair))
    assert straight(2.0, Told()) == 11.0


def test_a_comparison_can_be_returned() -> None:
    straight = straight_line(lambda x, y: (x <= y) & (y >= 0.0) & (x >= 1.0), 0.0, 0.0)
    assert straight(1.0, 2.0) is True
    for x, y in ((2.0, 1.0), (0.5, 2.0), (-2.0, -1.0), (float("nan"), 2.0)):
        assert straight(x, y) is False


def test_a_long_sum_is_no_deep_expression() -> None:
    straight = straight_line(sum, [0.0] * 800)
    assert straight([float(i) for i in range(800)]) == 799 * 400


def test_a_branch_on_an_argument_is_refused() -> None:
    with pytest.raises(TypeError, match="branch"):
        straight_line(lambda x: 1.0 if x else 0.0, 0.0)


def test_many_at_once_are_what_each_is_alone() -> None:
    straight = straight_line(shared, 0.0, Pair(0.0, [0.0] * 3))
    rng = np.random.default_rng(1)
    x, first, others = rng.normal(size=50), rng.normal(size=50), list(rng.normal(size=(3, 50)))
    total, parts = straight(x, Pair(first, others))
    for k in range(50):
        assert straight(x[k], Pair(first[k], [other[k] for other in others])) == (
            pytest.approx(total[k]),
            pytest.approx([part[k] for part in parts]),
        )


# -- the filter's own equations --------------------------------------------------------------------------------

FLAGS = (
    "has_equation",
    "rolls",
    "slides",
    "unsettled",
    "force_effect_observable",
    "friction_observable",
    "stuck_lately",
)
FORCES = ("pressing_force_n", "begin_force_n", "end_force_n")
LOADS = ("begin_load_n", "wheel_load_n")
TORQUES = ("wheel_torque_nm", "begin_torque_nm", "end_torque_nm", "impulse_std_ns", "unseen_std_ns")


@st.composite
def steps(draw: st.DrawFn) -> tuple[Wagon, Vector, Matrix, Conditions, bool]:
    """A wagon somewhere in its operating range, with any combination of conditions."""
    literal = draw(st.booleans())
    relaxation = draw(st.sampled_from((None, FrictionRelaxation(nominal=0.35, time_s=5.0))))
    wagon = make_wagon(draw(st.sampled_from((1, 2, 4))), relaxation, has_motors=draw(st.booleans()))
    s, n = wagon.layout, wagon.layout.wheelset_count
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    x = np.zeros(s.size)
    x[s.speed] = rng.uniform(1.0, 80.0)
    x[s.omega] = rng.uniform(0.0, 1.0, n) * x[s.speed] / 0.445
    x[s.friction], x[s.adhesion] = rng.uniform(0.1, 0.6, n), rng.uniform(-0.2, 0.4, n)
    x[s.deceleration], x[s.decay] = rng.uniform(-1.0, 1.0), rng.uniform(-0.5, 1.0)
    x[s.force_effect] = rng.uniform(-0.3, 0.3)
    x[s.uptake] = rng.uniform(-0.5, 1.0, 3)
    x[s.torque_error] = rng.uniform(-0.2, 0.2)
    root = rng.normal(size=(s.size, s.size)) * 0.01
    q = RIG if literal else WAGON

    def acting() -> Acting:
        flags = {name: float(draw(st.booleans())) for name in FLAGS}
        return Acting(*rng.uniform(0.0, 1.0, len(Acting._fields)).tolist())._replace(
            **flags,
            **dict(zip(FORCES, rng.uniform(0.0, 90_000.0, len(FORCES)).tolist(), strict=True)),
            **dict(zip(LOADS, rng.uniform(20_000.0, 90_000.0, len(LOADS)).tolist(), strict=True)),
            **dict(zip(TORQUES, rng.uniform(-5000.0, 5000.0, len(TORQUES)).tolist(), strict=True)),
            slip_change_mps=rng.uniform(-0.3, 0.3),
            omega_density=draw(st.sampled_from((q.omega, UNKNOWN_TORQUE_DENSITY))),
            adhesion_density=draw(st.sampled_from((q.adhesion_own, q.adhesion_sliding))),
        )

    densities = FixedDensities(*[getattr(q, name) for name in FixedDensities._fields])
    deceleration = draw(st.sampled_from((q.deceleration, q.deceleration_braking)))
    gradient, torque_error_density = rng.uniform(-0.03, 0.03), rng.uniform(0.0, 1e-4)
    on_wagon = ActingOnWagon(wagon.vehicle.mass_kg, gradient, deceleration, 0.0, 1.0, torque_error_density)
    now = Conditions(StepLength(0.02, 0.5, 0.0), on_wagon, [acting() for _ in range(n)], densities)
    return wagon, x.tolist(), (root @ root.T).tolist(), now, literal


@settings(max_examples=60)
@given(steps())
def test_a_compiled_prediction_is_the_equations_own(step: tuple[Wagon, Vector, Matrix, Conditions, bool]) -> None:
    wagon, x, covariance, now, literal = step
    equations = literal_step if literal else coupled_step
    compiled = straight_line(lambda *arguments: equations(wagon, *arguments), x, covariance, now)
    found, expected = Predicted(*compiled(x, covariance, now)), equations(wagon, x, covariance, now)
    for name in Predicted._fields:
        exact = np.array(getattr(expected, name))
        largest = np.abs(exact).max()
        assert np.array(getattr(found, name)) == pytest.approx(exact, rel=1e-12, abs=1e-12 * largest), name


@given(st.integers(0, 2**32 - 1), st.integers(0, 2), st.sampled_from((0.0, 1.0)))
def test_a_compiled_correction_is_the_equations_own(seed: int, index: int, free: float) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(5, 5))
    x, covariance = rng.normal(size=5).tolist(), (root @ root.T).tolist()
    seen = ekf.Innovation(float(rng.normal()), covariance[index][index] + 0.1)

    def correct(x: Vector, covariance: Matrix, seen: ekf.Innovation, free: float) -> tuple[Vector, Matrix]:
        return ekf.update(x, covariance, ekf.Measured(index), seen, [1.0, 1.0, 1.0, free, 0.0])

    compiled = straight_line(correct, x, covariance, seen, 0.0)
    for found, expected in zip(compiled(x, covariance, seen, free), correct(x, covariance, seen, free), strict=True):
        assert np.array(found) == pytest.approx(np.array(expected), rel=1e-12, abs=1e-12)
