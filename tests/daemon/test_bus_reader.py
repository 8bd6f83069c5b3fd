"""The thread that reads a bus: how long it rests and waits, by an event that only notes it."""

import threading
import time
from collections.abc import Callable
from queue import Empty, SimpleQueue

import pytest

from brake_monitor.bus.can_source import BusError
from brake_monitor.daemon import bus_reader
from brake_monitor.daemon.bus_reader import TICK_S, BusReader
from brake_monitor.daemon.buses import Buses
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.example_vehicles import example_settings

KERNEL_HOLDS_S = 0.03  # of the busiest bus, where it gives a reader little room


class Ending(threading.Event):
    """Set after so many waits, none of which takes any time."""

    def __init__(self, after: int) -> None:
        super().__init__()
        self.waits_s: list[float] = []
        self._after = after

    def wait(self, timeout: float | None = None) -> bool:
        assert timeout is not None
        self.waits_s.append(timeout)
        if len(self.waits_s) == self._after:
            self.set()
        return self.is_set()


class SilentBus:
    """One whose frames the kernel stamps; there are none."""

    dropped, keeps_time = 0, True

    def recv(self, _timeout_s: float) -> Frame | None:
        return None

    def close(self) -> None: ...


class BusyBus(SilentBus):
    """One that has so many frames, at each of which the kernel drops another one."""

    def __init__(self, count: int, *, keeps_time: bool) -> None:
        self.dropped, self.keeps_time, self._count = 3, keeps_time, count + 3

    def recv(self, _timeout_s: float) -> Frame | None:
        if self.dropped == self._count:
            return None
        self.dropped += 1
        return Frame(float(self.dropped), "a", 0x100, False, b"")


def read(
    open_bus: Callable[..., object], stopping: Ending, due_s: float, arrived: "SimpleQueue[Frame | None] | None" = None
) -> BusReader:
    """A reader that has ended."""
    bus = example_settings("wagon").can[0]
    reader = BusReader(bus, (), open_bus, arrived or SimpleQueue(), stopping, due_s=lambda: due_s)
    reader.start()
    reader.finish()
    assert reader.crash is None
    return reader


def test_it_never_rests_for_longer_than_the_kernel_has_room() -> None:
    stopping = Ending(after=50)
    read(lambda *_: SilentBus(), stopping, due_s=time.time() + 3600.0)
    assert 0.0 < min(stopping.waits_s) <= max(stopping.waits_s) < KERNEL_HOLDS_S


def test_after_a_rest_all_frames_are_fetched_that_are_there() -> None:
    arrived: SimpleQueue[Frame | None] = SimpleQueue()
    reader = read(lambda *_: BusyBus(200, keeps_time=True), Ending(after=2), time.time() + 3600.0, arrived)
    assert (arrived.qsize(), reader.dropped) == (200, 200)


def test_while_nobody_takes_them_no_more_frames_wait_than_there_is_room_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_reader, "FRAMES_WAITING", 10)
    arrived: SimpleQueue[Frame | None] = SimpleQueue()
    reader = read(lambda *_: BusyBus(200, keeps_time=False), Ending(after=3), 0.0, arrived)
    assert arrived.qsize() == 10
    assert reader.dropped == 11 + 1  # by the kernel, and the one in hand at the end


def test_a_bus_that_is_down_is_tried_less_and_less_often_and_soon_again_once_it_has_worked(
    caplog: pytest.LogCaptureFixture,
) -> None:
    attempts = iter([*[False] * 6, True])

    def open_bus(*_: object) -> SilentBus:
        if next(attempts, False):
            return FailingBus()
        raise BusError("down")

    class FailingBus(SilentBus):
        """Works once."""

        keeps_time = False
        works = True

        def recv(self, timeout_s: float) -> Frame | None:
            if not self.works:
                raise BusError("down")
            self.works = False
            return super().recv(timeout_s)

    stopping = Ending(after=8)
    reader = read(open_bus, stopping, due_s=0.0)
    assert stopping.waits_s == [0.2, 0.4, 0.8, 1.6, 2.0, 2.0, 0.2, 0.4]
    assert reader.failures == 2
    assert caplog.messages == ["down; it is opened anew until it works"] * 2  # once in each outage


def test_a_bus_that_is_open_is_not_opened_again_and_time_before_its_thread_began_is_none_that_it_hangs() -> None:
    opened: list[object] = []
    released = threading.Event()

    class HangingBus(SilentBus):
        keeps_time = False

        def recv(self, _timeout_s: float) -> Frame | None:
            released.wait(60.0)
            return None

    def open_bus(*_: object) -> HangingBus:
        opened.append(bus := HangingBus())
        return bus

    buses = Buses(Pipeline.from_settings(example_settings("wagon")), open_bus)
    buses._readers[0].beat_s -= 3600.0  # as where the buses had to be waited for
    buses.open()
    buses.start()
    assert buses.hanging(600.0) == []
    assert len(opened) == 1
    released.set()
    buses.finish()


def test_who_takes_waits_for_the_next_frame(monkeypatch: pytest.MonkeyPatch) -> None:
    """Else an idle bus would keep a processor busy."""
    waited: list[float] = []

    class Arriving:
        """A queue in which a frame comes while somebody waits for it."""

        def get(self, timeout: float) -> Frame:
            waited.append(timeout)
            return Frame(1.0, "can0", 1, False, b"")

        def get_nowait(self) -> Frame:
            raise Empty

    buses = Buses(Pipeline.from_settings(example_settings("wagon")), lambda *_: SilentBus())
    monkeypatch.setattr(buses, "_arrived", Arriving())
    assert [frame.can_id for frame in buses.take()] == [1]
    assert waited == [TICK_S]
