"""The thread that reads one bus and, when the bus fails, opens it again until it works."""

import logging
import threading
import time
from collections.abc import Callable, Sequence
from functools import partial
from queue import SimpleQueue

from brake_monitor.bus.can_source import BusError, LiveBus
from brake_monitor.errors import BrakeMonitorError
from brake_monitor.frame import CanFilter, Frame
from brake_monitor.settings.config import CanBus

TICK_S = 0.1  # longest wait for a frame, hence for a stop and for silence to be noticed
FRAMES_WAITING = 20_000  # two seconds of the busiest bus; beyond it the kernel's buffer fills
REST_S = 0.02  # a kernel that gives a reader little room holds 278 frames, 30 ms of the busiest bus
FRAMES_AT_ONCE = 1000
EARLY_S = 0.01  # before something is due: to take what waits, and for a sleep that lasts too long
REOPEN_FIRST_S = 0.2
REOPEN_LONGEST_S = 2.0

log = logging.getLogger(__name__)

OpenBus = Callable[[CanBus, Sequence[CanFilter]], LiveBus]


class BusReader:
    """Reads one bus into `arrived`; `open` and `start` it, then `finish` when `stopping` is set."""

    def __init__(
        self,
        bus: CanBus,
        filters: Sequence[CanFilter],
        open_bus: OpenBus,
        arrived: SimpleQueue[Frame | None],
        stopping: threading.Event,
        *,
        due_s: Callable[[], float],
    ) -> None:
        """`due_s` tells before which time of capture no frame makes anything due."""
        self.name = bus.name
        self.place = f"{bus.interface}:{bus.channel}"
        self.failures = 0
        self.dropped = 0
        self.down = False
        self._reasons: set[str] = set()  # why it is down, as logged
        self.crash: Exception | None = None  # an error of ours: for the main thread to raise
        self.beat_s = time.monotonic()
        self._open: Callable[[], LiveBus] = partial(open_bus, bus, filters)
        self._bus: LiveBus | None = None
        self._arrived = arrived
        self._stopping = stopping
        self._due_s = due_s
        self._thread = threading.Thread(target=self._run, name=f"bus {bus.name}", daemon=True)

    def open(self) -> None:
        """Open the bus for the first time; errors go to the caller."""
        if self._bus is None:
            self._bus = self._open()

    def open_or_fail(self) -> None:
        """Open the bus if that is possible now; else it counts as failed, and `start` goes on trying."""
        try:
            self.open()
        except BusError as error:
            self._note_failure(error)

    def start(self) -> None:
        """Read from now on, in a thread of its own."""
        self.beat_s = time.monotonic()
        self._thread.start()

    def finish(self) -> None:
        """Wait for the thread, and close the bus."""
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
        """Wait for frames and pass them on; False when the bus is down."""
        frames: list[Frame] = []
        try:
            if self._bus is None:
                self._bus = self._open()
            self._take(self._bus, frames)
        except BrakeMonitorError as error:
            self._note_failure(error)
            if self._bus is not None:
                self._bus.close()
                self._bus = None
        else:
            self._note_success()
        for frame in frames:
            if self._has_room():
                self._arrived.put(frame)
            else:
                self.dropped += 1
        return self._bus is not None

    def _take(self, bus: LiveBus, frames: list[Frame]) -> None:
        """Wait for the next frame or, while nothing is due, let some gather: waking two threads costs more than one.

        What has gathered is handed on REST_S before something is due, and what comes until then when it is: little is
        left to be done at that time.
        """
        before, until_s = bus.dropped, time.monotonic() + TICK_S
        try:
            left_s = self._left_s(bus)
            while left_s > REST_S and time.monotonic() < until_s and self._rest(left_s - REST_S):
                self._fetch(bus, frames, FRAMES_AT_ONCE)
                left_s = self._left_s(bus)
            if frames:
                return
            if left_s > 0.0:
                self._rest(left_s)
                self._fetch(bus, frames, FRAMES_AT_ONCE)
            else:
                self._fetch(bus, frames, 1, TICK_S)
        finally:
            self.dropped += bus.dropped - before

    def _left_s(self, bus: LiveBus) -> float:
        """For how long frames may gather."""
        return self._due_s() - EARLY_S - time.time() if bus.keeps_time else 0.0

    def _rest(self, longest_s: float) -> bool:
        """Rest for as long as the kernel certainly has room; False at the end."""
        return not self._stopping.wait(min(longest_s, REST_S))

    @staticmethod
    def _fetch(bus: LiveBus, frames: list[Frame], most: int, timeout_s: float = 0.0) -> None:
        """Take at most so many frames more, and wait for each no longer."""
        for _ in range(most):
            frame = bus.recv(timeout_s)
            if frame is None:
                return
            frames.append(frame)

    def _has_room(self) -> bool:
        """Wait until there is room for a frame; False at the end."""
        while self._arrived.qsize() >= FRAMES_WAITING:
            if self._stopping.wait(TICK_S):
                return False
        return True

    def _note_success(self) -> None:
        if self.down:
            self.down = False
            self._reasons.clear()
            log.info("%s is back", self.place)

    def _note_failure(self, error: BrakeMonitorError) -> None:
        if not self.down:
            self.down = True
            self.failures += 1
        if str(error) not in self._reasons:
            self._reasons.add(str(error))
            log.warning("%s; it is opened anew until it works", error)
