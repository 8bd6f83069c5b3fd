"""Whether the frames of a recording stand in the order of their times, as an estimate needs them."""

from collections.abc import Iterator
from math import inf

import numpy as np

from brake_monitor.digits import significant
from brake_monitor.frame import MOST_LATE_S, YEAR_S
from brake_monitor.frame_block import FrameBlock

MANY = 100  # frames that no bus carries at once


class TimeOrder:
    """Counts where time goes back: a clock was set, or what several recorders wrote was put together unsorted.

    No recorder waits for a year: where time goes ahead by more a clock was set, too, or a byte of the time is wrong.
    """

    def __init__(self) -> None:
        self._latest_s = -inf  # since time went back last
        self._count = 0
        self._greatest_s = 0.0
        self._last_s = inf  # of all frames so far; none ends an endless time
        self._seen = 0  # frames
        self._has_moved = False
        self._ahead_count = 0
        self._ahead_s = 0.0

    def see(self, block: FrameBlock) -> None:
        """Take the next frames."""
        ahead_s = np.diff(block.time_s, prepend=self._last_s)
        self._last_s = float(block.time_s[-1])
        self._has_moved |= bool(np.any(ahead_s[int(self._seen == 0) :]))
        self._seen += len(block.time_s)
        self._ahead_count += int(np.count_nonzero(ahead_s > YEAR_S))
        self._ahead_s = max(self._ahead_s, float(ahead_s.max()))
        latest_s = np.maximum.accumulate(np.concatenate(((self._latest_s,), block.time_s)))
        if (block.time_s >= latest_s[:-1] - MOST_LATE_S).all():  # the usual case
            self._latest_s = float(latest_s[-1])
            return
        for time_s in block.time_s.tolist():
            back_s = self._latest_s - time_s
            if back_s > MOST_LATE_S:
                self._count += 1
                self._greatest_s = max(self._greatest_s, back_s)
                self._latest_s = time_s
            elif back_s < 0.0:
                self._latest_s = time_s

    @property
    def remarks(self) -> Iterator[str]:
        """What it means for the estimate; none where the frames are in order."""
        if self._seen >= MANY and not self._has_moved:
            yield f"its {self._seen} frames all have the same time: nothing can be estimated from them"
        if self._count:
            hint = "" if self._count == 1 else "; sort the frames by time if it is not the clock that was set"
            yield (
                f"time goes back {_times(self._count)}, by up to {significant(self._greatest_s, 3)} s, and the "
                f"estimate starts anew{hint}"
            )
        if self._ahead_count:
            yield (
                f"time goes ahead {_times(self._ahead_count)} by up to {self._ahead_s / YEAR_S:.3g} years from one "
                "frame to the next: a clock was set, or the file is damaged"
            )


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count} times"
