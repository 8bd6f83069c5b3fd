"""A braking stays one record of what was done, whatever comes between its beginning and its end."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.frame import Frame
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.processing.turns import BLIND_S
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from drives import DRY, SILENCE_TOLD_S, drive
from faults import silence

CUT_S = 9.0  # the first braking begins at 5 s, and its brakes have let go by 14 s
OVER_S = 16.5


@cache
def settings() -> Settings:
    return example_settings("wagon")


def frames(from_s: float = 0.0, to_s: float = OVER_S) -> list[Frame]:
    return [frame for frame in drive(DRY).frames if EPOCH_S + from_s <= frame.time_s < EPOCH_S + to_s]


def played(pipeline: Pipeline, some: list[Frame]) -> list[ApplicationRecord]:
    return [stop for frame in some for stop in pipeline.step(frame).applications]


@cache
def whole() -> ApplicationRecord:
    """Of the braking as it was."""
    (stop,) = played(Pipeline.from_settings(settings()), frames())
    return stop


def assert_is_the_one(stop: ApplicationRecord, lost_s: float = 0.0, by_s: float = 0.0) -> None:
    expected = whole()
    share = 1.0 - lost_s / (expected.end_time_s - expected.start_time_s)
    assert stop.start_time_s - by_s == pytest.approx(expected.start_time_s, abs=0.02)
    assert stop.end_time_s - by_s == pytest.approx(expected.end_time_s, abs=0.2)
    assert stop.distance_m == pytest.approx(share * expected.distance_m, rel=0.05)
    assert stop.end_speed_mps == pytest.approx(expected.end_speed_mps, abs=0.2)
    for own, as_was in zip(stop.wheelsets, expected.wheelsets, strict=True):
        assert own.energy_j == pytest.approx(share * as_was.energy_j, rel=0.1)


def with_late_speed(delay_s: float) -> Settings:
    speed = replace(settings().signals.speed, delay_s=delay_s)
    return replace(settings(), signals=replace(settings().signals, speed=speed))


@pytest.mark.parametrize("delay_s", [0.0, 0.3])
@pytest.mark.parametrize("by_s", [3600.0, -3600.0])
def test_by_a_clock_that_is_set(by_s: float, delay_s: float) -> None:
    """What waits for a late sensor is of the time before, and waits on."""
    pipeline = Pipeline.from_settings(with_late_speed(delay_s))
    stops = played(pipeline, frames(to_s=CUT_S))
    pipeline.clock_set(by_s)
    stops += played(pipeline, [frame._replace(time_s=frame.time_s + by_s) for frame in frames(CUT_S)])
    (stop,) = stops
    assert_is_the_one(stop, by_s=by_s)


def test_by_a_restart_of_the_program(tmp_path: Path) -> None:
    pause_s = 1.5
    first, second = Pipeline.from_settings(settings()), Pipeline.from_settings(settings())
    with Store.open(tmp_path / "memory.db", "w", 2) as store:
        assert played(first, frames(to_s=CUT_S)) == []
        store.write(Batch(brakes=first.remembered().brakes))
    with Store.open(tmp_path / "memory.db", "w", 2) as store:
        second.resume(store.remembered())
        (stop,) = played(second, frames(CUT_S + pause_s))
        assert_is_the_one(stop, lost_s=pause_s)
        store.write(Batch(brakes=second.remembered().brakes, applications=[stop]))
    with Store.open(tmp_path / "memory.db", "w", 2) as store:
        brakes = store.brakes()
    assert brakes is not None
    assert (brakes.running, brakes.applications) == (None, (stop,))
    assert [unit.pads.since_fitted.stops for unit in brakes.units] == [1.0, 1.0]


def test_by_a_pressing_force_that_is_lost() -> None:
    pipeline = Pipeline.from_settings(settings())
    (force_id,) = [matching.can_id for matching in pipeline.decoder.matchings if matching.message == "BCU"]
    heard = [f for f in frames() if f.can_id != force_id or not EPOCH_S + CUT_S <= f.time_s < EPOCH_S + CUT_S + 3.0]
    (stop,) = played(pipeline, heard)
    assert_is_the_one(stop)


def test_by_a_silence_of_a_recording_in_which_it_ends() -> None:
    """The brake is released before it: two seconds later, with nobody to tell the time, the application is over."""
    heard = silence(14.3, 16.9)(frames(to_s=17.0))
    (stop,) = played(Pipeline.from_settings(settings()), heard)
    assert_is_the_one(stop)


@pytest.mark.parametrize(("silent_s", "lost_s"), [(0.8, 0.0), (3.0, 3.0)])  # for the filter the longer one is a gap
def test_by_a_silence_of_the_bus_where_a_late_sensor_is_waited_for(silent_s: float, lost_s: float) -> None:
    """Nor does the estimates' time go back as the bus speaks again."""
    pipeline, told_s, stops, last_s = Pipeline.from_settings(with_late_speed(0.3)), [], [], EPOCH_S
    for frame in silence(CUT_S, CUT_S + silent_s)(frames()):
        ticks = [pipeline.advance(time_s) for time_s in np.arange(last_s, frame.time_s, SILENCE_TOLD_S).tolist()[1:]]
        for outputs in (*ticks, pipeline.step(frame)):
            told_s += [outputs.estimate.time_s] if outputs.estimate is not None else []
            stops += outputs.applications
        last_s = frame.time_s
    (stop,) = stops
    assert_is_the_one(stop, lost_s)
    assert told_s == sorted(told_s)
    assert max(np.diff(told_s)) < BLIND_S + 0.15  # it is told of the silence as well
