"""The memory's file: SQLite, of one vehicle. What it holds has been checked, or is refused.

Every write is one transaction. In WAL mode with synchronous=FULL the log is on the disk when a transaction returns;
NORMAL would keep the file whole too, but a power cut could take back all transactions since the last checkpoint,
which is minutes. Whatever cuts a write short, the file holds the transactions up to some instant, and nothing else.
"""

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self, TypeVar

import msgspec
from msgspec import Struct

from brake_monitor.errors import InputError, WorkError
from brake_monitor.estimation.learned import Learned
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.gauge import Gauge
from brake_monitor.plural import plural
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.alarm_settings import APPLICATIONS_JUDGED
from brake_monitor.storage.plausible_brakes import is_time, why_impossible
from brake_monitor.storage.store_batch import ALARMS_KEPT, MESSAGES_KEPT, RECORDS_KEPT, Batch, GaugeMark, MarkedGauge
from brake_monitor.storage.store_schema import APPLICATION_ID, VERSIONS

BUSY_S = 2.0  # another process has the file for milliseconds
LOG_SIZE_BYTES = 4 << 20
CACHE_KIB = 256  # of each connection: what is written often lies on few pages; SQLite would fill 2 MB with the others

# SQLITE_ERROR: a missing table, or text that is not UTF-8.
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_FORMAT, sqlite3.SQLITE_ERROR}
T = TypeVar("T")


class StoreError(WorkError):
    """The disk does not do now what it should: full, read-only, gone, busy. It may later."""


class RefusedError(InputError):
    """The file is damaged, another vehicle's, a later version's or holds what cannot be."""


class Store:
    """The open file. One thread at a time; other threads and processes open it themselves."""

    def __init__(self, path: Path, mode: str) -> None:
        self._path = path
        with self._own_errors():
            self._db = _connect(path, mode)
        self._inodes: tuple[int | None, int | None] = (None, None)  # of the file and its log, once it is checked
        self._written: dict[str, object] = {}  # what `_state_of` told of what the file holds
        self._gauges_written = 0  # number of the last entry that is known to be marked as applied

    @classmethod
    def open(cls, path: Path, vehicle_id: str, wheelset_count: int) -> Self:
        """Open the vehicle's memory, made or brought up to date where needed, and check all of it.

        StoreError when the disk does not let it, RefusedError when what is there is not to be used.
        """
        _refuse_orphaned_log(path)
        return cls._once_checked(path, "rwc", lambda store: store._prepare(vehicle_id, wheelset_count))

    @classmethod
    def look(cls, path: Path, vehicle_id: str, mode: str = "ro") -> Self:
        """Open an existing memory beside the daemon's: to read, or with mode "rw" to enter a gauge reading."""
        if not path.exists():
            raise InputError(f"{path}: there is no memory here yet; the daemon makes it at its first start")
        return cls._once_checked(path, mode, lambda store: store._check_identity(vehicle_id))

    @classmethod
    def _once_checked(cls, path: Path, mode: str, check: Callable[[Self], None]) -> Self:
        store = cls(path, mode)
        try:
            with store._own_errors():
                store._db.execute(f"PRAGMA cache_size = -{CACHE_KIB}")
                check(store)
                store._inodes = _inodes(path)
        except BaseException:
            store.close()
            raise
        return store

    def close(self) -> None:
        """Give the file back; the log is merged into it, unless another process has it open."""
        self._db.close()

    @property
    def is_in_place(self) -> bool:
        """Whether it is still the file of its path, with its log: what was removed can be written on, and is lost."""
        (file, file_log), (now, log_now) = self._inodes, _inodes(self._path)
        return file == now and file_log in {None, log_now}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    # -- opening -----------------------------------------------------------------------------------------------

    def _prepare(self, vehicle_id: str, wheelset_count: int) -> None:
        ((found,),) = self._db.execute("PRAGMA integrity_check(1)")
        if found != "ok":
            raise self._refused(f"the file is damaged: {' '.join(found.split())}")
        self._db.execute("PRAGMA journal_mode = WAL")
        self._db.execute("PRAGMA synchronous = FULL")
        self._db.execute(f"PRAGMA journal_size_limit = {LOG_SIZE_BYTES}")
        version = self._version()
        if version == 0 and not list(self._db.execute("SELECT 1 FROM sqlite_schema LIMIT 1")):
            with self._transaction():
                self._db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                self._migrate(0)
                self._db.execute("INSERT INTO meta VALUES ('vehicle', ?)", (vehicle_id,))
        else:
            self._check_identity(vehicle_id, oldest=1)
            if version < len(VERSIONS):
                with self._transaction():
                    self._migrate(version)
        if not self.file:
            self._db.execute("INSERT INTO meta VALUES ('file', lower(hex(randomblob(16))))")
        self._check_content(wheelset_count)

    def _version(self) -> int:
        ((version,),) = self._db.execute("PRAGMA user_version")
        return int(version)

    def _migrate(self, version: int) -> None:
        for statement in (statement for script in VERSIONS[version:] for statement in script):
            self._db.execute(statement)
        self._db.execute(f"PRAGMA user_version = {len(VERSIONS)}")

    def _check_identity(self, vehicle_id: str, oldest: int | None = None) -> None:
        ((application,),) = self._db.execute("PRAGMA application_id")
        if application != APPLICATION_ID:
            raise self._refused("this is not a memory of the brake monitor")
        newest = len(VERSIONS)
        if not (oldest or newest) <= self._version() <= newest:
            raise self._refused(f"version {self._version()} of the memory, this program knows {newest}")
        rows = list(self._db.execute("SELECT value FROM meta WHERE name = 'vehicle'"))
        if rows != [(vehicle_id,)]:
            found = f'of vehicle "{rows[0][0]}"' if rows else "of no vehicle"
            raise self._refused(f'this is the memory {found}, not of "{vehicle_id}"')

    def _check_content(self, wheelset_count: int) -> None:
        """Check that everything that the program goes on with is of its type, and possible."""
        brakes = self.remembered().brakes
        self.gauges()
        for table, kind in (("alarms", Alarm), ("stops", ApplicationRecord)):
            for _ in self._each(f"SELECT content FROM {table}", kind):  # thousands, and none is needed now
                pass
        if brakes is not None and len(brakes.units) != wheelset_count:
            raise self._refused(f"it holds {plural(len(brakes.units), 'wheelset')}, the vehicle has {wheelset_count}")

    # -- writing -----------------------------------------------------------------------------------------------

    def write(self, batch: Batch) -> None:
        """Write all of it or, when StoreError is raised, nothing. State that has not changed costs no write."""
        state, gauges = _state_of(batch), self._gauges_to_mark(batch)
        changed = {name for name, now in state.items() if name not in self._written or self._written[name] != now}
        if not (changed or gauges or batch.alarms or batch.applications or batch.messages):
            return
        with self._own_errors(), self._transaction():
            self._write_state(batch, changed)
            if gauges:
                self._db.execute("UPDATE gauges SET applied = 1 WHERE number <= ?", (gauges,))
            self._write_events(batch)
        self._written |= state
        self._gauges_written = gauges or self._gauges_written

    def enter(self, gauge: Gauge) -> None:
        """Leave a gauge entry for the daemon; another process than the daemon may write nothing else."""
        with self._own_errors(), self._transaction():
            self._db.execute("INSERT INTO gauges (wheelset, content) VALUES (?, ?)", (gauge.wheelset, _text(gauge)))

    def _gauges_to_mark(self, batch: Batch) -> int:
        """Up to which number entries of this file are contained in the batch's brakes; 0 when that is known already."""
        mark = batch.gauges_applied
        if mark is None or mark.number == self._gauges_written or mark.file != self.file:
            return 0
        return mark.number

    def _write_state(self, batch: Batch, changed: set[str]) -> None:
        brakes = batch.brakes
        if "pads" in changed and brakes is not None:
            rows = [(i, brakes.time_s, _text(unit)) for i, unit in enumerate(brakes.units, 1)]
            self._db.executemany("INSERT OR REPLACE INTO wear VALUES (?, ?, ?)", rows)
        if "running" in changed and brakes is not None:
            self._db.execute("DELETE FROM meta WHERE name = 'running'")
            if brakes.running is not None:
                self._db.execute("INSERT INTO meta VALUES ('running', ?)", (_text(brakes.running),))
        if "learned" in changed and batch.learned is not None:
            self._db.execute("INSERT OR REPLACE INTO learned VALUES (1, ?)", (_text(batch.learned),))

    def _write_events(self, batch: Batch) -> None:
        db = self._db
        if batch.alarms:
            db.executemany(
                "INSERT INTO alarms (id, raised_time_s, cleared_time_s, content) VALUES (?, ?, ?, ?) "
                "ON CONFLICT (id) DO UPDATE SET cleared_time_s = excluded.cleared_time_s, content = excluded.content",
                [(a.id, a.raised_time_s, a.cleared_time_s, _text(a)) for a in batch.alarms.values()],
            )
            db.execute(
                "DELETE FROM alarms WHERE cleared_time_s IS NOT NULL "
                "AND number <= (SELECT max(number) FROM alarms) - ?",
                (ALARMS_KEPT,),
            )
        if batch.applications:
            rows = [(record.start_time_s, _text(record)) for record in batch.applications]
            db.executemany("INSERT OR REPLACE INTO stops (start_time_s, content) VALUES (?, ?)", rows)
            db.execute("DELETE FROM stops WHERE number <= (SELECT max(number) FROM stops) - ?", (RECORDS_KEPT,))
        if batch.messages:
            db.executemany("INSERT OR REPLACE INTO outbox VALUES (?, ?)", list(batch.messages.items()))
            db.execute("DELETE FROM outbox WHERE sequence <= ?", (max(batch.messages) - MESSAGES_KEPT,))

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        self._db.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._db.execute("COMMIT")
        except BaseException:
            with suppress(sqlite3.Error):  # a full disk has already rolled it back
                self._db.execute("ROLLBACK")
            raise

    # -- reading -----------------------------------------------------------------------------------------------

    def remembered(self) -> Remembered:
        """The state to go on with."""
        learned = self._read("SELECT content FROM learned", Learned)
        opened = self._read("SELECT content FROM alarms WHERE cleared_time_s IS NULL ORDER BY number", Alarm)
        return Remembered(learned[0] if learned else None, self.brakes(), tuple(opened))

    def brakes(self) -> Brakes | None:
        """The brake units as last written; None before."""
        with self._own_errors():
            rows = list(self._db.execute("SELECT wheelset, time_s, content FROM wear ORDER BY wheelset"))
            if not rows:
                return None
            time_s = msgspec.convert(rows[0][1], float | None)
            units = tuple(msgspec.json.decode(content, type=BrakeUnit) for *_, content in rows)
        if [wheelset for wheelset, *_ in rows] != list(range(1, len(rows) + 1)):
            raise self._refused("wheelsets are missing in the wear")
        running = self._read("SELECT value FROM meta WHERE name = 'running'", ApplicationRecord)
        brakes = Brakes(time_s, units, tuple(self.applications(APPLICATIONS_JUDGED)), running[0] if running else None)
        if reason := why_impossible(brakes):
            raise self._refused(reason)
        return brakes

    def applications(self, newest: int = RECORDS_KEPT) -> list[ApplicationRecord]:
        """The last brake applications, oldest first."""
        return self._read("SELECT content FROM stops ORDER BY number DESC LIMIT ?", ApplicationRecord, (newest,))[::-1]

    def alarms(self) -> list[Alarm]:
        """The alarms that are kept, in the order in which they were raised."""
        return self._read("SELECT content FROM alarms ORDER BY raised_time_s, number", Alarm)

    @property
    def file(self) -> str:
        """What tells this file from those before and after it; empty when no daemon has opened it yet."""
        with self._own_errors():
            rows = list(self._db.execute("SELECT value FROM meta WHERE name = 'file'"))
        return str(rows[0][0]) if rows else ""

    def gauges(self) -> list[MarkedGauge]:
        """The gauge entries that the written brakes do not contain yet, oldest first."""
        file = self.file
        with self._own_errors():
            rows = self._db.execute("SELECT number, content FROM gauges WHERE applied = 0 ORDER BY number")
            gauges = [
                MarkedGauge(GaugeMark(file, self._whole(number)), msgspec.json.decode(content, type=Gauge))
                for number, content in rows
            ]
        if not all(is_time(entry.gauge.time_s) for entry in gauges):
            raise self._refused("a gauge entry is of a time that cannot be")
        return gauges

    def messages(self) -> Iterator[tuple[int, bytes]]:
        """What waits in the outbox, by sequence; read as it is asked for."""
        with self._own_errors():
            for sequence, message in self._db.execute(
                "SELECT sequence, CAST(message AS BLOB) FROM outbox ORDER BY sequence"
            ):
                yield self._whole(sequence), bytes(message or b"")

    def changed_by_others(self) -> int:
        """A number that changes when another process has written."""
        with self._own_errors():
            ((number,),) = self._db.execute("PRAGMA data_version")
        return int(number)

    def _read(self, query: str, kind: type[T], parameters: tuple[float, ...] = ()) -> list[T]:
        return list(self._each(query, kind, parameters))

    def _each(self, query: str, kind: type[T], parameters: tuple[float, ...] = ()) -> Iterator[T]:
        with self._own_errors():
            for (content,) in self._db.execute(query, parameters):
                yield msgspec.json.decode(content, type=kind)

    def _whole(self, value: object) -> int:
        """A whole number from the file; a damaged table may hold anything."""
        try:
            return int(str(value))
        except ValueError:
            raise self._refused(f"the file is damaged: {value} is no whole number") from None

    # -- what is wrong -----------------------------------------------------------------------------------------

    @contextmanager
    def _own_errors(self) -> Iterator[None]:
        """Turn what SQLite or the disk cannot do, and content that makes no sense, into our own errors."""
        try:
            yield
        except sqlite3.ProgrammingError:
            raise
        except sqlite3.DatabaseError as error:
            what = " ".join(str(error).split())  # SQLite quotes schemas, lines and all
            if getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF in _DAMAGED:
                raise self._refused(f"the file is damaged: {what}") from None
            raise StoreError(f"{self._path}: {what}") from None
        except UnicodeDecodeError:
            raise self._refused("the file is damaged: there is text in it that is none") from None
        except msgspec.MsgspecError as error:
            raise self._refused(f"the content makes no sense: {error}") from None
        except OSError as error:
            raise StoreError(f"{self._path}: {error.strerror or error}") from None

    def _refused(self, sentence: str) -> RefusedError:
        return RefusedError(f"{self._path}: {sentence}")


def _state_of(batch: Batch) -> dict[str, object]:
    """What of a batch's state is worth a write when it changes.

    Neither temperatures nor times are: how far discs have cooled is worked out from the time anyway.
    """
    state: dict[str, object] = {}
    if batch.brakes is not None:
        state["pads"], state["running"] = [unit.pads for unit in batch.brakes.units], batch.brakes.running
    if batch.learned is not None:
        state["learned"] = msgspec.structs.replace(batch.learned, time_s=0.0)
    return state


def _text(content: Struct) -> str:
    return msgspec.json.encode(content).decode()


def _refuse_orphaned_log(path: Path) -> None:
    """SQLite would delete the log of a file that is empty."""
    log = log_of(path)
    if log.exists() and log.stat().st_size and not (path.exists() and path.stat().st_size):
        raise RefusedError(f"{path}: the file is missing or empty, and its log is not")


def _inodes(path: Path) -> tuple[int | None, int | None]:
    """Of a database and its write-ahead log."""
    return _inode(path), _inode(log_of(path))


def _inode(path: Path) -> int | None:
    """None where there is no such file."""
    try:
        return path.stat().st_ino
    except OSError:
        return None


def log_of(path: Path) -> Path:
    """The write-ahead log of a database."""
    return path.with_name(f"{path.name}-wal")


def _connect(path: Path, mode: str) -> sqlite3.Connection:
    return sqlite3.connect(
        f"{path.absolute().as_uri()}?mode={mode}",
        uri=True,
        timeout=BUSY_S,
        isolation_level=None,
        check_same_thread=False,
    )
