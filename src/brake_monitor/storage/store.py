"""What the memory holds: read, written, and checked to be possible before the program goes on with it."""

from collections.abc import Iterator
from pathlib import Path
from typing import Self, TypeVar

import msgspec
from msgspec import Struct

from brake_monitor.errors import InputError
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
from brake_monitor.storage.store_file import StoreFile, status_of

T = TypeVar("T")


class Store:
    """The memory in an open file. One thread at a time; other threads and processes open it themselves."""

    def __init__(self, file: StoreFile) -> None:
        self._file = file
        self._db = file.db
        self._written: dict[str, object] = {}  # what `_state_of` told of what the file holds
        self._gauges_written = 0  # number of the last entry that is known to be marked as applied

    @classmethod
    def open(cls, path: Path, vehicle_id: str, wheelset_count: int) -> Self:
        """Open the vehicle's memory, made or brought up to date where needed, and check all of it.

        StoreError when the disk does not let it, RefusedError when what is there is not to be used.
        """
        file = StoreFile(path, "rwc")
        store = cls(file)
        with file.being_checked():
            file.prepare(vehicle_id)
            store._check_content(wheelset_count)
        return store

    @classmethod
    def look(cls, path: Path, vehicle_id: str, mode: str = "ro") -> Self:
        """Open an existing memory beside the daemon's: to read, or with mode "rw" to enter a gauge reading."""
        if status_of(path) is None:
            raise InputError(f"{path}: there is no memory here yet; the daemon makes it at its first start")
        file = StoreFile(path, mode)
        with file.being_checked():
            file.check_vehicle(vehicle_id)
        return cls(file)

    def close(self) -> None:
        """Give the file back."""
        self._file.close()

    @property
    def is_in_place(self) -> bool:
        """As `StoreFile` says."""
        return self._file.is_in_place

    @property
    def file(self) -> str:
        """What tells its file from others."""
        return self._file.identity

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def _check_content(self, wheelset_count: int) -> None:
        """Check that everything that the program goes on with is of its type, and possible."""
        brakes = self.remembered().brakes
        self.gauges()
        for table, kind in (("alarms", Alarm), ("stops", ApplicationRecord)):
            for _ in self._each(f"SELECT content FROM {table}", kind):  # thousands, and none is needed now
                pass
        if brakes is not None and len(brakes.units) != wheelset_count:
            raise self._file.refused(
                f"it holds {plural(len(brakes.units), 'wheelset')}, the vehicle has {wheelset_count}"
            )

    # -- writing -----------------------------------------------------------------------------------------------

    def write(self, batch: Batch) -> None:
        """Write all of it or, when StoreError is raised, nothing. State that has not changed costs no write."""
        state, gauges = _state_of(batch), self._gauges_to_mark(batch)
        changed = {name for name, now in state.items() if name not in self._written or self._written[name] != now}
        if not (changed or gauges or batch.alarms or batch.applications or batch.messages):
            return
        with self._file.transaction():
            self._write_state(batch, changed)
            if gauges:
                self._db.execute("UPDATE gauges SET applied = 1 WHERE number <= ?", (gauges,))
            self._write_events(batch)
        self._written |= state
        self._gauges_written = gauges or self._gauges_written

    def enter(self, gauge: Gauge) -> None:
        """Leave a gauge entry for the daemon; another process than the daemon may write nothing else."""
        with self._file.transaction():
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

    # -- reading -----------------------------------------------------------------------------------------------

    def remembered(self) -> Remembered:
        """The state to go on with."""
        learned = self._read("SELECT content FROM learned", Learned)
        opened = self._read("SELECT content FROM alarms WHERE cleared_time_s IS NULL ORDER BY number", Alarm)
        return Remembered(learned[0] if learned else None, self.brakes(), tuple(opened))

    def brakes(self) -> Brakes | None:
        """The brake units as last written; None before."""
        with self._file.own_errors():
            rows = list(self._db.execute("SELECT wheelset, time_s, content FROM wear ORDER BY wheelset"))
            if not rows:
                return None
            time_s = msgspec.convert(rows[0][1], float | None)
            units = tuple(msgspec.json.decode(content, type=BrakeUnit) for *_, content in rows)
        if [wheelset for wheelset, *_ in rows] != list(range(1, len(rows) + 1)):
            raise self._file.refused("wheelsets are missing in the wear")
        running = self._read("SELECT value FROM meta WHERE name = 'running'", ApplicationRecord)
        brakes = Brakes(time_s, units, tuple(self.applications(APPLICATIONS_JUDGED)), running[0] if running else None)
        if reason := why_impossible(brakes):
            raise self._file.refused(reason)
        return brakes

    def applications(self, newest: int = RECORDS_KEPT) -> list[ApplicationRecord]:
        """The last brake applications, oldest first."""
        return self._read("SELECT content FROM stops ORDER BY number DESC LIMIT ?", ApplicationRecord, (newest,))[::-1]

    def alarms(self) -> list[Alarm]:
        """The alarms that are kept, in the order in which they were raised."""
        return self._read("SELECT content FROM alarms ORDER BY raised_time_s, number", Alarm)

    def gauges(self) -> list[MarkedGauge]:
        """The gauge entries that the written brakes do not contain yet, oldest first."""
        file = self.file
        with self._file.own_errors():
            rows = self._db.execute("SELECT number, content FROM gauges WHERE applied = 0 ORDER BY number")
            gauges = [
                MarkedGauge(GaugeMark(file, self._whole(number)), msgspec.json.decode(content, type=Gauge))
                for number, content in rows
            ]
        if not all(is_time(entry.gauge.time_s) for entry in gauges):
            raise self._file.refused("a gauge entry is of a time that cannot be")
        return gauges

    def messages(self) -> Iterator[tuple[int, bytes]]:
        """What waits in the outbox, by sequence; read as it is asked for."""
        with self._file.own_errors():
            for sequence, message in self._db.execute(
                "SELECT sequence, CAST(message AS BLOB) FROM outbox ORDER BY sequence"
            ):
                yield self._whole(sequence), bytes(message or b"")

    def changed_by_others(self) -> int:
        """A number that changes when another process has written."""
        with self._file.own_errors():
            ((number,),) = self._db.execute("PRAGMA data_version")
        return int(number)

    def _read(self, query: str, kind: type[T], parameters: tuple[float, ...] = ()) -> list[T]:
        return list(self._each(query, kind, parameters))

    def _each(self, query: str, kind: type[T], parameters: tuple[float, ...] = ()) -> Iterator[T]:
        with self._file.own_errors():
            for (content,) in self._db.execute(query, parameters):
                yield msgspec.json.decode(content, type=kind)

    def _whole(self, value: object) -> int:
        """A whole number from the file; a damaged table may hold anything."""
        try:
            return int(str(value))
        except ValueError:
            raise self._file.refused(f"the file is damaged: {value} is no whole number") from None


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
