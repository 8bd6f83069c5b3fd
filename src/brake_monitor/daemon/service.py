"""The daemon around the pipeline: threads, time and systemd.

One thread per bus reads and, when the bus fails, opens it anew; the main thread runs the pipeline; the publisher has
a thread of its own. What has no frames still has time: the pipeline is told of it, so that silence is published.
"""

import logging
import threading
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from queue import Empty, SimpleQueue

from brake_monitor.bus.can_source import open_bus
from brake_monitor.daemon.bus_reader import TICK_S, BusReader, OpenBus
from brake_monitor.daemon.capture_order import CaptureOrder
from brake_monitor.daemon.clocks import CaptureTime, SystemClock
from brake_monitor.daemon.sd_notify import notify, watchdog_s
from brake_monitor.frame import Frame
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.publishing.health import intake_of
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.config import Settings
from brake_monitor.storage.memory import Memory

FRAMES_PER_TURN = 1000
MANY_WAITING = 1000
STATUS_EVERY_S = 5.0
HEALTH_EVERY_S = 1.0
FINISH_S = 0.5  # at the end, for what has arrived
STUCK_S = 10.0  # a thread that completed no turn for as long hangs

log = logging.getLogger(__name__)


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
        gives_way: Callable[[], bool] = lambda: False,
    ) -> None:
        """`gives_way` is asked in every turn: whether a successor with another configuration is to take over now."""
        self.frames = 0
        self.remark = ""  # for systemd's status
        self._pipeline = pipeline
        self._wear = settings.wear
        self._publisher = publisher
        self._on_outputs = on_outputs
        self._memory = memory
        self._gives_way = gives_way
        self._stopping = threading.Event()
        self._arrived: SimpleQueue[Frame | None] = SimpleQueue()  # quicker than a queue that has a bound
        ways = open_bus, self._arrived, self._stopping
        is_alone = len(settings.can) == 1  # frames of several buses are put in order as they come: none may wait
        self._readers = [
            BusReader(
                bus,
                pipeline.decoder.can_filters(bus.name),
                *ways,
                due_s=lambda: pipeline.due_s if is_alone else 0.0,
            )
            for bus in settings.can
        ]
        self._order = CaptureOrder(len(self._readers))
        self._capture_time = CaptureTime()
        self._clock = SystemClock()
        self._told_s = time.monotonic()  # when the pipeline last gave out an estimate or was told the time
        self._status = "no estimate yet"
        self._status_due_s = self._health_due_s = 0.0
        self._status_every_s = min(STATUS_EVERY_S, (watchdog_s() or STATUS_EVERY_S) / 3)
        self._hanging: list[str] = []
        self._dropped_told = 0
        self._logged_alarms = {alarm.id: alarm.severity for alarm in pipeline.monitor.open_alarms()} if memory else {}
        self._given: list[Outputs] = []  # in this turn
        self._open_alarms_told = False
        self._wear_is_due = True  # to be published
        self._wear_news_told = 0  # as `Memory` counts them

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
        self.wake()

    def wake(self) -> None:
        """Have `run` look around now: to be called after each signal, from any thread.

        Until Python 3.13 a queue waits for ever where a signal is handled while the time that it waits for runs out.
        """
        self._arrived.put(None)

    def open(self, *, may_fail: bool = False) -> None:
        """Open the buses; InputError or WorkError when one cannot be, unless it may fail now as it may later."""
        for reader in self._readers:
            if may_fail:
                reader.open_or_fail()
            else:
                reader.open()

    def run(self) -> bool:
        """Open the buses unless that was tried, listen until `stop`, close them; the publisher is the caller's to open.

        Returns whether it gave way to a successor.
        """
        gave_way = False
        with ExitStack() as stack:
            for reader in self._readers:
                if not reader.down:
                    reader.open()
                stack.callback(reader.finish)
            stack.callback(lambda: None if gave_way else notify("STOPPING=1"))
            stack.callback(self._stopping.set)
            for reader in self._readers:
                reader.start()
            notify("READY=1")
            log.info("listening on %s", ", ".join(reader.place for reader in self._readers))
            if self._publisher is not None:
                self._tell_wear(self._publisher)
                self._tell_open_alarms(self._publisher)
            while not (self._stopping.is_set() or gave_way):
                self._turn()
                self._show_health()
                gave_way = self._gives_way()
        self._finish()
        log.info("stopped after %d frames, %d bus failures", self.frames, self.bus_failures)
        return gave_way

    def _finish(self) -> None:
        """Take what arrived and was accepted until the buses were closed; a machine that is far behind leaves some."""
        if self._publisher is not None:
            self._publisher.refuse_acknowledgements()
        until_s = time.monotonic() + FINISH_S
        self._turn()
        while (waiting := self._arrived.qsize() + self._order.held) and time.monotonic() < until_s:
            self._turn()
        if waiting:
            log.warning("%d frames that had arrived are given up", waiting)
        if self._memory is not None:
            self._memory.finish(self._pipeline)

    def _turn(self) -> None:
        """Take what arrived, or notice that nothing did."""
        frames = self._take()
        self._clock.look()
        for frame in frames:
            if set_by_s := self._clock.set_by_s(frame.time_s):
                self._note_clock_set(set_by_s)
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
            if not (frames or self._order.held):
                self._look_at_clock()
            self._give_out(self._pipeline.advance(self._capture_time.now_s()))
        if self._publisher is not None:
            self._serve(self._publisher)
        if self._memory is not None:
            given, self._given = self._given, []
            self._memory.see(self._pipeline, frames, given, self._capture_time.now_s())

    def _tell_wear(self, publisher: Publisher) -> None:
        """Tell of the pads when something has changed; not as of new ones while a late disk may know better."""
        if self._memory is not None:
            if not self._memory.has_resumed:
                return
            self._wear_is_due |= self._memory.wear_news != self._wear_news_told
            self._wear_news_told = self._memory.wear_news
        if self._wear_is_due:
            self._wear_is_due = False
            publisher.publish_wear(self._pipeline.brake_book.brakes, self._wear)

    def _look_at_clock(self) -> None:
        """Note in a silence what no frame shows: that the clock was set."""
        if set_by_s := self._clock.set_in_silence_by_s(self._capture_time.now_s()):
            self._note_clock_set(set_by_s)
            self._capture_time.clock_set(set_by_s)

    def _note_clock_set(self, by_s: float) -> None:
        log.warning("the clock was set by %+.1f s", by_s)
        self._pipeline.clock_set(by_s)

    def _tell_open_alarms(self, publisher: Publisher) -> None:
        """Tell once which are open as soon as what was kept is known, which may be late when the disk is."""
        if self._memory is not None and self._memory.has_resumed and not self._open_alarms_told:
            self._open_alarms_told = True
            publisher.publish_open_alarms(self._pipeline.monitor.open_alarms())

    def _serve(self, publisher: Publisher) -> None:
        """Do what remote parties may ask for, and tell how we do."""
        self._tell_wear(publisher)
        self._tell_open_alarms(publisher)
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
        arrived: list[Frame | None] = []
        with suppress(Empty):
            arrived.append(self._arrived.get(timeout=self._order.wait_s(TICK_S)))
            while len(arrived) < FRAMES_PER_TURN:
                arrived.append(self._arrived.get_nowait())
        now_s = time.monotonic()
        for frame in arrived:
            if frame is not None:
                self._order.put(frame, now_s)
        return self._order.take(now_s)

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
        self._wear_is_due |= bool(outputs.stops)
        if self._on_outputs is not None:
            self._on_outputs(outputs)
        if self._memory is not None:
            self._given.append(outputs)

    def _log_alarm(self, alarm: Alarm) -> None:
        """Log what a person would act on: not each update of what is known."""
        logged = self._logged_alarms.get(alarm.id)
        if alarm.cleared_time_s is not None:
            self._logged_alarms.pop(alarm.id, None)
            log.info("alarm %s cleared: %s", alarm.id, alarm.message)
        elif logged != alarm.severity:
            self._logged_alarms[alarm.id] = alarm.severity
            what = "raised" if logged is None else "is graver"
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
            if (waiting := self._arrived.qsize()) > MANY_WAITING:
                down.append(f"behind by {waiting} frames")
            if self._memory is not None and self._memory.failing:
                down.append("the memory fails")
            if self.remark:
                down.append(self.remark)
            notify("WATCHDOG=1", f"STATUS={', '.join((f'{self.frames} frames', self._status, *down))}")
