"""Evidence of an alarm: what was on the bus around it, whole, within bounds, and nothing of other times."""

import os
import tracemalloc
from math import inf
from pathlib import Path

import msgspec
import pytest

from brake_monitor.bus.candump_log import line_of, parse_line
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing import at_hand
from brake_monitor.processing.at_hand import AtHand, entry_count
from brake_monitor.processing.estimate_table import header
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.store_settings import StoreSettings
from brake_monitor.storage import evidence as evidence_module
from brake_monitor.storage.evidence import Evidence, EvidenceFolder, EvidenceRecorder, State
from brake_states import brakes, learned
from estimates import alarm, estimate

SETTINGS = StoreSettings(evidence_before_s=20.0, evidence_after_s=5.0)


def frame(time_s: float) -> Frame:
    return Frame(time_s, "can0", 0x123, False, b"\x01\x02")


def drive(recorder: EvidenceRecorder, from_s: int, to_s: int, *alarms: Alarm) -> list[Evidence]:
    """One frame, estimate and state per second; alarms at their raising."""
    told = []
    for time_s in range(from_s, to_s):
        recorder.see_frames([frame(time_s)])
        recorder.see_estimate(estimate(time_s=float(time_s)))
        recorder.see_state(time_s, Remembered(learned(time_s)))
        told += recorder.turn(time_s, [a for a in alarms if a.raised_time_s == time_s])
    return told


def test_it_is_told_at_once_and_again_with_what_came_after() -> None:
    raised = alarm(raised_time_s=100.0)
    at_once, whole = drive(EvidenceRecorder(SETTINGS), 0, 200, raised)
    assert list(at_once.frames)[-1].time_s == 100.0
    assert list(whole.frames)[-1].time_s == 105.0
    for told in (at_once, whole):
        begin_s = next(iter(told.frames)).time_s
        assert 75.0 <= begin_s <= 80.0
        assert told.state == State(raised, Remembered(learned(round(begin_s))))
        assert [f.time_s for f in told.frames] == [e.time_s for e in told.estimates]


def test_a_frame_that_was_underway_as_silence_raised_the_alarm_does_not_end_the_wait_for_what_comes_after() -> None:
    recorder, raised = EvidenceRecorder(SETTINGS), alarm(raised_time_s=100.1)
    assert len(recorder.turn(100.1, [raised])) == 1
    assert recorder.turn(100.0, []) == []
    (whole,) = drive(recorder, 101, 150)
    assert list(whole.frames)[-1].time_s == 105.0


def test_one_that_rises_and_grows_at_once_has_it_once() -> None:
    """As when a daemon catches up with a second of frames."""
    raised = alarm(raised_time_s=100.0)
    graver = alarm(raised_time_s=100.0, updated_time_s=100.1, message="The rail gives 0.02.")
    at_once, whole = drive(EvidenceRecorder(SETTINGS), 0, 200, raised, graver)
    assert at_once.state.alarm == whole.state.alarm == graver


def test_an_alarm_that_goes_on_or_was_open_before_has_its_evidence_already() -> None:
    recorder, before = EvidenceRecorder(SETTINGS), alarm(raised_time_s=50.0)
    recorder.resume(Remembered(open_alarms=(before,)))
    assert drive(recorder, 40, 80, before) == []
    assert recorder.finish() == []


def test_at_the_end_of_the_program_what_is_there_is_told() -> None:
    recorder, raised = EvidenceRecorder(SETTINGS), alarm(raised_time_s=10.0)
    assert len(drive(recorder, 0, 13, raised)) == 1
    (told,) = recorder.finish()
    assert list(told.frames)[-1].time_s == 12.0


def test_memory_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence_module, "FRAMES_AT_HAND", 15)
    monkeypatch.setattr(at_hand, "ENTRIES_IN_BLOCK", 5)
    recorder = EvidenceRecorder(SETTINGS)
    drive(recorder, 0, 1000)
    told = drive(recorder, 1000, 1001, alarm(raised_time_s=1000.0))
    assert 15 <= len(list(told[0].frames)) <= entry_count([told[0].frames]) < 20
    assert len(list(told[0].estimates)) <= 26


def test_of_a_long_day_no_more_states_are_kept_than_an_alarm_may_need() -> None:
    """One each 5 s, of the 25 s before, and the one before these, from which on frames are kept."""
    recorder = EvidenceRecorder(SETTINGS)
    drive(recorder, 0, 10_000)
    assert len(recorder._states) <= 25 / 5 + 2
    (told,) = drive(recorder, 10_000, 10_001, alarm(raised_time_s=10_000.0))
    assert 9_975.0 <= next(iter(told.frames)).time_s <= 9_980.0


def test_estimates_are_bounded_however_far_back_the_evidence_is_to_reach(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence_module, "ESTIMATES_AT_HAND", 30)
    monkeypatch.setattr(at_hand, "ENTRIES_IN_BLOCK", 5)
    recorder = EvidenceRecorder(StoreSettings(evidence_before_s=1e6))
    for from_s in (0, 5_000_000):  # the clock is set in between
        told = drive(recorder, from_s, from_s + 100, alarm(id=str(from_s), raised_time_s=from_s + 99.0))
        times_s = [e.time_s for e in told[-1].estimates]
        assert times_s == list(range(from_s + 100 - len(times_s), from_s + 100))
        assert 30 <= len(times_s) < 35


def test_a_clock_that_is_set_mixes_no_times() -> None:
    recorder = EvidenceRecorder(SETTINGS)
    drive(recorder, 5000, 5050)
    told = drive(recorder, 100, 120, alarm(raised_time_s=110.0))
    assert [f.time_s for f in told[0].frames] == list(range(100, 111))


def some(name: str, count: int = 100) -> Evidence:
    state = State(alarm(id=name), Remembered(learned(1), brakes(1), (alarm(),)))
    frames, estimates = AtHand(Frame, count), AtHand(Estimate, 2)
    frames.add(map(frame, range(count)))
    estimates.add([estimate(), estimate()])
    return Evidence(state, frames.between(0.0, count), estimates.between(0.0, inf))


@pytest.mark.parametrize("by_s", [20.0, 3600.0, -3600.0])
def test_a_clock_that_is_set_takes_nothing_from_evidence_that_awaits_its_end(by_s: float) -> None:
    """It is written over what was written at once."""
    recorder = EvidenceRecorder(SETTINGS)
    (at_once,) = drive(recorder, 0, 103, alarm(raised_time_s=100.0))
    recorder.see_frames([frame(102.0 + by_s)])
    (whole,) = recorder.turn(102.0 + by_s, [])
    assert [one.time_s for one in whole.frames] == [*(one.time_s for one in at_once.frames), 101.0, 102.0]
    assert whole.state == at_once.state


def test_the_files_are_a_log_a_table_and_the_state(tmp_path: Path) -> None:
    EvidenceFolder(tmp_path / "evidence", 10**6).write(some("slide-1-17"))
    log, table, state = (tmp_path / "evidence" / f"slide-1-17{suffix}" for suffix in (".log", ".csv", ".json"))
    assert [parse_line(line.rstrip("\n")) for line in log.read_text().splitlines()] == list(map(frame, range(100)))
    assert table.read_text().splitlines()[0] == ",".join(header(2))
    assert msgspec.json.decode(state.read_bytes(), type=State) == some("slide-1-17").state


def test_a_power_cut_takes_nothing_back_that_was_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The names of files are on the disk once their folder is, which has to be after the last one got its name."""
    done = list[str]()
    replace, fsync = Path.replace, os.fsync

    def note_name(part: Path, target: Path) -> Path:
        done.append(f"named {target.suffix}")
        return replace(part, target)

    def note_kept(number: int) -> None:
        path = Path(f"/proc/self/fd/{number}").readlink()
        done.append("folder kept" if path == tmp_path else f"kept {path.suffix}")
        fsync(number)

    monkeypatch.setattr(Path, "replace", note_name)
    monkeypatch.setattr(os, "fsync", note_kept)
    EvidenceFolder(tmp_path, 10**6).write(some("slide"))
    files = [step for suffix in (".log", ".csv", ".json") for step in (f"kept {suffix}", f"named {suffix}")]
    assert done == [*files, "folder kept"]


def test_writing_takes_little_more_memory_than_what_is_written(tmp_path: Path) -> None:
    """Of two minutes of a bus these are megabytes, which stay with the daemon once they were needed."""
    whole = some("slide", 20_000)
    tracemalloc.start()
    try:
        EvidenceFolder(tmp_path, 10**7).write(whole)
        most_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most_bytes < 1.3 * sum(path.stat().st_size for path in tmp_path.iterdir())


@pytest.mark.parametrize("name", ["../../etc/passwd", "a/b", "..", "", "ä\x00 b", "x" * 5000])
def test_no_id_leads_out_of_the_folder(tmp_path: Path, name: str) -> None:
    EvidenceFolder(tmp_path / "evidence", 10**6).write(some(name))
    assert len(list((tmp_path / "evidence").iterdir())) == 3
    assert [path.name for path in tmp_path.iterdir()] == ["evidence"]


def test_the_oldest_goes_first_and_the_disk_use_is_bounded(tmp_path: Path) -> None:
    folder = EvidenceFolder(tmp_path, 30_000)
    for number in range(20):
        folder.write(some(f"alarm-{number:02}"))
        for path in tmp_path.glob(f"alarm-{number:02}.*"):
            os.utime(path, (number, number))  # as if they were written seconds apart
        assert sum(path.stat().st_size for path in tmp_path.iterdir()) <= 30_000
    left = sorted({path.stem for path in tmp_path.iterdir()})
    assert 1 < len(left) < 20
    assert left == [f"alarm-{number:02}" for number in range(20 - len(left), 20)]
    assert all(len(list(tmp_path.glob(f"{name}.*"))) == 3 for name in left)


def test_evidence_that_is_written_again_takes_the_room_of_what_it_replaces(tmp_path: Path) -> None:
    """As that of each alarm is, with what came after: there is room for two, and both stay."""
    EvidenceFolder(tmp_path, 10**6).write(some("alarm-0"))
    used = sum(path.stat().st_size for path in tmp_path.iterdir())
    folder = EvidenceFolder(tmp_path, 2 * used)
    for _ in range(2):
        folder.write(some("alarm-1"))
    assert {path.stem for path in tmp_path.iterdir()} == {"alarm-0", "alarm-1"}


def test_the_bound_is_of_bytes_not_of_characters(tmp_path: Path) -> None:
    piece = some("alarm-0")
    spoken = msgspec.structs.replace(piece.state.alarm, message="Vérité")
    EvidenceFolder(tmp_path, 10**6).write(msgspec.structs.replace(piece, state=State(spoken, piece.state.remembered)))
    used = sum(path.stat().st_size for path in tmp_path.iterdir())
    again = msgspec.structs.replace(spoken, id="alarm-1")
    EvidenceFolder(tmp_path, 2 * used - 1).write(
        msgspec.structs.replace(piece, state=State(again, piece.state.remembered))
    )
    assert {path.stem for path in tmp_path.iterdir()} == {"alarm-1"}


def test_what_a_power_cut_left_half_written_goes(tmp_path: Path) -> None:
    (tmp_path / ".part-old.log").write_text("half")
    EvidenceFolder(tmp_path, 10**6).write(some("new"))
    assert not list(tmp_path.glob(".part-*"))


@pytest.mark.parametrize(
    "written",
    [
        Frame(1700000000.123456, "can0", 0x7FF, False, b""),
        Frame(1700000000.5, "can0", 0x7FF, True, b"\x00" * 8),
        Frame(1.0, "front", 0x1FFFFFFF, True, bytes(range(64))),
        Frame(1.0, "front", 0x1, False, b"", FrameKind.REMOTE),
        Frame(1.0, "front", 0x80, True, b"\x00" * 8, FrameKind.ERROR),
    ],
)
def test_a_line_is_read_as_the_frame_it_was_written_from(written: Frame) -> None:
    assert parse_line(line_of(written).rstrip("\n")) == written
