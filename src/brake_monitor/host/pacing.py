"""Recorded frames as if they happened now."""

import time
from collections.abc import Iterable, Iterator

from brake_monitor.frame import Frame

LONGEST_WAIT_S = 1e6  # a clock that was set may leave more in a recording than can be slept


def paced(frames: Iterable[Frame], speed: float) -> Iterator[Frame]:
    """Give each frame when its time has come at `speed` times real time; infinity gives them at once."""
    begun_s = time.monotonic()
    first_s: float | None = None
    for frame in frames:
        first_s = frame.time_s if first_s is None else first_s
        wait_s = begun_s + (frame.time_s - first_s) / speed - time.monotonic()
        if wait_s > 0.0:
            time.sleep(min(wait_s, LONGEST_WAIT_S))
        yield frame
