"""What the main thread and the one that writes to the disk give each other: all that they share, guarded."""

import logging
import threading
from collections import deque
from collections.abc import Sequence

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.at_hand import entry_count
from brake_monitor.processing.remembered import Remembered
from brake_monitor.storage.evidence import Evidence
from brake_monitor.storage.store_batch import Batch, MarkedGauge

EVIDENCE_WAITING = 20
EVIDENCE_FRAMES_WAITING = 150_000  # in all of it, some 2 MB

log = logging.getLogger(__name__)


class MemoryHandover:
    """Each side takes microseconds; only the thread that writes waits.

    Until the pipeline has taken up what was found on the disk nothing is written over it.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()  # guards all of it
        self._batch = Batch()
        self._evidence: deque[Evidence] = deque()
        self._found: Remembered | None = None  # on the disk, for the pipeline to go on with
        self._was_offered = False  # ... which it does once: what it has taken up twice counts twice
        self._gauges: list[MarkedGauge] = []  # for the pipeline to apply
        self.awaits_resume = True  # the pipeline has not taken up yet what was kept
        self.closing = False  # nothing more will come

    # -- the main thread's side --------------------------------------------------------------------------------

    @property
    def has_news(self) -> bool:
        """Whether the disk has told anything that the pipeline does not know."""
        return self._found is not None or bool(self._gauges)

    def take_news(self) -> tuple[Remembered | None, list[MarkedGauge]]:
        """What was found on the disk, and what people have entered since."""
        with self._changed:
            found, self._found = self._found, None
            gauges, self._gauges = self._gauges, []
        return found, gauges

    def note_resumed(self, over: dict[str, Alarm]) -> None:
        """The pipeline goes on with what was found; `over` are alarms of that time that it does not go on with."""
        with self._changed:
            self._batch.brakes = self._batch.learned = None  # this state was made without it
            self._batch = self._batch.then(Batch(alarms=over))
            self.awaits_resume = False

    def give(self, batch: Batch, evidence: Sequence[Evidence]) -> None:
        """Hand over what has to be written."""
        if not (batch or evidence):
            return
        with self._changed:
            self._batch = self._batch.then(batch)
            self._evidence.extend(evidence)
            if evidence:
                self._limit_evidence()
            self._changed.notify()

    def close(self) -> None:
        """Tell the writing thread that nothing more will come."""
        with self._changed:
            self.closing = True
            self._changed.notify()

    def _limit_evidence(self) -> None:
        evidence = self._evidence
        while len(evidence) > EVIDENCE_WAITING or entry_count(one.frames for one in evidence) > EVIDENCE_FRAMES_WAITING:
            log.warning("evidence of %s is given up, the disk fails", evidence.popleft().name)

    # -- the writing thread's side -----------------------------------------------------------------------------

    def wait(self, longest_s: float, *, for_work: bool) -> bool:
        """Wait until there is something to write, if that is wanted, or nothing more will come: True then."""
        with self._changed:
            self._changed.wait_for(lambda: self.closing or (for_work and self._has_work()), longest_s)
            return self.closing

    def _has_work(self) -> bool:
        return bool(self._evidence) or (bool(self._batch) and not self.awaits_resume)

    def offer(self, found: Remembered) -> bool:
        """Give what was found on the disk to the pipeline, unless it was given something before."""
        if self._was_offered:
            return False
        with self._changed:
            self._found, self._was_offered = found, True
        return True

    def add_gauges(self, new: Sequence[MarkedGauge]) -> None:
        """Entries for the pipeline to apply."""
        with self._changed:
            self._gauges += new

    def take_batch(self) -> Batch | None:
        """What is to be written now; None as long as nothing may be."""
        with self._changed:
            if self.awaits_resume:
                return None
            batch, self._batch = self._batch, Batch()
        return batch

    def put_first(self, batch: Batch) -> None:
        """Write this before all else: what could not be written, or what a new file has to hold."""
        with self._changed:
            self._batch = batch.then(self._batch)

    def oldest_evidence(self) -> Evidence | None:
        """The piece to be written next, which stays here until it is."""
        with self._changed:
            return self._evidence[0] if self._evidence else None

    def note_written(self, evidence: Evidence) -> None:
        """The piece is on the disk."""
        with self._changed:
            if self._evidence and self._evidence[0] is evidence:
                self._evidence.popleft()
