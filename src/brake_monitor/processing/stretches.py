"""Where in a block of frames something is due; what lies between can be taken together."""

from bisect import bisect_right

import numpy as np

from brake_monitor.arrays import Ints
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S
from brake_monitor.samples import MEASURED

BLIND_S = 0.5  # an estimate without any reading for longer says so


class Stretches:
    """The frames with samples of a block, numbered from 0, and what time does between them."""

    def __init__(
        self,
        block: FrameBlock,
        samples: SampleBlock,
        taken_s: float,
        begun_s: float | None,
        rate_hz: float,
        *,
        waits: bool,
    ) -> None:
        """`taken_s`: when time last went on before the block; `begun_s`: from when periods count, None: from here.

        `waits`: samples wait for others, so that any frame may be the one with which a reading is fused.
        """
        time_s = samples.frame_times_s
        before_s = np.concatenate(([taken_s], time_s))
        has_samples = np.zeros(len(block), dtype=np.bool_)
        has_samples[samples.frames] = True
        number: Ints = np.cumsum(has_samples) - has_samples  # of the next frame with samples
        passed_s = block.time_s - before_s[number]
        is_due = (passed_s < 0.0) | (passed_s >= OBSERVATION_PERIOD_S)
        is_due[samples.frames] = passed_s[samples.frames] > BLIND_S
        abrupt = np.zeros(len(time_s) + 1, dtype=np.bool_)
        abrupt[number[is_due]] = True
        self.abrupt = abrupt  # time alone makes a step due at the frame or just before it
        self.places: list[int] = samples.frames.tolist()  # in the block
        self.times_s = samples.listed_frame_times_s
        if begun_s is None:
            is_due[samples.frames[:1]] = True
            begun_s = float(min(block.time_s[is_due][:1], default=0.0))
        self._observed_turn = observed = np.floor((time_s - begun_s) / OBSERVATION_PERIOD_S)
        self._given_turn = given = np.floor((time_s - begun_s) * (rate_hz or 1.0))
        ends = abrupt[:-1].copy()
        ends[1:] |= (np.diff(observed) != 0.0) | (np.diff(given) != 0.0) | (np.diff(time_s) < 0.0) | (rate_hz == 0.0)
        self._ends: list[int] = [*np.flatnonzero(ends).tolist(), len(time_s)]
        tells = np.array([channel.quantity in MEASURED for channel in samples.channels], dtype=np.bool_)
        measures = np.full(len(time_s), waits)
        measures[number[samples.frame[tells[samples.channel]]]] = True
        numbers = np.where(measures, np.arange(len(time_s)), len(time_s))
        self._next_measuring: Ints = np.minimum.accumulate(numbers[::-1])[::-1]  # from each frame on
        goes_on = ~abrupt
        goes_on[1:-1] &= np.diff(time_s) >= 0.0
        self._can_be_last = goes_on & (rate_hz != 0.0)

    def end(self, frame: int, observed_turn: int, given_turn: int, fused_s: float) -> int:
        """Before which frame to stop when going on at this one: after the first at which anything may be due.

        The turns are those that something was last given out in; `fused_s` is when a sample was last fused.
        """
        end = self._ends[bisect_right(self._ends, frame)]
        if self._observed_turn[frame] != observed_turn or self._given_turn[frame] != given_turn:
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
        return min(self._next_measuring.item(frame) + 1, end)
