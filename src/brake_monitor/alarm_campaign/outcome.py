"""One drive through the whole path from frame to alarm, and its alarms beside those that are due."""

from collections.abc import Iterator, Sequence

from msgspec import Struct

from brake_monitor.alarm_campaign.drives import Drive
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.processing.playing import play
from brake_monitor.simulator.due import dues
from brake_monitor.simulator.due.alarm import DELAY_S, Due
from brake_monitor.simulator.simulate import EPOCH_S, Recording

BLOCK_FRAMES = 50_000
EARLY_S = 1.0  # an alarm may come this much before its condition qualifies by the truth


class Answer(Struct, frozen=True):
    """What became of one alarm that was due."""

    kind: str
    wheelset: int | None  # from 1
    qualified_s: float  # from the drive's start
    delay_s: float | None  # from when it qualified; None: never raised, or open from before
    is_in_time: bool
    reason: str


class FalseAlarm(Struct, frozen=True):
    """An alarm that was not due, nor a consequence of one that was."""

    kind: str
    wheelset: int | None
    raised_s: float  # from the drive's start
    message: str


class Outcome(Struct, frozen=True):
    """What one drive gave."""

    drive: Drive
    hours: float
    answers: tuple[Answer, ...]
    false_alarms: tuple[FalseAlarm, ...]


def judge(drive: Drive, *, is_one_of_many: bool) -> Outcome:
    """Drive, monitor and compare; the same drive gives the same outcome. Many are worth machine code, see `play`."""
    recording = drive.simulate()
    raised = alarms(recording, is_one_of_many=is_one_of_many)
    return compare(drive, recording.duration_s, dues(recording), raised)


def alarms(recording: Recording, *, is_one_of_many: bool) -> list[Alarm]:
    """Every alarm of a drive as it was last given out."""
    last: dict[str, Alarm] = {}
    pipeline = Pipeline.from_settings(recording.settings)
    for outputs in play(pipeline, _blocks(recording.frames), is_one_of_many=is_one_of_many):
        last |= {alarm.id: alarm for alarm in outputs.alarms}
    return list(last.values())


def _blocks(frames: Sequence[Frame]) -> Iterator[FrameBlock]:
    for begin in range(0, len(frames), BLOCK_FRAMES):
        yield FrameBlock.of(frames[begin : begin + BLOCK_FRAMES])


def compare(drive: Drive, duration_s: float, due: Sequence[Due], raised: Sequence[Alarm]) -> Outcome:
    """Hold the alarms that were raised against those that were due."""
    answers = tuple(_answer(one, raised) for one in due if one.by_s is not None)
    false_alarms = tuple(
        FalseAlarm(alarm.kind, alarm.wheelset, round(alarm.raised_time_s - EPOCH_S, 2), alarm.message)
        for alarm in raised
        if not any(_covers(one, alarm) for one in due)
    )
    return Outcome(drive, duration_s / 3600.0, answers, false_alarms)


def _covers(due: Due, alarm: Alarm) -> bool:
    """Whether the alarm speaks of what is due, or may come."""
    same = (due.kind, due.wheelset) == (alarm.kind, alarm.wheelset)
    return same and due.from_s - EARLY_S <= alarm.raised_time_s <= due.until_s


def _answer(due: Due, raised: Sequence[Alarm]) -> Answer:
    """How soon it was raised; one that is open from before need not be raised again."""
    assert due.by_s is not None
    qualified_s = due.by_s - DELAY_S[due.kind]
    ours = [alarm for alarm in raised if (alarm.kind, alarm.wheelset) == (due.kind, due.wheelset)]
    first_s = min((alarm.raised_time_s for alarm in ours if _covers(due, alarm)), default=None)
    is_open = any(
        alarm.raised_time_s < due.from_s and (alarm.cleared_time_s is None or alarm.cleared_time_s > due.from_s)
        for alarm in ours
    )
    return Answer(
        due.kind,
        due.wheelset,
        round(qualified_s - EPOCH_S, 2),
        None if first_s is None else round(max(first_s - qualified_s, 0.0), 2),
        is_open or (first_s is not None and first_s <= due.by_s),
        due.reason,
    )
