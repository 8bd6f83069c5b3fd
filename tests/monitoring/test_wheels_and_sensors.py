"""A stopped wheelset is not taken for a dead sensor, nor a sensor's fault for the wheelset's or the rail's."""

from collections.abc import Iterable
from dataclasses import replace
from functools import cache
from itertools import product
from math import inf

import pytest

from brake_monitor.frame import Frame, FrameKind
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Scenario, steps
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from faults import (
    Fault,
    beyond_range,
    biased,
    changed,
    error_code,
    frozen,
    lagging,
    lost,
    noisy,
    repeating_gateway,
    signal_changed,
    silence,
    stuck,
)

DRY = Scenario(
    name="braking on a dry rail",
    summary="coast, brake from 12 to 18 s, coast",
    initial_speed_mps=20.0,
    duration_s=30.0,
    demand=steps((12.0, 0.5), (18.0, 0.0)),
    rail_over_time=Profile(((0.0, 0.4),)),
)
SLIPPERY = Scenario(
    name="full brake on a slippery rail",
    summary="coast, full brake from 6 to 16 s, released",
    initial_speed_mps=20.0,
    duration_s=22.0,
    demand=steps((6.0, 1.0), (16.0, 0.0)),
    rail_over_time=Profile(((0.0, 0.05),)),
)
STANDING = Scenario(
    name="stop",
    summary="stops and stands",
    initial_speed_mps=6.0,
    duration_s=30.0,
    demand=steps((2.0, 0.6)),
    rail_over_time=Profile(((0.0, 0.4),)),
)
GENTLE = replace(
    STANDING,
    name="gentle stop",
    summary="stops with a fifth of the full brake",
    duration_s=60.0,
    demand=steps((2.0, 0.2)),
)
HARD = Scenario(
    name="full brake on a dry rail",
    summary="coast, full brake from 6 s until it stands",
    initial_speed_mps=20.0,
    duration_s=40.0,
    demand=steps((6.0, 1.0)),
    rail_over_time=Profile(((0.0, 0.4),)),
)
LONG = Scenario(
    name="long braking on a dry rail",
    summary="coast, brake from 8 to 24 s",
    initial_speed_mps=30.0,
    duration_s=25.0,
    demand=steps((8.0, 0.4), (24.0, 0.0)),
    rail_over_time=Profile(((0.0, 0.4),)),
)
PULLED = Scenario(
    name="pulled away",
    summary="a train pulls away to 25 m/s and stops",
    initial_speed_mps=2.0,
    duration_s=120.0,
    demand=LegJourney((Leg(Act.PULL, 25.0, pull_mps2=0.6), Leg(Act.STAND, lasts_s=5.0, demand=0.6)), 2000.0),
    rail_over_time=Profile(((0.0, 0.4),)),
)
LOCKED_SLIP = 0.97
RAISED_WITHIN_S = 3.0
WHEELS = ("n_A", "n_B")


@cache
def settings(vehicle: str = "wagon") -> Settings:
    return example_settings(vehicle)


@cache
def recording(scenario: Scenario, vehicle: str = "wagon", **modifiers: object) -> Recording:
    return simulate(scenario, settings(vehicle), seed=3, modifiers=Modifiers(**modifiers))  # type: ignore[arg-type]


def alarms(frames: Iterable[Frame], vehicle: str = "wagon") -> dict[tuple[str, int | None], Alarm]:
    """The last state of each, by kind and wheelset."""
    pipeline = Pipeline.from_settings(settings(vehicle))
    given = [alarm for frame in frames for alarm in pipeline.step(frame).alarms]
    return {(a.kind, a.wheelset): a for a in (*given, *pipeline.monitor.open_alarms())}


@cache
def alarms_as_simulated(scenario: Scenario, **modifiers: object) -> dict[tuple[str, int | None], Alarm]:
    """Of the wagon, with no fault but those of the simulator."""
    return alarms(recording(scenario, **modifiers).frames)


def kinds(found: dict[tuple[str, int | None], Alarm]) -> set[str]:
    return {kind for kind, _ in found}


def locked_from_s(run: Recording, wheelset: int) -> float:
    """When the truth says that it stands."""
    column = run.truth_header().index(f"slip_{wheelset}")
    return next(row[0] for row in run.truth() if row[column] > LOCKED_SLIP)


@pytest.mark.parametrize("vehicle", ["rig", "wagon", "bogie"])
def test_every_locked_wheelset_is_told_within_three_seconds(vehicle: str) -> None:
    run = recording(SLIPPERY, vehicle, slide_protection=False)
    found = alarms(run.frames, vehicle)
    for wheelset in range(1, settings(vehicle).vehicle.wheelset_count + 1):
        raised_s = found["wheelset_not_rotating", wheelset].raised_time_s
        assert 0.0 <= raised_s - locked_from_s(run, wheelset) <= RAISED_WITHIN_S
        assert found["slide", wheelset].severity == "alarm"  # dragged for far more than 50 m
    assert "input_implausible" not in kinds(found)


def test_a_recording_that_begins_with_locked_wheelsets_tells_of_them() -> None:
    frames = recording(SLIPPERY, slide_protection=False).frames
    begun = [frame for frame in frames if frame.time_s > EPOCH_S + 12.0]
    found = alarms(begun)
    for wheelset in (1, 2):
        assert found["wheelset_not_rotating", wheelset].raised_time_s - begun[0].time_s <= RAISED_WITHIN_S
    assert "input_implausible" not in kinds(found)


@pytest.mark.parametrize("vehicle", ["rig", "wagon", "bogie"])
def test_wheelsets_that_lock_while_the_vehicle_speed_is_away_are_told_when_it_is_back(vehicle: str) -> None:
    """Meanwhile the wagon has lost more speed than it does from one reading to the next."""
    away_s, back_s = 6.5, 12.0
    away = SensorFault("speed", 0, SensorFailure.LOST, away_s, back_s)
    run = recording(SLIPPERY, vehicle, slide_protection=False, sensor_faults=(away,))
    assert away_s < locked_from_s(run, 1) - EPOCH_S < back_s
    found = alarms(run.frames, vehicle)
    for wheelset in range(1, settings(vehicle).vehicle.wheelset_count + 1):
        assert found["wheelset_not_rotating", wheelset].raised_time_s - EPOCH_S - back_s <= RAISED_WITHIN_S
    assert "input_implausible" not in kinds(found)


def test_a_vehicle_speed_that_comes_back_as_no_wagon_can_have_become_is_contradicted() -> None:
    doubled = signal_changed("vehicle speed", lambda _, v: 2 * v, 13.0, inf)(recording(DRY).frames)
    found = alarms(lost("GNSS", 12.0, 15.0)(doubled))
    assert set(found) == {("input_lost", None), ("input_implausible", None)}


def test_the_wheel_slide_protection_lets_no_wheelset_stand() -> None:
    assert "wheelset_not_rotating" not in kinds(alarms_as_simulated(SLIPPERY))


def test_low_adhesion_is_told_with_its_severity_and_place_within_a_second() -> None:
    run = recording(SLIPPERY)
    alarm = alarms_as_simulated(SLIPPERY)["low_adhesion", None]
    evidence = alarm.evidence
    assert alarm.severity in {"warning", "info"}  # the rail's peak is about 0.045, what slides gets less
    assert 0.02 < evidence["least_adhesion"] <= evidence["median_adhesion"] < 0.06
    assert evidence["latitude_deg_start"] < evidence["latitude_deg_end"]  # the track runs north
    degrees = evidence["latitude_deg_end"] - evidence["latitude_deg_start"]
    assert evidence["distance_m"] == pytest.approx(degrees * 111_320.0, abs=25.0)  # positions come once a second
    slips = [run.truth_header().index(f"slip_{wheelset}") for wheelset in (1, 2)]
    sliding = [row[0] for row in run.truth() if max(row[place] for place in slips) > 0.05]
    assert alarm.raised_time_s - sliding[0] <= 1.0 + 0.5


@pytest.mark.parametrize(("quantity", "message"), [("axle_speed", "WSP"), ("pressing_force", "BCU")])
def test_low_adhesion_is_told_by_wheelsets_that_miss_nothing(quantity: str, message: str) -> None:
    """One sensor of another wheelset is dead from the beginning; where all are, nothing is known of the rail."""
    whole = alarms_as_simulated(SLIPPERY)["low_adhesion", None]
    run = recording(SLIPPERY, sensor_faults=(SensorFault(quantity, 0, SensorFailure.ERROR_CODE, 0.0),))
    found = alarms(run.frames)
    assert ("input_implausible", 1) in found
    alarm = found["low_adhesion", None]
    assert alarm.raised_time_s - whole.raised_time_s < 2.0
    assert alarm.evidence["median_adhesion"] == pytest.approx(whole.evidence["median_adhesion"], rel=0.2)
    assert "low_adhesion" not in kinds(alarms(lost(message, 0.0, inf)(run.frames)))


FAULTS: list[tuple[str, Fault, set[tuple[str, int | None]]]] = [
    ("wheel speed dies while coasting", signal_changed("wheel speed", lambda *_: 0.0, 8.0, inf), {("implausible", 1)}),
    ("wheel speed dies in braking", signal_changed("wheel speed", lambda *_: 0.0, 14.0, inf), {("implausible", 1)}),
    ("wheel speed is dead", signal_changed("wheel speed", lambda *_: 0.0, 0.0, inf), {("implausible", 1)}),
    (
        "all wheel speeds die",
        changed("WSP", WHEELS, lambda *_: 0.0, 8.0, inf),
        {("implausible", 1), ("implausible", 2)},
    ),
    ("wheel speed freezes", frozen("wheel speed", 13.0, inf), {("implausible", 1)}),
    ("wheel speed scatters", noisy("WSP", ("n_A",), 1.0, 2.0), {("implausible", 1)}),
    ("all wheel speeds scatter: no sensor alone", noisy("WSP", WHEELS, 1.0, 2.0), set()),
    ("vehicle speed scatters", noisy("GNSS", ("v_ground",), 0.35, 2.0), {("implausible", None)}),
    ("wheel speed is 15 % low", biased("wheel speed", 0.85), {("implausible", 1)}),
    ("wheel speed is 15 % high", biased("wheel speed", 1.15), {("implausible", 1)}),
    ("wheel speed is 20 % low", biased("wheel speed", 0.80), {("implausible", 1)}),
    ("wheel speed is 20 % high", biased("wheel speed", 1.20), {("implausible", 1)}),
    (
        "all wheel speeds are 15 % low",
        changed("WSP", WHEELS, lambda _, v: 0.85 * v, 0.0, inf),
        {("implausible", 1), ("implausible", 2)},
    ),
    ("vehicle speed is nought", signal_changed("vehicle speed", lambda *_: 0.0, 13.0, 20.0), {("implausible", None)}),
    ("vehicle speed doubles", signal_changed("vehicle speed", lambda _, v: 2 * v, 13.0, 20.0), {("implausible", None)}),
    (
        "vehicle speed is 25 % high",
        signal_changed("vehicle speed", lambda _, v: 1.25 * v, 2.0, inf),
        {("implausible", None)},
    ),
    (
        "vehicle speed is 20 % low",
        signal_changed("vehicle speed", lambda _, v: 0.8 * v, 5.0, inf),
        {("implausible", None)},
    ),
    ("vehicle speed freezes", frozen("vehicle speed", 12.5, inf), {("implausible", None)}),
    ("vehicle speed is an error code", error_code("vehicle speed", 10.0, 20.0), {("implausible", None)}),
    ("vehicle speed is out of range", beyond_range("vehicle speed", 10.0, 20.0), {("implausible", None)}),
    ("pressing force is an error code", error_code("pressing force", 10.0, 20.0), {("implausible", 1)}),
    ("brake control repeats a frame", stuck("BCU", 13.0, 20.0), {("implausible", 1), ("implausible", 2)}),
    ("pressing force freezes", frozen("pressing force", 14.0, inf), {("implausible", 1)}),
    ("wheel speeds are lost", lost("WSP", 14.0, 20.0), {("lost", 1), ("lost", 2)}),
    ("pressing forces are lost", lost("BCU", 14.0, 20.0), {("lost", 1), ("lost", 2)}),
    ("vehicle speed is lost", lost("GNSS", 10.0, 20.0), {("lost", None)}),
    (
        "a gateway repeats what it was told",
        repeating_gateway(10.0, inf),
        {("implausible", None), ("implausible", 1), ("implausible", 2)},
    ),
    (
        "a gateway repeats what it was told for a while",
        repeating_gateway(10.0, 20.0),
        {("implausible", None), ("implausible", 1), ("implausible", 2)},
    ),
]


@pytest.mark.parametrize(("fault", "due"), [case[1:] for case in FAULTS], ids=[case[0] for case in FAULTS])
def test_a_sensor_fault_is_told_as_such_and_as_nothing_else(fault: Fault, due: set[tuple[str, int | None]]) -> None:
    found = alarms(fault(recording(DRY).frames))
    assert set(found) == {(f"input_{kind}", wheelset) for kind, wheelset in due}


@pytest.mark.parametrize(("scenario", "from_s", "to_s"), [(HARD, 8.0, 16.0), (LONG, 12.0, 18.0)])
def test_what_a_gateway_tells_again_in_a_braking_accuses_no_sensor_after_it(
    scenario: Scenario, from_s: float, to_s: float
) -> None:
    """All speeds fall at once when it hears of them again. Pads press meanwhile with a force that stands still too."""
    found = alarms(repeating_gateway(from_s, to_s)(recording(scenario).frames))
    assert set(found) == {("input_implausible", wheelset) for wheelset in (None, 1, 2)}
    for alarm in found.values():
        assert set(str(alarm.evidence["conditions"]).split(", ")) == {"repeated"}
        assert alarm.raised_time_s - EPOCH_S < from_s + 2.5
        assert alarm.cleared_time_s - EPOCH_S < to_s + 6.0


def test_a_tunnel_beside_a_dead_wheel_speed_is_survived() -> None:
    """No slip is told while the vehicle speed is lost; a wheelset that seems to stand yet does not roll freely."""
    dies, tunnel = signal_changed("wheel speed", lambda *_: 0.0, 0.0, inf), lost("GNSS", 3.0, 11.0)
    assert set(alarms(tunnel(dies(recording(DRY).frames)))) == {("input_implausible", 1), ("input_lost", None)}


@pytest.mark.parametrize("pause_s", [0.5, 3.0])
@pytest.mark.parametrize("ended_s", [10.0, 13.0])
def test_a_wheel_speed_that_is_known_to_be_dead_stops_no_wheelset_after_a_restart(
    ended_s: float, pause_s: float
) -> None:
    """It died at 4 s; the program ends before or as the brake is applied, and goes on as it presses."""
    frames = signal_changed("wheel speed", lambda _, __: 0.0, 4.0, inf)(recording(DRY).frames)
    begun_s = EPOCH_S + max(ended_s + pause_s, 13.0)
    first, second = (Pipeline.from_settings(settings()) for _ in range(2))
    raised = [a for f in frames if f.time_s < EPOCH_S + ended_s for a in first.step(f).alarms]
    second.resume(first.remembered())
    raised += [a for f in frames if f.time_s >= begun_s for a in second.step(f).alarms]
    assert {alarm.id for alarm in raised} == {raised[0].id}
    assert (raised[0].kind, raised[0].wheelset) == ("input_implausible", 1)


@pytest.mark.parametrize("which", [{1}, {1, 2}])
def test_a_wheelset_that_stands_goes_on_to_be_told_after_a_restart(which: set[int]) -> None:
    """Its brake locks it in the braking, and all are released: by itself a 0 would be that of a sensor."""
    signals, until_s, begun_s = tuple(f"n_{'AB'[i - 1]}" for i in which), EPOCH_S + 20.0, EPOCH_S + 20.5
    locks = changed("WSP", signals, lambda t, v: v * min(max((13.6 - t) / 0.6, 0.0), 1.0), 13.0, inf)
    frames = locks(recording(DRY).frames)
    first, second = (Pipeline.from_settings(settings()) for _ in range(2))
    before = [a for f in frames if f.time_s < until_s for a in first.step(f).alarms]
    second.resume(first.remembered())
    after = [a for f in frames if f.time_s >= begun_s for a in second.step(f).alarms]
    standing = {alarm.id for alarm in before if alarm.kind == "wheelset_not_rotating"}
    assert {alarm.wheelset for alarm in before if alarm.id in standing} == which
    assert not {alarm.kind for alarm in after} & {"input_implausible"}
    still = {alarm.id: alarm for alarm in second.monitor.open_alarms() if alarm.id in standing}
    assert set(still) == standing
    for alarm in still.values():
        now_m, then_m = alarm.evidence["dragged_m"], first_of(before, alarm.id).evidence["dragged_m"]
        assert isinstance(now_m, float)
        assert isinstance(then_m, float)
        assert now_m > then_m + 50.0


def first_of(alarms: list[Alarm], alarm_id: str) -> Alarm:
    """The alarm as it was raised."""
    return next(alarm for alarm in alarms if alarm.id == alarm_id)


@pytest.mark.parametrize("died_s", [4.0, 15.0], ids=["before the first braking", "in it"])
@pytest.mark.parametrize("ended_s", [25.0, 29.0, 31.5])
def test_a_pressing_force_that_is_known_to_be_dead_accuses_no_brake_after_a_restart(
    ended_s: float, died_s: float
) -> None:
    """It says 0 from then on. The program ends between two brakings, or in the second one."""
    demand = steps((12.0, 0.5), (20.0, 0.0), (30.0, 0.5), (40.0, 0.0))
    twice = replace(DRY, initial_speed_mps=28.0, duration_s=45.0, demand=demand)
    frames = signal_changed("pressing force", lambda _, __: 0.0, died_s, inf)(recording(twice).frames)
    first, second = (Pipeline.from_settings(settings()) for _ in range(2))
    raised = [a for f in frames if f.time_s < EPOCH_S + ended_s for a in first.step(f).alarms]
    second.resume(first.remembered())
    raised += [a for f in frames if f.time_s >= EPOCH_S + ended_s + 0.5 for a in second.step(f).alarms]
    assert {alarm.id for alarm in raised} == {raised[0].id}
    assert (raised[0].kind, raised[0].wheelset) == ("input_implausible", 1)


@pytest.mark.parametrize(("scenario", "cut_out_kmh"), [*product((STANDING, GENTLE, HARD), (5.5, 9.0)), (PULLED, 7.0)])
def test_wheel_speed_sensors_that_cut_out_at_a_crawl_tell_nothing_of_the_rail(
    scenario: Scenario, cut_out_kmh: float
) -> None:
    """Passive ones give no pulses below some km/h; what a hard brake does not stop in time reads the same."""
    cut_out = changed("WSP", WHEELS, lambda _, kmh: 0.0 if kmh < cut_out_kmh else kmh, 0.0, inf)
    worn = {"wheel_radius_factor": (1.0, 0.97)}  # the worn one cuts out later
    assert kinds(alarms(cut_out(recording(scenario, **worn).frames))) == kinds(alarms_as_simulated(scenario, **worn))


def test_a_vehicle_speed_that_lags_while_a_train_pulls_away_accuses_no_wheel_speed() -> None:
    assert "input_implausible" not in kinds(alarms(lagging("GNSS", 1.5)(recording(PULLED).frames)))


@pytest.mark.parametrize("begins_s", [0.0, 13.0])
def test_nothing_is_told_of_a_recording_that_begins_anywhere(begins_s: float) -> None:
    frames = [frame for frame in recording(DRY).frames if frame.time_s >= EPOCH_S + begins_s]
    assert alarms(frames) == {}


@pytest.mark.parametrize("begins_s", [0.0, 20.0])
def test_a_vehicle_speed_at_standstill_stops_no_wheelset(begins_s: float) -> None:
    run = recording(STANDING)
    stood_s = run.duration_s - 4.0
    begins_s = min(begins_s, stood_s - 0.5)
    frames = [f for f in run.frames if f.time_s >= EPOCH_S + begins_s]
    said = signal_changed("vehicle speed", lambda *_: 20.0, stood_s if begins_s == 0.0 else 0.0, inf)(frames)
    assert set(alarms(said)) == {("input_implausible", None)}


def test_silence_within_a_recording_is_the_buss_and_ends_with_it() -> None:
    (alarm,) = alarms(silence(14.0, 20.0)(recording(DRY).frames)).values()
    assert alarm.kind == "bus_silent"
    assert alarm.raised_time_s - EPOCH_S == pytest.approx(16.0, abs=0.2)
    assert alarm.cleared_time_s - EPOCH_S == pytest.approx(22.0, abs=0.3)


def test_a_silence_of_an_hour_is_not_said_to_be_shorter() -> None:
    """The rules see a minute of it."""
    frames = recording(DRY).frames
    later = [f if f.time_s < EPOCH_S + 14.0 else f._replace(time_s=f.time_s + 3600.0) for f in frames]
    (alarm,) = alarms(later).values()
    assert alarm.message.startswith("No frame for at least 60 s on bus can0: ")


def test_silence_at_the_end_of_a_recording_is_none() -> None:
    assert alarms(silence(14.0, inf)(recording(DRY).frames)) == {}


def error_frames(from_s: float, count: int, can_id: int) -> list[Frame]:
    return [Frame(EPOCH_S + from_s + k / 50, "can0", can_id, False, bytes(8), FrameKind.ERROR) for k in range(count)]


@pytest.mark.parametrize(
    ("errors", "severity"),
    [
        (error_frames(14.0, 50, 0x08), "warning"),
        (error_frames(14.0, 1, 0x40), "alarm"),
        (error_frames(14.0, 3, 0x08), None),
    ],
    ids=["many errors", "bus-off", "a few errors"],
)
def test_error_frames_are_the_buss(errors: list[Frame], severity: str | None) -> None:
    frames = recording(DRY).frames
    if severity == "alarm":
        frames = silence(14.0, 15.5)(frames)
    found = alarms(sorted([*frames, *errors], key=lambda frame: frame.time_s))
    assert {key: alarm.severity for key, alarm in found.items()} == (
        {("bus_fault", None): severity} if severity else {}
    )


def test_an_interface_that_is_down_is_the_buss() -> None:
    frames = recording(DRY).frames
    pipeline = Pipeline.from_settings(settings())
    for frame in frames[:500]:
        pipeline.step(frame)
    pipeline.bus_down("can0", True)
    (alarm,) = pipeline.advance(frames[499].time_s + 1.0).alarms
    assert (alarm.kind, alarm.severity) == ("bus_fault", "alarm")


def test_a_vehicle_speed_that_lags_by_a_second_is_no_slide() -> None:
    """The wheelsets turn more slowly than it says by what the wagon has lost meanwhile, more than 5 % in the end."""
    assert not kinds(alarms(lagging("GNSS", 1.0)(recording(HARD).frames))) & {"low_adhesion", "slide"}


@pytest.mark.parametrize("failing_from_s", [10.0, 22.0])
def test_a_frozen_vehicle_speed_stays_frozen_when_the_wagon_stands(failing_from_s: float) -> None:
    found = alarms(frozen("vehicle speed", failing_from_s, inf)(recording(HARD).frames))
    assert found["input_implausible", None].cleared_time_s is None
    assert kinds(found) == {"input_implausible"}


@pytest.mark.parametrize("factor", [0.6, 1.5])
def test_a_wheel_that_turns_as_nothing_makes_it_turn_is_a_sensor(factor: float) -> None:
    """No brake presses until 12 s."""
    reading = signal_changed("wheel speed", lambda _, value: factor * value, 5.0, inf)
    found = alarms(reading(recording(DRY).frames))
    assert kinds(found) == {"input_implausible"}
    assert found["input_implausible", 1].raised_time_s - EPOCH_S < 10.0


@pytest.mark.parametrize("value_bar", [0.0, 2.0])
def test_a_pressure_that_stands_still_is_no_brake_fault(value_bar: float) -> None:
    found = alarms(signal_changed("pressing force", lambda _, __: value_bar, 5.0, inf)(recording(HARD).frames))
    assert kinds(found) == {"input_implausible"}
    assert ("input_implausible", 1) in found


def test_a_pressure_that_dies_in_mid_brake_is_no_brake_fault() -> None:
    found = alarms(signal_changed("pressing force", lambda _, __: 0.0, 12.0, inf)(recording(HARD).frames))
    assert set(found) == {("input_implausible", 1)}
    assert found["input_implausible", 1].raised_time_s - EPOCH_S < 18.0


def test_a_brake_that_loses_its_air_beside_three_that_coarse_sensors_show_still_is_no_sensor_fault() -> None:
    """The pressures come in steps of 0.05 bar; from 16 s on no air reaches the first cylinder any more."""
    frames = recording(LONG, "bogie", brake_faults=(BrakeFault(0, from_s=16.0, isolated=True),)).frames
    for message, signals in (("BrakeLead", ("p_1", "p_2")), ("BrakeTrail", ("p_3", "p_4"))):
        frames = changed(message, signals, lambda _, bar: round(bar / 0.05) * 0.05, 0.0, inf, vehicle="bogie")(frames)
    assert set(alarms(frames, "bogie")) == {("brake_not_applied", 1)}


def test_a_force_that_says_0_from_the_start_is_no_isolated_brake_where_braking_begins_at_once() -> None:
    """Five seconds after the recording did: what a second of free rolling has shown tells creep of one per cent."""
    frames = changed("BrakeLead", ("p_2",), lambda _, __: 0.0, -1.0, 12.0, vehicle="bogie")(
        list(simulate(SCENARIOS["sanding"], settings("bogie"), 1).frames)
    )
    found = alarms([frame for frame in frames if frame.time_s < EPOCH_S + 10.0], "bogie")
    assert ("input_implausible", 2) in found
    assert "brake_not_applied" not in kinds(found)
