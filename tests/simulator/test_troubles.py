"""What goes wrong in the simulator goes wrong as mechanics say, and what is due of it follows from the truth."""

import dataclasses
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.cli import main
from brake_monitor.frame import FrameKind
from brake_monitor.settings.config import Settings, SignalMapping
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault, set_faults
from brake_monitor.simulator.due import dues
from brake_monitor.simulator.due.alarm import DELAY_S, Due
from brake_monitor.simulator.ordinary_service import ordinary_disturbances, ordinary_service
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S, TRUTH_STEP_S, Recording, run
from brake_monitor.simulator.troubles import AIR_LOST_S, FIRST_S, TROUBLES, Trouble

AFTER_FIRST_S = slice(2500, 5500)  # rows between the first and the second braking


@cache
def wagon() -> Settings:
    return example_settings("wagon")


@cache
def moved(scenario: Scenario, settings: Settings, modifiers: Modifiers) -> Recording:
    return run(scenario, settings, 2, modifiers, row_s=TRUTH_STEP_S)


@cache
def drive(name: str, vehicle: str = "wagon") -> Recording:
    """What is wrong with sensors and the bus changes nothing of how the vehicle moves: one motion serves them all."""
    trouble = TROUBLES.get(name) or Trouble(SCENARIOS[name], Modifiers())
    scenario = dataclasses.replace(trouble.scenario, name="", summary="")
    sound = dataclasses.replace(trouble.modifiers, sensor_faults=(), bus_faults=())
    motion = moved(scenario, trouble.settings(example_settings(vehicle)), sound)
    return dataclasses.replace(motion, modifiers=trouble.modifiers)


def due(name: str, vehicle: str = "wagon") -> list[Due]:
    """What must be raised."""
    return [one for one in dues(drive(name, vehicle)) if one.by_s is not None]


def test_a_cylinder_that_keeps_a_rest_drags_and_its_pressure_shows_it() -> None:
    pressure, force = (drive("residual").trace.wheelset(0, name) for name in ("pressure_bar", "pressing_force_n"))
    assert np.allclose(pressure[AFTER_FIRST_S], 0.6, atol=0.01)
    assert np.allclose(force[AFTER_FIRST_S], 18600.0 * 0.6 - 4650.0, rtol=0.03)
    assert np.all(drive("residual").trace.wheelset(1, "pressing_force_n")[AFTER_FIRST_S] == 0.0)


def test_stuck_pads_drag_while_the_pressure_says_released_and_the_disc_warms() -> None:
    trace = drive("stuck").trace
    assert np.all(trace.wheelset(0, "pressure_bar")[AFTER_FIRST_S] < 0.01)
    assert np.all(trace.wheelset(0, "pressing_force_n")[AFTER_FIRST_S] == 9e3)
    assert trace.wheelset(0, "disc_temperature_c")[5500] > trace.wheelset(0, "disc_temperature_c")[2500] + 3.0
    assert np.all(trace.wheelset(0, "pressing_force_n")[: round(FIRST_S / TRUTH_STEP_S)] == 0.0)


def test_an_isolated_cylinder_never_fills() -> None:
    trace = drive("unapplied").trace
    assert np.all(trace.wheelset(0, "pressure_bar") == 0.0)
    assert np.max(trace.wheelset(1, "pressing_force_n")) > 30e3


def test_a_cylinder_loses_its_air_in_mid_application_and_the_other_does_not() -> None:
    lost, sound = (drive("air-lost").trace.wheelset(i, "pressing_force_n") for i in (0, 1))
    before, after = round((AIR_LOST_S - 1.0) / TRUTH_STEP_S), round((AIR_LOST_S + 5.0) / TRUTH_STEP_S)
    assert lost[before] == pytest.approx(sound[before])
    assert lost[after] == 0.0
    assert sound[after] == pytest.approx(sound[before], rel=0.01)


def test_of_two_it_is_due_only_when_the_next_application_shows_it() -> None:
    (one,) = due("air-lost")
    assert one.from_s - EPOCH_S > 80.0
    assert one.wheelset == 1


def test_of_four_it_is_due_at_once() -> None:
    (first, _) = due("air-lost", "bogie")
    assert first.wheelset == 1
    assert AIR_LOST_S < first.from_s - EPOCH_S < AIR_LOST_S + 3.0


@pytest.mark.parametrize(("name", "kind"), [("residual", "dragging_brake"), ("unapplied", "brake_not_applied")])
def test_of_four_what_two_brakes_do_is_due_of_both(name: str, kind: str) -> None:
    assert {(one.kind, one.wheelset) for one in due(f"{name}-bogie", "bogie")} == {(kind, 1), (kind, 2)}


def test_bad_rigging_weakens_the_force_and_not_the_pressure() -> None:
    trace = drive("uneven").trace
    force, sound = (trace.wheelset(i, "pressing_force_n")[1500] for i in (0, 1))
    assert force == pytest.approx(0.55 * sound, rel=0.01)
    assert trace.wheelset(0, "pressure_bar")[1500] == pytest.approx(trace.wheelset(1, "pressure_bar")[1500])


@pytest.mark.parametrize(("name", "factor"), [("weak-pads", 0.66), ("grabbing-pads", 1.33)])
def test_other_pads_have_another_friction_at_the_same_force(name: str, factor: float) -> None:
    sound, other = (drive(which).trace.wheelset(0, "friction")[1700] for which in ("lost-speed", name))
    assert other == pytest.approx(factor * sound, rel=0.03)


def test_weak_pads_are_due_by_several_stops_to_standstill_and_not_by_the_first() -> None:
    """Gradients, 0.2 m/s² beside sound brakes of 0.53 m/s², make 38 % doubtful by 38 %, over root n of n stops."""
    first = min(one.from_s for one in due("weak-pads-stops")) - EPOCH_S
    stop_s = 88.0
    assert 2 * stop_s < first < 5 * stop_s


def test_hot_pads_fade() -> None:
    trace = drive("fading", "bogie").trace
    hot = trace.wheelset(0, "disc_temperature_c") > 550.0
    braking = trace.wheelset(0, "pressing_force_n") > 20e3
    assert np.mean(trace.wheelset(0, "friction")[hot & braking]) < 0.82 * np.mean(
        trace.wheelset(0, "friction")[~hot & braking][:5000]
    )


def test_on_a_hill_that_may_as_well_be_a_pull_only_hot_discs_are_due_unless_its_gradient_is_told() -> None:
    recording = drive("fading", "bogie")
    assert {one.kind for one in dues(recording) if one.by_s is not None} == {"hot_disc"}
    signals = replace(recording.settings.signals, gradient=SignalMapping("Track", "gradient", "1"))
    told = dataclasses.replace(recording, settings=replace(recording.settings, signals=signals))
    assert {one.kind for one in dues(told) if one.by_s is not None} == {"hot_disc", "friction_out_of_band"}


@pytest.mark.parametrize("name", ["locked", "dragged"])
def test_without_slide_protection_the_wheels_lock_and_are_dragged(name: str) -> None:
    trace = drive(name).trace
    locked = (trace.wheelset(0, "omega_radps") == 0.0) & (trace.wagon("speed_mps") > 5.0)
    assert np.sum(locked) * TRUTH_STEP_S > 20.0
    released = np.arange(len(locked)) * TRUTH_STEP_S > 52.0
    assert np.any(locked & released) == (name == "dragged")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("wsp", {("low_adhesion", None)}),
        ("leaf", {("low_adhesion", None)}),
        (
            "locked",
            {
                ("low_adhesion", None),
                ("slide", 1),
                ("slide", 2),
                ("wheelset_not_rotating", 1),
                ("wheelset_not_rotating", 2),
            },
        ),
        ("residual", {("dragging_brake", 1)}),
        ("stuck", {("dragging_brake", 1)}),
        ("unapplied", {("brake_not_applied", 1)}),
        ("air-lost", {("brake_not_applied", 1)}),
        ("uneven", {("uneven_braking", 1), ("friction_out_of_band", 1)}),
        ("weak-pads", {("friction_out_of_band", 1), ("friction_out_of_band", 2)}),
        ("weak-pads-stops", {("friction_out_of_band", 1), ("friction_out_of_band", 2)}),
        ("grabbing-pads", {("friction_out_of_band", 1), ("friction_out_of_band", 2)}),
        ("hot", {("hot_disc", 1), ("hot_disc", 2)}),
        ("worn", {("pad_near_limit", 1), ("pad_near_limit", 2)}),
        ("lost-speed", {("input_lost", None)}),
        ("lost-pressures", {("input_lost", 1)}),
        ("frozen-wheel-speed", {("input_implausible", 1)}),
        ("dead-wheel-speed", {("input_implausible", 1)}),
        ("silent", {("bus_silent", None)}),
        ("bus-off", {("bus_fault", None)}),
        ("biased-wheel-speed", set()),
    ],
)
def test_exactly_what_is_wrong_is_due(name: str, expected: set[tuple[str, int | None]]) -> None:
    assert {(one.kind, one.wheelset) for one in due(name)} == expected


def test_a_locked_wheelset_is_due_three_seconds_after_it_stopped_turning() -> None:
    trace, locked = drive("locked").trace, [one for one in due("locked") if one.kind == "wheelset_not_rotating"]
    assert locked
    for one in locked:
        assert one.wheelset is not None
        turns = np.abs(trace.wheelset(one.wheelset - 1, "omega_radps")) * 0.445 > 0.03 * trace.wagon("speed_mps")
        stopped_s = float(np.argmin(turns)) * TRUTH_STEP_S
        assert one.by_s == pytest.approx(EPOCH_S + stopped_s + DELAY_S[one.kind], abs=0.02)


@cache
def in_service(vehicle: str, seed: int) -> Recording:
    """A quarter of an hour."""
    settings = example_settings(vehicle)
    modifiers = ordinary_disturbances(seed, settings.vehicle.wheelset_count, in_train=seed % 2 == 0)
    return run(ordinary_service(seed, 900.0), settings, seed, modifiers, row_s=TRUTH_STEP_S)


ALONE, PULLED = ("bogie", 1), ("wagon", 4)  # by a train, which sets back


@pytest.mark.parametrize(("vehicle", "seed"), [ALONE, PULLED])
def test_in_ordinary_service_nothing_is_due_and_nothing_slides(vehicle: str, seed: int) -> None:
    service = in_service(vehicle, seed)
    assert dues(service) == []
    trace = service.trace
    speed_mps = trace.wagon("speed_mps")
    assert np.max(speed_mps) > 8.0
    assert np.sum(speed_mps == 0.0) * TRUTH_STEP_S > 20.0
    assert np.ptp(trace.wagon("gradient")) > 0.004
    for i in range(trace.wheelset_count):
        assert not np.any(trace.wheelset(i, "past_peak"))
        assert not np.any(trace.wheelset(i, "wsp"))
        assert np.max(trace.wheelset(i, "disc_temperature_c")) < 250.0


def test_some_service_goes_backwards_and_the_bus_tells_no_sign() -> None:
    service = in_service(*PULLED)
    speed_mps = service.trace.wagon("speed_mps")
    assert np.min(speed_mps) < -1.0
    gnss = [frame for frame in service.frames if frame.can_id == 672]
    shown = np.array([int.from_bytes(frame.data[:2], "little") * 0.005 for frame in gnss])
    truth = np.interp([f.time_s - EPOCH_S for f in gnss], np.arange(len(speed_mps)) * TRUTH_STEP_S, speed_mps)
    assert np.max(np.abs(shown - np.abs(truth))) < 0.2


@pytest.mark.parametrize(
    ("failure", "said_rpm"),
    [
        (SensorFailure.FROZEN, [100.0, 110.0, 120.0, 120.0, 120.0, 150.0]),
        (SensorFailure.STUCK, [100.0, 110.0, 30.0, 30.0, 30.0, 150.0]),
        (SensorFailure.BIASED, [100.0, 110.0, 150.0, 160.0, 170.0, 150.0]),
        (SensorFailure.LOST, [100.0, 110.0, 120.0, 130.0, 140.0, 150.0]),
    ],
)
def test_a_sensor_says_the_wrong_thing_while_its_fault_lasts(failure: SensorFailure, said_rpm: list[float]) -> None:
    """By the SI value of the fault, in the sensor's unit."""
    radps_per_rpm = np.pi / 30.0
    fault = SensorFault("axle_speed", 0, failure, from_s=2.0, to_s=5.0, value=30.0 * radps_per_rpm)
    times_s = np.arange(6.0)
    assert fault.reading(times_s, 100.0 + 10.0 * times_s, radps_per_rpm).tolist() == pytest.approx(said_rpm)


def test_a_fault_of_a_brake_begins_at_its_time_and_on_its_wheelset() -> None:
    fault = BrakeFault(1, 10.0, True, 0.6, 9e3, 0.5, Profile(((0.0, 0.7),)))
    sound, early, late = ([SimpleNamespace(), SimpleNamespace()] for _ in range(3))
    set_faults((), 0.0, sound)
    set_faults((fault,), 9.9, early)
    assert early == sound
    set_faults((fault,), 10.0, late)
    assert late[0] == sound[0]
    assert vars(late[1]) == {"inlet": 0.0, "least_bar": 0.6, "stuck_n": 9e3, "rigging": 0.5, "friction_factor": 0.7}


def test_faults_of_one_brake_act_together() -> None:
    wheels = [SimpleNamespace()]
    worn = BrakeFault(friction=Profile(((0.0, 0.8),)))
    bent = BrakeFault(0, rigging=0.5, residual_bar=0.4)
    leaking = BrakeFault(0, rigging=0.9, residual_bar=0.3)
    set_faults((bent, BrakeFault(0, stuck_force_n=5e3), worn, leaking), 1.0, wheels)
    set_faults((bent, BrakeFault(0, stuck_force_n=5e3), worn, leaking), 2.0, wheels)
    expected = {"inlet": 1.0, "least_bar": 0.4, "stuck_n": 5e3, "rigging": 0.45, "friction_factor": 0.8}
    assert vars(wheels[0]) == pytest.approx(expected)


def test_a_silent_bus_carries_nothing_and_a_bad_contact_error_frames() -> None:
    def between(name: str, from_s: float, to_s: float) -> list[FrameKind]:
        return [f.kind for f in drive(name).frames if from_s <= f.time_s - EPOCH_S < to_s]

    assert between("silent", 30.0, 38.0) == []
    assert len(between("silent", 38.0, 39.0)) > 150
    noisy = between("error-frames", 30.0, 31.0)
    assert noisy.count(FrameKind.ERROR) == 50
    assert 80 < noisy.count(FrameKind.DATA) < 110


def test_the_command_writes_what_is_due(tmp_path: Path) -> None:
    assert main(["simulate", "stuck", "--seed", "2", "--due", str(tmp_path / "due.jsonl")]) == 0
    lines = (tmp_path / "due.jsonl").read_bytes().splitlines()
    assert [msgspec.json.decode(line, type=Due) for line in lines] == dues(drive("stuck"))


def test_a_trouble_that_one_wheelset_cannot_have_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "uneven", "--vehicle", "rig", "--due", "x"]) == 2
    assert "at least 2 wheelsets" in capsys.readouterr().err
