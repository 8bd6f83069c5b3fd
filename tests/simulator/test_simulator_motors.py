"""Motors of the plant: they drive, brake before the pads do, and hand over to them."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from brake_monitor.cli import main
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.samples import Quantity
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.physics.motors import POWER_W_PER_KG, MotorDrive, Motors
from brake_monitor.simulator.physics.pad import NOMINAL_FRICTION
from brake_monitor.simulator.physics.pneumatics import FILL
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording, run

ROW_S = 0.01
DRY = Profile(((0.0, 0.45),))
STOP = Scenario("stop", "from 20 m/s, by 60 %", 20.0, 40.0, steps((2.0, 0.6)), DRY)
FADE_MPS = 8.0
BLENDED = Modifiers(motors=Motors(frozenset({0, 1}), FADE_MPS))


def drive(scenario: Scenario, modifiers: Modifiers) -> Recording:
    return run(scenario, example_settings("railcar"), 3, modifiers, row_s=ROW_S)


@pytest.fixture(scope="module")
def blended() -> Recording:
    return drive(STOP, BLENDED)


def wheelset(recording: Recording, i: int, name: str) -> np.ndarray:
    return recording.trace.wheelset(i, name)


def test_motors_brake_first_and_hand_over_to_their_pads(blended: Recording) -> None:
    speed_mps = blended.trace.wagon("speed_mps")
    settled = np.arange(len(speed_mps)) * ROW_S > 5.0
    fast = settled & (speed_mps > FADE_MPS + 0.5)
    slow = settled & (speed_mps < 0.4 * FADE_MPS) & (speed_mps > 0.5)
    for i in (0, 1):
        assert np.max(wheelset(blended, i, "motor_torque_nm")[fast]) < -1000.0
        assert np.max(wheelset(blended, i, "pressing_force_n")[fast]) == 0.0
        assert np.max(np.abs(wheelset(blended, i, "motor_torque_nm")[slow])) < 100.0
        assert np.min(wheelset(blended, i, "pressing_force_n")[slow]) > 20e3
    for i in (2, 3):
        assert not np.any(wheelset(blended, i, "motor_torque_nm"))
        assert np.min(wheelset(blended, i, "pressing_force_n")[fast]) > 20e3


def test_a_blended_brake_retards_as_the_pads_alone_do(blended: Recording) -> None:
    alone = drive(STOP, Modifiers())
    assert len(blended.trace.values) == pytest.approx(len(alone.trace.values), rel=0.05)


def test_torques_and_forces_account_for_all_momentum(blended: Recording) -> None:
    trace, vehicle = blended.trace, blended.settings.vehicle
    rows = slice(300, 1000)
    rail_n = np.sum([wheelset(blended, i, "creep_force_n") for i in range(4)], axis=0)
    resistance_n = trace.wagon("resistance_n")
    slowed_mps = trace.wagon("speed_mps")[rows.start] - trace.wagon("speed_mps")[rows.stop]
    impulse_ns = float(np.sum((rail_n + resistance_n)[rows])) * ROW_S
    assert impulse_ns == pytest.approx(vehicle.mass_kg * slowed_mps, rel=1e-3)
    for i, (radius_m, inertia) in enumerate(zip(vehicle.wheel_radius_m, vehicle.wheelset_inertia_kgm2, strict=True)):
        braking_nm = wheelset(blended, i, "brake_torque_nm") - wheelset(blended, i, "motor_torque_nm")
        turned_nm = wheelset(blended, i, "creep_force_n") * radius_m - braking_nm
        omega = wheelset(blended, i, "omega_radps")
        spun = inertia * (omega[rows.stop] - omega[rows.start])
        assert float(np.sum(turned_nm[rows])) * ROW_S == pytest.approx(spun, rel=0.02)


def test_slide_protection_takes_the_torque_away() -> None:
    slippery = Scenario("slippery", "", 20.0, 12.0, steps((2.0, 0.8)), Profile(((0.0, 0.04),)))
    slides = drive(slippery, BLENDED)
    torque_nm, wsp = wheelset(slides, 0, "motor_torque_nm"), wheelset(slides, 0, "wsp")
    assert np.any(wsp > 0.0)
    assert np.min(torque_nm) < -2000.0
    assert np.max(torque_nm[wsp > 0.0]) > -200.0
    assert np.max(wheelset(slides, 0, "slip")) < 0.6


def test_motors_start_the_wagon_either_way_and_the_bus_says_accelerating_positive() -> None:
    legs = (Leg(Act.STAND, lasts_s=4.0, demand=0.3), Leg(Act.PULL, 3.0, lasts_s=12.0, pull_mps2=0.4))
    shunting = Scenario("shunting", "", 0.0, 16.0, LegJourney(legs, 1e3, frozenset({1})), DRY)
    back = drive(shunting, BLENDED)
    assert np.min(back.trace.wagon("speed_mps")) < -2.0
    decoder = SignalDecoder.from_settings(back.settings)
    told = [sample for frame in back.frames for sample in decoder.decode(frame) if sample.time_s > EPOCH_S + 8.0]
    torques_nm = [sample.value for sample in told if sample.quantity is Quantity.WHEEL_TORQUE and sample.wheelset == 0]
    assert np.min(torques_nm[:100]) > 500.0
    assert back.trace.wheelset(0, "motor_torque_nm")[-1] == pytest.approx(np.mean(torques_nm[-5:]), abs=200.0)


@pytest.mark.parametrize("demand", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("speed_mps", [0.1, 6.0, 30.0])
def test_motors_brake_either_way_alike_and_no_more_than_they_are_asked_or_able_to(
    demand: float, speed_mps: float
) -> None:
    vehicle = example_settings("railcar").vehicle
    radius_m, full_n = vehicle.wheel_radius_m[0], 40e3
    full_nm = NOMINAL_FRICTION * full_n * vehicle.brake_radius_m[0]
    torques_nm = []
    for way in (1.0, -1.0):
        omega, brake_m = way * speed_mps / radius_m, vehicle.brake_radius_m[0]
        wheel: Any = SimpleNamespace(
            omega_radps=omega, radius_m=radius_m, brake_radius_m=brake_m, full_force_n=full_n, motor_nm=0.0, valve=FILL
        )
        motors = MotorDrive(Motors(frozenset({0}), FADE_MPS), vehicle, [wheel], vehicle.mass_kg)
        for _ in range(300):
            motors.step(0.01, demand, 0.0, [wheel])
        torques_nm.append(wheel.motor_nm)
        assert wheel.blending * demand * full_nm + abs(wheel.motor_nm) == pytest.approx(demand * full_nm, rel=1e-3)
    assert torques_nm[0] == pytest.approx(-torques_nm[1])
    assert 0.0 <= torques_nm[0] <= demand * full_nm + 1e-9
    assert torques_nm[0] * speed_mps / radius_m <= POWER_W_PER_KG * vehicle.mass_kg / vehicle.wheelset_count * 1.001
    assert (torques_nm[0] > 0.0) is (demand > 0.0 and speed_mps > FADE_MPS / 2.0)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--motors", "5"], "has 4 wheelsets"),
        (["--motors", "front"], "numbers of wheelsets"),
        (["--motors-fade", "30"], "--motors 1,2"),
        (["--motors", "1", "--motors-fade", "0"], "km/h, 1 to 200"),
    ],
)
def test_motors_that_cannot_be_are_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = main(["simulate", "dry", "--vehicle", "railcar", "-o", str(tmp_path / "x.log"), *options])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert said in capsys.readouterr().err
