"""Ties the pipeline to the disk: what it goes on with after a restart, and evidence of its alarms.

The main thread hands over what has changed and never waits; a thread of its own writes. When the disk fails nothing
is lost as long as the program lives: it is tried again until it works.
"""

import fcntl
import logging
import os
import shutil
import threading
import time
from collections import deque
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from math import inf
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Self

from msgspec.structs import replace

from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.stops import StopRecord
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.processing.remembered import Remembered, joined
from brake_monitor.settings.config import Settings
from brake_monitor.storage.evidence import Evidence, EvidenceFolder, EvidenceRecorder, frame_count
from brake_monitor.storage.store import Batch, NumberedGauge, RefusedError, Store, StoreError, log_of, why_impossible

STATE_EVERY_S = 0.5  # of the frames' time; with the time to write it, less than a second can be lost
TURN_S = 0.5
RETRY_S = 1.0
CLOSE_S = 3.0
STUCK_S = 10.0  # a disk that does not answer for as long fails
EVIDENCE_WAITING = 20
EVIDENCE_FRAMES_WAITING = 150_000  # in all of it, some 50 MB
REFUSED_KEPT = 5
FILE_NAME = "memory.db"
EVIDENCE_FOLDER = "evidence"

log = logging.getLogger(__name__)


def state_directory(settings: Settings) -> Path | None:
    """Where the memory is: as configured, else what systemd says; None when nobody says."""
    if not settings.store.enabled:
        return None
    told = os.environ.get("STATE_DIRECTORY", "").split(":")[0]
    return settings.store.directory or (Path(told) if told else None)


class Memory:
    """Keeps one vehicle's state in a directory. `start`, then `resume` the pipeline, `see` each turn, `close`.

    What is found on the disk goes to the pipeline before anything is written over it, however late the disk comes.
    """

    def __init__(self, settings: Settings, directory: Path) -> None:
        self.refused = ""  # why what was found at the start could not be used
        self._settings = settings
        self._directory = directory
        self._path = directory / FILE_NAME
        self._recorder = EvidenceRecorder(settings.store)
        self._now_s = self._state_s = -inf  # frames' time; that of the last state that was handed over
        self._gauge_applied = 0

        # What the two threads hand each other, guarded by _news.
        self._news = threading.Condition()
        self._batch = Batch()
        self._evidence: deque[Evidence] = deque()
        self._found: Remembered | None = None  # on the disk, for the pipeline to go on with
        self._awaits_resume = True  # until then nothing is written
        self._gauges: list[NumberedGauge] = []  # for the pipeline to apply
        self._closing = False

        self._folder = EvidenceFolder(directory / EVIDENCE_FOLDER, settings.store.evidence_max_bytes)
        self._store: Store | None = None
        self._lock: int | None = None  # open file that only one daemon can lock
        self._open_alarms: dict[str, Alarm] = {}
        self._has_looked = False  # at what can be read of a disk that cannot be written
        self._changes_seen = -1
        self._gauge_offered = 0
        self._failing = ""
        self._beat_s = time.monotonic()
        self._thread = threading.Thread(target=self._run, name="memory", daemon=True)

    @property
    def failing(self) -> str:
        """Why nothing can be written now; empty when all is well."""
        if self._thread.is_alive():
            return f"{self._directory}: the disk does not answer" if self._is_stuck() else self._failing
        has_died = self._thread.ident is not None and not self._closing
        return f"{self._directory}: the thread that writes has ended" if has_died else self._failing

    def _is_stuck(self) -> bool:
        return time.monotonic() - self._beat_s > STUCK_S

    # -- the main thread's side --------------------------------------------------------------------------------

    @property
    def has_resumed(self) -> bool:
        """Whether the pipeline goes on with what was kept; not so as long as the disk cannot be read."""
        return not self._awaits_resume

    def start(self) -> None:
        """Read what is there and begin to write. A disk that fails is no reason not to start.

        WorkError when another daemon uses the directory.
        """
        try:
            self._lock_directory()
        except OSError as error:
            self._note_failure(f"{self._directory}: {error.strerror or error}")
        self._turn()
        self._thread.start()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def resume(self, pipeline: Pipeline) -> None:
        """Let the pipeline go on with what was found, and apply what people have measured."""
        with self._news:
            found, self._found = self._found, None
            gauges, self._gauges = self._gauges, []
        if found is not None:
            over = self._go_on(pipeline, found)
            with self._news:
                self._batch.brakes = self._batch.learned = None  # these did not know of it yet
                self._batch = self._batch.then(Batch(alarms=over))
                self._awaits_resume = False
        for number, gauge in gauges:
            self._gauge_applied = number
            try:
                pipeline.apply(gauge)
            except InputError as error:
                log.warning("%s; it is left out", error)
            else:
                log.info("wheelset %d: %s", gauge.wheelset, gauge.told())
        if found is not None or gauges:
            self._state_s = -inf  # hand the state over at the next chance

    def see(self, pipeline: Pipeline, frames: Sequence[Frame], outputs: Iterable[Outputs], time_s: float) -> None:
        """Take what arrived and what came of it until `time_s`; never waits for the disk nor fails with it."""
        if self._found is not None or self._gauges:
            self.resume(pipeline)
        self._now_s = time_s
        pipeline.memory_failure = self.failing
        alarms: list[Alarm] = []
        stops: list[StopRecord] = []
        self._recorder.see_frames(frames)
        for output in outputs:
            alarms += output.alarms
            stops += output.stops
            if output.estimate is not None:
                self._recorder.see_estimate(output.estimate)
        batch = Batch(alarms={alarm.id: alarm for alarm in alarms}, stops=stops)
        if not 0.0 <= time_s - self._state_s < STATE_EVERY_S:
            self._state_s = time_s
            self._add_state(batch, pipeline)
        self._hand_over(batch, self._recorder.turn(time_s, alarms))

    def finish(self, pipeline: Pipeline) -> None:
        """Hand over the last state: the pipeline will not go on."""
        batch = Batch()
        self._add_state(batch, pipeline)
        self._hand_over(batch, self._recorder.finish())

    def close(self) -> None:
        """Write what waits, within CLOSE_S, and end the thread; a second call does nothing."""
        with self._news:
            self._closing = True
            self._news.notify()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_S)
        if self._thread.is_alive():
            log.warning("the memory has not been written within %.1f s: the disk hangs; leaving it", CLOSE_S)

    def _go_on(self, pipeline: Pipeline, found: Remembered) -> dict[str, Alarm]:
        """Give the pipeline what was found; the open alarms among it that it does not go on with, cleared.

        It has raised them anew meanwhile, or their rule is off.
        """
        now = pipeline.remembered()
        raised = {(alarm.kind, alarm.wheelset) for alarm in now.open_alarms}
        brakes = found.brakes
        if brakes is not None and now.brakes is not None:
            brakes = joined(brakes, now.brakes)
        opened = tuple(alarm for alarm in found.open_alarms if (alarm.kind, alarm.wheelset) not in raised)
        try:
            pipeline.resume(Remembered(found.learned, brakes, opened))
        except InputError as error:
            log.warning("%s; it is learned anew", error)
            pipeline.resume(Remembered(None, brakes, opened))
        self._recorder.resume(found)
        taken_up = {alarm.id for alarm in pipeline.remembered().open_alarms}
        return {alarm.id: self._given_up(alarm) for alarm in found.open_alarms if alarm.id not in taken_up}

    def _given_up(self, alarm: Alarm) -> Alarm:
        now_s = max(self._now_s, alarm.updated_time_s)  # before the first frame nobody knows the time
        return replace(alarm, cleared_time_s=now_s, updated_time_s=now_s)

    def _add_state(self, batch: Batch, pipeline: Pipeline) -> None:
        state = pipeline.remembered()
        if state.brakes is None:
            return
        if reason := why_impossible(state.brakes):
            log.error("%s: this is not remembered", reason)
            return
        batch.brakes, batch.learned, batch.gauges_applied = state.brakes, state.learned, self._gauge_applied
        self._recorder.see_state(self._now_s, state)

    def _hand_over(self, batch: Batch, evidence: Sequence[Evidence]) -> None:
        if not (batch or evidence):
            return
        with self._news:
            self._batch = self._batch.then(batch)
            self._evidence.extend(evidence)
            if evidence:
                self._limit_evidence()
            self._news.notify()

    def _limit_evidence(self) -> None:
        while len(self._evidence) > EVIDENCE_WAITING or frame_count(self._evidence) > EVIDENCE_FRAMES_WAITING:
            log.warning("evidence of %s is given up, the disk fails", self._evidence.popleft().name)

    # -- the thread's side -------------------------------------------------------------------------------------

    def _run(self) -> None:
        closing = False
        while not closing:
            with self._news:
                wait_s = RETRY_S if self._failing else TURN_S
                self._news.wait_for(lambda: self._closing or (self._has_work() and not self._failing), wait_s)
                closing = self._closing
            self._turn()
            self._beat_s = time.monotonic()
        if self._store is not None:
            self._store.close()
        if self._lock is not None:
            os.close(self._lock)

    def _has_work(self) -> bool:
        return bool(self._evidence) or (bool(self._batch) and not self._awaits_resume)

    def _turn(self) -> None:
        """Write what there is, look for what people have entered; note whether that works."""
        try:
            self._work()
        except (WorkError, OSError) as error:
            self._note_failure(str(error))

    def _work(self) -> None:
        try:
            if self._store is None:
                self._open()
            self._write_batch()
            self._look_for_gauges()
            self._write_evidence()
        except RefusedError as error:
            self._set_aside(str(error))
            return
        if self._failing:
            log.info("%s: the memory is written again", self._directory)
            self._failing = ""

    def _open(self) -> None:
        """Open the file; the first time, what it holds is for the pipeline."""
        try:
            self._lock_directory()
            store = self._open_or_set_aside()
        except (StoreError, OSError) as error:
            if not self._has_looked:
                self._has_looked = True
                self._offer(self._look_at_copy())
            raise StoreError(str(error)) from None
        self._offer(store.remembered())
        self._store = store
        self._changes_seen = -1
        with self._news:
            self._batch = Batch(alarms=dict(self._open_alarms)).then(self._batch)

    def _open_or_set_aside(self) -> Store:
        vehicle_id = self._settings.vehicle.id
        try:
            return Store.open(self._path, vehicle_id, self._settings.vehicle.wheelset_count)
        except RefusedError as error:
            self._set_aside(str(error))
            return Store.open(self._path, vehicle_id, self._settings.vehicle.wheelset_count)

    def _look_at_copy(self) -> Remembered | None:
        """What is on a disk that can only be read: SQLite itself needs to write beside the file."""
        vehicle = self._settings.vehicle
        try:
            with TemporaryDirectory() as folder:
                for path in (self._path, log_of(self._path)):
                    if path.exists():
                        shutil.copy(path, folder)
                if not (copy := Path(folder, FILE_NAME)).exists():
                    return None
                with Store.open(copy, vehicle.id, vehicle.wheelset_count) as store:
                    return store.remembered()
        except (StoreError, RefusedError, OSError):
            return None

    def _offer(self, found: Remembered | None) -> None:
        if found is None or not self._awaits_resume or self._found is not None:
            return
        self._open_alarms = {alarm.id: alarm for alarm in found.open_alarms}
        with self._news:
            self._found = found

    def _write_batch(self) -> None:
        assert self._store is not None
        with self._news:
            if self._awaits_resume:
                return
            batch, self._batch = self._batch, Batch()
        self._open_alarms |= batch.alarms
        self._open_alarms = {name: a for name, a in self._open_alarms.items() if a.cleared_time_s is None}
        try:
            self._store.write(batch)
        except (StoreError, RefusedError):
            with self._news:
                self._batch = batch.then(self._batch)
            raise

    def _look_for_gauges(self) -> None:
        assert self._store is not None
        changes = self._store.changed_by_others()
        if changes == self._changes_seen:
            return
        self._changes_seen = changes
        new = [entry for entry in self._store.gauges() if entry.number > self._gauge_offered]
        if new:
            self._gauge_offered = new[-1].number
            with self._news:
                self._gauges += new

    def _write_evidence(self) -> None:
        """One piece a turn, so that the state never waits for more than one; at the end all of them."""
        while True:
            with self._news:
                if not self._evidence:
                    return
                evidence = self._evidence[0]
            self._folder.write(evidence)
            with self._news:
                if self._evidence and self._evidence[0] is evidence:
                    self._evidence.popleft()
                if not self._closing:
                    return

    def _note_failure(self, reason: str) -> None:
        """The disk fails: go on without, and open everything anew at the next attempt."""
        if not self._failing:
            log.warning("%s; what is to be remembered is kept in the process and written when that works again", reason)
        self._failing = reason
        if self._store is not None:
            self._store.close()
            self._store = None

    def _set_aside(self, reason: str) -> None:
        """Leave what cannot be used under another name and begin a new file."""
        if self._store is not None:
            self._store.close()
            self._store = None
        stamp = datetime.now(UTC).strftime("%Y%m%dT%H%M%S.%fZ")
        aside = self._path.with_name(f"refused-{stamp}-{FILE_NAME}")
        for path, target in ((self._path, aside), (log_of(self._path), log_of(aside))):
            if path.exists():
                path.rename(target)
        self.refused = f"{reason}; it is kept as {aside.name}"
        log.warning("%s, and a new memory begins", self.refused)
        self._path.with_name(f"{FILE_NAME}-shm").unlink(missing_ok=True)
        for old in sorted(self._directory.glob(f"refused-*-{FILE_NAME}"))[:-REFUSED_KEPT]:
            old.unlink()
            log_of(old).unlink(missing_ok=True)

    def _lock_directory(self) -> None:
        """Make sure that no other daemon writes here: WorkError when one does, OSError when the disk fails."""
        if self._lock is not None:
            return
        self._directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        lock = os.open(self._directory / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(lock)
            if isinstance(error, BlockingIOError):
                raise WorkError(f"{self._directory}: another brake-monitor keeps its memory here") from None
            raise
        self._lock = lock
