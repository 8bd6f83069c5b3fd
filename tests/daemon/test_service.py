"""The daemon around the pipeline: frames in, silence told, buses that fail, a clean end."""

import json
import os
import resource
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, suppress
from pathlib import Path
from queue import Empty, Queue
from types import SimpleNamespace
from typing import Any, NamedTuple

import can
import pytest
import zenoh

from background import in_background
from brake_monitor.bus.can_source import BusError
from brake_monitor.daemon import bus_reader, watchdog
from brake_monitor.daemon import service as service_module
from brake_monitor.daemon.bus_reader import BusReader
from brake_monitor.daemon.buses import FRAMES_PER_TURN
from brake_monitor.daemon.sd_notify import notify, watchdog_s
from brake_monitor.daemon.service import Service
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame
from brake_monitor.host.stop_signals import stopped_by_signals
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.gauge import Gauge
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.config import CanBus
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.storage.memory import Memory
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch
from brake_states import brakes
from estimates import alarm, estimate
from network import is_answered, session
from network import running as publishing
from program import PATIENCE_S, Python, next_of, until


class BusDown(NamedTuple):
    """A call of that name."""

    name: str
    is_down: bool


class ClockSet(NamedTuple):
    """A call of that name."""

    by_s: float


class RecordingPipeline:
    """Stands in for the pipeline on buses of these names: notes what it is given, gives out what the test wants."""

    def __init__(self, *names: str) -> None:
        buses = tuple(CanBus(interface="virtual", channel=name, dbc=(), name=name) for name in names or ("a",))
        self.settings = SimpleNamespace(can=buses, wear=WearSettings())
        self.decoder = SimpleNamespace(can_filters=lambda bus: [], counts=DecodeCounts(), channels=())
        self.estimator = SimpleNamespace(reset_count=0, late_count=0, outlier_count=0)
        self.brake_book = SimpleNamespace(brakes=Brakes(None, (), ()))
        self.calls: Queue[Frame | float | BusDown] = Queue()
        self.outputs = Outputs()
        self.memory_failure = ""
        self.newest_reading_s: float | None = None
        self.due_s = 0.0  # something always is

    def step(self, frame: Frame) -> Outputs:
        self.calls.put(frame)
        return self.outputs

    def advance(self, time_s: float) -> Outputs:
        self.calls.put(time_s)
        return self.outputs

    def acknowledge(self, alarm_id: str, time_s: float) -> Outputs:
        return Outputs(None, (alarm(id=alarm_id, acknowledged_time_s=time_s, updated_time_s=time_s),))

    def clock_set(self, by_s: float) -> None:
        self.calls.put(ClockSet(by_s))

    def bus_down(self, name: str, is_down: bool) -> None:
        self.calls.put(BusDown(name, is_down))

    def next(self, kind: type | tuple[type, ...]) -> Any:
        """The next call of a kind; the others are passed over."""
        while not isinstance(call := next_of(self.calls), kind):
            pass
        return call


class ScriptedBus:
    """Stands in for a live bus: gives out what is put into it; an exception in it is raised."""

    dropped = 0
    keeps_time = False

    def __init__(self, *script: Frame | Exception) -> None:
        self.script: Queue[Frame | Exception] = Queue()
        for item in script:
            self.script.put(item)
        self.closed = threading.Event()

    def recv(self, timeout_s: float) -> Frame | None:
        if self.script.empty():
            threading.Event().wait(min(timeout_s, 0.01))
            return None
        item = self.script.get()
        if isinstance(item, Exception):
            raise item
        return item

    def close(self) -> None:
        self.closed.set()


class Buses:
    """Opens scripted buses: first those that the test prepared, then empty ones; an exception among them is raised."""

    def __init__(self, *prepared: ScriptedBus | Exception) -> None:
        self.prepared = list(prepared)
        self.opened: Queue[ScriptedBus] = Queue()

    def __call__(self, bus: CanBus, filters: object) -> ScriptedBus:
        opened = self.prepared.pop(0) if self.prepared else ScriptedBus()
        if isinstance(opened, Exception):
            raise opened
        self.opened.put(opened)
        return opened

    def next(self) -> ScriptedBus:
        return next_of(self.opened)


def frame(time_s: float, bus: str = "a", can_id: int = 0x100) -> Frame:
    return Frame(time_s, bus, can_id, False, b"\x01")


def running(service: Service) -> AbstractContextManager[object]:
    """The service in a thread; what it raised is raised here."""
    return in_background(service.run, service.stop, PATIENCE_S)


def test_frames_of_a_python_can_bus_go_to_the_pipeline_and_its_outputs_to_the_observer() -> None:
    pipeline, seen = RecordingPipeline("service-1"), Queue()
    pipeline.outputs = Outputs(estimate())
    service = Service(pipeline, on_outputs=seen.put)
    with can.Bus(interface="virtual", channel="service-1") as sender, running(service):
        next_of(seen)  # it is open now: it has told the time
        before_s = time.time()
        sender.send(can.Message(arbitration_id=0x123, is_extended_id=True, data=b"\x07\x08"))
        got = pipeline.next(Frame)
        assert next_of(seen).estimate == estimate()
    assert (got.bus, got.can_id, got.extended, got.data) == ("service-1", 0x123, True, b"\x07\x08")
    assert before_s <= got.time_s <= time.time()
    assert service.frames == 1


def test_silence_is_told_in_the_time_of_the_last_frame_whatever_its_clock() -> None:
    pipeline, buses = RecordingPipeline(), Buses()
    service = Service(pipeline, open_bus=buses)
    with running(service):
        begun_s = pipeline.next(float)
        assert abs(begun_s - time.time()) < PATIENCE_S  # nothing came yet: the wall clock
        buses.next().script.put(frame(5.0))
        pipeline.next(Frame)
        told_s = [pipeline.next(float) for _ in range(3)]
    assert 5.0 <= told_s[0] <= told_s[1] <= told_s[2] < 5.0 + PATIENCE_S


def test_between_frames_the_time_is_told_no_more_often_than_ten_times_a_second() -> None:
    """It costs as much as a frame."""
    pipeline, told_s, begun_s = RecordingPipeline(), list[float](), time.monotonic()
    pipeline.advance = lambda time_s: (told_s.append(time_s), NOTHING)[1]
    service = Service(pipeline, open_bus=Buses())
    service._told_s -= 3600.0
    with running(service):
        for number in range(100):
            service.buses._arrived.put(frame(float(number)))
            pipeline.next(Frame)
    assert len(told_s) <= (time.monotonic() - begun_s) / bus_reader.TICK_S + 1


def test_silence_after_frames_that_came_together_is_told_in_the_time_of_the_last() -> None:
    pipeline = RecordingPipeline()
    service = Service(pipeline, open_bus=Buses())
    for time_s in (5.0, 500.0):
        service.buses._arrived.put(frame(time_s))
    with running(service):
        assert [pipeline.next(Frame).time_s for _ in range(2)] == [5.0, 500.0]
        assert 500.0 <= pipeline.next(float) < 500.0 + PATIENCE_S


def test_frames_of_several_buses_are_merged_in_the_order_of_their_capture(monkeypatch: pytest.MonkeyPatch) -> None:
    pipeline = RecordingPipeline("a", "b")
    service = Service(pipeline, open_bus=Buses())
    for time_s in (1.0, 3.0, 5.0):
        service.buses._arrived.put(frame(time_s, "a"))
    for time_s in (2.0, 4.0):
        service.buses._arrived.put(frame(time_s, "b"))
    with running(service):
        got = [pipeline.next(Frame) for _ in range(5)]
    assert [(f.time_s, f.bus) for f in got] == [(1.0, "a"), (2.0, "b"), (3.0, "a"), (4.0, "b"), (5.0, "a")]


def test_a_bus_that_fails_is_opened_anew_until_it_works(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    failing, other = ScriptedBus(), ScriptedBus()
    not_up_yet = ScriptedBus(BusError("not up yet"))  # opens, but does not work: the same outage
    works = ScriptedBus(frame(7.0))
    pipeline = RecordingPipeline("a", "b")
    buses = Buses(failing, other, InputError("no such interface"), not_up_yet, works)
    service = Service(pipeline, open_bus=buses)
    with running(service):
        failing.script.put(BusError("the bus is gone"))
        assert pipeline.next(Frame).time_s == 7.0
        other.script.put(frame(8.0, "b"))  # the other bus was never disturbed
        assert pipeline.next(Frame).bus == "b"
        assert service.buses.failures == 1
    assert all(bus.closed.is_set() for bus in (failing, other, not_up_yet, works))
    told = [record.message for record in caplog.records if "bus is gone" in record.message or "back" in record.message]
    assert told == ["the bus is gone; it is opened anew until it works", "virtual:a is back"]


def settable_clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """By how much the system's clock is ahead, one number to set it by."""
    true_time, offset_s = time.time, [0.0]
    monkeypatch.setattr(time, "time", lambda: true_time() + offset_s[0])
    return offset_s


@pytest.mark.parametrize("by_s", [3600.0, -3600.0, 1.5])
def test_the_pipeline_is_told_when_the_clock_was_set_with_the_first_frame_of_the_new_time(
    by_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipeline, buses, offset_s = RecordingPipeline(), Buses(), settable_clock(monkeypatch)
    with running(Service(pipeline, open_bus=buses)):
        bus = buses.next()
        bus.script.put(frame(5000.0))
        pipeline.next(Frame)
        offset_s[0] = by_s
        pipeline.next(float)  # a turn later it has been noticed, and nothing been told
        for time_s in (5000.01, 5000.02 + by_s, 5000.03 + by_s):  # the first had been captured before
            bus.script.put(frame(time_s))
        calls = [pipeline.next((Frame, ClockSet)) for _ in range(4)]
    assert [call.time_s if isinstance(call, Frame) else call for call in calls] == [
        5000.01,
        ClockSet(pytest.approx(by_s, abs=0.2)),
        5000.02 + by_s,
        5000.03 + by_s,
    ]


@pytest.mark.parametrize("has_frames", [False, True], ids=["before the first frame", "after some"])
@pytest.mark.parametrize("by_s", [7200.0, -7200.0, 4.0, -4.0])
def test_a_clock_that_is_set_in_a_silence_is_followed_at_once(
    by_s: float, has_frames: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipeline, buses, offset_s = RecordingPipeline(), Buses(), settable_clock(monkeypatch)
    with running(Service(pipeline, open_bus=buses)):
        bus = buses.next()
        if has_frames:
            bus.script.put(frame(time.time()))
            pipeline.next(Frame)
        pipeline.next(float)
        offset_s[0] = by_s
        begun_s = time.time()
        assert pipeline.next(ClockSet).by_s == pytest.approx(by_s, abs=0.2)
        for _ in range(3):
            assert begun_s - 2.0 < pipeline.next((float, ClockSet)) <= time.time()
        bus.script.put(frame(time.time()))
        assert isinstance(pipeline.next((Frame, ClockSet)), Frame)
        assert all(isinstance(pipeline.next((float, ClockSet)), float) for _ in range(2))


class FrozenBus(ScriptedBus):
    """As long as it does not thaw, the thread that reads it does not go on."""

    def __init__(self, *script: Frame | Exception) -> None:
        super().__init__(*script)
        self.thaws, self.is_awaited = threading.Event(), threading.Event()
        self.thaws.set()

    def recv(self, timeout_s: float) -> Frame | None:
        if not self.thaws.is_set():
            self.is_awaited.set()
            self.thaws.wait(PATIENCE_S)
        return super().recv(timeout_s)


def noting(ask: Callable[[], bool], asked: Queue[float]) -> Callable[[], bool]:
    """As `ask`, and notes when it was asked."""

    def ask_and_note() -> bool:
        asked.put(time.monotonic())
        return ask()

    return ask_and_note


def test_what_came_while_the_machine_stood_still_is_no_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service_module, "LOOKS_S", PATIENCE_S)
    true_monotonic, stood_s = time.monotonic, [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: true_monotonic() + stood_s[0])
    bus, pipeline, turns = FrozenBus(frame(5000.0)), RecordingPipeline(), Queue[float]()
    service = Service(pipeline, open_bus=Buses(bus))
    monkeypatch.setattr(service, "_knows_of_silence", noting(service._knows_of_silence, turns))
    with running(service):
        pipeline.next(Frame)
        bus.thaws.clear()
        assert bus.is_awaited.wait(PATIENCE_S)
        stood_s[0] = 100.0
        while not turns.empty():
            turns.get()
        for _ in range(3):  # the main thread goes on first
            next_of(turns)
        missed = [frame(5000.0 + tenth / 10) for tenth in range(1, 1000)]
        for one in missed:
            bus.script.put(one)
        bus.thaws.set()
        calls = [pipeline.next((Frame, float))]
        while calls[-1] != missed[-1]:
            calls.append(pipeline.next((Frame, float)))
        calls.append(pipeline.next(float))
    times_s = [call.time_s if isinstance(call, Frame) else call for call in calls]
    assert times_s == sorted(times_s)
    assert [call for call in calls if isinstance(call, Frame)] == missed


@pytest.mark.parametrize("names", ["a", "ab"])
def test_a_clock_that_is_set_is_not_told_before_frames_that_are_underway(
    names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However long those before them take; of two buses the second one's frame is held back meanwhile."""
    monkeypatch.setattr(service_module, "TICK_S", 0.0)  # time is told in each turn
    pipeline, offset_s = RecordingPipeline(*names), settable_clock(monkeypatch)
    service, note, begun_s = Service(pipeline, open_bus=Buses()), pipeline.step, time.time()
    first, underway = frame(begun_s, "a"), frame(begun_s + 0.001, names[-1])

    def step(taken: Frame) -> Outputs:
        if taken is first:
            offset_s[0] = 3600.0
            if names == "a":
                service.buses._arrived.put(underway)
        return note(taken)

    pipeline.step = step
    for there in (first, underway)[: len(names)]:
        service.buses._arrived.put(there)
    with running(service):
        calls = [pipeline.next((Frame, ClockSet)) for _ in range(3)]
    assert calls == [first, underway, ClockSet(pytest.approx(3600.0, abs=0.2))]


def test_a_clock_that_frames_are_not_stamped_with_is_not_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    pipeline, buses, offset_s = RecordingPipeline(), Buses(), settable_clock(monkeypatch)
    with running(Service(pipeline, open_bus=buses)):
        buses.next().script.put(frame(5000.0))
        pipeline.next(Frame)
        offset_s[0] = 7200.0
        calls = [pipeline.next((float, ClockSet)) for _ in range(4)]
    assert calls == [pytest.approx(5000.0, abs=PATIENCE_S)] * 4


class KernelBus(ScriptedBus):
    """One whose frames are stamped before they are fetched; notes how long each was waited for."""

    keeps_time = True

    def __init__(self, *script: Frame | Exception) -> None:
        super().__init__(*script)
        self.waits_s: Queue[float] = Queue()

    def recv(self, timeout_s: float) -> Frame | None:
        self.waits_s.put(timeout_s)
        return super().recv(timeout_s)


def test_frames_that_the_kernel_stamps_gather_while_nothing_is_due_and_are_fetched_together() -> None:
    pipeline, bus = RecordingPipeline(), KernelBus(*map(frame, range(20)))
    pipeline.due_s = time.time() + 3600.0
    with running(Service(pipeline, open_bus=Buses(bus))):
        assert [pipeline.next(Frame).time_s for _ in range(20)] == [*range(20)]
        assert {next_of(bus.waits_s) for _ in range(20)} == {0.0}


def test_frames_that_gather_are_handed_on_together_however_often_they_are_fetched(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What takes them costs more to be woken than the frames do."""
    fetched: list[float] = []
    handed_on: Queue[int] = Queue()

    class TricklingBus(KernelBus):
        def recv(self, timeout_s: float) -> Frame | None:
            if self.waits_s.qsize() % 2:  # one frame at each fetch
                self.waits_s.get()
                return None
            self.waits_s.put(timeout_s)
            fetched.append(timeout_s)
            return frame(0.0)

    arrived = SimpleNamespace(put=lambda _: handed_on.put(len(fetched)), qsize=lambda: 0)
    monkeypatch.setattr(bus_reader, "REST_S", 1e-4)
    bus, stopping, due_s = RecordingPipeline().settings.can[0], threading.Event(), time.time() + 3600.0
    reader = BusReader(bus, (), Buses(TricklingBus()), arrived, stopping, due_s=lambda: due_s)
    reader.start()
    so_far = [next_of(handed_on) for _ in range(200)]
    stopping.set()
    reader.finish()
    assert len(set(so_far)) < len(so_far)


def test_frames_are_awaited_when_something_is_due() -> None:
    pipeline, bus = RecordingPipeline(), KernelBus(*map(frame, range(20)))
    pipeline.due_s = time.time()
    with running(Service(pipeline, open_bus=Buses(bus))):
        assert [pipeline.next(Frame).time_s for _ in range(20)] == [*range(20)]
        assert {next_of(bus.waits_s) for _ in range(20)} == {bus_reader.TICK_S}


def test_frames_of_several_buses_do_not_gather() -> None:
    """They are put in the order of their capture as they come, which one that waits would upset."""
    pipeline, buses = RecordingPipeline("a", "b"), (KernelBus(*map(frame, range(20))), KernelBus())
    pipeline.due_s = time.time() + 3600.0
    with running(Service(pipeline, open_bus=Buses(*buses))):
        for bus in buses:
            assert {next_of(bus.waits_s) for _ in range(20)} == {bus_reader.TICK_S}


class DroppingBus(KernelBus):
    """One whose kernel drops seven frames."""

    @property
    def dropped(self) -> int:
        return 7 if self.script.empty() else 0


def test_frames_that_had_gathered_when_the_bus_failed_are_taken_and_what_was_dropped_is_counted() -> None:
    pipeline, bus = RecordingPipeline(), DroppingBus(*map(frame, range(20)), BusError("the bus is gone"))
    pipeline.due_s = time.time() + 3600.0
    service = Service(pipeline, open_bus=Buses(bus))
    with running(service):
        assert [pipeline.next(Frame).time_s for _ in range(20)] == [*range(20)]
        assert bus.closed.wait(PATIENCE_S)
    assert service.buses.dropped_frames == 7


@pytest.mark.usefixtures("fed")
def test_what_was_dropped_and_failures_of_all_buses_are_counted_and_logged(caplog: pytest.LogCaptureFixture) -> None:
    failing = [DroppingBus(BusError("the bus is gone")) for _ in "ab"]
    service = Service(RecordingPipeline("a", "b"), open_bus=Buses(*failing))
    with running(service):
        assert all(bus.closed.wait(PATIENCE_S) for bus in failing)
        until(lambda: "the kernel dropped" in caplog.text)
    assert (service.buses.dropped_frames, service.buses.failures) == (14, 2)


def test_a_turn_ends_however_many_frames_wait() -> None:
    """Else nothing but frames would be seen to on a bus that is too fast."""
    buses = Service(RecordingPipeline(), open_bus=Buses()).buses
    for number in range(FRAMES_PER_TURN + 500):
        buses._arrived.put(frame(float(number)))
    assert [len(buses.take()) for _ in range(2)] == [FRAMES_PER_TURN, 500]


def test_the_pipeline_is_told_of_an_interface_that_stays_down_and_when_it_is_back() -> None:
    failing, pipeline = ScriptedBus(), RecordingPipeline()
    first, is_back = iter([failing]), threading.Event()

    def open_bus(*_: object) -> ScriptedBus:
        if opened := next(first, None):
            return opened
        if is_back.is_set():
            return ScriptedBus()
        raise BusError("still down")

    with running(Service(pipeline, open_bus=open_bus)):
        failing.script.put(BusError("the bus is gone"))
        assert pipeline.next(BusDown) == BusDown("a", True)
        is_back.set()
        assert pipeline.next(BusDown) == BusDown("a", False)


def test_a_bus_that_cannot_be_opened_at_the_start_ends_it_and_closes_the_others() -> None:
    first = ScriptedBus()
    service = Service(RecordingPipeline("a", "b"), open_bus=Buses(first, InputError("no b here")))
    with pytest.raises(InputError, match="no b here"):
        service.run()
    assert first.closed.is_set()


def test_a_fault_of_ours_in_a_reader_ends_the_service_instead_of_a_silent_bus() -> None:
    bus = ScriptedBus(ZeroDivisionError())
    with pytest.raises(ZeroDivisionError):
        Service(RecordingPipeline(), open_bus=Buses(bus)).run()
    assert bus.closed.is_set()


def test_a_fault_in_the_pipeline_ends_the_service_and_closes_everything() -> None:
    pipeline, bus = RecordingPipeline(), ScriptedBus(frame(1.0))
    pipeline.step = lambda frame: 1 / 0
    with pytest.raises(ZeroDivisionError):
        Service(pipeline, open_bus=Buses(bus)).run()
    assert bus.closed.is_set()


def test_a_slow_pipeline_makes_the_reader_wait_and_loses_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_reader, "FRAMES_WAITING", 2)
    pipeline, buses, gate = RecordingPipeline(), Buses(), threading.Semaphore(0)
    note = pipeline.step

    def slow(frame: Frame) -> Outputs:
        assert gate.acquire(timeout=PATIENCE_S)
        return note(frame)

    pipeline.step = slow
    with running(Service(pipeline, open_bus=buses)):
        bus = buses.next()
        for number in range(20):
            bus.script.put(frame(float(number)))
        for number in range(20):
            gate.release()
            assert pipeline.next(Frame).time_s == number


@pytest.mark.parametrize("names", ["a", "ab"])
def test_frames_that_arrive_while_a_successor_is_looked_for_are_taken(
    names: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service_module, "FINISH_S", PATIENCE_S)  # this machine is never too far behind
    pipeline, buses = RecordingPipeline(*names), Buses()

    def gives_way() -> bool:
        for i, name in enumerate(names):
            bus = buses.next()
            for number in range(50):
                bus.script.put(frame(10.0 * number + i, name))
        until(lambda: service.buses._arrived.qsize() == 50 * len(names))
        return True

    service = Service(pipeline, open_bus=buses)
    assert service.run(gives_way)
    assert service.frames == 50 * len(names)
    times_s = [pipeline.next(Frame).time_s for _ in range(service.frames)]
    assert times_s == sorted(times_s)


def test_a_machine_that_is_far_behind_ends_in_time_and_tells_how_much_it_gives_up(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(service_module, "FINISH_S", 0.0)
    service = Service(RecordingPipeline(), open_bus=Buses())

    def gives_way() -> bool:
        for number in range(3 * FRAMES_PER_TURN):
            service.buses._arrived.put(frame(float(number)))
        return True

    assert service.run(gives_way)
    assert service.frames == FRAMES_PER_TURN
    assert f"{2 * FRAMES_PER_TURN} frames that had arrived are given up" in caplog.messages


def test_what_was_accepted_while_a_successor_was_looked_for_is_acknowledged_and_nothing_is_accepted_later() -> None:
    pipeline, acknowledged = RecordingPipeline(), []
    pipeline.acknowledge = lambda alarm_id, time_s: (acknowledged.append(alarm_id), Outputs())[1]
    with (
        Publisher(ZenohSettings(accept_acknowledgements=True), "wagon-1") as publisher,
        session(publisher.endpoints[0]) as other,
    ):

        def acknowledge() -> zenoh.Reply:
            (reply,) = other.get("brake/v1/wagon-1/acknowledge", payload='{"id": "seen"}')
            return reply

        def gives_way() -> bool:
            assert acknowledge().ok
            return True

        publisher.publish(Outputs(None, (alarm(id="seen"),)))
        until(lambda: publisher.counters.events_sent == 1)
        assert Service(pipeline, publisher, open_bus=Buses()).run(gives_way)
        assert acknowledged == ["seen"]
        assert "try again later" in acknowledge().err.payload.to_string()


def test_it_publishes_over_zenoh_and_closes_the_session() -> None:
    pipeline, buses = RecordingPipeline(), Buses()
    pipeline.outputs = Outputs(estimate(), (alarm(),))
    with publishing() as publisher, running(Service(pipeline, publisher, open_bus=buses)):
        buses.next().script.put(frame(1.0))
        pipeline.next(Frame)
    assert publisher.counters.estimates_sent >= 1
    assert publisher.counters.events_sent >= 1
    assert not any(thread.name == "zenoh" for thread in threading.enumerate())


def test_a_remote_acknowledgement_reaches_the_pipeline_and_comes_back_with_wear_and_health() -> None:
    pipeline, buses = RecordingPipeline(), Buses()
    pads = BrakeUnit(PadWear.new(WearSettings()), 15.0)
    pipeline.brake_book.brakes = Brakes(1.0, (pads,), ())
    with (
        Publisher(ZenohSettings(accept_acknowledgements=True), "wagon-1") as publisher,
        session(publisher.endpoints[0]) as other,
        running(Service(pipeline, publisher, open_bus=buses)),
    ):
        publisher.publish(Outputs(None, (alarm(id="seen"),)))
        until(lambda: publisher.counters.events_sent == 2)  # and the wear at the start
        (reply,) = other.get("brake/v1/wagon-1/acknowledge", payload='{"id": "seen"}')
        assert reply.ok
        until(lambda: publisher.counters.events_sent == 3)
        until(lambda: is_answered(other, "brake/v1/wagon-1/health"))
        told = {str(r.ok.key_expr): json.loads(r.ok.payload.to_string()) for r in other.get("brake/v1/*/**") if r.ok}
    assert told["brake/v1/wagon-1/alarm/low_adhesion"]["acknowledged_time_s"] is not None
    assert told["brake/v1/wagon-1/axle/1/wear"]["thickness_mm"] == 35.0
    assert (told["brake/v1/wagon-1/health"]["data_age_s"], told["brake/v1/wagon-1/health"]["quality"]) == (None, "bad")


def test_open_alarms_that_a_late_disk_brings_are_told(tmp_path: Path) -> None:
    configured = example_settings("wagon")
    vehicle, directory, disk = configured.vehicle, tmp_path / "state", tmp_path / "disk"
    (tmp_path / "absent").mkdir()
    with Store.open(tmp_path / "absent" / FILE_NAME, vehicle.id, vehicle.wheelset_count) as store:
        store.write(Batch(alarms={"kept": alarm(id="kept")}))
    directory.symlink_to(disk)
    pipeline = Pipeline.from_settings(configured)
    with Publisher(ZenohSettings(), "wagon-1") as publisher, Memory(pipeline, directory) as memory:
        memory.resume()
        assert not memory.has_resumed
        with running(Service(pipeline, publisher, memory, open_bus=Buses())):
            (tmp_path / "absent").rename(disk)
            until(lambda: memory.has_resumed)
            with session(publisher.endpoints[0]) as other:
                until(lambda: is_answered(other, "brake/v1/wagon-1/alarm/low_adhesion"))
                (reply,) = other.get("brake/v1/wagon-1/alarm/low_adhesion")
    assert json.loads(reply.ok.payload.to_bytes())["id"] == "kept"


def test_wear_is_told_when_the_disk_has_told_of_it_and_as_people_measure_it(tmp_path: Path) -> None:
    """Not as of new pads before."""
    configured = example_settings("wagon")
    vehicle, directory, disk = configured.vehicle, tmp_path / "state", tmp_path / "disk"
    (tmp_path / "absent").mkdir()
    with Store.open(tmp_path / "absent" / FILE_NAME, vehicle.id, vehicle.wheelset_count) as store:
        store.write(Batch(brakes=brakes(5)))
    directory.symlink_to(disk)
    pipeline, told = Pipeline.from_settings(configured), list[Brakes]()
    publisher = SimpleNamespace(
        publish=lambda _: None,
        publish_health=lambda _: None,
        publish_open_alarms=lambda _: None,
        publish_wear=lambda now, _: told.append(now),
        acknowledged=lambda: [],
        refuse_acknowledgements=lambda _: None,
        heartbeat_age_s=lambda: 0.0,
    )
    with Memory(pipeline, directory) as memory:
        memory.resume()
        with running(Service(pipeline, publisher, memory, open_bus=Buses())):
            until(lambda: memory.failing)
            assert told == []
            (tmp_path / "absent").rename(disk)
            until(lambda: told)
            assert told[0].units[0].pads.since_fitted.energy_j == brakes(5).units[0].pads.since_fitted.energy_j
            with Store.look(disk / FILE_NAME, vehicle.id, "rw") as store:
                store.enter(Gauge(1.7e9, 2, 30.0))
            until(lambda: len(told) == 2)
            assert told[1].units[1].pads.gauge_thickness_mm == 30.0


class NotingMemory:
    """Stands in for the memory: notes what it sees."""

    failing, has_resumed, wear_news = "", True, 0

    def __init__(self) -> None:
        self.frames: list[Frame] = []
        self.given: list[Outputs] = []
        self.is_finished = False

    def see(self, frames: list[Frame], given: list[Outputs], _now_s: float) -> None:
        assert not self.is_finished
        self.frames += frames
        self.given += given

    def finish(self) -> None:
        self.is_finished = True


def test_the_memory_sees_every_frame_and_all_that_comes_of_it_once_and_hears_of_the_end() -> None:
    pipeline, memory, numbers = RecordingPipeline(), NotingMemory(), range(20)
    pipeline.monitor = SimpleNamespace(open_alarms=tuple)
    pipeline.advance = lambda _: Outputs()
    pipeline.step = lambda frame: Outputs(estimate(time_s=frame.time_s))
    with running(Service(pipeline, None, memory, open_bus=Buses(ScriptedBus(*map(frame, numbers))))):
        until(lambda: len(memory.frames) == len(numbers))
    assert [frame.time_s for frame in memory.frames] == [*numbers]
    assert [given.estimate.time_s for given in memory.given if given.estimate] == [*numbers]
    assert memory.is_finished


class NotingPublisher:
    """Stands in for the publisher: notes what it is told besides estimates and alarms."""

    def __init__(self) -> None:
        self.told: list[str] = []

    def publish_health(self, _: object) -> None:
        self.told.append("health")

    def publish_open_alarms(self, _: object) -> None:
        self.told.append("open alarms")

    def publish_wear(self, *_: object) -> None:
        self.told.append("wear")

    def publish(self, _: Outputs) -> None: ...

    def refuse_acknowledgements(self, _: str) -> None: ...

    def acknowledged(self) -> list[str]:
        return []

    def heartbeat_age_s(self) -> float:
        return 0.0


def test_wear_is_told_after_each_brake_application_open_alarms_once_and_health_each_second() -> None:
    pipeline, publisher, begun_s = RecordingPipeline(), NotingPublisher(), time.monotonic()
    pipeline.monitor = SimpleNamespace(open_alarms=tuple)
    pipeline.step = lambda frame: Outputs(None, (), ("a brake application",) if frame.time_s in (2.0, 5.0) else ())
    service = Service(pipeline, publisher, NotingMemory(), open_bus=Buses())
    with running(service):
        for number in range(10):
            service.buses._arrived.put(frame(float(number)))
            until(lambda number=number: service.frames == number + 1)
    assert publisher.told.count("wear") == 3  # and at the start
    assert publisher.told.count("open alarms") == 1
    assert 1 <= publisher.told.count("health") <= (time.monotonic() - begun_s) / service_module.HEALTH_EVERY_S + 1


def test_an_alarm_that_an_earlier_run_has_logged_is_not_logged_again(caplog: pytest.LogCaptureFixture) -> None:
    pipeline, memory = RecordingPipeline(), NotingMemory()
    pipeline.monitor = SimpleNamespace(open_alarms=lambda: (alarm(id="kept"),))
    pipeline.outputs = Outputs(None, (alarm(id="kept"), alarm(id="new")))
    with running(Service(pipeline, None, memory, open_bus=Buses())):
        until(lambda: memory.given)
    assert [message.split(",")[0] for message in caplog.messages] == ["alarm new raised"]


def test_an_alarm_is_logged_when_it_is_raised_graver_and_cleared(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO")
    pipeline, buses = RecordingPipeline(), Buses()
    cleared = alarm(cleared_time_s=1700000009.0)
    warning, graver = alarm(severity=Severity.WARNING), alarm(severity=Severity.ALARM)
    outputs = iter(Outputs(None, (told,)) for told in (warning, warning, graver, graver, cleared))
    note = pipeline.step
    pipeline.step = lambda frame: (note(frame), next(outputs))[1]
    with running(Service(pipeline, open_bus=buses)):
        bus = buses.next()
        for time_s in (1.0, 2.0, 3.0, 4.0, 5.0):
            bus.script.put(frame(time_s))
            pipeline.next(Frame)
    lines = [record.message.split(":")[0] for record in caplog.records if record.message.startswith("alarm")]
    name = "alarm low_adhesion-1700000000000"
    assert lines == [f"{name} raised, severity warning", f"{name} is graver, severity alarm", f"{name} cleared"]


class Systemd:
    """The other end of $NOTIFY_SOCKET, which reads at once: of what nobody reads the kernel keeps ten messages."""

    def __init__(self, listening: socket.socket) -> None:
        self._listening = listening
        self._told: Queue[bytes] = Queue()

    def read(self) -> None:
        while told := self._listening.recv(4096):
            self._told.put(told)

    def stop(self) -> None:
        self._listening.shutdown(socket.SHUT_RD)

    def next(self) -> bytes:
        return next_of(self._told)

    def hears_nothing_more(self) -> bool:
        """For twenty watchdog periods; what came before is passed over."""
        deadline_s = time.monotonic() + PATIENCE_S
        with suppress(Empty):
            while time.monotonic() < deadline_s:
                self._told.get(timeout=2.0)
            return False
        return True


@pytest.fixture
def systemd(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Systemd]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / "notify"))
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))
        monkeypatch.setenv("WATCHDOG_USEC", "100000")
        monkeypatch.setenv("WATCHDOG_PID", str(os.getpid()))
        systemd = Systemd(listening)
        with in_background(systemd.read, systemd.stop, PATIENCE_S):
            yield systemd


def test_systemd_is_told_of_readiness_life_and_the_end(systemd: Systemd) -> None:
    service = Service(RecordingPipeline(), open_bus=Buses())
    with running(service):
        assert systemd.next() == b"READY=1"
        for _ in range(3):
            assert systemd.next().startswith(b"WATCHDOG=1\nSTATUS=0 frames, no estimate yet")
    while (said := systemd.next()).startswith(b"WATCHDOG=1"):
        pass
    assert said == b"STOPPING=1"


def test_systemd_is_not_told_of_an_end_where_a_successor_takes_over(systemd: Systemd) -> None:
    assert Service(RecordingPipeline(), open_bus=Buses()).run(lambda: True)
    notify("the successor's turn")
    told = [systemd.next()]
    while told[-1] != b"the successor's turn":
        told.append(systemd.next())
    assert told[0] == b"READY=1"
    assert b"STOPPING=1" not in told


def test_the_watchdog_starves_when_a_thread_hangs(systemd: Systemd, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service_module, "STUCK_S", 0.5)
    buses, released, hangs = Buses(), threading.Event(), threading.Event()

    def hang(timeout_s: float) -> None:
        hangs.set()
        released.wait(PATIENCE_S)

    with running(Service(RecordingPipeline(), open_bus=buses)):
        assert systemd.next() == b"READY=1"
        buses.next().recv = hang
        assert hangs.wait(PATIENCE_S)
        assert systemd.hears_nothing_more()
        released.set()
        assert systemd.next().startswith(b"WATCHDOG=1")


def test_life_is_told_when_no_file_can_be_opened_any_more(systemd: Systemd) -> None:
    notify("READY=1")
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (0, limits[1]))
    try:
        notify("WATCHDOG=1")
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)
    assert [systemd.next() for _ in range(2)] == [b"READY=1", b"WATCHDOG=1"]


def test_without_systemd_nothing_is_told_and_nothing_fails(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("NOTIFY_SOCKET", raising=False)
    monkeypatch.delenv("WATCHDOG_USEC", raising=False)
    notify("READY=1")
    assert watchdog_s() is None
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "nobody"))
    notify("READY=1")


def test_the_watchdog_of_another_process_is_not_ours(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WATCHDOG_USEC", "3000000")
    monkeypatch.setenv("WATCHDOG_PID", str(os.getpid()))
    assert watchdog_s() == 3.0
    monkeypatch.setenv("WATCHDOG_PID", "1")
    assert watchdog_s() is None


def test_an_abstract_notify_socket_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    name = f"brake-monitor-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(f"\0{name}")
        monkeypatch.setenv("NOTIFY_SOCKET", f"@{name}")
        notify("READY=1", "STATUS=on")
        listening.settimeout(PATIENCE_S)
        assert listening.recv(4096) == b"READY=1\nSTATUS=on"


DAEMON = """
import os, signal, threading, time
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.daemon.bus_reader import TICK_S
from brake_monitor.daemon.service import Service
from brake_monitor.host.stop_signals import stopped_by_signals
from test_service import RecordingPipeline
first = []
def say(outputs):
    if not first:
        first.append(print("running", flush=True))
def handle_slowly(number, frame):
    time.sleep(3 * TICK_S)
    os.write(1, b"handled\\n")  # `print` may be what this one interrupts, and refuses to be begun again
def reload():
    renewed.set()
    service.wake()
signal.signal(signal.SIGUSR1, handle_slowly)
renewed = threading.Event()
with Publisher(ZenohSettings(), "w") as publisher:
    service = Service(RecordingPipeline(), publisher, on_outputs=say)
    with stopped_by_signals(service.stop, reload):
        print("gave way" if service.run(renewed.is_set) else "stopped", flush=True)
print("closed", flush=True)
"""


@pytest.fixture
def daemon() -> Iterator[Python]:
    """One that runs in a process of its own; its bus is silent."""
    with Python(DAEMON) as child:
        yield child


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_ends_the_process_cleanly(daemon: Python, number: signal.Signals) -> None:
    daemon.wait_for("running")
    status, _ = daemon.end(number)
    assert (status, daemon.lines) == (0, ["running", "stopped", "closed"])


@pytest.mark.parametrize(("number", "end"), [(signal.SIGTERM, "stopped"), (signal.SIGHUP, "gave way")])
def test_a_signal_is_obeyed_when_no_frame_comes_and_handling_one_takes_longer_than_the_wait_for_a_frame(
    daemon: Python, number: signal.Signals, end: str
) -> None:
    daemon.wait_for("running")
    daemon.send_signal(signal.SIGUSR1)
    daemon.wait_for("handled")
    status, _ = daemon.end(number)
    assert (status, daemon.lines) == (0, ["running", "handled", end, "closed"])


@pytest.fixture
def interruptible() -> Iterator[None]:
    """As in a terminal; what a shell runs in the background inherits that SIGINT is ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_signals_go_back_to_what_they_were_and_a_second_one_is_not_caught() -> None:
    stops: list[str] = []
    with stopped_by_signals(lambda: stops.append("stop")):
        signal.raise_signal(signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert stops == ["stop"]
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


def test_a_signal_in_the_midst_of_what_holds_a_lock_stops_all_the_same() -> None:
    lock, stopped = threading.Lock(), threading.Event()

    def stop() -> None:
        with lock:
            stopped.set()

    with stopped_by_signals(stop):
        with lock:
            signal.raise_signal(signal.SIGTERM)
        assert stopped.wait(PATIENCE_S)


@pytest.fixture
def fed(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What systemd is told of the state, after each turn of the service."""
    told: list[str] = []
    monkeypatch.setattr(watchdog, "notify", lambda _, status: told.append(status))
    monkeypatch.setattr(watchdog, "STATUS_EVERY_S", 0.0)
    return told


def test_a_publisher_that_hangs_starves_the_watchdog_too(fed: list[str], caplog: pytest.LogCaptureFixture) -> None:
    age_s = [watchdog.STUCK_S + 1.0]
    publisher = SimpleNamespace(
        publish=lambda _: None,
        publish_health=lambda _: None,
        publish_wear=lambda *_: None,
        acknowledged=lambda: [],
        refuse_acknowledgements=lambda _: None,
        heartbeat_age_s=lambda: age_s[0],
    )
    with running(Service(RecordingPipeline(), publisher, open_bus=Buses())):
        until(lambda: "threads without progress for 10 s: Zenoh" in caplog.messages)
        assert fed == []
        age_s[0] = 0.0
        until(lambda: fed)
    assert caplog.messages.count("threads without progress for 10 s: Zenoh") == 1
    assert "threads without progress for 10 s: none any more" in caplog.messages


def test_who_asks_systemd_is_told_the_remark_on_a_configuration(fed: list[str]) -> None:
    service = Service(RecordingPipeline(), open_bus=Buses())
    service.remark = "a new configuration was refused"
    with running(service):
        until(lambda: fed)
    assert fed[0] == "STATUS=0 frames, no estimate yet, a new configuration was refused"


def test_who_asks_systemd_is_told_of_what_fails(fed: list[str]) -> None:
    pipeline, buses = RecordingPipeline(), Buses(ScriptedBus(BusError("gone")), *[BusError("gone")] * 100)
    pipeline.monitor = SimpleNamespace(open_alarms=tuple)
    memory = SimpleNamespace(failing="disk full", has_resumed=True, see=lambda *_: None, finish=lambda: None)
    with running(Service(pipeline, None, memory, open_bus=buses)):
        until(lambda: fed and "down" in fed[-1])
    assert fed[-1] == "STATUS=0 frames, no estimate yet, virtual:a is down, the memory fails"


def test_who_asks_systemd_is_told_how_far_the_daemon_is_behind(fed: list[str]) -> None:
    begun, goes_on = threading.Event(), threading.Event()

    def held(_: Frame) -> Outputs:
        begun.set()
        goes_on.wait(PATIENCE_S)
        return Outputs()

    pipeline, least = RecordingPipeline(), 4000 - FRAMES_PER_TURN  # are not those that the first turn takes
    pipeline.step = held
    service = Service(pipeline, open_bus=Buses(ScriptedBus(*[frame(1.0)] * 4000)))
    with running(service):
        until(lambda: begun.is_set() and service.buses.frames_waiting >= least)
        goes_on.set()
        until(lambda: service.frames == 4000 and fed and "behind" not in fed[-1])
    behind = [int(told.rpartition("behind by ")[2].split()[0]) for told in fed if "behind by" in told]
    assert behind[0] >= least
    assert min(behind) > service_module.MANY_WAITING
