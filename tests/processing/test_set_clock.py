"""The clock that stamps frames is set, and the pipeline told of it: nothing changes but the times that are told.

By so many seconds that adding them to a time loses no bit.
"""

from collections.abc import Callable, Iterator
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.frame import YEAR_S, Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, SILENCE_TOLD_S, SLIDE, drive
from faults import silence

AHEAD_S = 4096.0
OVER_S = EPOCH_S + 16.5  # the first braking is
DRIVES = {
    "braking": lambda: drive(DRY),
    "locked wheelsets": lambda: drive(SLIDE, Modifiers(slide_protection=False)),
}
SILENT_S, END_S = (12.0, 18.0), 20.0
Clock = Callable[[float], float]


def steps(frames: list[Frame]) -> Iterator[Frame | float]:
    """As the service has them: it also tells when nothing arrives."""
    last_s = frames[0].time_s
    for frame in frames:
        yield from np.arange(last_s, frame.time_s, SILENCE_TOLD_S).tolist()[1:]
        yield frame
        last_s = frame.time_s


def played(pipeline: Pipeline, frames: list[Frame], set_s: float = np.inf, by_s: float = 0.0) -> list[Outputs]:
    """What comes of each step; the clock is set as it shows `set_s`."""
    outputs, is_set = [], False
    for step in steps(frames):
        time_s = step.time_s if isinstance(step, Frame) else step
        if time_s >= set_s and not is_set:
            is_set = True
            pipeline.clock_set(by_s)
        shown_s = time_s + by_s * is_set
        outputs.append(
            pipeline.step(step._replace(time_s=shown_s)) if isinstance(step, Frame) else pipeline.advance(shown_s)
        )
    return outputs


@cache
def case(name: str) -> tuple[Settings, list[Frame], list[Outputs]]:
    """A drive with a silence in it, and what is told of it when nobody sets the clock."""
    recording = DRIVES[name]()
    frames = silence(*SILENT_S)([frame for frame in recording.frames if frame.time_s < EPOCH_S + END_S])
    return recording.settings, frames, played(Pipeline.from_settings(recording.settings), frames)


def alarm_by(clock: Clock, alarm: Alarm) -> Alarm:
    """All of its times as they were told, each when it was."""
    times = {name: getattr(alarm, name) for name in ("raised_time_s", "updated_time_s", "cleared_time_s")}
    evidence = {k: clock(v) if k.endswith("_time_s") else v for k, v in alarm.evidence.items()}
    raised_ms = round(clock(alarm.raised_time_s) * 1000)
    told = {name: None if time_s is None else clock(time_s) for name, time_s in times.items()}
    return replace(alarm, id=f"{alarm.id.rpartition('-')[0]}-{raised_ms}", evidence=evidence, **told)


def later(told: Estimate | ApplicationRecord, by_s: float) -> Estimate | ApplicationRecord:
    times = {name: getattr(told, name) + by_s for name in told.__struct_fields__ if name.endswith("time_s")}
    return replace(told, **times)


def expected(before: list[Outputs], set_s: float, by_s: float) -> list[tuple[object, ...]]:
    """What is to be told, by what was told when nobody set the clock."""
    found = []
    newest_s = -np.inf  # of the estimates, as they came
    for outputs in before:
        if outputs.estimate is not None:
            newest_s = outputs.estimate.time_s
        ahead_s = by_s * (newest_s >= set_s)

        def clock(time_s: float) -> float:
            return time_s + by_s * (time_s >= set_s)

        found.append(
            (
                outputs.estimate and later(outputs.estimate, ahead_s),
                [alarm_by(clock, alarm) for alarm in outputs.alarms],
                [later(stop, ahead_s) for stop in outputs.applications],
            )
        )
    return found


@pytest.mark.parametrize(
    ("name", "set_s", "by_s"),
    [
        ("braking", 9.0, AHEAD_S),
        ("locked wheelsets", 4.0, AHEAD_S),
        ("locked wheelsets", 8.0, -AHEAD_S),
        ("locked wheelsets", 15.0, AHEAD_S),
        ("locked wheelsets", 15.0, -AHEAD_S),
    ],
    ids=["in a braking", "before a slide", "in a slide", "ahead in a silence", "back in a silence"],
)
def test_the_same_is_told_by_the_new_time(name: str, set_s: float, by_s: float) -> None:
    settings, frames, undisturbed = case(name)
    set_s += EPOCH_S
    outputs = played(Pipeline.from_settings(settings), frames, set_s, by_s)
    for told, due in zip(outputs, expected(undisturbed, set_s, by_s), strict=True):
        assert (told.estimate, list(told.alarms), list(told.applications)) == due
    assert any(told.applications or told.alarms for told in undisturbed)


def test_what_is_asked_and_kept_between_is_of_the_new_time() -> None:
    settings, frames, _ = case("braking")
    pipeline = Pipeline.from_settings(settings)
    cut = [frame for frame in frames if frame.time_s < EPOCH_S + 11.0]
    played(pipeline, cut, EPOCH_S + 9.0, AHEAD_S)
    now_s = cut[-1].time_s + AHEAD_S
    kept = pipeline.remembered()
    assert kept.learned is not None
    assert kept.brakes is not None
    assert kept.brakes.running is not None
    assert 0.0 <= pipeline.due_s - now_s <= 0.1
    newest_s = [pipeline.newest_reading_s, kept.learned.time_s, kept.brakes.time_s, kept.brakes.running.end_time_s]
    assert newest_s == pytest.approx([now_s] * 4, abs=0.15)


def gone_on(wrong_s: float = 0.0, set_s: float = np.inf, by_s: float = 0.0) -> tuple[Pipeline, list[ApplicationRecord]]:
    """After a restart in the midst of a braking, by a clock that is set right before the first frame."""
    settings, frames, _ = case("braking")
    again_s = EPOCH_S + 10.0
    first, second = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    played(first, [frame for frame in frames if frame.time_s < again_s - 2.0])
    second.resume(first.remembered())
    second.advance(again_s - 0.1 - wrong_s)
    second.clock_set(wrong_s)
    rest = [frame for frame in drive(DRY).frames if again_s <= frame.time_s < OVER_S]
    return second, [stop for told in played(second, rest, set_s, by_s) for stop in told.applications]


@pytest.mark.parametrize("by_s", [AHEAD_S, -AHEAD_S])
def test_a_pause_is_as_long_as_a_clock_says_that_is_set_before_the_first_frame(by_s: float) -> None:
    (right, right_stops), (wrong, wrong_stops) = gone_on(), gone_on(by_s)
    assert len(right_stops) == 1
    assert wrong_stops == right_stops
    assert wrong.estimator.learned() == right.estimator.learned()
    assert wrong.brake_book.brakes == right.brake_book.brakes


def test_a_leap_of_years_is_a_clock_that_was_set_and_no_silence() -> None:
    """By the first satellites that a gateway without a clock of its own hears; nobody tells the pipeline of it."""
    recording, set_s, by_s = drive(DRY), EPOCH_S + 9.0, 45 * YEAR_S
    shown = [frame._replace(time_s=frame.time_s + by_s * (frame.time_s >= set_s)) for frame in recording.frames]
    pipeline = Pipeline.from_settings(recording.settings)
    outputs = [pipeline.step(frame) for frame in shown]
    assert [alarm.kind for output in outputs for alarm in output.alarms] == []


def test_what_an_earlier_run_saw_of_a_braking_is_told_by_the_new_time() -> None:
    (_, (stop,)), (_, (shown,)) = gone_on(), gone_on(set_s=EPOCH_S + 12.0, by_s=AHEAD_S)
    assert shown == later(stop, AHEAD_S)
