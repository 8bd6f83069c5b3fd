"""The plant obeys mechanics: balances of force and energy, signs, convergence, standstill, locked wheels, WSP."""

import os
import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from msgspec import structs
from numpy.typing import NDArray

from brake_monitor.settings.config import Vehicle
from brake_monitor.simulator.physics.coupler import TRAIN_MPS2, GivenPull, SpringToTrain
from brake_monitor.simulator.physics.pneumatics import BrakeGear
from brake_monitor.simulator.plant import GRAVITY_MPS2, Modifiers, Plant
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.trace import Trace

PLACES_M = {1: (0.0,), 2: (4.5, -4.5), 4: (9.5, 7.0, -7.0, -9.5)}
NONE = Modifiers()


def vehicle(count: int) -> Vehicle:
    return Vehicle(
        id="test",
        mass_kg=18000.0 * count,
        axle_positions_m=PLACES_M[count],
        cog_height_m=1.6 if count > 1 else 0.0,
        wheelset_inertia_kgm2=(118.0,) * count,
        wheel_radius_m=(0.445,) * count,
        brake_radius_m=(0.247,) * count,
        track_resistance_n=900.0 * count,
        drag_n_per_mps2=1.3 * count,
    )


def braking(level: float, speed_mps: float = 25.0, duration_s: float = 8.0, demand: float = 1.0) -> Scenario:
    """Coast for a second, then brake on a rail of that level."""
    return Scenario("test", "", speed_mps, duration_s, steps((1.0, demand)), Profile(((0.0, level),)))


def simulate(
    scenario: Scenario, count: int = 2, modifiers: Modifiers = NONE, seed: int = 3, step_s: float = 0.001
) -> Trace:
    gears = (BrakeGear(18600.0, -4650.0),) * count
    return Plant(scenario, vehicle(count), gears, modifiers, seed=seed, step_s=step_s).run()


def integral(values: NDArray[np.float64], step_s: float) -> float:
    return float(np.sum(values[1:] + values[:-1]) * 0.5 * step_s)


def kinetic_energy_j(trace: Trace, row: int, count: int) -> float:
    wagon = vehicle(count)
    rotation = sum(118.0 * trace.wheelset(i, "omega_radps")[row] ** 2 for i in range(count))
    return 0.5 * float(wagon.mass_kg * trace.wagon("speed_mps")[row] ** 2 + rotation)


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize(
    ("level", "modifiers"),
    [
        (0.45, NONE),
        (0.04, NONE),
        (0.04, Modifiers(gradient=-0.01, train=GivenPull)),
        (0.04, Modifiers(gradient=0.01, train=SpringToTrain)),
        (0.04, Modifiers(slide_protection=False)),
    ],
    ids=["dry", "sliding", "downhill in a train", "uphill on a spring", "locked"],
)
def test_kinetic_energy_goes_into_brakes_creep_and_resistance(count: int, level: float, modifiers: Modifiers) -> None:
    trace = simulate(braking(level), count, modifiers)
    speed = trace.wagon("speed_mps")
    power = trace.wagon("resistance_n") * speed
    for i in range(count):
        omega = trace.wheelset(i, "omega_radps")
        power = power + trace.wheelset(i, "brake_torque_nm") * omega
        power = power + trace.wheelset(i, "creep_force_n") * (speed - omega * 0.445)
    lost_j = kinetic_energy_j(trace, 0, count) - kinetic_energy_j(trace, -1, count)
    assert integral(power, trace.step_s) == pytest.approx(lost_j, rel=0.005)


@pytest.mark.parametrize("level", [0.45, 0.04])
def test_the_wagon_and_each_wheelset_obey_newton_in_every_step(level: float) -> None:
    trace = simulate(braking(level))
    speed, force = trace.wagon("speed_mps"), trace.wagon("resistance_n").copy()
    for i in range(2):
        creep, omega = trace.wheelset(i, "creep_force_n"), trace.wheelset(i, "omega_radps")
        force += creep
        moment = creep * 0.445 - trace.wheelset(i, "brake_torque_nm")
        change = 118.0 * (omega[-1] - omega[0])
        assert integral(moment, trace.step_s) == pytest.approx(change, abs=0.005 * abs(change) + 1.0)
    np.testing.assert_allclose(trace.wagon("acceleration_mps2"), -force / 36000.0, rtol=1e-9)
    assert integral(force, trace.step_s) == pytest.approx(36000.0 * (speed[0] - speed[-1]), rel=0.001)


def test_halving_the_step_changes_little_and_ever_less() -> None:
    runs = [simulate(braking(0.25, duration_s=4.0), 1, step_s=step_s) for step_s in (0.002, 0.001, 0.0005, 0.00025)]
    ends = [np.array([r.wagon("speed_mps")[-1], 0.445 * r.wheelset(0, "omega_radps")[-1]]) for r in runs]
    errors = [float(np.max(np.abs(a - b))) for a, b in pairwise(ends)]
    assert errors[0] < 0.01
    assert errors[1] < 0.6 * errors[0]
    assert errors[2] < 0.6 * errors[1]


def test_a_free_slide_converges_with_the_step() -> None:
    scenario, unprotected = braking(0.05, duration_s=2.6), Modifiers(slide_protection=False)
    runs = [simulate(scenario, 1, unprotected, step_s=step_s) for step_s in (0.001, 0.0005)]
    slips = [r.wheelset(0, "slip")[-1] for r in runs]
    assert 0.1 < slips[0] < 0.9
    assert slips[0] == pytest.approx(slips[1], rel=0.01)


def test_coasting_is_slowed_by_resistance_alone_and_wheels_roll() -> None:
    trace = simulate(braking(0.45, duration_s=0.9))
    speed = trace.wagon("speed_mps")
    resistance_n = 1800.0 + 2.6 * 25.0**2
    inertia_kg = 36000.0 + 2 * 118.0 / 0.445**2
    assert (speed[0] - speed[-1]) / 0.9 == pytest.approx(resistance_n / inertia_kg, rel=0.01)
    assert all(np.max(np.abs(trace.wheelset(i, "slip"))) < 1e-3 for i in (0, 1))


def test_signs_and_load_transfer_under_braking() -> None:
    trace = simulate(braking(0.45))
    assert trace.wagon("acceleration_mps2")[-1] < 0.0
    for i in (0, 1):
        for name in ("slip", "adhesion", "creep_force_n", "brake_torque_nm", "friction"):
            assert trace.wheelset(i, name)[-1] > 0.0
    leading, trailing = (trace.wheelset(i, "load_n") for i in (0, 1))
    np.testing.assert_allclose(leading + trailing, 36000.0 * GRAVITY_MPS2, rtol=1e-9)
    shift_n = -1.6 / 9.0 * 36000.0 * trace.wagon("acceleration_mps2")[-1]  # (4) of the paper
    assert leading[-1] - 0.5 * 36000.0 * GRAVITY_MPS2 == pytest.approx(shift_n, rel=0.01)


@pytest.mark.parametrize(
    ("modifiers", "height_m"), [(Modifiers(gradient=-0.03), 0.0), (Modifiers(train=GivenPull), 1.6 - 1.0)]
)
def test_wheel_loads_balance_the_moments_about_the_centre_of_mass(modifiers: Modifiers, height_m: float) -> None:
    """Rail and running resistance have the lever of 1.6 m; gravity has none, the coupler a short one."""
    trace = simulate(braking(0.45, duration_s=12.0), modifiers=modifiers)
    loads_n = [trace.wheelset(i, "load_n")[-2000:].mean() for i in (0, 1)]
    rail_n = sum(trace.wheelset(i, "creep_force_n")[-2000:].mean() for i in (0, 1))
    resistance_n = 1800.0 + 2.6 * (trace.wagon("speed_mps")[-2000:] ** 2).mean()
    moment_nm = 1.6 * (rail_n + resistance_n) + height_m * trace.wagon("coupler_force_n")[-2000:].mean()
    assert (loads_n[0] - loads_n[1]) * 4.5 == pytest.approx(moment_nm, rel=0.01)


def test_bogies_that_pitch_balance_the_moments_of_their_pivots_and_all_wheelsets_those_of_the_vehicle() -> None:
    """Each bogie is pulled by half of the force, 0.9 m above the rail; its wheelsets are 2.5 m apart."""
    on_bogies = structs.replace(vehicle(4), wheelsets_per_bogie=2, pivot_height_m=0.9)
    trace = Plant(braking(0.45, duration_s=12.0), on_bogies, (BrakeGear(18600.0, -4650.0),) * 4, NONE, seed=3).run()
    loads_n = np.array([trace.wheelset(i, "load_n")[-2000:].mean() for i in range(4)])
    rail_n = sum(trace.wheelset(i, "creep_force_n")[-2000:].mean() for i in range(4))
    braked_n = rail_n + 3600.0 + 5.2 * (trace.wagon("speed_mps")[-2000:] ** 2).mean()
    assert loads_n.sum() == pytest.approx(72000.0 * GRAVITY_MPS2)
    assert loads_n @ np.array(PLACES_M[4]) == pytest.approx(1.6 * braked_n, rel=0.01)
    for leading, trailing in ((0, 1), (2, 3)):
        assert (loads_n[leading] - loads_n[trailing]) * 1.25 == pytest.approx(0.9 * braked_n / 2, rel=0.01)


@pytest.mark.parametrize("gradient", [0.01, -0.01])
def test_a_gradient_pulls_downhill(gradient: float) -> None:
    scenario = braking(0.45, duration_s=0.9)
    sloping, level = simulate(scenario, modifiers=Modifiers(gradient=gradient)), simulate(scenario)
    difference = sloping.wagon("acceleration_mps2")[800] - level.wagon("acceleration_mps2")[800]
    inertia_factor = 1.0 + 2 * 118.0 / 0.445**2 / 36000.0
    assert difference == pytest.approx(-GRAVITY_MPS2 * gradient / inertia_factor, rel=0.01)


def test_the_coupler_starts_with_the_brake_and_swings() -> None:
    force_n = simulate(braking(0.45, duration_s=12.0), modifiers=Modifiers(train=GivenPull)).wagon("coupler_force_n")
    assert np.all(force_n[:1000] == 0.0)
    assert np.min(force_n[6000:]) >= 9e3
    assert np.max(force_n[6000:]) <= 31e3
    assert np.ptp(force_n[6000:]) > 5e3
    kilonewton_per_s = np.abs(force_n[6100:] - force_n[6000:-100]).max() / 100.0
    assert 3.0 < kilonewton_per_s < 17.0  # of three sines of 10 kN / 3 with 2.3, 4.1 and 7.9 s


def test_a_wagon_on_a_spring_goes_with_its_train() -> None:
    """On a rail on which its own brakes do little, the train stops it; on a good one it holds the train back."""
    slippery, good = (
        simulate(braking(level, duration_s=14.0), modifiers=Modifiers(train=SpringToTrain)) for level in (0.04, 0.45)
    )
    for trace, holds_back in ((slippery, 1.0), (good, -1.0)):
        lost_mps = -np.diff(trace.wagon("speed_mps")[[8000, 14000]])[0]
        assert lost_mps == pytest.approx(TRAIN_MPS2 * 6.0, rel=0.1)
        assert holds_back * trace.wagon("coupler_force_n")[14000] > 2e3
    rail_n = sum(good.wheelset(i, "creep_force_n") for i in (0, 1))
    balance_n = rail_n + good.wagon("resistance_n") + 36000.0 * good.wagon("acceleration_mps2")
    np.testing.assert_allclose(balance_n, 0.0, atol=1e-6 * np.max(rail_n))


def test_mass_factor_and_worn_wheels_are_the_truth() -> None:
    trace = simulate(braking(0.45), modifiers=Modifiers(mass_factor=1.2, wheel_radius_factor=(0.95, 1.0)))
    assert trace.wheelset(0, "load_n")[0] == pytest.approx(0.5 * 1.2 * 36000.0 * GRAVITY_MPS2)
    assert trace.wheelset(0, "omega_radps")[0] == pytest.approx(25.0 / (0.95 * 0.445))
    with pytest.raises(ValueError, match="wheel_radius_factor"):
        simulate(braking(0.45), modifiers=Modifiers(wheel_radius_factor=(1.0, 1.0, 1.0)))


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("gradient", [0.0, 0.02, -0.02])
def test_a_braked_wagon_stops_and_stays(count: int, gradient: float) -> None:
    trace = simulate(braking(0.45, speed_mps=4.0, duration_s=30.0), count, Modifiers(gradient=gradient))
    stopped = int(np.argmax(trace.wagon("speed_mps") == 0.0))
    assert 3.0 < stopped * trace.step_s < 10.0
    assert np.all(trace.wagon("speed_mps")[stopped:] == 0.0)
    assert np.all(trace.wagon("speed_mps")[:stopped] > 0.0)
    assert trace.duration_s == pytest.approx(stopped * trace.step_s + 5.0, abs=0.1)
    for i in range(count):
        assert np.all(trace.wheelset(i, "omega_radps") >= 0.0)
        assert np.all(trace.wheelset(i, "omega_radps")[stopped + 1 :] == 0.0)


def test_without_a_brake_a_steep_hill_turns_the_wagon_back() -> None:
    uphill = simulate(braking(0.45, speed_mps=1.0, duration_s=15.0, demand=0.0), modifiers=Modifiers(gradient=0.03))
    assert uphill.wagon("speed_mps")[-1] < -1.0
    assert uphill.wheelset(0, "omega_radps")[-1] == pytest.approx(uphill.wagon("speed_mps")[-1] / 0.445, rel=0.01)
    assert uphill.wagon("resistance_n")[-1] == pytest.approx(36000 * 9.80665 * 0.03 - 1800, rel=0.01)


def test_a_locked_wheel_stays_locked_until_the_brake_lets_go() -> None:
    scenario = replace(braking(0.02, duration_s=25.0), demand=steps((1.0, 1.0), (15.0, 0.0)))
    trace = simulate(scenario, modifiers=Modifiers(slide_protection=False))
    assert trace.wagon("speed_mps")[-1] > 10.0
    for i in (0, 1):
        omega = trace.wheelset(i, "omega_radps")
        assert np.all(omega >= 0.0)
        locked = omega == 0.0
        assert np.all(locked[8000:15000])
        creep_nm = trace.wheelset(i, "creep_force_n") * 0.445
        np.testing.assert_allclose(trace.wheelset(i, "brake_torque_nm")[locked], creep_nm[locked], rtol=1e-9)
        limit_nm = trace.wheelset(i, "friction") * trace.wheelset(i, "pressing_force_n") * 0.247
        assert np.all(creep_nm[locked] <= limit_nm[locked] * 1.001)
        assert omega[-1] * 0.445 == pytest.approx(trace.wagon("speed_mps")[-1], rel=0.01)


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("level", [0.02, 0.035, 0.05])
def test_the_slide_protection_lets_wheels_slide_but_not_lock(count: int, level: float) -> None:
    trace = simulate(braking(level, duration_s=10.0), count)
    for i in range(count):
        slip = trace.wheelset(i, "slip")
        force_n = trace.wheelset(i, "pressing_force_n")[3000:]
        assert np.max(slip) < 0.3
        assert np.max(slip[3000:]) > 0.05
        assert np.percentile(slip, 95) < 0.25
        assert np.min(force_n) < 0.3 * np.max(force_n)
        assert np.mean(trace.wheelset(i, "wsp")[3000:]) > 0.95
    wagon_n = np.sum([trace.wheelset(i, "creep_force_n") for i in range(count)], axis=0)
    used = wagon_n[3000:] / (18000.0 * count * GRAVITY_MPS2)
    assert np.mean(used) > 0.6 * level  # a good controller brakes with most of what the rail gives
    assert np.max(used) < 1.4 * level


def test_a_dry_rail_needs_no_slide_protection() -> None:
    trace = simulate(braking(0.45))
    assert not np.any(trace.wheelset(0, "wsp"))
    assert not np.any(trace.wheelset(0, "past_peak"))


def test_the_seed_decides_everything() -> None:
    scenario = braking(0.04, duration_s=3.0)
    first, again, other = (simulate(scenario, seed=seed).values for seed in (1, 1, 2))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


def test_compiled_and_plain_python_give_the_same_truth(tmp_path: Path) -> None:
    pytest.importorskip("numba")
    program = (
        "import sys, numpy, test_simulator_plant as t; "
        "numpy.save(sys.argv[1], t.simulate(t.braking(0.04, duration_s=4.0), 2).values)"
    )
    plain = tmp_path / "plain.npy"
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, "-c", program, str(plain)], env=environment, check=True, timeout=300)
    np.testing.assert_allclose(simulate(braking(0.04, duration_s=4.0), 2).values, np.load(plain), rtol=1e-9, atol=1e-9)


def test_rows_may_be_noted_less_often() -> None:
    gears = (BrakeGear(18600.0, -4650.0),) * 2
    sparse = Plant(braking(0.04, duration_s=3.0), vehicle(2), gears, NONE, seed=3, row_s=0.01).run()
    assert sparse.step_s == 0.01
    np.testing.assert_array_equal(sparse.values, simulate(braking(0.04, duration_s=3.0)).values[::10])
