"""The memory's file as SQLite keeps it: opened, checked to be the vehicle's, brought up to date, written as a whole.

Every write is one transaction. In WAL mode with synchronous=FULL the log is on the disk when a transaction returns;
NORMAL would keep the file whole too, but a power cut could take back all transactions since the last checkpoint,
which is minutes. Whatever cuts a write short, the file holds the transactions up to some instant, and nothing else.
"""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import msgspec

from brake_monitor.errors import InputError, WorkError
from brake_monitor.storage.store_schema import APPLICATION_ID, VERSIONS

BUSY_S = 2.0  # another process has the file for milliseconds
CONNECTION = (  # what SQLite does not note in the file
    "cache_size = -256",  # KiB: what is written often lies on few pages; it would fill 2 MB with the others
    "synchronous = FULL",
    f"journal_size_limit = {4 << 20}",  # bytes
)

# SQLITE_ERROR: a missing table, or text that is not UTF-8.
_DAMAGED = {sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB, sqlite3.SQLITE_FORMAT, sqlite3.SQLITE_ERROR}


class StoreError(WorkError):
    """The disk does not do now what it should: full, read-only, gone, busy. It may later."""


class RefusedError(InputError):
    """The file is damaged, another vehicle's, a later version's or holds what cannot be."""


class StoreFile:
    """The open file. One thread at a time; other threads and processes open it themselves."""

    def __init__(self, path: Path, mode: str) -> None:
        """`mode` as in SQLite: "ro", "rw", or "rwc" for a file that may have to be made."""
        self._path = path
        with self.own_errors():
            self._refuse_orphaned_log()
            self.db = _connect(path, mode)
        self._inodes: tuple[int | None, int | None] = (None, None)  # of the file and its log, once it is checked

    def close(self) -> None:
        """Give the file back; the log is merged into it, unless another process has it open."""
        self.db.close()

    @property
    def is_in_place(self) -> bool:
        """Whether it is still the file of its path, with its log: what was removed can be written on, and is lost."""
        (file, file_log), (now, log_now) = self._inodes, _inodes(self._path)
        return file == now and file_log in {None, log_now}

    @property
    def identity(self) -> str:
        """What tells this file from those before and after it; empty when no daemon has opened it yet."""
        with self.own_errors():
            rows = list(self.db.execute("SELECT value FROM meta WHERE name = 'file'"))
        return str(rows[0][0]) if rows else ""

    # -- opening -----------------------------------------------------------------------------------------------

    def _refuse_orphaned_log(self) -> None:
        """SQLite would delete the log of a file that is empty, also where it is only to read."""
        log, file = status_of(log_of(self._path)), status_of(self._path)
        if log and log.st_size and not (file and file.st_size):
            raise self.refused("the file is missing or empty, and its log is not")

    @contextmanager
    def being_checked(self) -> Iterator[None]:
        """While this lasts it is checked; where that raises anything it is closed."""
        try:
            with self.own_errors():
                for setting in CONNECTION:
                    self.db.execute(f"PRAGMA {setting}")
                yield
                self._inodes = _inodes(self._path)
        except BaseException:
            self.close()
            raise

    def prepare(self, vehicle_id: str) -> None:
        """Make what is missing, or bring it up to date; RefusedError when it is damaged or not this vehicle's."""
        ((found,),) = self.db.execute("PRAGMA integrity_check(1)")
        if found != "ok":
            raise self.refused(f"the file is damaged: {' '.join(found.split())}")
        self.db.execute("PRAGMA journal_mode = WAL")
        version = self._version()
        if version == 0 and not list(self.db.execute("SELECT 1 FROM sqlite_schema LIMIT 1")):
            with self.transaction():
                self.db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
                self._migrate(0)
                self.db.execute("INSERT INTO meta VALUES ('vehicle', ?)", (vehicle_id,))
        else:
            self.check_vehicle(vehicle_id, oldest=1)
            if version < len(VERSIONS):
                with self.transaction():
                    self._migrate(version)
        if not self.identity:
            self.db.execute("INSERT INTO meta VALUES ('file', lower(hex(randomblob(16))))")

    def _version(self) -> int:
        ((version,),) = self.db.execute("PRAGMA user_version")
        return int(version)

    def _migrate(self, version: int) -> None:
        for statement in (statement for script in VERSIONS[version:] for statement in script):
            self.db.execute(statement)
        self.db.execute(f"PRAGMA user_version = {len(VERSIONS)}")

    def check_vehicle(self, vehicle_id: str, oldest: int | None = None) -> None:
        """RefusedError when it is not the memory of this vehicle, or of another version; `oldest` that will do."""
        ((application,),) = self.db.execute("PRAGMA application_id")
        if application != APPLICATION_ID:
            raise self.refused("this is not a memory of the brake monitor")
        newest = len(VERSIONS)
        if not (oldest or newest) <= self._version() <= newest:
            raise self.refused(f"version {self._version()} of the memory, this program knows {newest}")
        rows = list(self.db.execute("SELECT value FROM meta WHERE name = 'vehicle'"))
        if rows != [(vehicle_id,)]:
            found = f'of vehicle "{rows[0][0]}"' if rows else "of no vehicle"
            raise self.refused(f'this is the memory {found}, not of "{vehicle_id}"')

    @contextmanager
    def transaction(self) -> Iterator[None]:
        """While this lasts is written all or, when it raises anything, nothing."""
        with self.own_errors():
            self.db.execute("BEGIN IMMEDIATE")
            try:
                yield
                self.db.execute("COMMIT")
            except BaseException:
                with suppress(sqlite3.Error):  # a full disk has already rolled it back
                    self.db.execute("ROLLBACK")
                raise

    # -- what is wrong -----------------------------------------------------------------------------------------

    @contextmanager
    def own_errors(self) -> Iterator[None]:
        """Turn what SQLite or the disk cannot do, and content that makes no sense, into our own errors."""
        try:
            yield
        except sqlite3.ProgrammingError:
            raise
        except sqlite3.DatabaseError as error:
            what = " ".join(str(error).split())  # SQLite quotes schemas, lines and all
            if getattr(error, "sqlite_errorcode", sqlite3.SQLITE_ERROR) & 0xFF in _DAMAGED:
                raise self.refused(f"the file is damaged: {what}") from None
            raise StoreError(f"{self._path}: {what}") from None
        except UnicodeDecodeError:
            raise self.refused("the file is damaged: there is text in it that is none") from None
        except msgspec.MsgspecError as error:
            raise self.refused(f"the content makes no sense: {error}") from None
        except OSError as error:
            raise StoreError(f"{self._path}: {error.strerror or error}") from None

    def refused(self, sentence: str) -> RefusedError:
        """Says what is wrong, with the path."""
        return RefusedError(f"{self._path}: {sentence}")


def _inodes(path: Path) -> tuple[int | None, int | None]:
    """Of a database and its write-ahead log."""
    return _inode(path), _inode(log_of(path))


def _inode(path: Path) -> int | None:
    """None where there is no such file."""
    try:
        return path.stat().st_ino
    except OSError:
        return None


def status_of(path: Path) -> os.stat_result | None:
    """None where there is no such file; OSError when the disk fails, of which `Path.exists` says no more since 3.14."""
    try:
        return path.stat()
    except (FileNotFoundError, NotADirectoryError):
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
