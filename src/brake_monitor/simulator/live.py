"""A recording played onto a bus as if it happened now. Nothing else in this package sends a frame."""

from collections.abc import Iterable

import can

from brake_monitor.frame import Frame
from brake_monitor.host.pacing import paced
from brake_monitor.simulator.files import to_message


def play(frames: Iterable[Frame], bus: can.BusABC, speed: float) -> None:
    """Send the frames on `bus`, each when its time has come at `speed` times real time (infinity: at once).

    Raises can.CanError when the bus refuses.
    """
    for frame in paced(frames, speed):
        bus.send(to_message(frame))
