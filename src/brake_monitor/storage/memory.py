"""Ties the pipeline to the disk: what it goes on with after a restart, and evidence of its alarms.

The main thread hands over what has changed and never waits; a thread of its own writes (`memory_writer`). When the
disk fails nothing is lost as long as the program lives.
"""

import logging
from collections.abc import Iterable, Sequence
from math import inf
from pathlib import Path
from typing import Self

from msgspec.structs import replace

from brake_monitor.errors import InputError
from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.processing.remembered import Remembered
from brake_monitor.storage.evidence import EvidenceFolder, EvidenceRecorder
from brake_monitor.storage.memory_directory import MemoryDirectory
from brake_monitor.storage.memory_handover import MemoryHandover
from brake_monitor.storage.memory_writer import MemoryWriter
from brake_monitor.storage.plausible_brakes import why_impossible
from brake_monitor.storage.store_batch import Batch, GaugeMark, MarkedGauge

STATE_EVERY_S = 0.5  # in frames' time; including the time to write, less than a second can be lost
EVIDENCE_FOLDER = "evidence"

log = logging.getLogger(__name__)


class Memory:
    """Keeps a pipeline's state in a directory. `start`, then `resume`, `see` each turn, `finish`, `close`.

    What is found on the disk goes to the pipeline before anything is written over it, however late the disk comes.
    """

    def __init__(self, pipeline: Pipeline, place: Path) -> None:
        settings = pipeline.settings
        self._pipeline = pipeline
        self._recorder = EvidenceRecorder(settings.store)
        self._now_s = self._state_s = -inf  # frames' time; that of the last state that was handed over
        self._gauge_applied: GaugeMark | None = None
        self.wear_news = 0  # how often the pipeline has taken up pads from the disk or from people
        self._handover = MemoryHandover()
        directory = MemoryDirectory(place, settings.vehicle.id, settings.vehicle.wheelset_count)
        folder = EvidenceFolder(place / EVIDENCE_FOLDER, settings.store.evidence_max_bytes)
        self._writer = MemoryWriter(self._handover, directory, folder)

    @property
    def failing(self) -> str:
        """Why nothing can be written now; empty when all is well."""
        return self._writer.failing

    @property
    def is_writing(self) -> bool:
        """Whether the thread that writes, and holds the directory's lock, has not ended."""
        return self._writer.is_alive

    @property
    def has_resumed(self) -> bool:
        """Whether the pipeline goes on with what was kept; not so as long as the disk cannot be read."""
        return not self._handover.awaits_resume

    def start(self) -> None:
        """Read what is there and begin to write. A disk that fails is no reason not to start.

        WorkError when another daemon uses the directory.
        """
        self._writer.start()

    def close(self) -> None:
        """Write what waits, within three seconds, and end; a second call does nothing."""
        self._writer.close()

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def resume(self) -> None:
        """Let the pipeline go on with what was found, and apply what people have measured."""
        found, gauges = self._handover.take_news()
        if found is not None:
            self._handover.note_resumed(self._go_on(found))
        for entry in gauges:
            self._apply(entry)
        if found is not None or gauges:
            self.wear_news += 1
            self._state_s = -inf  # hand the state over at the next chance

    def see(self, frames: Sequence[Frame], outputs: Iterable[Outputs], time_s: float) -> None:
        """Take what arrived and what came of it until `time_s`; never waits for the disk nor fails with it."""
        if self._handover.has_news:
            self.resume()
        self._now_s = time_s
        self._pipeline.memory_failure = self.failing
        alarms: list[Alarm] = []
        ended: list[ApplicationRecord] = []
        self._recorder.see_frames(frames)
        for output in outputs:
            alarms += output.alarms
            ended += output.applications
            if output.estimate is not None:
                self._recorder.see_estimate(output.estimate)
        batch = Batch(alarms={alarm.id: alarm for alarm in alarms}, applications=ended)
        if ended or not 0.0 <= time_s - self._state_s < STATE_EVERY_S:  # what has ended must not be kept as running
            self._state_s = time_s
            self._add_state(batch)
        self._handover.give(batch, self._recorder.turn(time_s, alarms))

    def finish(self) -> None:
        """Hand over the last state: the pipeline will not go on."""
        batch = Batch()
        self._add_state(batch)
        self._handover.give(batch, self._recorder.finish())

    def _go_on(self, found: Remembered) -> dict[str, Alarm]:
        """Give the pipeline what was found; the open alarms among it that it does not go on with, cleared.

        It has raised them anew meanwhile, or their rule is off.
        """
        pipeline = self._pipeline
        raised = {(alarm.kind, alarm.wheelset) for alarm in pipeline.remembered().open_alarms}
        opened = tuple(alarm for alarm in found.open_alarms if (alarm.kind, alarm.wheelset) not in raised)
        for sentence in found.without_use(pipeline.settings):
            log.info("the configuration has changed: %s", sentence)
        try:
            pipeline.resume(Remembered(found.learned, found.brakes, opened))
        except InputError as error:
            log.warning("%s; it is learned anew", error)
            pipeline.resume(Remembered(None, found.brakes, opened))
        self._recorder.resume(found)
        taken_up = {alarm.id for alarm in pipeline.remembered().open_alarms}
        given_up = [alarm for alarm in found.open_alarms if alarm.id not in taken_up]
        for alarm in given_up:
            log.info("alarm %s of an earlier run cleared: its rule is off, or has raised it anew", alarm.id)
        return {alarm.id: self._given_up(alarm) for alarm in given_up}

    def _given_up(self, alarm: Alarm) -> Alarm:
        now_s = max(self._now_s, alarm.updated_time_s)  # before the first frame nobody knows the time
        return replace(alarm, cleared_time_s=now_s, updated_time_s=now_s)

    def _apply(self, entry: MarkedGauge) -> None:
        self._gauge_applied = entry.mark
        try:
            self._pipeline.apply(entry.gauge)
        except InputError as error:
            log.warning("%s; it is left out", error)
        else:
            log.info("wheelset %d: %s", entry.gauge.wheelset, entry.gauge.told())

    def _add_state(self, batch: Batch) -> None:
        state = self._pipeline.remembered()
        if state.brakes is None:
            return
        if reason := why_impossible(state.brakes):
            log.error("%s: this is not remembered", reason)
            return
        batch.brakes, batch.learned, batch.gauges_applied = state.brakes, state.learned, self._gauge_applied
        self._recorder.see_state(self._now_s, state)
