"""All buses of a vehicle: each is read by a thread of its own; their frames come in the order of their capture."""

import logging
import threading
import time
from collections.abc import Iterable
from contextlib import suppress
from queue import Empty, SimpleQueue

from brake_monitor.daemon.bus_reader import TICK_S, BusReader, OpenBus
from brake_monitor.daemon.capture_order import CaptureOrder
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline

FRAMES_PER_TURN = 1000

log = logging.getLogger(__name__)


class Buses:
    """`open` and `start` them, `take` what they give, then `stop` and `finish`."""

    def __init__(self, pipeline: Pipeline, open_bus: OpenBus) -> None:
        """The buses of the pipeline's settings; of their frames only those that the pipeline maps."""
        configured = pipeline.settings.can
        is_alone = len(configured) == 1  # frames of several buses are put in order as they come: none may wait
        self._arrived: SimpleQueue[Frame | None] = SimpleQueue()  # quicker than a queue that has a bound; None: wake up
        self._stopping = threading.Event()
        self._readers = [
            BusReader(
                bus,
                pipeline.decoder.can_filters(bus.name),
                open_bus,
                self._arrived,
                self._stopping,
                due_s=lambda: pipeline.due_s if is_alone else 0.0,
            )
            for bus in configured
        ]
        self._unfinished = list(self._readers)
        self._order = CaptureOrder(len(configured))
        self._told_down = dict.fromkeys((bus.name for bus in configured), False)

    def open(self, *, may_fail: bool = False) -> None:
        """Open them; InputError or WorkError when one cannot be, unless it may fail now as it may later."""
        for reader in self._readers:
            if may_fail:
                reader.open_or_fail()
            else:
                reader.open()

    def start(self) -> None:
        """Listen from now on; open them before unless that was tried."""
        for reader in self._readers:
            if not reader.down:
                reader.open()
        for reader in self._readers:
            reader.start()
        log.info("listening on %s", ", ".join(reader.place for reader in self._readers))

    def stop(self) -> None:
        """Listen no more; from any thread. What has arrived can still be taken."""
        self._stopping.set()
        self.wake()

    def wake(self) -> None:
        """Have `take` return now; from any thread."""
        self._arrived.put(None)

    def finish(self) -> None:
        """Close them; a second call does nothing."""
        self._stopping.set()
        while self._unfinished:
            self._unfinished.pop().finish()

    def take(self) -> list[Frame]:
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

    def changes(self) -> Iterable[tuple[str, bool]]:
        """Names of the buses that went down (True) or work again (False) since the last call."""
        down = {reader.name: reader.down for reader in self._readers}
        changed, self._told_down = down.items() - self._told_down.items(), down
        return changed

    def raise_crash(self) -> None:
        """Raise what has ended one of the threads."""
        for reader in self._readers:
            if reader.crash is not None:
                raise reader.crash

    def hanging(self, longest_s: float) -> list[str]:
        """The places of those whose threads have completed no turn for longer."""
        now_s = time.monotonic()
        return [reader.place for reader in self._readers if now_s - reader.beat_s > longest_s]

    def were_read_since(self, time_s: float) -> bool:
        """Whether the threads of all that work have completed a turn since then, by the clock that nobody sets."""
        return all(reader.down or reader.beat_s >= time_s for reader in self._readers)

    @property
    def is_stopping(self) -> bool:
        """Whether `stop` was called."""
        return self._stopping.is_set()

    @property
    def frames_waiting(self) -> int:
        """How many frames have arrived and are not yet put in order."""
        return self._arrived.qsize()

    @property
    def frames_held(self) -> int:
        """How many frames are held back until no bus can give an earlier one."""
        return self._order.held

    @property
    def failures(self) -> int:
        """How often a bus failed while it was listened to."""
        return sum(reader.failures for reader in self._readers)

    @property
    def dropped_frames(self) -> int:
        """How many frames the kernel dropped because they were not fetched in time."""
        return sum(reader.dropped for reader in self._readers)

    @property
    def down(self) -> tuple[str, ...]:
        """The places of those that do not work."""
        return tuple(reader.place for reader in self._readers if reader.down)
