"""A recording played through the pipeline: everything that a report tells, gathered on the way."""

from collections.abc import Callable, Iterable

import numpy as np

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimate import Status
from brake_monitor.frame_block import FrameBlock
from brake_monitor.inspection.remarks import remarks_on_mapping
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.processing.playing import play
from brake_monitor.report.curves import Curves
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.config import Settings


class Recording:
    """What became of one recording."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.pipeline = Pipeline.from_settings(settings)
        self.decoder = SignalDecoder.from_settings(settings)  # for traffic and pipeline; counts what was recorded alone
        self.traffic = Traffic(self.decoder.channels)
        self.curves = Curves(settings.vehicle.wheelset_count)
        self.applications: list[ApplicationRecord] = []
        self.remarks: list[str] = []
        self.statuses: dict[Status, int] = dict.fromkeys(Status, 0)
        self._alarms: dict[str, Alarm] = {}

    def play(
        self,
        blocks: Iterable[FrameBlock],
        remarks: Callable[[], Iterable[str]],
        progress: Callable[[], float] | None = None,
    ) -> None:
        """Take the whole recording.

        `remarks` gives what its reader has to say of it afterwards, `progress` how much it has read.
        """
        for outputs in play(self.pipeline, blocks, self._decoded, progress=progress):
            self._take(outputs)
        self.note_alarms(self.pipeline.monitor.open_alarms())
        doubts = remarks_on_mapping(self.traffic, self.decoder, self.settings)
        self.remarks = [*remarks(), *self.decoder.remarks, *doubts]

    def _decoded(self, block: FrameBlock) -> SampleBlock:
        """The samples of a block, which is noted as what the recording carries."""
        samples = self.decoder.decode_block(block)
        self.traffic.see_block(block, samples)
        return samples

    def _take(self, outputs: Outputs) -> None:
        self.applications += outputs.applications
        self.note_alarms(outputs.alarms)
        if outputs.estimate is not None:
            self.curves.take(outputs.estimate, self._is_told)
            self.statuses[outputs.estimate.status] += 1

    def note_alarms(self, alarms: Iterable[Alarm]) -> None:
        """Take alarms as they stand now."""
        self._alarms |= {alarm.id: alarm for alarm in alarms}

    def _is_told(self, quantity: Quantity, wheelset: int) -> bool:
        """Whether an input is told now. A pressing force that others contradict is shown as it is told."""
        estimator = self.pipeline.estimator
        believed = quantity is Quantity.PRESSING_FORCE or (quantity, wheelset) not in estimator.disbelieved
        return believed and estimator.input_condition((quantity, wheelset)) is InputCondition.GOOD

    @property
    def begun_s(self) -> float:
        """The time of the earliest estimate, 0 when there is none; times are told from there."""
        times_s = self.curves.table()[:, 0]
        return float(times_s.min()) if len(times_s) else 0.0

    @property
    def ended_s(self) -> float:
        """That of the latest."""
        times_s = self.curves.table()[:, 0]
        return float(times_s.max()) if len(times_s) else 0.0

    def forces_told(self, from_s: float, to_s: float) -> list[bool]:
        """Whether the pressing force of each wheelset was told at any time between these."""
        table = self.curves.table()
        own = self.curves.columns(table[(table[:, 0] >= from_s) & (table[:, 0] <= to_s)])["wheelsets"]
        return [bool(np.isfinite(columns["pressing_force_n"]).any()) for columns in own.values()]

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Every alarm as it stands at the end, in the order of raising."""
        return tuple(self._alarms.values())
