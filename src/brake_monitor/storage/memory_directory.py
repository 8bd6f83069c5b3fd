"""The directory that one daemon keeps a vehicle's memory in: its lock, its file, and what had to be set aside."""

import fcntl
import logging
import os
import shutil
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from brake_monitor.errors import WorkError
from brake_monitor.processing.remembered import Remembered
from brake_monitor.settings.config import Settings
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_file import RefusedError, StoreError, log_of, status_of

REFUSED_KEPT = 5
FILE_NAME = "memory.db"

log = logging.getLogger(__name__)


def state_directory(settings: Settings) -> Path | None:
    """The configured directory, else systemd's $STATE_DIRECTORY, else None."""
    if not settings.store.enabled:
        return None
    told = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
    return settings.store.directory or (Path(told) if told else None)


def set_aside_in(place: Path) -> list[Path]:
    """The memories in a directory that could not be used there, the oldest first."""
    return sorted(place.glob(f"refused-*-{FILE_NAME}"))


class MemoryDirectory:
    """Opens the vehicle's file in a directory that no other daemon uses; what cannot be used there is set aside."""

    def __init__(self, place: Path, vehicle_id: str, wheelset_count: int) -> None:
        self.place = place
        self._path = place / FILE_NAME
        self._vehicle = (vehicle_id, wheelset_count)
        self._lock: int | None = None  # open file that only one daemon can lock

    def lock(self) -> None:
        """Make sure that no other daemon writes here: WorkError when one does, OSError when the disk fails."""
        path = self.place / "lock"
        if self._lock is not None:
            if (there := status_of(path)) and there.st_ino == os.fstat(self._lock).st_ino:
                return
            self.unlock()  # it was taken away
        self.place.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(lock)
            if isinstance(error, BlockingIOError):
                raise WorkError(f"{self.place}: another brake-monitor keeps its memory here") from None
            raise
        self._lock = lock

    def unlock(self) -> None:
        """Let another daemon have it."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def open(self) -> Store:
        """Open the file, or a new one where it cannot be used; StoreError or OSError when the disk fails."""
        self.lock()
        if (there := status_of(self._path)) and there.st_size == 0:
            log.warning("%s: the file is empty, and a new memory begins", self._path)
        try:
            return Store.open(self._path, *self._vehicle)
        except RefusedError as error:
            self.set_aside(str(error))
            return Store.open(self._path, *self._vehicle)

    def look(self) -> Remembered | None:
        """What is on a disk that can only be read: SQLite itself needs to write beside the file."""
        try:
            with TemporaryDirectory() as folder:
                for path in (self._path, log_of(self._path)):
                    if status_of(path):
                        shutil.copy(path, folder)
                if not (copy := Path(folder, FILE_NAME)).exists():
                    return None
                with Store.open(copy, *self._vehicle) as store:
                    return store.remembered()
        except (StoreError, RefusedError, OSError):
            return None

    def set_aside(self, reason: str) -> None:
        """Leave what cannot be used under another name, so that a new file begins."""
        stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%S.%fZ")
        aside = self._path.with_name(f"refused-{stamp}-{FILE_NAME}")
        for path, target in ((self._path, aside), (log_of(self._path), log_of(aside))):
            if status_of(path):
                path.rename(target)
        log.warning("%s; it is kept as %s, and a new memory begins", reason, aside.name)
        self._path.with_name(f"{FILE_NAME}-shm").unlink(missing_ok=True)
        others = [path for path in set_aside_in(self.place) if path != aside]  # whatever the clock shows
        for old in others[: 1 - REFUSED_KEPT]:
            old.unlink()
            log_of(old).unlink(missing_ok=True)
