"""The one path on real frames: estimates follow the truth of a plant that shares nothing with the estimator."""

from functools import cache
from pathlib import Path

import msgspec
import numpy as np
import pytest

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S
from brake_monitor.processing.estimate_table import header, line
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.samples import ESSENTIAL, InputCondition, Quantity
from brake_monitor.settings.config import OutputSettings
from brake_monitor.settings.example_vehicles import EXAMPLES, example_config, example_settings
from brake_monitor.simulator.scenarios import SCENARIOS
from brake_monitor.simulator.simulate import Recording
from brake_monitor.simulator.simulate import run as simulate
from drives import DRY, SLIDE, drive, play

SETTLED_S = 3.0
LEAST_SPEED_MPS = 2.0
ROUNDING_S = 1e-6  # of times since 1970


@cache
def recording(scenario: str, vehicle: str) -> Recording:
    return simulate(scenario, example_settings(vehicle), seed=11)


@cache
def given(scenario: str, vehicle: str) -> list[Outputs]:
    """What the pipeline gave out of a recording."""
    run = recording(scenario, vehicle)
    pipeline = Pipeline.from_settings(run.settings)
    return [outputs for frame in run.frames if (outputs := pipeline.step(frame)) is not NOTHING]


def estimated(scenario: str, vehicle: str) -> list[Estimate]:
    return [outputs.estimate for outputs in given(scenario, vehicle) if outputs.estimate is not None]


@cache
def truth(scenario: str, vehicle: str) -> dict[str, np.ndarray]:
    run = recording(scenario, vehicle)
    return dict(zip(run.truth_header(), np.array(list(run.truth())).T, strict=True))


def truth_at(scenario: str, vehicle: str, times_s: np.ndarray, name: str) -> np.ndarray:
    columns = truth(scenario, vehicle)
    return np.interp(times_s, columns["time_s"], columns[name])


@pytest.mark.parametrize(
    ("scenario", "vehicle"),
    [*((scenario, "wagon") for scenario in SCENARIOS), ("leaf", "rig"), ("sanding", "bogie"), ("wsp", "railcar")],
)
def test_adhesion_follows_the_truth(scenario: str, vehicle: str) -> None:
    found = estimated(scenario, vehicle)
    times_s = np.array([e.time_s for e in found])
    is_fast = truth_at(scenario, vehicle, times_s, "speed_mps") > LEAST_SPEED_MPS
    judged = (times_s > times_s[0] + SETTLED_S) & is_fast
    error = np.array([e.adhesion for e in found]) - truth_at(scenario, vehicle, times_s, "adhesion")
    assert judged.sum() > 200
    assert np.sqrt(np.mean(error[judged] ** 2)) <= 0.005
    settled = judged & (times_s > times_s[0] + SETTLED_S + 0.5)
    assert {e.status for e, s in zip(found, settled, strict=True) if s} == {Status.VALID}


def test_slip_and_saturation_follow_the_truth() -> None:
    found = [e for e in estimated("wsp", "wagon") if e.speed_mps > 5.0]
    times_s = np.array([e.time_s for e in found])
    for i in (1, 2):
        error = np.array([e.wheelsets[i - 1].slip for e in found]) - truth_at("wsp", "wagon", times_s, f"slip_{i}")
        assert np.sqrt(np.mean(error**2)) < 0.01
    sliding = np.max([truth_at("wsp", "wagon", times_s, f"slip_{i}") for i in (1, 2)], axis=0) > 0.08
    assert all(e.saturated for e, s in zip(found, sliding, strict=True) if s)
    coasting = [e for e in found if e.time_s - times_s[0] < 15.0]
    assert not any(e.saturated for e in coasting)


def test_the_same_frames_give_the_same_bytes() -> None:
    run = recording("leaf", "wagon")
    first, second = ([line(e) for e in play(run.settings, run.frames[:5000])] for _ in range(2))
    assert first == second


def test_low_adhesion_is_raised_on_leaves_and_never_on_dry_rail() -> None:
    def alarms(scenario: str) -> list[str]:
        return [alarm.kind for outputs in given(scenario, "wagon") for alarm in outputs.alarms]

    assert "low_adhesion" in alarms("leaf")
    assert alarms("dry") == []


@pytest.mark.parametrize(("rate_hz", "least_period_s"), [(10.0, 0.09), (2.0, 0.45)])
def test_estimates_come_at_the_configured_rate(rate_hz: float, least_period_s: float) -> None:
    run = recording("dry", "wagon")
    settings = msgspec.structs.replace(run.settings, output=OutputSettings(rate_hz=rate_hz))
    times_s = np.array([e.time_s for e in play(settings, run.frames[:3000])])
    periods_s = np.diff(times_s)
    assert periods_s.min() > least_period_s - 0.03
    assert np.median(periods_s) == pytest.approx(1.0 / rate_hz, abs=0.015)


@pytest.mark.parametrize("rate_hz", [10.0, 25.0])
def test_frames_that_change_places_give_no_estimate_twice(rate_hz: float) -> None:
    """Each two of them, however near to the instant at which an estimate is due."""
    run = recording("dry", "wagon")
    settings = msgspec.structs.replace(run.settings, output=OutputSettings(rate_hz=rate_hz))
    even = [frame._replace(time_s=run.frames[0].time_s + k * 0.004) for k, frame in enumerate(run.frames[:8000])]
    in_order, swapped = play(settings, even), play(settings, [even[k ^ 1] for k in range(len(even))])
    assert np.diff([estimate.time_s for estimate in swapped]).min() > 0.0
    assert len(swapped) == pytest.approx(len(in_order), abs=2)


def test_rate_zero_gives_an_estimate_for_every_fused_frame() -> None:
    run = recording("dry", "wagon")
    settings = msgspec.structs.replace(run.settings, output=OutputSettings(rate_hz=0.0))
    frames = run.frames[:2000]
    pipeline = Pipeline.from_settings(settings)
    speeds = {Quantity.SPEED, Quantity.AXLE_SPEED}
    measuring = sum(any(s.quantity in speeds for s in pipeline.decoder.decode(frame)) for frame in frames)
    assert len(play(settings, frames)) == measuring


@pytest.mark.parametrize("rate_hz", [0.0, 3.0, 10.0, 100.0])
def test_nothing_is_given_out_before_it_is_due(rate_hz: float) -> None:
    run = recording("leaf", "wagon")
    settings = msgspec.structs.replace(run.settings, output=OutputSettings(rate_hz=rate_hz))
    pipeline = Pipeline.from_settings(settings)
    count = 0
    for frame in run.frames[:8000]:
        due_s = pipeline.due_s
        outputs = pipeline.step(frame)
        if outputs.estimate is not None or outputs.alarms:
            count += 1
            assert frame.time_s > due_s - ROUNDING_S
            assert pipeline.due_s > frame.time_s - ROUNDING_S  # nor is it due all the time
        elif rate_hz:
            assert pipeline.due_s <= frame.time_s + max(1.0 / rate_hz, OBSERVATION_PERIOD_S)
    assert count > 100


def test_silence_is_given_out_as_invalid_with_its_reasons() -> None:
    run = recording("dry", "wagon")
    pipeline = Pipeline.from_settings(run.settings)
    for frame in run.frames[:4000]:
        pipeline.step(frame)
    end_s = run.frames[3999].time_s
    told = [pipeline.advance(end_s + tenth / 10).estimate for tenth in range(1, 31)]
    silent = [e for e in told if e is not None]
    assert silent[-1].status is Status.INVALID
    assert silent[-1].time_s == pytest.approx(end_s + 3.0, abs=0.11)
    assert {"speed 1 lost", "axle_speed 2 lost", "pressing_force 1 lost"} <= set(silent[-1].reasons)
    assert {reason.split()[0] for reason in silent[-1].reasons} == set(ESSENTIAL)  # all else makes no estimate invalid
    assert len(silent) > 15


def test_columns_up_to_the_status_are_the_agreed_ones() -> None:
    columns = header(2)
    assert columns[: columns.index("status") + 1] == [
        *("time_s", "speed_mps", "adhesion", "adhesion_std", "saturated"),
        *("omega_1_radps", "slip_1", "friction_1", "friction_1_std", "friction_1_status"),
        *("omega_2_radps", "slip_2", "friction_2", "friction_2_std", "friction_2_status"),
        "status",
    ]
    run = recording("dry", "wagon")
    assert all(len(line(e).split(",")) == len(columns) for e in play(run.settings, run.frames[:500]))


def test_example_vehicles_are_in_the_package() -> None:
    for name in EXAMPLES:
        assert Path(example_config(name)).is_file()


def test_a_flag_that_is_neither_0_nor_1_does_not_act_and_is_told() -> None:
    run = recording("dry", "wagon")
    first, second = run.settings.signals.wsp_active
    flags = (msgspec.structs.replace(first, offset=2.0), second)
    signals = msgspec.structs.replace(run.settings.signals, wsp_active=flags)
    pipeline = Pipeline.from_settings(msgspec.structs.replace(run.settings, signals=signals))
    outputs = [pipeline.step(frame) for frame in run.frames[:2000]]
    assert not any(o.estimate.wheelsets[0].wsp_active for o in outputs if o.estimate is not None)
    (alarm,) = (alarm for o in outputs for alarm in o.alarms)
    assert (alarm.kind, alarm.wheelset) == ("input_implausible", 1)
    assert (alarm.evidence["signals"], alarm.evidence["conditions"]) == ("WSP.wsp_A", "out of range")


@pytest.mark.parametrize("delay_s", [0.0, 0.3])
@pytest.mark.parametrize(
    ("message", "quantity"), [("BCU", Quantity.PRESSING_FORCE), ("WSP", Quantity.AXLE_SPEED)], ids=["forces", "wheels"]
)
def test_what_is_lost_stays_lost_though_another_sensor_is_waited_for(
    message: str, quantity: Quantity, delay_s: float
) -> None:
    """Of a signal that lapses some readings wait for the late vehicle speed: they are no sign of life."""
    settings = example_settings("wagon")
    speed = msgspec.structs.replace(settings.signals.speed, delay_s=delay_s)
    settings = msgspec.structs.replace(settings, signals=msgspec.structs.replace(settings.signals, speed=speed))
    pipeline, frames = Pipeline.from_settings(settings), drive(DRY).frames
    lost_s, lost_id = frames[0].time_s + 8.0, ids_of(pipeline)[message]
    given = [pipeline.step(f) for f in frames if f.can_id != lost_id or f.time_s < lost_s]
    kinds = {alarm.kind for outputs in given for alarm in outputs.alarms}
    last = [outputs.estimate for outputs in given if outputs.estimate is not None][-1]
    assert pipeline.estimator.input_condition((quantity, 0)) is InputCondition.LOST
    assert kinds == {"input_lost"}
    assert last.status is Status.INVALID


def ids_of(pipeline: Pipeline) -> dict[str, int]:
    return {matching.message: matching.can_id for matching in pipeline.decoder.matchings}


@pytest.mark.parametrize("signed", [(Quantity.SPEED,), (Quantity.SPEED, Quantity.AXLE_SPEED)], ids=["vehicle", "all"])
def test_a_wagon_that_goes_back_brakes_as_one_that_goes_on(signed: tuple[Quantity, ...]) -> None:
    """Sensors may tell a sign or not: estimates, alarms and what the brakes did are those of the way it goes.

    But for the wheel loads (`test_reversing`), which this wagon shifts by nothing, so low is its centre of gravity.
    """
    settings, frames = example_settings("wagon"), drive(SLIDE).frames[:5000]
    settings = msgspec.structs.replace(settings, vehicle=msgspec.structs.replace(settings.vehicle, cog_height_m=0.0))
    ahead, back = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    decode = back.decoder.decode
    back.decoder.decode = lambda frame: [
        s._replace(value=-s.value) if s.quantity in signed else s for s in decode(frame)
    ]
    assert [back.step(frame) for frame in frames] == [ahead.step(frame) for frame in frames]
    assert back.brake_book.brakes == ahead.brake_book.brakes
    assert min(unit.pads.since_fitted.energy_j for unit in back.brake_book.brakes.units) > 1e5


SILENT_S, SET_S, DOWN_S = 10.0, 15.0, 20.0


def silenced_and_set_back(pipeline: Pipeline, by_s: float, *, is_told: bool) -> tuple[list[float], list[float]]:
    """Speeds fall silent, then the clock is set, then the bus goes down: when estimates came, and that was told."""
    frames, ids = drive(DRY).frames, ids_of(pipeline)
    estimates_s, faults_s, is_set, down = [], [], False, False
    for frame in frames:
        true_s = frame.time_s - frames[0].time_s
        if true_s >= SILENT_S and frame.can_id in (ids["WSP"], ids["GNSS"]):
            continue
        if true_s >= SET_S:
            if is_told and not is_set:
                pipeline.clock_set(-by_s)
            is_set = True
        if true_s >= DOWN_S and not down:
            pipeline.bus_down(pipeline.settings.can[0].name, True)
            down = True
        outputs = pipeline.step(frame._replace(time_s=frame.time_s - by_s * is_set))
        estimates_s += [true_s] * (outputs.estimate is not None)
        faults_s += [true_s for alarm in outputs.alarms if alarm.kind == "bus_fault"]
    return estimates_s, faults_s


@pytest.mark.parametrize("is_told", [True, False], ids=["told", "seen in the frames"])
def test_a_clock_that_is_set_back_in_a_silence_silences_nothing_more(is_told: bool) -> None:
    pipeline = Pipeline.from_settings(example_settings("wagon"))
    estimates_s, faults_s = silenced_and_set_back(pipeline, 600.0, is_told=is_told)
    gaps_s = np.diff([t for t in estimates_s if t > SILENT_S + 1.0])
    assert max(gaps_s) < 1.1
    assert estimates_s[-1] > DOWN_S + 5.0
    assert faults_s[0] == pytest.approx(DOWN_S, abs=0.2)


def test_a_clock_that_is_set_ahead_cools_no_disc() -> None:
    pipeline, frames = Pipeline.from_settings(example_settings("wagon")), drive(DRY).frames
    braked = [f for f in frames if f.time_s < frames[0].time_s + 14.0]
    for frame in braked:
        pipeline.step(frame)
    hot_c = [unit.disc_temperature_c for unit in pipeline.brake_book.brakes.units]
    assert min(hot_c) > 30.0
    pipeline.clock_set(3600.0)
    for frame in frames[len(braked) : len(braked) + 200]:
        pipeline.step(frame._replace(time_s=frame.time_s + 3600.0))
    now_c = [unit.disc_temperature_c for unit in pipeline.brake_book.brakes.units]
    assert now_c == pytest.approx(hot_c, abs=10.0)


def test_a_silent_bus_makes_the_data_older_and_not_the_estimates() -> None:
    pipeline, frames = Pipeline.from_settings(example_settings("wagon")), drive(DRY).frames[:4000]
    pipeline.advance(frames[0].time_s - 5.0)  # nothing has come yet
    assert pipeline.newest_reading_s is None
    for frame in frames:
        pipeline.step(frame)
    heard_s = pipeline.newest_reading_s
    assert heard_s == pytest.approx(frames[-1].time_s, abs=0.05)
    silent = [pipeline.advance(frames[-1].time_s + k / 10).estimate for k in range(1, 100)]
    assert [e.time_s for e in silent if e is not None][-1] > frames[-1].time_s + 9.0
    assert pipeline.newest_reading_s == heard_s


@pytest.mark.parametrize("by_s", [3600.0, -3600.0])
def test_no_signal_lapses_for_a_clock_that_was_set(by_s: float) -> None:
    pipeline, frames = Pipeline.from_settings(example_settings("wagon")), drive(DRY).frames[:4000]
    for frame in frames:
        pipeline.step(frame)
    pipeline.clock_set(by_s)
    pipeline.advance(frames[-1].time_s + by_s + 0.01)
    assert pipeline.decoder.counts.stale == 0
    pipeline.advance(frames[-1].time_s + by_s + 60.0)
    assert pipeline.decoder.counts.stale == len(pipeline.decoder.channels)
