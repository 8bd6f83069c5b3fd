"""The memory's file survives whatever cuts a write short, and what cannot be is refused."""

import os
import random
import shutil
import sqlite3
import subprocess
import sys
import tracemalloc
from collections.abc import Callable
from contextlib import closing
from functools import partial
from math import nan
from pathlib import Path

import pytest
from msgspec.structs import replace

from brake_monitor.errors import InputError
from brake_monitor.monitoring.brake_units.gauge import Gauge
from brake_monitor.monitoring.brake_units.wear import PadUse
from brake_monitor.settings.alarm_settings import APPLICATIONS_JUDGED
from brake_monitor.storage import store as store_module
from brake_monitor.storage import store_file, store_schema
from brake_monitor.storage.plausible_brakes import why_impossible
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch, GaugeMark
from brake_monitor.storage.store_file import RefusedError, StoreError, log_of
from brake_states import WHEELSETS, batch, brakes, learned, pads, stop
from estimates import alarm
from killed_writer import look

HERE = Path(__file__).parents[1]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "memory.db"


def opened(path: Path, vehicle: str = "w") -> Store:
    return Store.open(path, vehicle, WHEELSETS)


def written(path: Path, *numbers: int) -> None:
    with opened(path) as store:
        for number in numbers:
            store.write(batch(number))


def test_what_is_written_is_there_again(path: Path) -> None:
    written(path, 1, 2, 3)
    assert look(path) == 3


def test_the_last_state_counts_and_an_alarm_is_one_row_that_ends(path: Path) -> None:
    acknowledged, cleared = alarm(id="a", acknowledged_time_s=2.0), alarm(id="b", raised_time_s=5.0, cleared_time_s=9.0)
    with opened(path) as store:
        store.write(Batch(alarms={"a": alarm(id="a"), "b": alarm(id="b", raised_time_s=5.0)}))
        store.write(Batch(alarms={"a": acknowledged, "b": cleared}))
    with opened(path) as store:
        assert store.remembered().open_alarms == (acknowledged,)
        assert store.alarms() == [cleared, acknowledged]


def test_what_has_not_changed_costs_no_write(path: Path) -> None:
    with opened(path) as store:
        store.write(Batch(brakes(1), learned(1)))
        size = log_of(path).stat().st_size
        colder = tuple(replace(unit, disc_temperature_c=15.0) for unit in brakes(1).units)
        later = replace(learned(1), time_s=1.8e9)
        store.write(Batch(replace(brakes(1), time_s=1.8e9, units=colder), later))  # at a standstill
        assert log_of(path).stat().st_size == size
        store.write(Batch(brakes(2), learned(1)))
        assert log_of(path).stat().st_size > size


def test_histories_are_bounded_and_open_alarms_stay(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ALARMS_KEPT", "RECORDS_KEPT", "MESSAGES_KEPT"):
        monkeypatch.setattr(store_module, name, 5)
    with opened(path) as store:
        store.write(Batch(alarms={"open": alarm(id="open")}))
        for i in range(1, 21):
            ended = alarm(id=str(i), raised_time_s=1.7e9 + i, cleared_time_s=1.7e9 + i)
            store.write(Batch(alarms={ended.id: ended}, applications=[stop(i)], messages={i: b"m"}))
        assert [a.id for a in store.alarms()] == ["open", "16", "17", "18", "19", "20"]
        assert len(store.applications()) == 5
        assert [sequence for sequence, _ in store.messages()] == [16, 17, 18, 19, 20]


def test_a_restart_gives_the_rules_no_more_brake_applications_than_they_had(path: Path) -> None:
    newest = APPLICATIONS_JUDGED + 10
    written(path, *range(1, newest + 1))
    with opened(path) as store:
        found = store.remembered().brakes
    assert found is not None
    assert found.applications == tuple(map(stop, range(newest - APPLICATIONS_JUDGED + 1, newest + 1)))


def test_two_batches_that_could_not_be_written_are_one() -> None:
    both = batch(1).then(batch(2))
    assert both.brakes == brakes(2)
    assert both.applications == [stop(1), stop(2)]
    assert list(both.alarms) == ["hot_disc-1-1", "hot_disc-1-2"]
    assert both.messages == {1: b"1", 2: b"2"}


@pytest.mark.parametrize("seed", [4, 5, 6, 7])  # each with a file of its own: to look at a full one takes long
def test_a_process_that_is_killed_at_any_instant_loses_nothing_that_was_written(path: Path, seed: int) -> None:
    rounds = 63
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), os.environ.get("PYTHONPATH", "")])}
    told = subprocess.run(
        [sys.executable, HERE / "killed_writer.py", path, str(seed), str(rounds)],
        capture_output=True, text=True, check=False, env=environment, timeout=1500,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr
    done, writes, _ = map(int, told.stdout.split())
    assert done == rounds
    assert writes > rounds / 2


def test_a_log_that_was_cut_short_is_the_past(path: Path, tmp_path: Path) -> None:
    """As after a power cut in the midst of a write: some of the last writes are missing, never a part of one."""
    store = opened(path)
    for number in range(1, 31):
        store.write(batch(number))
    log = log_of(path).read_bytes()
    chance, seen = random.Random(5), set()
    copy = tmp_path / "copy.db"
    for length in [len(log), *(chance.randrange(1, len(log)) for _ in range(150))]:
        shutil.copy(path, copy)
        log_of(copy).write_bytes(log[:length])
        seen.add(look(copy))
        for left in tmp_path.glob("copy*"):
            left.unlink()
    store.close()
    assert max(seen) == 30
    assert len(seen) > 20


def test_a_file_that_was_cut_short_or_scrambled_is_whole_or_refused(path: Path, tmp_path: Path) -> None:
    written(path, *range(1, 31))
    good = path.read_bytes()
    chance, refused = random.Random(6), 0
    copy = tmp_path / "copy.db"
    for _ in range(150):
        place = chance.randrange(1, len(good))
        noise = chance.randbytes(64) if chance.random() < 0.5 else None
        copy.write_bytes(good[:place] if noise is None else good[:place] + noise + good[place + 64 :])
        damaged = copy.read_bytes()
        try:
            with opened(copy):
                pass
        except RefusedError:
            refused += 1
            assert copy.read_bytes() == damaged
        for left in tmp_path.glob("copy*"):
            left.unlink()
    assert refused > 100


@pytest.mark.parametrize(
    "how", [opened, partial(Store.look, vehicle_id="w"), partial(Store.look, vehicle_id="w", mode="rw")]
)
def test_an_empty_file_with_a_log_is_refused_before_sqlite_deletes_the_log(
    path: Path, tmp_path: Path, how: Callable[[Path], Store]
) -> None:
    """Also by who only wants to look, as `wear show` does before the daemon is started again."""
    with opened(path) as store:
        store.write(batch(2))
        log = log_of(path).read_bytes()
    copy = tmp_path / "copy.db"
    copy.touch()
    log_of(copy).write_bytes(log)
    with pytest.raises(RefusedError, match="its log is not"):
        how(copy)
    assert log_of(copy).read_bytes() == log


def test_every_connection_writes_alike(path: Path) -> None:
    """The daemon's two, and that of who enters what was measured."""
    with opened(path) as daemon, Store.look(path, "w", "rw") as person:
        for setting, value in (("synchronous", 2), ("journal_size_limit", 4 << 20), ("cache_size", -256)):
            for store in (daemon, person):
                assert list(store._db.execute(f"PRAGMA {setting}")) == [(value,)]


def altered(statement: str, *parameters: object) -> Callable[[Path], None]:
    def alter(path: Path) -> None:
        with sqlite3.connect(path) as db:
            db.execute(statement, parameters)
        db.close()

    return alter


def schema_spoilt(path: Path) -> None:
    """One letter of a table's definition, which takes several lines."""
    content = path.read_bytes()
    spoilt = content.replace(b"CREATE TABLE gauges (", b"CREATE TABLE gauges`(")
    assert spoilt != content
    path.write_bytes(spoilt)


REFUSED = {
    "a schema is spoilt": (schema_spoilt, "damaged"),
    "no database": (lambda path: path.write_bytes(b"not a database at all" * 500), "damaged"),
    "another program's": (altered("PRAGMA application_id = 7"), "not a memory of the brake monitor"),
    "a later version's": (altered("PRAGMA user_version = 99"), "version 99"),
    "no version": (altered("PRAGMA user_version = 0"), "version 0"),
    "no vehicle": (altered("DELETE FROM meta"), "of no vehicle"),
    "another vehicle's": (altered("UPDATE meta SET value = 'wagon-7' WHERE name = 'vehicle'"), 'of vehicle "wagon-7"'),
    "a table is gone": (altered("DROP TABLE stops"), "no such table"),
    "no JSON": (altered("UPDATE wear SET content = '{'"), "makes no sense"),
    "not a number": (altered("UPDATE wear SET content = replace(content, '4.0', 'NaN')"), "makes no sense"),
    "a wrong type": (altered("UPDATE wear SET content = replace(content, '4.0', '\"x\"')"), "makes no sense"),
    "negative": (
        altered("UPDATE wear SET content = replace(content, '\"energy_j\":1.5', '\"energy_j\":-1.5')"),
        "negative",
    ),
    "beyond all numbers": (altered("UPDATE wear SET content = replace(content, '4.0', '1e999')"), "makes no sense"),
    "a wheelset is gone": (altered("DELETE FROM wear WHERE wheelset = 1"), "wheelsets are missing"),
    "a wheelset too few": (altered("DELETE FROM wear WHERE wheelset = 2"), "1 wheelset, the vehicle has 2"),
    "an alarm without severity": (altered("UPDATE alarms SET content = '{}'"), "makes no sense"),
    "learned nonsense": (altered("UPDATE learned SET content = '[]'"), "makes no sense"),
    "a text as time": (altered("UPDATE wear SET time_s = 'noon'"), "makes no sense"),
    "later than all times": (altered("UPDATE wear SET time_s = 1e300"), "of a time that cannot be"),
    "before all times": (altered("UPDATE wear SET time_s = -1e12"), "of a time that cannot be"),
    "measured at no time": (
        altered("UPDATE wear SET content = replace(content, '\"gauged_time_s\":null', '\"gauged_time_s\":1e300')"),
        "of a time that cannot be",
    ),
    "entered at no time": (
        altered(
            "INSERT INTO gauges (wheelset, content) VALUES (1, ?)", '{"time_s":1e300,"wheelset":1,"thickness_mm":30}'
        ),
        "of a time that cannot be",
    ),
    "a braking of other wheelsets": (
        altered(
            "INSERT INTO meta SELECT 'running', json_set(content, '$.wheelsets', json_array()) FROM stops",
        ),
        "one of 0 wheelsets",
    ),
    "entries are gone": (altered("DROP TABLE gauges"), "no such table"),
}
IDENTITY = ("no database", "another program's", "a later version's", "no version", "no vehicle", "another vehicle's")


@pytest.mark.parametrize(("damage", "sentence"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_is_refused_with_the_reason(path: Path, damage: Callable[[Path], None], sentence: str) -> None:
    written(path, 1)
    damage(path)
    before = path.read_bytes()
    with pytest.raises(RefusedError, match=sentence) as refused:
        opened(path)
    assert str(refused.value).startswith(f"{path}: ")
    assert "\n" not in str(refused.value)
    assert path.read_bytes() == before


def look_at_all(path: Path) -> None:
    with Store.look(path, "w") as store:
        store.remembered()
        store.applications()
        store.gauges()


@pytest.mark.parametrize("name", [name for name in REFUSED if name not in (*IDENTITY, "a wheelset too few")])
def test_what_cannot_be_is_refused_also_where_it_is_only_looked_at(path: Path, name: str) -> None:
    written(path, 1)
    damage, sentence = REFUSED[name]
    damage(path)
    with pytest.raises(RefusedError, match=sentence) as refused:
        look_at_all(path)
    assert str(refused.value).startswith(f"{path}: ")


def test_a_file_that_another_process_holds_is_named(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(path, 1)
    monkeypatch.setattr(store_file, "BUSY_S", 0.0)
    with closing(sqlite3.connect(path, isolation_level=None)) as other, Store.look(path, "w", "rw") as store:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(StoreError) as told:
            store.enter(Gauge(5.0, 2, 31.5))
    assert str(told.value) == f"{path}: database is locked"


def test_a_table_that_is_one_still_but_holds_no_numbers_is_damaged(path: Path) -> None:
    """One letter less in a definition, and sequences are no longer numbered by themselves."""
    with Store.open(path, "wagon-1", 2) as store:
        store.write(Batch(messages={5: b"message"}))
    for change in (
        "DROP TABLE outbox",
        "CREATE TABLE outbox (sequence, message)",
        "INSERT INTO outbox VALUES (NULL, x'')",
    ):
        altered(change)(path)
    with Store.open(path, "wagon-1", 2) as store, pytest.raises(RefusedError, match="damaged: None is no whole number"):
        list(store.messages())


def test_numbers_that_cannot_be_are_told() -> None:
    good = brakes(3)
    assert why_impossible(good) is None
    for energy_j in (-1.0, nan):
        unit = replace(good.units[1], pads=replace(pads(1), since_gauge=PadUse(energy_j=energy_j)))
        bad = replace(good, units=(good.units[0], unit))
        assert "wheelset 2" in str(why_impossible(bad))


def test_a_file_of_an_earlier_version_is_brought_up_to_date(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(path, 1, 2)
    newer = (*store_schema.VERSIONS, ("ALTER TABLE stops ADD COLUMN place TEXT", "CREATE TABLE more (x)"))
    monkeypatch.setattr(store_file, "VERSIONS", newer)
    with pytest.raises(RefusedError, match=r"version 1 of the memory, this program knows 2"):
        Store.look(path, "w")
    assert look(path) == 2
    with sqlite3.connect(path) as db:
        assert db.execute("PRAGMA user_version").fetchone() == (2,)
        assert db.execute("SELECT place FROM stops").fetchall() == [(None,), (None,)]
    db.close()


def test_a_migration_that_fails_leaves_the_file_as_it_was(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    written(path, 1, 2)
    newer = (*store_schema.VERSIONS, ("CREATE TABLE more (x)", "CREATE TABLE stops (y)"))
    monkeypatch.setattr(store_file, "VERSIONS", newer)
    with pytest.raises(RefusedError, match="already exists"):
        opened(path)
    monkeypatch.undo()
    assert look(path) == 2


def test_a_gauge_entry_waits_until_the_wear_contains_it(path: Path) -> None:
    written(path, 1)
    entry = Gauge(5.0, 2, 31.5)
    with opened(path) as daemon:
        assert daemon.gauges() == []
        before = daemon.changed_by_others()
        with Store.look(path, "w", "rw") as person:
            person.enter(entry)
        assert daemon.changed_by_others() != before
        ((mark, gauge),) = daemon.gauges()
        assert gauge == entry
        daemon.write(Batch(brakes(2), gauges_applied=GaugeMark("another file", mark.number)))
        assert daemon.gauges() == [(mark, gauge)]
        daemon.write(Batch(brakes(2), gauges_applied=mark))
        assert daemon.gauges() == []


def test_what_is_applied_and_written_is_not_written_again_and_again(path: Path) -> None:
    with opened(path) as daemon:
        with Store.look(path, "w", "rw") as person:
            person.enter(Gauge(5.0, 2, 31.5))
        ((mark, _),) = daemon.gauges()
        daemon.write(Batch(brakes(2), gauges_applied=mark))
        with Store.look(path, "w") as other:
            before = other.changed_by_others()
            daemon.write(Batch(brakes(2), gauges_applied=mark))
            assert other.changed_by_others() == before


def test_a_memory_that_begins_anew_is_another_file(path: Path) -> None:
    with opened(path) as daemon:
        first = daemon.file
    with opened(path) as daemon:
        assert daemon.file == first
    path.unlink()
    with opened(path) as daemon:
        assert daemon.file != first


def test_looking_needs_a_memory_of_the_right_vehicle(path: Path) -> None:
    with pytest.raises(InputError, match="there is no memory here yet"):
        Store.look(path, "w")
    written(path, 1)
    with pytest.raises(RefusedError, match='of vehicle "w", not of "v"'):
        Store.look(path, "v")


def test_a_memory_of_years_is_opened_and_read_in_little_memory(path: Path) -> None:
    """What is only checked, or passed on, is not kept; it would stay with the daemon to its end."""
    some = {f"slide-{k}": alarm(id=f"slide-{k}", cleared_time_s=1.8e9, message=1000 * "x") for k in range(2000)}
    with opened(path) as store:
        store.write(Batch(alarms=some, messages=dict.fromkeys(range(1, 2001), 1000 * b"x"), applications=[stop(1)]))
    tracemalloc.start()
    try:
        with opened(path) as store:
            read = sum(len(message) for _, message in store.messages())
        most_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert read == 2_000_000
    assert most_bytes < 200_000
