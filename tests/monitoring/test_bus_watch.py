"""A bus watch that passes over the frames of a block must hear what it hears of each."""

from random import Random

import pytest

from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.bus_watch import BUS_OFF, BusWatch


@pytest.mark.parametrize("seed", range(20))
def test_a_bus_watch_hears_the_same(seed: int) -> None:
    random = Random(seed)
    frames = [
        Frame(random.uniform(0.0, 10.0), random.choice(("can0", "rear", "")), 0x100, False, b"") for _ in range(30)
    ]
    block = FrameBlock.of(frames)
    begin, end = sorted(random.sample(range(31), 2))
    singly, together = (BusWatch(("can0", "rear"), ()) for _ in range(2))
    for watch in (singly, together):
        watch.reports(0.5)
        watch.see(Frame(1.0, "can0", BUS_OFF, True, b"", FrameKind.ERROR))
    for frame in frames[begin:end]:
        singly.see(frame)
    together.pass_over(block, begin, end)
    assert together.reports(10.0) == singly.reports(10.0)
