"""The model of the wagon: balance of forces and moments, signs, and an exact Jacobian."""

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from brake_monitor.estimation.model.load_distribution import spread_over
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2, FrictionRelaxation, Inputs, Wagon
from brake_monitor.settings.config import Vehicle
from wagons import AXLES, derivative, jacobian, make_wagon, of_each, told


def braking_state(wagon: Wagon, adhesion: float = 0.1, friction: float = 0.35) -> np.ndarray:
    s, speed_mps = wagon.layout, 25.0
    x = np.zeros(s.size)
    x[s.omega] = [0.95 * speed_mps / own.wheel_radius_m for own in wagon.wheelsets]
    x[s.speed] = speed_mps
    x[s.friction] = friction
    x[s.adhesion] = adhesion
    return x


def braking_inputs(wagon: Wagon, pressing_force_n: float = 40_000.0) -> Inputs:
    return told(wagon.inputs(), pressing_force_n=[pressing_force_n] * wagon.layout.wheelset_count)


@st.composite
def situations(draw: st.DrawFn) -> tuple[Wagon, np.ndarray, Inputs]:
    """A wagon somewhere in its operating range, each wheelset different."""
    friction = draw(st.sampled_from((None, FrictionRelaxation(nominal=0.35, time_s=5.0))))
    wagon = make_wagon(draw(st.sampled_from((1, 2, 4))), friction, has_motors=draw(st.booleans()))
    n, s = wagon.layout.wheelset_count, wagon.layout

    def vector(low: float, high: float) -> np.ndarray:
        return np.array(draw(st.lists(st.floats(low, high), min_size=n, max_size=n)))

    x = np.zeros(s.size)
    x[s.speed] = draw(st.floats(1.0, 80.0))
    x[s.omega] = vector(0.0, 1.0) * x[s.speed] / 0.445
    x[s.friction] = vector(0.1, 0.6)
    x[s.adhesion] = vector(-0.2, 0.4)
    x[s.deceleration] = draw(st.floats(-1.0, 1.0))
    x[s.torque_error] = draw(st.floats(-0.2, 0.2))
    level = wagon.inputs()._replace(
        mass_kg=wagon.vehicle.mass_kg * draw(st.floats(0.6, 1.5)), gradient=draw(st.floats(-0.03, 0.03))
    )
    u = told(
        level,
        pressing_force_n=vector(0.0, 90_000.0),
        wheel_torque_nm=vector(-5000.0, 5000.0),
        friction_observable=(vector(0.0, 1.0) > 0.5).astype(float),
        wheel_radius_m=[0.445 * draw(st.floats(0.9, 1.1)) for _ in range(n)],
        brake_radius_m=[0.247 * draw(st.floats(0.9, 1.1)) for _ in range(n)],
    )
    return wagon, x, wagon.settled(x, u)


@given(situations())
def test_wheel_loads_carry_the_wagon_and_its_braking_moment(situation: tuple[Wagon, np.ndarray, Inputs]) -> None:
    """Moments about the centre of gravity: of what acts there, gravity and what is unmodelled, there is none."""
    wagon, x, u = situation
    load_n = of_each(u, "wheel_load_n")
    resistance_n = wagon.vehicle.track_resistance_n + wagon.vehicle.drag_n_per_mps2 * x[wagon.layout.speed] ** 2
    positions = np.array(AXLES[wagon.layout.wheelset_count])
    assert load_n.sum() == pytest.approx(u.mass_kg * GRAVITY_MPS2)
    if wagon.layout.wheelset_count > 1:
        moment = wagon.vehicle.cog_height_m * (x[wagon.layout.adhesion] @ load_n + resistance_n)
        assert load_n @ positions == pytest.approx(moment, abs=1e-6 * u.mass_kg)


@given(situations())
def test_force_balance_of_the_whole_wagon(situation: tuple[Wagon, np.ndarray, Inputs]) -> None:
    """(1): what retards the wagon is the sum of the creep forces and the resistances, with the whole of m g."""
    wagon, x, u = situation
    s = wagon.layout
    acceleration = derivative(wagon, x, u)[s.speed]
    creep_n = x[s.adhesion] @ of_each(u, "wheel_load_n")
    resistance_n = wagon.vehicle.track_resistance_n + wagon.vehicle.drag_n_per_mps2 * x[s.speed] ** 2
    weight_n = u.mass_kg * GRAVITY_MPS2 * u.gradient
    unmodelled_n = u.mass_kg * x[s.deceleration]
    assert -u.mass_kg * acceleration == pytest.approx(creep_n + resistance_n + weight_n + unmodelled_n, abs=1e-3)


@pytest.mark.parametrize("n", AXLES)
def test_a_common_adhesion_decelerates_with_g_and_not_half_of_it(n: int) -> None:
    wagon = make_wagon(n)
    x = braking_state(wagon, adhesion=0.1)
    rolling = braking_state(wagon, adhesion=0.0)
    u = wagon.inputs()
    retarded = wagon.acceleration_mps2(rolling, u) - wagon.acceleration_mps2(x, u)
    assert retarded == pytest.approx(0.1 * GRAVITY_MPS2)


@pytest.mark.parametrize("n", [2, 4])
def test_braking_loads_the_leading_wheelset(n: int) -> None:
    wagon = make_wagon(n)
    x = braking_state(wagon)
    u = wagon.settled(x, wagon.inputs())
    assert wagon.acceleration_mps2(x, u) < 0.0
    assert (np.diff(of_each(u, "wheel_load_n")) < 0.0).all()


@pytest.mark.parametrize("n", [2, 4])
def test_a_gradient_known_or_not_leaves_the_wheels_alone(n: int) -> None:
    """Braked downhill at steady speed the leading wheelset is loaded as on the level."""
    wagon = make_wagon(n)
    s, x, u = wagon.layout, braking_state(wagon), braking_inputs(wagon)
    level = derivative(wagon, x, wagon.settled(x, u))
    x[s.deceleration] = level[s.speed] / 2.0
    steady = derivative(wagon, x, wagon.settled(x, u._replace(gradient=level[s.speed] / 2.0 / GRAVITY_MPS2)))
    assert steady[s.speed] == pytest.approx(0.0, abs=1e-12)
    assert steady[s.omega] == pytest.approx(level[s.omega], rel=1e-12)


def test_two_axle_load_transfer_is_the_printed_one() -> None:
    """(4): ∓ (h/a) m v̇ for the wheel base a."""
    wagon = make_wagon(2)
    mass_kg = wagon.vehicle.mass_kg
    load_n = np.array(wagon.wheel_load_n(-1.0, mass_kg))
    assert load_n - mass_kg * GRAVITY_MPS2 / 2 == pytest.approx(1.6 / 9.0 * mass_kg * np.array([1.0, -1.0]))


def test_a_centre_of_gravity_off_the_middle_loads_the_nearer_wheelset() -> None:
    share, transfer = spread_over(np.array([3.0, -6.0]))
    assert share == pytest.approx([6.0 / 9.0, 3.0 / 9.0])  # the lever rule
    assert share @ np.array([3.0, -6.0]) == pytest.approx(0.0)
    assert transfer.sum() == pytest.approx(0.0)


@pytest.mark.parametrize("places_m", [(9.4, 7.6, -7.6, -9.4), (10.4, 8.6, -6.6, -8.4), (-8.0, -6.0, 7.0, 9.0)])
def test_on_bogies_every_frame_is_in_balance(places_m: tuple[float, ...]) -> None:
    """Forces and moments of the body about its pivots, and of each bogie about the rail below its own."""
    pivot_m, cog_m, braking_mps2 = 0.9, 1.6, 1.2
    wagon = Wagon.from_vehicle(
        Vehicle("bogies", 72_000.0, places_m, cog_m, (118.0,) * 4, (0.445,) * 4, (0.247,) * 4, 0.0, 0.0, 2, pivot_m)
    )
    m, places = wagon.vehicle.mass_kg, np.array(places_m).reshape(2, 2)
    centres_m = places.mean(axis=1)
    at_rest_n = np.array(wagon.wheel_load_n(0.0, m)).reshape(2, 2)
    assert at_rest_n[:, 0] == pytest.approx(at_rest_n[:, 1])  # nothing pitches a bogie
    assert at_rest_n.sum() == pytest.approx(m * GRAVITY_MPS2)
    assert at_rest_n.sum(axis=1) @ centres_m == pytest.approx(0.0, abs=1e-6)
    moved_n = np.array(wagon.wheel_load_n(-braking_mps2, m)).reshape(2, 2) - at_rest_n
    assert moved_n.sum() == pytest.approx(0.0, abs=1e-9)
    assert moved_n.sum(axis=1) @ centres_m == pytest.approx(m * braking_mps2 * (cog_m - pivot_m))
    for own_n, own_m, centre_m in zip(moved_n, places, centres_m, strict=True):
        assert own_n @ (own_m - centre_m) == pytest.approx(0.5 * m * braking_mps2 * pivot_m)


@pytest.mark.parametrize("n", AXLES)
def test_the_brake_slows_the_wheel_and_the_rail_turns_it(n: int) -> None:
    wagon = make_wagon(n)
    s = wagon.layout
    braked = derivative(wagon, braking_state(wagon, adhesion=0.0), braking_inputs(wagon))
    assert (braked[s.omega] < 0.0).all()
    released = derivative(wagon, braking_state(wagon, adhesion=0.05), wagon.inputs())
    assert (released[s.omega] > 0.0).all()
    assert released[s.speed] < 0.0


def test_a_wheelset_in_balance_keeps_its_speed() -> None:
    """(6): mu_w F_z r_W = mu_b F r_B when omega does not change."""
    wagon = make_wagon(1)
    x, s = braking_state(wagon), wagon.layout
    load_n = wagon.vehicle.mass_kg * GRAVITY_MPS2
    (wheelset,) = wagon.wheelsets
    u = braking_inputs(wagon, 0.1 * load_n * wheelset.wheel_radius_m / (0.35 * wheelset.brake_radius_m))
    assert derivative(wagon, x, u)[s.omega] == pytest.approx(0.0, abs=1e-9)


def test_a_motor_turns_its_wheelset_by_more_than_it_says_where_k_says_so() -> None:
    wagon = make_wagon(1, has_motors=True)
    x, s = braking_state(wagon, adhesion=0.0), wagon.layout
    x[s.torque_error] = 0.08
    (wheelset,) = wagon.wheelsets
    driven = derivative(wagon, x, told(wagon.inputs(), wheel_torque_nm=[2000.0]))
    assert driven[s.omega] * wheelset.inertia_kgm2 == pytest.approx(1.08 * 2000.0)


def test_a_locked_wheelset_has_no_wheel_equation() -> None:
    wagon = make_wagon(2)
    u = told(braking_inputs(wagon), has_equation=[0.0, 1.0])
    xdot = derivative(wagon, braking_state(wagon), u)
    assert xdot[0] == 0.0
    assert xdot[1] != 0.0
    assert not jacobian(wagon, braking_state(wagon), u)[0].any()


@settings(max_examples=60)
@given(situations())
def test_jacobian_is_the_finite_difference_of_the_model(situation: tuple[Wagon, np.ndarray, Inputs]) -> None:
    wagon, x, u = situation
    step = 1e-6 * np.maximum(1.0, np.abs(x))
    columns = [
        (derivative(wagon, x + h * e, u) - derivative(wagon, x - h * e, u)) / (2.0 * h)
        for h, e in zip(step, np.eye(len(x)), strict=True)
    ]
    assert jacobian(wagon, x, u) == pytest.approx(np.array(columns).T, rel=1e-5, abs=1e-4)


def test_first_order_friction_returns_to_nominal_while_it_rubs() -> None:
    """(9): a small deviation falls to 1/e in the time constant, from either side; a held friction stays."""
    wagon = make_wagon(2, FrictionRelaxation(nominal=0.35, time_s=20.0))
    s, u, step_s = wagon.layout, told(braking_inputs(wagon), friction_observable=[1.0, 0.0]), 0.01
    for deviation in (0.002, -0.002):
        x = braking_state(wagon, friction=0.35 + deviation)
        for _ in range(2000):
            x[s.friction] += step_s * derivative(wagon, x, u)[s.friction]
        assert x[s.friction][0] - 0.35 == pytest.approx(deviation / np.e, rel=0.01)
        assert x[s.friction][1] == 0.35 + deviation


def test_jacobian_is_the_symbolic_derivative_for_two_wheelsets() -> None:
    """The equations written down once more in sympy, from (1), (2), (4), (6), (7), the loads solved for."""
    wagon = make_wagon(2)
    symbols = sympy.symbols("w1 w2 v b1 b2 a1 a2 d E B C1 C2 C3 L")
    _, _, v, b1, b2, a1, a2, d, *_ = symbols
    m, h, a = wagon.vehicle.mass_kg, wagon.vehicle.cog_height_m, 9.0
    front, rear, rail = sympy.symbols("front rear rail")  # `rail`: what rail and air make of v̇
    resistance = wagon.vehicle.track_resistance_n + wagon.vehicle.drag_n_per_mps2 * v**2
    force = (30_000.0, 50_000.0)
    first, second = wagon.wheelsets
    rows = [
        (a1 * front * first.wheel_radius_m - b1 * force[0] * 0.247) / first.inertia_kgm2,
        (a2 * rear * second.wheel_radius_m - b2 * force[1] * 0.247) / second.inertia_kgm2,
        -(a1 * front + a2 * rear + resistance) / m - d,
    ]
    x = np.array([50.0, 55.0, 25.0, 0.33, 0.37, 0.08, 0.12, 0.1, -0.1, 0.15, 0.8, 0.3, 0.1, 0.05])
    at = dict(zip(symbols, x, strict=True))
    balance = [
        front - m * GRAVITY_MPS2 / 2 + h / a * m * rail,
        rear - m * GRAVITY_MPS2 / 2 - h / a * m * rail,
        m * rail + a1 * front + a2 * rear + resistance,
    ]
    loads = sympy.solve([equation.subs(at) for equation in balance], (front, rear, rail))
    u = wagon.settled(x, told(wagon.inputs(), pressing_force_n=force))
    assert of_each(u, "wheel_load_n") == pytest.approx([float(loads[front]), float(loads[rear])], rel=1e-12)
    expected = np.array(sympy.Matrix(rows).jacobian(symbols).subs(at | loads), dtype=float)
    moving = [0, 1, 2]
    assert jacobian(wagon, x, u)[moving] == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert not np.delete(jacobian(wagon, x, u), moving, axis=0).any()
