"""A recording at once: all its samples, and what an estimator knows as they pass, by machine code where it is ready."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from brake_monitor.arrays import Bools, Floats, Ints
from brake_monitor.compiled.kept_code import with_machine_code
from brake_monitor.decoding.sample_block import Columns, SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.core.readout import OF_WAGON, OF_WHEELSET, WagonReadout, WheelsetReadout, read_out, width
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import MEASURED, Sample


def all_samples(decoder: SignalDecoder, blocks: Iterable[FrameBlock]) -> SampleBlock:
    """The samples of all frames in the order in which a daemon would have had them, what becomes STALE included."""
    parts, times_s, frames = [], [np.zeros(0)], 0
    for block in blocks:
        samples = decoder.decode_block(block)
        decoded = Columns(samples.frame, samples.channel, samples.value, samples.quality)
        for columns in (_lapsed(decoder, samples), decoded):
            parts.append(columns._replace(frame=columns.frame + frames))
        times_s.append(block.time_s)
        frames += len(block)
    return SampleBlock.of(decoder.channels, np.concatenate(times_s), parts or [_columns(decoder, [])])


def _lapsed(decoder: SignalDecoder, samples: SampleBlock) -> Columns:
    """Let the samples of a block pass; what becomes STALE meanwhile."""
    found: list[tuple[int, Sample]] = []
    frame, end = 0, len(samples.frames)
    passage = decoder.passage(samples)
    while (stop := passage.quiet_until(frame, end)) < end:
        passage.settle(stop - 1)
        decoder.note(samples.of_frames(stop, stop + 1))
        found += [(int(samples.frames[stop]), lapsed) for lapsed in decoder.expire(float(samples.frame_times_s[stop]))]
        frame = stop + 1
        passage = decoder.passage(samples, frame)
    passage.settle(end - 1)
    return _columns(decoder, found)


def _columns(decoder: SignalDecoder, found: Sequence[tuple[int, Sample]]) -> Columns:
    """Samples with the places of their frames as columns."""
    numbers = {channel.measurand: k for k, channel in enumerate(decoder.channels)}
    return Columns.of([(frame, numbers[one.measurand], one.value, one.quality) for frame, one in found])


@dataclass(frozen=True)
class Known:
    """What an estimator knew at K instants, in the names of `WagonReadout` and `WheelsetReadout`."""

    rows: Floats  # (K, `width`), in order

    def wagon(self, name: str) -> Floats:
        """A value of the wagon, shape (K,)."""
        return self.rows[:, WagonReadout._fields.index(name)]

    def each(self, name: str) -> Floats:
        """A value of each wheelset, shape (K, N)."""
        return self.rows[:, OF_WAGON + WheelsetReadout._fields.index(name) :: OF_WHEELSET]

    def where(self, wanted: Bools) -> "Known":
        """At some of the instants."""
        return Known(self.rows[wanted])


def take_all(estimator: Estimator, samples: SampleBlock, every_s: float = 0.0) -> Known:
    """Let an estimator take all samples; what it knows after each frame with readings, or some every so often."""
    row = _rows(samples, every_s)
    taker = None if estimator.waits else with_machine_code(estimator)
    rows = taker.take_all(samples, row) if taker is not None else _one_by_one(estimator, samples, row)
    return Known(rows[np.isfinite(rows[:, 0])])


def _rows(samples: SampleBlock, every_s: float) -> Ints:
    """For each sample the row for what is known after it, -1: none; the last ones of frames with readings have one."""
    measures = np.array([channel.quantity in MEASURED for channel in samples.channels], dtype=np.bool_)
    is_reading = measures[samples.channel]
    begins = samples.first[:-1]
    last = samples.first[1:] - 1
    chosen = last[np.logical_or.reduceat(is_reading, begins)] if len(begins) else last
    if every_s and len(chosen):
        turn = np.floor(samples.time_s[chosen] / every_s)
        chosen = chosen[np.append(turn[1:] != turn[:-1], True)]
    row = np.full(len(samples), -1)
    row[chosen] = np.arange(len(chosen))
    return row


def _one_by_one(estimator: Estimator, samples: SampleBlock, row: Ints) -> Floats:
    """Let the estimator take each sample by itself; the same rows that machine code gives."""
    known = np.full((int(row.max(initial=-1)) + 1, width(len(estimator.core.wheels))), np.nan)
    told_s = -inf
    for sample, place in zip(samples.samples, row.tolist(), strict=True):
        estimator.take(sample)
        has_moved = estimator.time_s > told_s if estimator.waits else estimator.time_s == sample.time_s
        if place >= 0 and has_moved:
            read_out(estimator.core, known[place])
            told_s = estimator.time_s
    return known
