"""The thread that writes the memory. When the disk fails it is tried again until it works."""

import logging
import threading
import time

from brake_monitor.errors import WorkError
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.remembered import Remembered
from brake_monitor.storage.evidence import EvidenceFolder
from brake_monitor.storage.memory_directory import MemoryDirectory
from brake_monitor.storage.memory_handover import MemoryHandover
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch, GaugeMark
from brake_monitor.storage.store_file import RefusedError, StoreError

TURN_S = 0.5
RETRY_S = 1.0
CLOSE_S = 3.0
STUCK_S = 10.0  # a disk that does not answer for this long has failed

log = logging.getLogger(__name__)


class MemoryWriter:
    """`start`, then `close`. What is found on the disk is offered to the pipeline, however late the disk comes."""

    def __init__(self, handover: MemoryHandover, directory: MemoryDirectory, folder: EvidenceFolder) -> None:
        self._handover = handover
        self._directory = directory
        self._folder = folder
        self._store: Store | None = None
        self._open_alarms: dict[str, Alarm] = {}
        self._has_looked = False  # at what can be read of a disk that cannot be written
        self._changes_seen = -1
        self._gauge_offered = GaugeMark("", 0)
        self._failing = ""
        self._beat_s = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="memory", daemon=True)

    @property
    def failing(self) -> str:
        """Why nothing can be written now; empty when all is well."""
        place = self._directory.place
        if self.is_alive:
            return f"{place}: the disk does not answer" if self._is_stuck() else self._failing
        has_died = self._thread.ident is not None and not self._handover.closing
        return f"{place}: the thread that writes has ended" if has_died else self._failing

    @property
    def is_alive(self) -> bool:
        """Whether its thread has not ended."""
        return self._thread.is_alive()

    def _is_stuck(self) -> bool:
        return time.monotonic() - self._beat_s > STUCK_S

    def start(self) -> None:
        """Read what is there and begin to write. A disk that fails is no reason not to start.

        WorkError when another daemon uses the directory.
        """
        try:
            self._directory.lock()
        except OSError as error:
            self._note_failure(self._sentence(error))
        self._turn()
        self._thread.start()

    def close(self) -> None:
        """Write what waits, within CLOSE_S, and end the thread; a second call does nothing."""
        self._handover.close()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_S)
        if self.is_alive:
            log.warning("the memory has not been written within %.1f s: the disk hangs; leaving it", CLOSE_S)

    def _run(self) -> None:
        closing = False
        try:
            while not closing:
                closing = self._handover.wait(RETRY_S if self._failing else TURN_S, for_work=not self._failing)
                self._turn()
                self._beat_s = time.monotonic()
        finally:
            self._let_go()
            self._directory.unlock()

    def _turn(self) -> None:
        """Write what there is, look for what people have entered; note whether that works."""
        try:
            self._work()
        except WorkError as error:
            self._note_failure(str(error))
        except OSError as error:
            self._note_failure(self._sentence(error))

    def _work(self) -> None:
        if self._store is not None and not self._store.is_in_place:
            log.warning("%s: the memory was taken away; all that is known is written anew", self._directory.place)
            self._let_go()
        try:
            store = self._store or self._open()
            self._write_batch(store)
            self._look_for_gauges(store)
            self._write_evidence()
        except RefusedError as error:
            self._let_go()
            self._directory.set_aside(str(error))
            return
        if self._failing:
            log.info("%s: the memory is written again", self._directory.place)
            self._failing = ""

    def _open(self) -> Store:
        """Open the file; the first time, what it holds is for the pipeline."""
        try:
            store = self._directory.open()
        except (StoreError, OSError):
            if not self._has_looked:
                self._has_looked = True
                self._offer(self._directory.look())
            raise
        self._offer(store.remembered())
        self._store = store
        self._changes_seen = -1
        self._handover.put_first(Batch(alarms=dict(self._open_alarms)))
        return store

    def _offer(self, found: Remembered | None) -> None:
        if found is not None and self._handover.offer(found):
            self._open_alarms = {alarm.id: alarm for alarm in found.open_alarms}

    def _write_batch(self, store: Store) -> None:
        batch = self._handover.take_batch()
        if batch is None:
            return
        self._open_alarms |= batch.alarms
        self._open_alarms = {name: a for name, a in self._open_alarms.items() if a.cleared_time_s is None}
        try:
            store.write(batch)
        except (StoreError, RefusedError):
            self._handover.put_first(batch)
            raise

    def _look_for_gauges(self, store: Store) -> None:
        changes = store.changed_by_others()
        if changes == self._changes_seen:
            return
        self._changes_seen = changes
        file, number = self._gauge_offered
        new = [entry for entry in store.gauges() if entry.mark.file != file or entry.mark.number > number]
        if new:
            self._gauge_offered = new[-1].mark
            self._handover.add_gauges(new)

    def _write_evidence(self) -> None:
        """One piece a turn, so that the state never waits for more than one; at the end all of them."""
        while (evidence := self._handover.oldest_evidence()) is not None:
            self._folder.write(evidence)
            self._handover.note_written(evidence)
            if not self._handover.closing:
                return

    def _note_failure(self, reason: str) -> None:
        """The disk fails: go on without, and open everything again at the next attempt."""
        if not self._failing:
            log.warning("%s; what is to be remembered is kept in the process and written when that works again", reason)
        self._failing = reason
        self._let_go()

    def _sentence(self, error: OSError) -> str:
        return f"{error.filename or self._directory.place}: {error.strerror or error}"

    def _let_go(self) -> None:
        if self._store is not None:
            self._store.close()
            self._store = None
