"""What a step of the filter makes of a wheelset between rolling and sliding, and past the peak of its creep curve.

The reference is the torque balance of a wheelset that turns evenly: mu_w F_z r_W = mu_b F r_B, with pads that rub the
less the harder they press.
"""

import numpy as np
import pytest

from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.brake_step import Conditions, Predicted, StepLength, coupled_step
from brake_monitor.estimation.model.regime import FixedDensities
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2, Wagon
from brake_monitor.settings.config import Vehicle

MASS_KG, RADIUS_M, BRAKE_RADIUS_M = 36_000.0, 0.445, 0.247
LOAD_N = MASS_KG * GRAVITY_MPS2 / 2
SPEED_MPS, FRICTION, ADHESION = 20.0, 0.35, 0.06
DENSITIES = FixedDensities(*[getattr(WAGON, name) for name in FixedDensities._fields])
STEP_S = 0.02

WAGON_OF_TWO = Wagon.from_vehicle(
    Vehicle(
        id="test",
        mass_kg=MASS_KG,
        axle_positions_m=(4.5, -4.5),
        cog_height_m=0.0,
        wheelset_inertia_kgm2=(118.0, 118.0),
        wheel_radius_m=(RADIUS_M, RADIUS_M),
        brake_radius_m=(BRAKE_RADIUS_M, BRAKE_RADIUS_M),
        track_resistance_n=1800.0,
    )
)
LAYOUT = WAGON_OF_TWO.layout
UPTAKE = (0.9, 0.4, -0.1)
DECAY_SPM = 0.2
FORCE_EFFECT = -0.12  # of mu_b, by the braking ratio F r_B / (F_z r_W)


def state(force_effect: float = 0.0) -> list[float]:
    x = [0.0] * LAYOUT.size
    x[LAYOUT.omega] = [SPEED_MPS * 0.97 / RADIUS_M] * 2
    x[LAYOUT.speed] = SPEED_MPS
    x[LAYOUT.friction], x[LAYOUT.adhesion] = [FRICTION] * 2, [ADHESION] * 2
    x[LAYOUT.force_effect] = force_effect
    x[LAYOUT.decay], x[LAYOUT.uptake] = DECAY_SPM, list(UPTAKE)
    return x


def acting(begin_force_n: float, end_force_n: float, **other: float) -> Acting:
    """On a wheelset that neither rolls nor is locked, with a force that rises evenly."""
    nothing = Acting(*[0.0] * len(Acting._fields))
    return nothing._replace(
        pressing_force_n=0.5 * (begin_force_n + end_force_n), begin_force_n=begin_force_n, end_force_n=end_force_n,
        wheel_radius_m=RADIUS_M, brake_radius_m=BRAKE_RADIUS_M, begin_load_n=LOAD_N, wheel_load_n=LOAD_N,
        has_equation=1.0, unsettled=1.0, force_effect_observable=1.0, friction_observable=1.0, **other,
    )  # fmt: skip


def now(leading: Acting, trailing: Acting) -> Conditions:
    level = ActingOnWagon(MASS_KG, 0.0, 0.0, pitching_mps2=0.0, heading=1.0, torque_error_density=0.0)
    return Conditions(StepLength(STEP_S, 1.0, 0.0), level, [leading, trailing], DENSITIES)


def stepped(x: list[float], leading: Acting, trailing: Acting) -> Predicted:
    return coupled_step(WAGON_OF_TWO, x, np.eye(LAYOUT.size).tolist(), now(leading, trailing))


@pytest.mark.parametrize(
    ("weights", "share"),
    [((1.0, 0.0, 0.0), UPTAKE[0]), ((0.5, 0.5, 0.0), 0.65), ((0.0, 0.0, 1.0), UPTAKE[2]), ((0.0, 0.0, 0.0), 0.0)],
)
def test_the_rail_takes_up_its_share_of_a_change_of_brake_torque(
    weights: tuple[float, float, float], share: float
) -> None:
    names = ("small_slip", "medium_slip", "large_slip")
    leading = acting(30_000.0, 40_000.0, **dict(zip(names, weights, strict=True)))
    moved = stepped(state(), leading, acting(30_000.0, 30_000.0))
    asked = FRICTION * 10_000.0 * BRAKE_RADIUS_M / (LOAD_N * RADIUS_M)
    assert moved.x[LAYOUT.adhesion][0] - ADHESION == pytest.approx(share * asked, rel=1e-9, abs=1e-15)
    assert moved.x[LAYOUT.adhesion][1] == ADHESION


@pytest.mark.parametrize("rolls", [1.0, 0.0])
def test_after_slides_friction_changes_with_the_braking_ratio_and_adhesion_that_follows_it_with_both(
    rolls: float,
) -> None:
    """mu_w = q (mu_b0 + E q) at any q, which a step reaches to first order in Δq."""
    x, full_n, steps = state(FORCE_EFFECT), 80_000.0, 500
    x[LAYOUT.adhesion] = [0.0] * 2
    for k in range(steps):
        begin_force_n, end_force_n = full_n * k / steps, full_n * (k + 1) / steps
        moved = stepped(x, acting(begin_force_n, end_force_n, rolls=rolls), acting(0.0, 0.0))
        x[LAYOUT.friction], x[LAYOUT.adhesion] = moved.x[LAYOUT.friction], moved.x[LAYOUT.adhesion]
    ratio = full_n * BRAKE_RADIUS_M / (LOAD_N * RADIUS_M)
    friction = FRICTION + FORCE_EFFECT * ratio
    assert x[LAYOUT.friction] == pytest.approx([friction, FRICTION], rel=1e-9)
    assert x[LAYOUT.adhesion] == pytest.approx([rolls * ratio * friction, 0.0], rel=1e-3)


def test_a_wheelset_that_rolls_asks_the_rail_for_the_same_force_as_braking_loads_it_more() -> None:
    """mu_w F_z r_W = mu_b F r_B at the old load and at the new one, also where the force rises meanwhile."""
    x, heavier_n, begin_force_n, end_force_n = state(), 1.06 * LOAD_N, 30_000.0, 45_000.0
    asked = FRICTION * BRAKE_RADIUS_M / RADIUS_M
    x[LAYOUT.adhesion] = [asked * begin_force_n / LOAD_N] * 2
    steady, rising = [
        acting(begin_force_n, end, rolls=1.0)._replace(
            wheel_load_n=heavier_n, unsettled=0.0, force_effect_observable=0.0
        )
        for end in (begin_force_n, end_force_n)
    ]
    moved = stepped(x, steady, rising)
    assert np.array(moved.x[LAYOUT.adhesion]) * heavier_n == pytest.approx(
        [asked * begin_force_n, asked * end_force_n], rel=1e-9
    )
    assert moved.x[0] == pytest.approx(x[0], abs=1e-9)  # nothing turns the steady one faster or slower


def test_adhesion_of_a_wheelset_that_slides_decays_exponentially_with_slip_speed() -> None:
    """mu_w = mu_0 e^{-B w}, whatever the brake does; that of one that does not slide stays as it is."""
    x, steps, faster_mps = state(), 250, 2.0
    for direction in (1.0, -1.0):
        for _ in range(steps):
            sliding = acting(30_000.0, 30_000.0, slides=1.0, slip_change_mps=direction * faster_mps / steps)
            rolling = acting(30_000.0, 30_000.0, slip_change_mps=direction)
            x[LAYOUT.adhesion] = stepped(x, sliding, rolling).x[LAYOUT.adhesion]
        expected = ADHESION * np.exp(-DECAY_SPM * faster_mps) if direction > 0.0 else ADHESION
        assert x[LAYOUT.adhesion][0] == pytest.approx(expected, rel=1e-3)
        assert x[LAYOUT.adhesion][1] == ADHESION


def test_the_step_s_matrix_is_the_derivative_of_what_the_rail_gives() -> None:
    leading = acting(30_000.0, 40_000.0, small_slip=0.3, medium_slip=0.7)
    trailing = acting(50_000.0, 20_000.0, large_slip=1.0, slides=1.0, slip_change_mps=0.2)
    x, least = state(FORCE_EFFECT), 1e-6
    step = np.array(stepped(x, leading, trailing).step)
    for place in range(LAYOUT.friction.start, LAYOUT.size):
        higher, lower = list(x), list(x)
        higher[place] += least
        lower[place] -= least
        moved = [np.array(stepped(end, leading, trailing).x) - end for end in (higher, lower)]
        slope = (moved[0] - moved[1]) / (2.0 * least)
        for block in (LAYOUT.friction, LAYOUT.adhesion):
            assert step[block, place] == pytest.approx(slope[block], rel=1e-6, abs=1e-9)
