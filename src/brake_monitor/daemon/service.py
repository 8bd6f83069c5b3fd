"""The daemon around the pipeline: threads, time and systemd.

One thread per bus reads and, when the bus fails, opens it anew; the main thread runs the pipeline; the publisher and
the memory have threads of their own. What has no frames still has time: the pipeline is told of it, so that silence is
published.
"""

import logging
import time
from collections.abc import Callable
from contextlib import ExitStack
from math import inf

from brake_monitor.bus.can_source import open_bus
from brake_monitor.daemon.alarm_log import AlarmLog
from brake_monitor.daemon.bus_reader import TICK_S, OpenBus
from brake_monitor.daemon.buses import Buses
from brake_monitor.daemon.frame_clock import FrameClock
from brake_monitor.daemon.sd_notify import notify
from brake_monitor.daemon.watchdog import STUCK_S, Watchdog
from brake_monitor.plural import plural
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.publishing.health import intake_of
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.storage.memory import Memory

MANY_WAITING = 1000
HEALTH_EVERY_S = 1.0
FINISH_S = 0.5  # at the end, for what has arrived
STOOD_STILL_S = 0.3  # a turn that lasts longer: the machine was paused, or has no time for us ...
LOOKS_S = 1.0  # ... and its readers may take so long to look at what came meanwhile

log = logging.getLogger(__name__)


class Service:
    """Listens until `stop`; everything that comes out of the pipeline goes to the publisher and to `on_outputs`."""

    def __init__(
        self,
        pipeline: Pipeline,
        publisher: Publisher | None = None,
        memory: Memory | None = None,
        *,
        on_outputs: Callable[[Outputs], None] = lambda outputs: None,
        open_bus: OpenBus = open_bus,
    ) -> None:
        self.frames = 0
        self.remark = ""  # for systemd's status
        self.buses = Buses(pipeline, open_bus)
        self._pipeline = pipeline
        self._publisher = publisher
        self._memory = memory
        self._on_outputs = on_outputs
        self._clock = FrameClock()
        self._watchdog = Watchdog()
        self._alarm_log = AlarmLog(pipeline.monitor.open_alarms() if memory else ())
        self._told_s = time.monotonic()  # when the pipeline last gave out an estimate or was told the time
        self._turned_s = self._told_s
        self._went_on_s = -inf  # when this machine last had stood still, and went on
        self._status = "no estimate yet"
        self._health_due_s = 0.0
        self._given: list[Outputs] = []  # in this turn
        self._open_alarms_told = False
        self._wear_is_due = True  # to be published
        self._wear_news_told = 0  # as `Memory` counts them

    def stop(self) -> None:
        """End `run` soon; from any thread or signal handler."""
        self.buses.stop()

    def wake(self) -> None:
        """Have `run` look around now: to be called after each signal, from any thread.

        Until Python 3.13 a queue waits for ever where a signal is handled while the time that it waits for runs out.
        """
        self.buses.wake()

    def run(self, gives_way: Callable[[], bool] = lambda: False) -> bool:
        """Listen until `stop`, from opening the buses to closing them; the publisher is the caller's to open.

        `gives_way` is asked in every turn: whether a successor with another configuration is to take over now. Returns
        whether it does.
        """
        gave_way = False
        with ExitStack() as stack:
            stack.callback(self.buses.finish)
            self.buses.start()
            stack.callback(lambda: None if gave_way else notify("STOPPING=1"))
            notify("READY=1")
            while not (self.buses.is_stopping or gave_way):
                self._turn()
                self._show_life()
                gave_way = gives_way()
        self._finish()
        log.info("stopped after %d frames, %d bus failures", self.frames, self.buses.failures)
        return gave_way

    def _finish(self) -> None:
        """Take what arrived and was accepted until the buses were closed; a machine that is far behind leaves some."""
        if self._publisher is not None:
            self._publisher.refuse_acknowledgements("the daemon is about to end or to begin anew; try again later")
        until_s = time.monotonic() + FINISH_S
        self._turn()
        while (waiting := self.buses.frames_waiting + self.buses.frames_held) and time.monotonic() < until_s:
            self._turn()
        if waiting:
            log.warning("%d frames that had arrived are given up", waiting)
        if self._memory is not None:
            self._memory.finish()

    def _turn(self) -> None:
        """Take what arrived, or notice that nothing did."""
        frames = self.buses.take()
        self._clock.look()
        for frame in frames:
            if set_by_s := self._clock.set_by_s(frame.time_s):
                self._note_clock_set(set_by_s)
            self._give_out(self._pipeline.step(frame))
        if frames:
            self.frames += len(frames)
            self._clock.captured(frames[-1].time_s)
        for name, is_down in self.buses.changes():
            self._pipeline.bus_down(name, is_down)
        if self._knows_of_silence() and time.monotonic() - self._told_s >= TICK_S:
            self._told_s = time.monotonic()
            is_silent = not (frames or self.buses.frames_held)
            if is_silent and (set_by_s := self._clock.set_in_silence_by_s()):
                self._note_clock_set(set_by_s)
            self._give_out(self._pipeline.advance(self._clock.now_s()))
        if self._publisher is not None:
            self._serve(self._publisher)
        if self._memory is not None:
            given, self._given = self._given, []
            self._memory.see(frames, given, self._clock.now_s())

    def _knows_of_silence(self) -> bool:
        """Whether nothing waits unseen that came while this machine stood still; to be asked in every turn."""
        now_s = time.monotonic()
        if now_s - self._turned_s > STOOD_STILL_S:
            self._went_on_s = now_s
        self._turned_s = now_s
        return self.buses.were_read_since(self._went_on_s) or now_s - self._went_on_s > LOOKS_S

    def _note_clock_set(self, by_s: float) -> None:
        log.warning("the clock was set by %+.1f s", by_s)
        self._pipeline.clock_set(by_s)

    def _give_out(self, outputs: Outputs) -> None:
        if outputs is NOTHING:
            return
        if outputs.estimate is not None:
            self._told_s = time.monotonic()
            self._status = ", ".join((f"estimate {outputs.estimate.status}", *outputs.estimate.reasons))
        for alarm in outputs.alarms:
            self._alarm_log.see(alarm)
        if self._publisher is not None:
            self._publisher.publish(outputs)
        self._wear_is_due |= bool(outputs.applications)
        self._on_outputs(outputs)
        if self._memory is not None:
            self._given.append(outputs)

    # -- what the publisher is told besides --------------------------------------------------------------------

    def _serve(self, publisher: Publisher) -> None:
        """Do what remote parties may ask for, and tell how we do."""
        self._tell_wear(publisher)
        self._tell_open_alarms(publisher)
        for alarm_id in publisher.acknowledged():
            log.info("alarm %r acknowledged over Zenoh", alarm_id)
            self._give_out(self._pipeline.acknowledge(alarm_id, self._clock.now_s()))
        now_s = time.monotonic()
        if now_s >= self._health_due_s:
            self._health_due_s = now_s + HEALTH_EVERY_S
            buses = self.buses
            publisher.publish_health(
                intake_of(self._pipeline, buses.down, buses.failures, buses.frames_waiting, buses.dropped_frames)
            )

    def _tell_wear(self, publisher: Publisher) -> None:
        """Tell of the pads when something has changed; not as of new ones while a late disk may know better."""
        if self._memory is not None:
            if not self._memory.has_resumed:
                return
            self._wear_is_due |= self._memory.wear_news != self._wear_news_told
            self._wear_news_told = self._memory.wear_news
        if self._wear_is_due:
            self._wear_is_due = False
            publisher.publish_wear(self._pipeline.brake_book.brakes, self._pipeline.settings.wear)

    def _tell_open_alarms(self, publisher: Publisher) -> None:
        """Tell once which are open as soon as what was kept is known, which may be late when the disk is."""
        if self._memory is not None and self._memory.has_resumed and not self._open_alarms_told:
            self._open_alarms_told = True
            publisher.publish_open_alarms(self._pipeline.monitor.open_alarms())

    # -- what systemd is told ----------------------------------------------------------------------------------

    def _show_life(self) -> None:
        """Feed the watchdog when every thread has made progress, and raise what ended one."""
        self.buses.raise_crash()
        if not self._watchdog.is_due():
            return
        hanging = self.buses.hanging(STUCK_S)
        if self._publisher is not None and self._publisher.heartbeat_age_s() > STUCK_S:
            hanging.append("Zenoh")
        self._watchdog.feed(hanging, self._state())
        self._watchdog.note_dropped(self.buses.dropped_frames)

    def _state(self) -> list[str]:
        """What a person who asks systemd should know."""
        state = [plural(self.frames, "frame"), self._status, *(f"{place} is down" for place in self.buses.down)]
        if (waiting := self.buses.frames_waiting) > MANY_WAITING:
            state.append(f"behind by {waiting} frames")
        if self._memory is not None and self._memory.failing:
            state.append("the memory fails")
        return [*state, self.remark] if self.remark else state
