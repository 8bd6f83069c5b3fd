"""Frames of several buses in the order of their capture: the threads that read them know nothing of each other."""

import logging
from math import inf

from brake_monitor.frame import Frame

PATIENCE_S = 0.05  # for a bus that gives nothing; the others' frames wait no longer for it
CLOCK_SET_S = 0.5  # a bus whose time goes back by more has had its clock set
LONGEST_HELD_S = 0.5  # longer only where buses are stamped by different clocks
MOST_HELD = 20_000

log = logging.getLogger(__name__)


class CaptureOrder:
    """Holds a frame back until no bus can give an earlier one. With one bus nothing is held."""

    def __init__(self, bus_count: int) -> None:
        self._bus_count = bus_count
        self._held: list[tuple[Frame, float]] = []  # and when it arrived
        self._free: list[Frame] = []
        self._newest: dict[str, tuple[float, float]] = {}  # of each bus: capture time, and when it arrived
        self._clocks_differ = False

    @property
    def held(self) -> int:
        """How many frames are held back."""
        return len(self._held)

    def put(self, frame: Frame, now_s: float) -> None:
        """A frame arrives; `now_s` is of a clock that nobody sets."""
        if self._bus_count == 1:
            self._free.append(frame)
            return
        newest_s, _ = self._newest.get(frame.bus, (frame.time_s, now_s))
        if frame.time_s < newest_s - CLOCK_SET_S or len(self._held) >= MOST_HELD:
            self._release(inf)
            self._newest = {}
        self._held.append((frame, now_s))
        self._newest[frame.bus] = (frame.time_s, now_s)

    def wait_s(self, longest_s: float) -> float:
        """How long to wait for the next frame; less while frames are held back, which must not wait for long."""
        return min(longest_s, PATIENCE_S / 2) if self._held else longest_s

    def take(self, now_s: float) -> list[Frame]:
        """The frames whose turn has come."""
        if self._held and (self._clocks_differ or now_s - self._held[0][1] > LONGEST_HELD_S):
            self._compare_clocks()
        if self._clocks_differ:
            self._free += [frame for frame, _ in self._held]
            self._held = []
        elif self._held:
            awaited = [time_s for time_s, arrived_s in self._newest.values() if now_s - arrived_s < PATIENCE_S]
            self._release(min(awaited, default=inf))
        free, self._free = self._free, []
        return free

    def _compare_clocks(self) -> None:
        ahead_s = {bus: time_s - arrived_s for bus, (time_s, arrived_s) in self._newest.items()}
        behind = min(ahead_s, key=ahead_s.__getitem__)
        ahead = max(ahead_s, key=ahead_s.__getitem__)
        apart_s = ahead_s[ahead] - ahead_s[behind]
        if self._clocks_differ:
            self._clocks_differ = apart_s > LONGEST_HELD_S / 2
        elif apart_s > LONGEST_HELD_S:
            self._clocks_differ = True
            log.warning(
                "the time stamps of bus %s are %.1f s behind those of bus %s: their frames are taken as they come",
                behind,
                apart_s,
                ahead,
            )

    def _release(self, until_s: float) -> None:
        self._free += sorted((f for f, _ in self._held if f.time_s <= until_s), key=lambda frame: frame.time_s)
        self._held = [(frame, arrived_s) for frame, arrived_s in self._held if frame.time_s > until_s]
