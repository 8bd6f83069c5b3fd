"""Events that subscribers must not miss, in the daemon's memory: what is kept there outlives the daemon."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from brake_monitor.errors import BrakeMonitorError, WorkError
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch


class StoreOutbox:
    """An outbox in a vehicle's memory, over a connection of its own, which is opened again after each failure."""

    def __init__(self, path: Path, vehicle_id: str) -> None:
        self._path = path
        self._vehicle_id = vehicle_id
        self._store: Store | None = None

    def keep(self, messages: Mapping[int, bytes]) -> None:
        """Keep these; WorkError or InputError when that cannot be done now."""
        try:
            self._opened().write(Batch(messages=dict(messages)))
        except BrakeMonitorError:
            self.close()
            raise

    def kept(self) -> Iterator[bytes]:
        """Every message that is kept, oldest first; read as it is asked for."""
        try:
            for _, message in self._opened().messages():
                yield message
        except BrakeMonitorError:
            self.close()
            raise

    def close(self) -> None:
        """Give the file back."""
        if self._store is not None:
            self._store.close()
            self._store = None

    def _opened(self) -> Store:
        if self._store is not None and not self._store.is_in_place:
            self.close()
        try:
            self._store = self._store or Store.look(self._path, self._vehicle_id, "rw")
        except OSError as error:
            raise WorkError(f"{self._path}: {error.strerror or error}") from None
        return self._store
