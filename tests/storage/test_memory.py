"""The memory beside a running pipeline: what the disk does costs nothing, a restart counts nothing twice."""

import os
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from datetime import datetime
from errno import EEXIST, ENOTDIR, EROFS
from pathlib import Path
from types import SimpleNamespace

import pytest
from msgspec.structs import replace

from brake_monitor.errors import BrakeMonitorError, InputError, WorkError
from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.gauge import Gauge, after_gauge
from brake_monitor.processing import at_hand
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.storage import memory_directory, memory_handover
from brake_monitor.storage.evidence import SUFFIXES, Evidence, EvidenceFolder
from brake_monitor.storage.memory import EVIDENCE_FOLDER, Memory
from brake_monitor.storage.memory_directory import FILE_NAME, MemoryDirectory, set_aside_in, state_directory
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_monitor.storage.store_file import StoreError
from brake_states import WHEELSETS, batch, brakes, learned, stop
from estimates import alarm
from program import until

VEHICLE = "wagon-8127"
SETTINGS = example_settings("wagon")


class StandIn:
    """Stands in for the pipeline: its state is that of a number."""

    def __init__(self, number: int = 0) -> None:
        self.number = number
        self.resumed: list[Remembered] = []
        self.gauges: list[Gauge] = []
        self.open: tuple[Alarm, ...] = ()
        self.running: ApplicationRecord | None = None
        self.memory_failure = ""
        self.settings = SETTINGS

    def remembered(self) -> Remembered:
        known = replace(brakes(self.number), running=self.running) if self.number else None
        for gauge in self.gauges if known else ():
            known = after_gauge(known, gauge, WearSettings())
        return Remembered(learned(self.number), known, self.open)

    def resume(self, remembered: Remembered) -> None:
        self.resumed.append(remembered)
        self.open = (*self.open, *remembered.open_alarms)

    def apply(self, gauge: Gauge) -> None:
        self.gauges.append(gauge)


@contextmanager
def began(directory: Path, pipeline: StandIn | Pipeline) -> Iterator[Memory]:
    """A memory; afterwards all is written, be that within the time that it gives itself or not."""
    with Memory(pipeline, directory) as memory:
        memory.resume()
        yield memory
    until(lambda: not memory.is_writing)


def live(memory: Memory, pipeline: StandIn, number: int, *alarms: Alarm) -> None:
    """Go on to the state after `number` seconds."""
    pipeline.number = number
    memory.see((), [Outputs(None, alarms, (stop(number),))], 1.7e9 + number)


def kept(directory: Path) -> Store:
    return Store.open(directory / FILE_NAME, VEHICLE, WHEELSETS)


def seen(directory: Path, mode: str = "ro") -> Store:
    """Beside whoever keeps it."""
    return Store.look(directory / FILE_NAME, VEHICLE, mode)


def energy_j(directory: Path) -> float | None:
    """None while the file is being made."""
    try:
        with seen(directory) as store:
            found = store.brakes()
    except BrakeMonitorError:
        return None
    return found.units[0].pads.since_fitted.energy_j if found else 0.0


def live_until_kept(directory: Path, memory: Memory, pipeline: StandIn, number: int, *alarms: Alarm) -> None:
    live(memory, pipeline, number, *alarms)
    until(lambda: energy_j(directory) == 1.5 * number)


def test_what_was_known_at_the_end_is_what_the_next_run_begins_with(tmp_path: Path) -> None:
    pipeline, acknowledged = StandIn(), alarm(acknowledged_time_s=1.7e9)
    with began(tmp_path, pipeline) as memory:
        assert pipeline.resumed == [Remembered()]
        live(memory, pipeline, 1, alarm())
        live(memory, pipeline, 2, acknowledged)
        pipeline.number = 3
        memory.finish()
    again = StandIn()
    with began(tmp_path, again):
        (found,) = again.resumed
    assert found.learned == learned(3)
    assert found.brakes is not None
    assert found.brakes.units == brakes(3).units
    assert found.brakes.applications == (stop(1), stop(2))
    assert found.open_alarms == (acknowledged,)


def test_what_a_changed_configuration_makes_it_forget_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1, alarm())
    again = StandIn()
    again.settings = replace(SETTINGS, wear=replace(SETTINGS.wear, new_pad_thickness_mm=30.0))
    with caplog.at_level("INFO"), began(tmp_path, again):
        assert again.resumed
    assert "the configuration has changed: [wear] was changed" in caplog.text


def test_what_was_learned_that_cannot_be_costs_neither_alarms_nor_wear(tmp_path: Path) -> None:
    class Picky(StandIn):
        """A pipeline that cannot go on with what was learned, as of a wagon with other wheelsets."""

        def resume(self, remembered: Remembered) -> None:
            if remembered.learned is not None:
                raise InputError("this was learned of something else")
            super().resume(remembered)

    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1, alarm())
    again = Picky()
    with began(tmp_path, again):
        (found,) = again.resumed
    assert found.open_alarms == (alarm(),)
    assert found.brakes is not None
    assert found.brakes.units == brakes(1).units


def test_to_try_again_and_again_where_another_daemon_is_leaves_no_file_open(tmp_path: Path) -> None:
    first, second = (MemoryDirectory(tmp_path, VEHICLE, WHEELSETS) for _ in range(2))
    first.lock()
    opened = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(10):
        with pytest.raises(WorkError, match="another brake-monitor keeps its memory here"):
            second.lock()
    assert len(list(Path("/proc/self/fd").iterdir())) == opened
    first.unlock()
    second.lock()
    second.unlock()


def test_an_alarm_is_on_the_disk_long_before_the_end(tmp_path: Path) -> None:
    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1, alarm())
        with seen(tmp_path) as store:
            assert store.alarms() == [alarm()]


def test_a_brake_application_is_never_on_the_disk_as_ended_and_as_going_on(tmp_path: Path) -> None:
    """A program that is killed then would end it once more as it begins anew, and count it twice."""
    pipeline = StandIn(1)
    pipeline.running = stop(2)

    def on_disk() -> tuple[ApplicationRecord | None, list[ApplicationRecord]]:
        with seen(tmp_path) as store:
            found = store.brakes()
        return (None, []) if found is None else (found.running, list(found.applications))

    with began(tmp_path, pipeline) as memory:
        memory.see((), (), 1.7e9)
        until(lambda: energy_j(tmp_path) == 1.5)
        assert on_disk() == (stop(2), [])
        pipeline.running = None
        memory.see((), [Outputs(applications=(stop(2),))], 1.7e9 + 0.1)
        until(lambda: on_disk()[1])
        assert on_disk() == (None, [stop(2)])


def test_the_state_waits_for_one_piece_of_evidence_and_not_for_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipeline, order = StandIn(), []
    write_evidence, write_state = EvidenceFolder.write, Store.write

    def noted_evidence(folder: EvidenceFolder, evidence: Evidence) -> None:
        order.append(f"evidence {evidence.name}")
        if len([done for done in order if done.startswith("evidence")]) == 1:
            live(memory, pipeline, 2, alarm(id="c", kind="slide"))  # while the first is written
        write_evidence(folder, evidence)

    def noted_state(store: Store, batch: Batch) -> None:
        order.extend(f"alarm {name}" for name in batch.alarms)
        write_state(store, batch)

    monkeypatch.setattr(EvidenceFolder, "write", noted_evidence)
    monkeypatch.setattr(Store, "write", noted_state)
    with began(tmp_path, pipeline) as memory:
        live(memory, pipeline, 1, alarm(id="a"), alarm(id="b", kind="hot_disc"))
        until(lambda: "evidence c" in order)
    assert order[:6] == ["alarm a", "alarm b", "evidence a", "alarm c", "evidence b", "evidence c"]
    assert {path.stem for path in (tmp_path / "evidence").iterdir()} == {"a", "b", "c"}


def test_a_second_daemon_is_refused(tmp_path: Path) -> None:
    with began(tmp_path, StandIn()), pytest.raises(WorkError, match="another brake-monitor"):
        Memory(StandIn(), tmp_path).start()
    with began(tmp_path, StandIn()) as memory:
        assert not memory.failing


def impossible(path: Path) -> None:
    with Store.open(path, VEHICLE, WHEELSETS) as store:
        unit = brakes(1).units[0]
        worn = replace(unit, pads=replace(unit.pads, gauge_thickness_mm=-3.0))
        store.write(Batch(replace(brakes(1), units=(worn, unit))))


REFUSED = {
    "damaged": lambda path: path.write_bytes(b"\0" * 5000),
    "of another vehicle": lambda path: Store.open(path, "wagon-7", WHEELSETS).close(),
    "with impossible content": impossible,
}


@pytest.mark.parametrize("damage", REFUSED.values(), ids=REFUSED)
def test_what_is_refused_is_kept_aside_and_a_new_memory_begins(
    tmp_path: Path, damage: Callable[[Path], None], caplog: pytest.LogCaptureFixture
) -> None:
    damage(tmp_path / FILE_NAME)
    before = (tmp_path / FILE_NAME).read_bytes()
    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        assert pipeline.resumed == [Remembered()]
        assert "it is kept as refused-" in caplog.text
        assert not memory.failing
        live(memory, pipeline, 5)
    assert energy_j(tmp_path) == 7.5
    (aside,) = tmp_path.glob("refused-*.db")
    assert aside.read_bytes() == before
    assert aside.name in caplog.text


def test_a_file_that_a_power_cut_has_left_empty_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    (tmp_path / FILE_NAME).touch()
    with began(tmp_path, StandIn()) as memory:
        assert not memory.failing
    assert [line for line in caplog.messages if "empty" in line] == [
        f"{tmp_path / FILE_NAME}: the file is empty, and a new memory begins"
    ]


def test_of_what_is_refused_again_and_again_only_the_last_is_kept(tmp_path: Path) -> None:
    for _ in range(8):
        (tmp_path / FILE_NAME).write_bytes(b"\0" * 5000)
        with began(tmp_path, StandIn()):
            pass
    assert len(list(tmp_path.glob("refused-*"))) == 5


def test_what_is_refused_while_the_clock_is_years_behind_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As on a gateway without a battery for its clock, before the network has set it."""
    before = [tmp_path / f"refused-2026010{day}T000000.000000Z-{FILE_NAME}" for day in range(1, 6)]
    for path in before:
        path.write_text("refused")
    (tmp_path / FILE_NAME).write_text("no memory")
    booted = SimpleNamespace(now=lambda zone: datetime(1970, 1, 1, tzinfo=zone))
    monkeypatch.setattr(memory_directory, "datetime", booted)
    with began(tmp_path, StandIn()):
        pass
    (kept,) = set(set_aside_in(tmp_path)) - set(before)
    assert kept.read_text() == "no memory"
    assert set_aside_in(tmp_path) == [kept, *before[1:]]


def test_a_file_damaged_while_the_daemon_runs_is_replaced_by_all_that_it_knows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def notice(*_: object) -> None:
        for path in tmp_path.glob(f"{FILE_NAME}*"):
            path.unlink()
        raise StoreError("taken away")

    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1, alarm())
        with monkeypatch.context() as patched:
            patched.setattr(Store, "write", notice)
            live(memory, pipeline, 2)
            until(lambda: memory.failing)
        until(lambda: (tmp_path / FILE_NAME).exists() and not memory.failing)
        until(lambda: energy_j(tmp_path) == 3.0)
    with kept(tmp_path) as store:
        assert store.remembered().open_alarms == (alarm(),)


@pytest.mark.parametrize("is_whole", [True, False], ids=["the directory", "its file"])
def test_what_is_taken_away_while_the_daemon_runs_is_made_anew_with_all_that_it_knows(
    is_whole: bool, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """The file that is open could be written on, and would be gone at the end."""
    place, pipeline = tmp_path / "state", StandIn()
    with began(place, pipeline) as memory:
        live_until_kept(place, memory, pipeline, 1, alarm())
        if is_whole:
            evidence = place / EVIDENCE_FOLDER
            until(lambda: len(list(evidence.glob("[!.]*"))) == len(SUFFIXES))
            place.rename(tmp_path / "elsewhere")  # at once: while a tree is removed other things go wrong first
        else:
            for path in place.glob(f"{FILE_NAME}*"):
                path.unlink()
        live_until_kept(place, memory, pipeline, 2)
        with pytest.raises(WorkError, match="another brake-monitor keeps its memory here"):
            Memory(StandIn(), place).start()
    assert "the memory was taken away; all that is known is written anew" in caplog.text
    with kept(place) as store:
        assert store.remembered().open_alarms == (alarm(),)


def change(path: Path, statement: str) -> None:
    with closing(sqlite3.connect(path)) as db, db:
        db.execute(statement)


def test_a_file_damaged_while_the_daemon_runs_that_cannot_be_set_aside_fails_until_it_can(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Flash that dies: a page is damaged, and the kernel mounts the disk read-only."""

    def fail(*_: object) -> None:
        raise OSError(EROFS, "Read-only file system")

    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1, alarm())
        with monkeypatch.context() as patched:
            patched.setattr(Path, "rename", fail)
            change(tmp_path / FILE_NAME, "DROP TABLE gauges")
            until(lambda: memory.failing)
            assert "Read-only file system" in memory.failing
            assert memory._writer._thread.is_alive()
            live(memory, pipeline, 2)
            assert "Read-only" in pipeline.memory_failure
        until(lambda: not memory.failing)
        live_until_kept(tmp_path, memory, pipeline, 3)
    with kept(tmp_path) as store:
        assert store.alarms() == [alarm()]


def test_an_entry_that_is_none_does_not_end_the_writing(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1)
        change(tmp_path / FILE_NAME, "INSERT INTO gauges (wheelset, content) VALUES (1, '{')")
        until(lambda: "the content makes no sense" in caplog.text)
        live_until_kept(tmp_path, memory, pipeline, 2)
        assert not memory.failing


def test_what_fails_is_told_in_words_for_a_person(tmp_path: Path) -> None:
    """The alarm's message and health carry it: no error number, no Python."""
    file = tmp_path / "file"
    file.touch()
    pipeline = StandIn()
    with began(file, pipeline) as memory:
        live(memory, pipeline, 1)
        assert pipeline.memory_failure == f"{file}: {os.strerror(EEXIST)}"
    with began(file / "state", pipeline) as memory:
        live(memory, pipeline, 1)
        assert pipeline.memory_failure == f"{file / 'state'}: {os.strerror(ENOTDIR)}"


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_thread_that_ends_by_a_fault_of_ours_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pipeline = StandIn()
    memory = Memory(pipeline, tmp_path)
    assert not memory.failing
    with memory:
        memory.resume()
        monkeypatch.setattr(Store, "changed_by_others", lambda _: 1 / 0)
        until(lambda: memory.failing)
        assert memory.failing == f"{tmp_path}: the thread that writes has ended"
        live(memory, pipeline, 1)
        assert pipeline.memory_failure == memory.failing


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk of 1 MB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1m", "none", disk], check=True)
    try:
        yield disk
    finally:
        subprocess.run(["umount", "-l", disk], check=True)


def fill(disk: Path) -> Path:
    filler = disk / "filler"
    with filler.open("wb", buffering=0) as stream:
        for block in (4096, 1):
            try:
                while stream.write(b"x" * block):
                    pass
            except OSError:
                continue
    return filler


@pytest.mark.mount
def test_a_full_disk_loses_nothing_as_long_as_the_program_lives(small_disk: Path) -> None:
    pipeline, raised = StandIn(), [alarm(id=f"a-{i}", raised_time_s=1.7e9 + i) for i in range(10, 20)]
    with began(small_disk, pipeline) as memory:
        live_until_kept(small_disk, memory, pipeline, 1)
        filler = fill(small_disk)
        for number in range(10, 20):
            live(memory, pipeline, number, raised[number - 10])
        until(lambda: memory.failing)
        assert "full" in memory.failing or "No space" in memory.failing
        live(memory, pipeline, 20)
        filler.unlink()
        until(lambda: not memory.failing)
        until(lambda: energy_j(small_disk) == 30.0)
    with kept(small_disk) as store:
        assert store.alarms() == raised
        assert store.applications() == [stop(number) for number in (1, *range(10, 21))]


def test_evidence_that_waits_for_the_disk_is_bounded_by_its_frames_and_shared_ones_count_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(memory_handover, "EVIDENCE_FRAMES_WAITING", 100)
    monkeypatch.setattr(at_hand, "ENTRIES_IN_BLOCK", 4)
    store = replace(SETTINGS.store, evidence_before_s=20.0, evidence_after_s=0.0)
    (tmp_path / "state").write_text("in the way")
    pipeline = StandIn(1)
    pipeline.settings = replace(SETTINGS, store=store)
    memory = Memory(pipeline, tmp_path / "state")

    def drive(from_s: int, to_s: int) -> list[float]:
        """Two frames a second, two alarms each minute: when those were raised whose evidence waits."""
        for time_s in range(from_s, to_s):
            frames = [Frame(time_s - 0.1 * n, "can0", 0x123, False, b"") for n in (1, 0)]
            raised = tuple(alarm(id=f"{time_s}-{i}", raised_time_s=time_s) for i in range(2) if time_s % 60 == 0)
            memory.see(frames, [Outputs(None, raised)], float(time_s))
            assert len({frame for piece in memory._handover._evidence for frame in piece.frames}) <= 100
        return [piece.state.alarm.raised_time_s for piece in memory._handover._evidence]

    assert drive(1000, 1030) == [1020, 1020, 1020, 1020]  # both at once, and then whole
    first, second, *_ = (list(piece.frames) for piece in memory._handover._evidence)
    assert len(first) > 40
    assert first == second
    assert set(drive(1030, 1450)) == {1380, 1440}


@pytest.mark.mount
def test_a_disk_that_becomes_read_only_and_comes_back(small_disk: Path) -> None:
    pipeline = StandIn()
    with began(small_disk, pipeline) as memory:
        live_until_kept(small_disk, memory, pipeline, 1, alarm())
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    again = StandIn()
    with began(small_disk, again) as memory:  # what can be read is gone on with
        assert memory.failing
        assert again.resumed[0].open_alarms == (alarm(),)
        assert again.resumed[0].brakes is not None
        live(memory, again, 2)
        subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)
        until(lambda: not memory.failing)
        until(lambda: energy_j(small_disk) == 3.0)
        assert len(again.resumed) == 1


def test_a_disk_that_comes_late_is_added_to_and_not_overwritten(tmp_path: Path) -> None:
    elsewhere, directory = tmp_path / "elsewhere", tmp_path / "state"
    elsewhere.mkdir()
    with kept(elsewhere) as store:
        store.write(batch(100))  # 150 J, and an alarm of kind low_adhesion that is open
    directory.write_text("in the way")
    pipeline = StandIn(2)
    pipeline.open = (alarm(id="new"),)
    with began(directory, pipeline) as memory:
        assert memory.failing
        live(memory, pipeline, 2, alarm(id="new"))
        assert str(directory) in pipeline.memory_failure
        directory.unlink()
        elsewhere.rename(directory)

        def arrived() -> bool:
            live(memory, pipeline, 2)
            return bool(pipeline.resumed)

        until(arrived)
        (found,) = pipeline.resumed
        assert found.brakes is not None
        assert found.brakes.units[0].pads.since_fitted.energy_j == 150.0  # to which this run's adds up
        assert found.open_alarms == ()  # it was raised anew: the old one is over
        until(lambda: not memory.failing)
    with kept(directory) as store:
        (opened,) = store.remembered().open_alarms
        assert opened.id == "new"


def test_open_alarms_of_a_rule_that_is_off_are_over(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    off, on = alarm(id="off", updated_time_s=1.7e9 + 7.0), alarm(id="on", kind="bus_silent", wheelset=None)
    with kept(tmp_path) as store:
        store.write(Batch(alarms={a.id: a for a in (off, on)}))
    alarms = replace(SETTINGS.alarms, low_adhesion=replace(SETTINGS.alarms.low_adhesion, enabled=False))
    pipeline = Pipeline.from_settings(replace(SETTINGS, alarms=alarms))
    with began(tmp_path, pipeline):
        assert pipeline.monitor.open_alarms() == (on,)
    with kept(tmp_path) as store:
        assert store.remembered().open_alarms == (on,)
        assert store.alarms() == [replace(off, cleared_time_s=1.7e9 + 7.0), on]
    assert [line for line in caplog.messages if "alarm" in line] == [
        "alarm off of an earlier run cleared: its rule is off, or has raised it anew"
    ]


def test_what_a_person_enters_is_taken_up_while_the_daemon_runs_and_only_once(tmp_path: Path) -> None:
    pipeline, entry = StandIn(), Gauge(1.7e9, 2, 30.0)
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1)
        with seen(tmp_path, "rw") as store:
            store.enter(entry)

        def applied() -> bool:
            memory.see((), (), 1.7e9 + 1)
            return bool(pipeline.gauges)

        until(applied)

        def is_written() -> bool:
            with seen(tmp_path) as store:
                return not store.gauges()

        until(is_written)
    again = StandIn()
    with began(tmp_path, again):
        (found,) = again.resumed
        assert again.gauges == []
    assert found.brakes is not None
    assert found.brakes.units[1].pads.gauge_thickness_mm == 30.0
    assert found.brakes.units[0].pads.gauge_thickness_mm == WearSettings().new_pad_thickness_mm


def test_what_a_person_enters_into_a_memory_that_began_anew_is_taken_up(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Its entries are numbered from 1 again, as those of the memory that was set aside were."""
    pipeline = StandIn()

    def applied(entry: Gauge) -> bool:
        memory.see((), (), 1.7e9 + 1)
        return entry in pipeline.gauges

    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 1)
        for thickness_mm in (30.0, 29.0, 28.0):
            entry = Gauge(1.7e9, 2, thickness_mm)
            with seen(tmp_path, "rw") as store:
                store.enter(entry)
            until(lambda entry=entry: applied(entry))
        change(tmp_path / FILE_NAME, "INSERT INTO gauges (wheelset, content) VALUES (1, '{')")
        until(lambda: "the content makes no sense" in caplog.text)
        until(lambda: energy_j(tmp_path) is not None)
        anew = Gauge(1.7e9 + 1.0, 1, 25.0)
        live(memory, pipeline, 2)
        with seen(tmp_path, "rw") as store:
            store.enter(anew)
        until(lambda: applied(anew))


def test_an_entry_that_nothing_can_be_reckoned_with_is_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """It was taken before its bounds were."""
    with kept(tmp_path) as store:
        store.write(Batch(brakes(2)))
        store.enter(Gauge(1.7e9, 1, 30.0, 1e200))
        store.enter(Gauge(1.7e9, 2, 31.0))
    pipeline = Pipeline.from_settings(SETTINGS)
    with began(tmp_path, pipeline) as memory:
        memory.finish()
    assert "wheelset 1: pads measured, 30 mm: this entry is none that can be; it is left out" in caplog.text
    with kept(tmp_path) as store:
        found = store.brakes()
        assert store.gauges() == []
    assert found is not None
    new_mm = WearSettings().new_pad_thickness_mm
    assert [unit.pads.gauge_thickness_mm for unit in found.units] == [new_mm, 31.0]


def test_what_cannot_be_is_not_written_over_what_is_good(tmp_path: Path) -> None:
    pipeline = StandIn()
    with began(tmp_path, pipeline) as memory:
        live_until_kept(tmp_path, memory, pipeline, 2)
        live(memory, pipeline, -5)
    assert energy_j(tmp_path) == 3.0


def test_the_directory_is_the_configured_one_or_that_of_systemd(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)
    assert state_directory(SETTINGS) is None
    monkeypatch.setenv("STATE_DIRECTORY", f"{tmp_path}:/other")
    assert state_directory(SETTINGS) == tmp_path
    configured = replace(SETTINGS, store=replace(SETTINGS.store, directory=Path("/mine")))
    assert state_directory(configured) == Path("/mine")
    assert state_directory(replace(SETTINGS, store=replace(SETTINGS.store, enabled=False))) is None
