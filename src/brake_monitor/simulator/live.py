"""A recording played onto a bus as if it happened now. Nothing else in this package sends a frame."""

import math
import time
from collections.abc import Iterable

import can

from brake_monitor.frame import Frame
from brake_monitor.simulator.files import to_message


def play(frames: Iterable[Frame], bus: can.BusABC, speed: float = 1.0) -> None:
    """Send the frames on `bus`, each when its time has come at `speed` times real time (infinity: at once).

    Raises can.CanError when the bus refuses.
    """
    begun_s = time.monotonic()
    first_s: float | None = None
    for frame in frames:
        first_s = frame.time_s if first_s is None else first_s
        wait_s = 0.0 if math.isinf(speed) else begun_s + (frame.time_s - first_s) / speed - time.monotonic()
        if wait_s > 0.0:
            time.sleep(wait_s)
        bus.send(to_message(frame))
