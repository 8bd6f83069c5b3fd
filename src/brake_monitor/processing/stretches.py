"""Where in a block of frames an estimate or a look of the rules may be due; frames between can be taken together."""

from bisect import bisect_left, bisect_right

import numpy as np

from brake_monitor.arrays import Bools, Floats, Ints
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame import MOST_LATE_S
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S
from brake_monitor.processing.turns import BLIND_S, Turns
from brake_monitor.samples import MEASURED


class Stretches:
    """The frames with samples of a block, numbered from 0, and between which of them something is due."""

    def __init__(self, block: FrameBlock, samples: SampleBlock, turns: Turns, *, waits: bool) -> None:
        """`turns` are those of the pipeline, which go on as the block is taken.

        `waits`: samples wait for others, so that any frame may be the one with which a reading is fused.
        """
        self._turns = turns
        self.places: list[int] = samples.frames.tolist()  # in the block
        self.times_s = samples.listed_frame_times_s
        time_s, count = samples.frame_times_s, len(samples.frames)
        number = np.searchsorted(samples.frames, np.arange(len(block)))  # of the next frame with samples
        is_due = _due_by_time(block, samples, number, turns.taken_s)
        self.abrupt = np.zeros(count + 1, dtype=np.bool_)  # time alone makes a step due at the frame or just before it
        self.abrupt[number[is_due]] = True
        begun_s = turns.begun_s
        if not turns.have_begun:
            is_due[samples.frames[:1]] = True
            begun_s = float(min(block.time_s[is_due][:1], default=0.0))
        since_s = _late_ones_apart(time_s, turns.latest_s) - begun_s
        self._observed = np.floor(since_s / OBSERVATION_PERIOD_S)
        self._given = np.floor(since_s * (turns.rate_hz or 1.0))
        goes_back = np.diff(time_s, prepend=time_s[:1]) < 0.0
        ends = self.abrupt[:-1] | goes_back | (turns.rate_hz == 0.0)
        self._can_be_last = ~ends
        for turn in (self._observed, self._given):
            ends |= np.diff(turn, prepend=turn[:1]) != 0.0
        self._ends: list[int] = [*np.flatnonzero(ends).tolist(), count]
        tells = np.array([channel.quantity in MEASURED for channel in samples.channels], dtype=np.bool_)
        measures = np.full(count, waits)
        measures[number[samples.frame[tells[samples.channel]]]] = True
        self._measuring: list[int] = [*np.flatnonzero(measures).tolist(), count]

    def end(self, frame: int) -> int:
        """Before which frame to stop when going on at this one: after the first at which anything may be due."""
        turns, fused_s = self._turns, self._turns.fused_s
        end = self._ends[bisect_right(self._ends, frame)]
        if self._observed[frame] != turns.observed or self._given[frame] != turns.given:
            stop = self._given_out_by(frame, end)
        elif end < len(self.places) and self._can_be_last[end]:
            stop = self._given_out_by(end, self._ends[bisect_right(self._ends, end)])
        else:
            stop = end
        first_s, last_s = self.times_s[frame], max(self.times_s[end - 1], self.times_s[stop - 1])
        may_be_blind = last_s - min(fused_s, first_s) > BLIND_S or fused_s - first_s > BLIND_S
        return frame + 1 if may_be_blind else stop

    def _given_out_by(self, frame: int, end: int) -> int:
        """Before which frame to stop when something is due from one on: it is given out as soon as one is fused."""
        return min(self._measuring[bisect_left(self._measuring, frame)] + 1, end)


def _late_ones_apart(time_s: Floats, latest_s: float) -> Floats:
    """How far time had gone at each of these frames: one that came late does not put it back, a clock does."""
    gone_s: Floats = np.maximum.accumulate(np.concatenate(([latest_s], time_s)))[1:]
    if (gone_s - time_s <= MOST_LATE_S).all():  # the usual case
        return gone_s
    gone_s = time_s.copy()
    for frame, own_s in enumerate(time_s.tolist()):
        latest_s = latest_s if 0.0 < latest_s - own_s <= MOST_LATE_S else own_s
        gone_s[frame] = latest_s
    return gone_s


def _due_by_time(block: FrameBlock, samples: SampleBlock, number: Ints, taken_s: float) -> Bools:
    """At which frames time alone makes a step due: it goes back, or on by so much since the last frame with samples."""
    passed_s = block.time_s - np.concatenate(([taken_s], samples.frame_times_s))[number]
    is_due: Bools = (passed_s < 0.0) | (passed_s >= OBSERVATION_PERIOD_S)
    is_due[samples.frames] = passed_s[samples.frames] > BLIND_S  # these are taken anyway
    return is_due
