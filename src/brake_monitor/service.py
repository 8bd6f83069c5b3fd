"""The daemon around the pipeline: threads, time, signals and systemd.

One thread per bus reads and, when the bus fails, opens it anew; the main thread runs the pipeline; the publisher has
a thread of its own. What has no frames still has time: the pipeline is told of it, so that silence is published.
"""

import logging
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from functools import partial
from queue import Empty, Full, Queue
from types import FrameType

from brake_monitor.can_filter import CanFilter
from brake_monitor.can_source import LiveBus, open_bus
from brake_monitor.config import CanBus, Settings
from brake_monitor.errors import BrakeMonitorError
from brake_monitor.frame import Frame
from brake_monitor.health import intake_of
from brake_monitor.memory import Memory
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.publisher import Publisher
from brake_monitor.sd_notify import notify, watchdog_s

TICK_S = 0.1  # longest wait for a frame, hence for a stop and for silence to be noticed
FRAMES_WAITING = 20_000  # two seconds of the busiest bus; beyond it the kernel's buffer fills
FRAMES_PER_TURN = 1000
UNDERWAY_S = 0.04  # a captured frame may take as long to get here; time that is told stays that much behind
REOPEN_FIRST_S = 0.2
REOPEN_LONGEST_S = 2.0
STATUS_EVERY_S = 5.0
HEALTH_EVERY_S = 1.0
STUCK_S = 10.0  # a thread that completed no turn for as long hangs

log = logging.getLogger(__name__)

OpenBus = Callable[[CanBus, Sequence[CanFilter]], LiveBus]


class Service:
    """Listens until `stop`; everything that comes out of the pipeline goes to the publisher and to `on_outputs`."""

    def __init__(
        self,
        settings: Settings,
        pipeline: Pipeline,
        publisher: Publisher | None = None,
        on_outputs: Callable[[Outputs], None] | None = None,
        open_bus: OpenBus = open_bus,
        *,
        memory: Memory | None = None,
    ) -> None:
        self.frames = 0
        self._pipeline = pipeline
        self._wear = settings.wear
        self._publisher = publisher
        self._on_outputs = on_outputs
        self._memory = memory
        self._stopping = threading.Event()
        self._arrived: Queue[Frame] = Queue(FRAMES_WAITING)
        self._readers = [
            _Reader(bus, pipeline.decoder.can_filters(bus.name), open_bus, self._arrived, self._stopping)
            for bus in settings.can
        ]
        self._capture_time = _CaptureTime()
        self._told_s = time.monotonic()  # when the pipeline last gave out an estimate or was told the time
        self._status = "no estimate yet"
        self._status_due_s = self._health_due_s = 0.0
        self._status_every_s = min(STATUS_EVERY_S, (watchdog_s() or STATUS_EVERY_S) / 3)
        self._hanging: list[str] = []
        self._dropped_told = 0
        self._open_alarms = {alarm.id for alarm in pipeline.monitor.open_alarms()} if memory else set()
        self._given: list[Outputs] = []  # in this turn

    @property
    def bus_failures(self) -> int:
        """How often a bus failed while it was listened to."""
        return sum(reader.failures for reader in self._readers)

    @property
    def dropped_frames(self) -> int:
        """How many frames the kernel had no room for because they were not fetched in time."""
        return sum(reader.dropped for reader in self._readers)

    def stop(self) -> None:
        """End `run` soon; from any thread or signal handler."""
        self._stopping.set()

    def open(self) -> None:
        """Open the buses; InputError or WorkError when one cannot be. Later one may fail and come back."""
        for reader in self._readers:
            reader.open()

    def run(self) -> None:
        """Open the buses unless they are, listen until `stop`, close them; the publisher is the caller's to open."""
        with ExitStack() as stack:
            for reader in self._readers:
                reader.open()
                stack.callback(reader.finish)
            stack.callback(notify, "STOPPING=1")
            stack.callback(self._stopping.set)
            for reader in self._readers:
                reader.start()
            notify("READY=1")
            log.info("listening on %s", ", ".join(reader.place for reader in self._readers))
            if self._publisher is not None:
                self._publisher.publish_wear(self._pipeline.brake_book.brakes, self._wear)
            while not self._stopping.is_set():
                self._turn()
                self._show_health()
            if self._memory is not None:
                self._memory.finish(self._pipeline)
        log.info("stopped after %d frames, %d bus failures", self.frames, self.bus_failures)

    def _turn(self) -> None:
        """Take what arrived, or notice that nothing did."""
        frames = self._take()
        for frame in frames:
            self._give_out(self._pipeline.step(frame))
        if frames:
            self.frames += len(frames)
            self._capture_time.set(frames[-1].time_s)
        for reader in self._readers:
            if reader.down != reader.told_down:
                reader.told_down = reader.down
                self._pipeline.bus_down(reader.name, reader.told_down)
        if time.monotonic() - self._told_s >= TICK_S:
            self._told_s = time.monotonic()
            self._give_out(self._pipeline.advance(self._capture_time.now_s()))
        if self._publisher is not None:
            self._serve(self._publisher)
        if self._memory is not None:
            given, self._given = self._given, []
            self._memory.see(self._pipeline, frames, given, self._capture_time.now_s())

    def _serve(self, publisher: Publisher) -> None:
        """Do what remote parties may ask for, and tell how we do."""
        for alarm_id in publisher.acknowledged():
            log.info("alarm %r acknowledged over Zenoh", alarm_id)
            self._give_out(self._pipeline.acknowledge(alarm_id, self._capture_time.now_s()))
        now_s = time.monotonic()
        if now_s >= self._health_due_s:
            self._health_due_s = now_s + HEALTH_EVERY_S
            down = tuple(reader.place for reader in self._readers if reader.down)
            publisher.publish_health(
                intake_of(self._pipeline, down, self.bus_failures, self._arrived.qsize(), self.dropped_frames)
            )

    def _take(self) -> list[Frame]:
        """Wait for a frame and take those that are there as well, in the order of their capture."""
        frames: list[Frame] = []
        with suppress(Empty):
            frames.append(self._arrived.get(timeout=TICK_S))
            while len(frames) < FRAMES_PER_TURN:
                frames.append(self._arrived.get_nowait())
        if len(self._readers) > 1:
            frames.sort(key=lambda frame: frame.time_s)
        return frames

    def _give_out(self, outputs: Outputs) -> None:
        if outputs is NOTHING:
            return
        if outputs.estimate is not None:
            self._told_s = time.monotonic()
            self._status = ", ".join((f"estimate {outputs.estimate.status}", *outputs.estimate.reasons))
        for alarm in outputs.alarms:
            self._log_alarm(alarm)
        if self._publisher is not None:
            self._publisher.publish(outputs)
            if outputs.stops:
                self._publisher.publish_wear(self._pipeline.brake_book.brakes, self._wear)
        if self._on_outputs is not None:
            self._on_outputs(outputs)
        if self._memory is not None:
            self._given.append(outputs)

    def _log_alarm(self, alarm: Alarm) -> None:
        if alarm.cleared_time_s is not None:
            self._open_alarms.discard(alarm.id)
            log.info("alarm %s cleared: %s", alarm.id, alarm.message)
        else:
            what = "still open" if alarm.id in self._open_alarms else "raised"
            self._open_alarms.add(alarm.id)
            log.warning("alarm %s %s, severity %s: %s", alarm.id, what, alarm.severity, alarm.message)

    def _show_health(self) -> None:
        """Feed the watchdog when every thread has made progress, and raise what ended one."""
        for reader in self._readers:
            if reader.crash is not None:
                raise reader.crash
        now_s = time.monotonic()
        if now_s < self._status_due_s:
            return
        self._status_due_s = now_s + self._status_every_s
        hanging = [reader.place for reader in self._readers if now_s - reader.beat_s > STUCK_S]
        if self._publisher is not None and self._publisher.heartbeat_age_s() > STUCK_S:
            hanging.append("Zenoh")
        if hanging != self._hanging:
            self._hanging = hanging
            log.warning("threads without progress for %.0f s: %s", STUCK_S, ", ".join(hanging) or "none any more")
        dropped = self.dropped_frames
        if dropped > self._dropped_told:
            log.warning("the kernel dropped %d frames: this machine is too slow", dropped - self._dropped_told)
            self._dropped_told = dropped
        if not hanging:
            down = [f"{reader.place} is down" for reader in self._readers if reader.down]
            if self._memory is not None and self._memory.failing:
                down.append("the memory fails")
            notify("WATCHDOG=1", f"STATUS={', '.join((f'{self.frames} frames', self._status, *down))}")


class _CaptureTime:
    """The time as it would be stamped on a frame captured now, whatever clock the bus stamps with.

    It runs on from the last frame with the monotonic clock; before the first it is the wall clock, as in the kernel.
    """

    def __init__(self) -> None:
        self.set(time.time())

    def set(self, time_s: float) -> None:
        self._offset_s = time_s - time.monotonic()
        self._newest_s = time_s

    def now_s(self) -> float:
        """Never before the newest frame, and behind by what may still be underway."""
        return max(self._newest_s, time.monotonic() + self._offset_s - UNDERWAY_S)


class _Reader:
    """The thread that reads one bus; `open` and `start` it, then `finish` when `stopping` is set."""

    def __init__(
        self,
        bus: CanBus,
        filters: Sequence[CanFilter],
        open_bus: OpenBus,
        arrived: Queue[Frame],
        stopping: threading.Event,
    ) -> None:
        self.name = bus.name
        self.place = f"{bus.interface}:{bus.channel}"
        self.failures = 0
        self.dropped = 0
        self.down = False
        self.told_down = False  # what the pipeline knows of it
        self._reasons: set[str] = set()  # why it is down, as logged
        self.crash: Exception | None = None  # an error of ours: for the main thread to raise
        self.beat_s = time.monotonic()
        self._open: Callable[[], LiveBus] = partial(open_bus, bus, filters)
        self._bus: LiveBus | None = None
        self._arrived = arrived
        self._stopping = stopping
        self._thread = threading.Thread(target=self._run, name=f"bus {bus.name}", daemon=True)

    def open(self) -> None:
        """Open the bus for the first time; what is wrong with it is the caller's."""
        if self._bus is None:
            self._bus = self._open()

    def start(self) -> None:
        self.beat_s = time.monotonic()
        self._thread.start()

    def finish(self) -> None:
        if self._thread.ident is not None:
            self._thread.join(timeout=1.0)
        if self._bus is not None and not self._thread.is_alive():
            self._bus.close()

    def _run(self) -> None:
        try:
            wait_s = REOPEN_FIRST_S
            while not self._stopping.is_set():
                if self._read():
                    wait_s = REOPEN_FIRST_S
                else:
                    self._stopping.wait(wait_s)
                    wait_s = min(2 * wait_s, REOPEN_LONGEST_S)
                self.beat_s = time.monotonic()
        except Exception as error:  # noqa: BLE001 - not lost: the main thread raises it
            self.crash = error

    def _read(self) -> bool:
        """Wait for the next frame and pass it on; False when the bus is down."""
        try:
            if self._bus is None:
                self._bus = self._open()
            before = self._bus.dropped
            frame = self._bus.recv(TICK_S)
            self.dropped += self._bus.dropped - before
        except BrakeMonitorError as error:
            if not self.down:
                self.down = True
                self.failures += 1
            if str(error) not in self._reasons:
                self._reasons.add(str(error))
                log.warning("%s; it is opened anew until it works", error)
            if self._bus is not None:
                self._bus.close()
                self._bus = None
            return False
        if self.down:
            self.down = False
            self._reasons.clear()
            log.info("%s is back", self.place)
        while frame is not None and not self._stopping.is_set():
            try:
                self._arrived.put(frame, timeout=TICK_S)
            except Full:
                continue
            break
        return True


@contextmanager
def stopped_by_signals(stop: Callable[[], None]) -> Iterator[None]:
    """Call `stop` at the first SIGTERM or SIGINT; a second one does what it does by default. Main thread only."""
    previous = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT)}

    def handle(number: int, _frame: FrameType | None) -> None:
        log.info("%s: stopping", signal.Signals(number).name)
        signal.signal(number, previous[signal.Signals(number)])
        stop()

    for number in previous:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
