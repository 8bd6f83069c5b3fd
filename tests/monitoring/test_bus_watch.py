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


def test_error_frames_are_counted_on_their_bus_and_one_that_says_off_holds_until_the_next_frame() -> None:
    watch = BusWatch(("can0", "rear"), ())
    for time_s, bus, can_id, kind in (
        (1.0, "can0", 0x08, FrameKind.ERROR),
        (1.1, "can0", 0x08, FrameKind.ERROR),
        (1.2, "rear", BUS_OFF, FrameKind.ERROR),
        (1.3, "elsewhere", BUS_OFF, FrameKind.ERROR),
    ):
        watch.see(Frame(time_s, bus, can_id, True, bytes(8), kind))
    assert [(bus.error_frames, bus.is_off) for bus in watch.reports(1.5)] == [(2, False), (1, True)]
    watch.see(Frame(2.0, "rear", 0x100, False, b""))
    watch.down("can0", True)
    assert [(bus.error_frames, bus.is_off) for bus in watch.reports(2.5)] == [(2, True), (1, False)]


def test_silence_is_counted_since_the_last_frame_and_anew_after_a_clock_that_was_set() -> None:
    watch = BusWatch(("can0", "rear"), ())
    assert [bus.silent_s for bus in watch.reports(100.0)] == [0.0, 0.0]
    watch.see(Frame(104.0, "can0", 0x100, False, b""))
    watch.see(Frame(104.5, "rear", 0x08, True, bytes(8), FrameKind.ERROR))  # no sign of life
    assert [bus.silent_s for bus in watch.reports(105.0)] == [1.0, 5.0]
    assert [bus.silent_s for bus in watch.reports(50.0)] == [0.0, 0.0]
    assert [bus.silent_s for bus in watch.reports(53.0)] == [3.0, 3.0]
    assert [bus.silent_s for bus in watch.reports(1.7e9)] == [0.0, 0.0]  # by satellites, which tell the year
    assert [bus.silent_s for bus in watch.reports(1.7e9 + 3600.0)] == [3600.0, 3600.0]
