"""Events that subscribers must not miss, in the daemon's memory: what is kept there outlives the daemon."""

import threading
from collections.abc import Iterator, Mapping
from pathlib import Path

from brake_monitor.errors import BrakeMonitorError, WorkError
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_monitor.storage.store_file import StoreError

KEPT_WITHIN_S = 1.0  # who publishes waits no longer for a disk; what it keeps later was sent meanwhile


class StoreOutbox:
    """An outbox in a vehicle's memory, over a connection of its own, which is opened again after each failure."""

    def __init__(self, path: Path, vehicle_id: str) -> None:
        self._path = path
        self._vehicle_id = vehicle_id
        self._guard = threading.Lock()  # whoever has it uses the file
        self._store: Store | None = None
        self._is_closed = False
        self._writing: threading.Thread | None = None

    @property
    def is_writing(self) -> bool:
        """Whether the disk has not answered yet."""
        return self._writing is not None and self._writing.is_alive()

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep these; WorkError or InputError when that cannot be done now. A disk that hangs may keep them later."""
        if self._is_closed:
            raise WorkError(f"{self._path}: no more events are kept")
        if not self.is_writing:
            failures: list[Exception] = []
            arguments = (Batch(messages=dict(messages)), failures)
            self._writing = threading.Thread(target=self._write, args=arguments, name="outbox", daemon=True)
            try:
                self._writing.start()
            except RuntimeError as error:  # there may be only so many threads
                raise StoreError(f"{self._path}: {error}") from None
            self._writing.join(KEPT_WITHIN_S)
            if not self.is_writing:
                if failures:
                    raise failures[0]
                return
        raise StoreError(f"{self._path}: the disk does not answer")

    def kept(self) -> Iterator[bytes]:
        """Every message that is kept, oldest first; read as it is asked for."""
        with self._guard:
            try:
                for _, message in self._opened().messages():
                    yield message
            except BrakeMonitorError:
                self._let_go()
                raise

    def close(self) -> None:
        """Keep no more, and give the file back; a disk that hangs is not waited for."""
        self._is_closed = True
        self._give_back()

    def _write(self, batch: Batch, failures: list[Exception]) -> None:
        with self._guard:
            try:
                self._opened().write(batch)
            except Exception as error:  # noqa: BLE001 - raised where the answer is awaited
                self._let_go()
                failures.append(error)
        if self._is_closed:
            self._give_back()

    def _give_back(self) -> None:
        """Unless it is in use: who uses it gives it back then."""
        if self._guard.acquire(blocking=False):
            try:
                self._let_go()
            finally:
                self._guard.release()

    def _let_go(self) -> None:
        if self._store is not None:
            self._store.close()
            self._store = None

    def _opened(self) -> Store:
        if self._store is not None and not self._store.is_in_place:
            self._let_go()
        try:
            self._store = self._store or Store.look(self._path, self._vehicle_id, "rw")
        except OSError as error:
            raise WorkError(f"{self._path}: {error.strerror or error}") from None
        return self._store
