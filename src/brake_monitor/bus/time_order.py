"""Whether the frames of a recording stand in the order of their times, as an estimate needs them."""

from math import inf

import numpy as np

from brake_monitor.frame_block import FrameBlock

TOLERATED_S = 0.05  # what is captured as much earlier is still fused


class TimeOrder:
    """Counts where time goes back: a clock was set, or what several recorders wrote was put together unsorted."""

    def __init__(self) -> None:
        self._latest_s = -inf  # since time went back last
        self._count = 0
        self._greatest_s = 0.0

    def see(self, block: FrameBlock) -> None:
        """Take the next frames."""
        latest_s = np.maximum.accumulate(np.concatenate(((self._latest_s,), block.time_s)))
        if (block.time_s >= latest_s[:-1] - TOLERATED_S).all():  # as nearly always
            self._latest_s = float(latest_s[-1])
            return
        for time_s in block.time_s.tolist():
            back_s = self._latest_s - time_s
            if back_s > TOLERATED_S:
                self._count += 1
                self._greatest_s = max(self._greatest_s, back_s)
                self._latest_s = time_s
            elif back_s < 0.0:
                self._latest_s = time_s

    @property
    def remark(self) -> str | None:
        """What it means for the estimate; None where the frames are in order."""
        if not self._count:
            return None
        times = "once" if self._count == 1 else f"{self._count} times"
        hint = "" if self._count == 1 else "; sort the frames by time if it is not the clock that was set"
        return f"time goes back {times}, by up to {self._greatest_s:.3g} s, and the estimate starts anew{hint}"
