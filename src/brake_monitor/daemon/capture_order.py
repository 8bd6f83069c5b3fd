"""Frames of several buses in the order of their capture: the threads that read them know nothing of each other."""

from brake_monitor.frame import Frame

PATIENCE_S = 0.05  # for a bus that gives nothing; the others' frames wait no longer for it
CLOCK_SET_S = 0.5  # a bus whose time goes back by more has had its clock set
MOST_HELD = 20_000


class CaptureOrder:
    """Holds a frame back until no bus can give an earlier one. With one bus nothing is held."""

    def __init__(self, bus_count: int) -> None:
        self._bus_count = bus_count
        self._held: list[Frame] = []
        self._free: list[Frame] = []
        self._newest: dict[str, tuple[float, float]] = {}  # of each bus: capture time, and when it arrived

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
            self._release(self._held, [])
            self._newest = {}
        self._held.append(frame)
        self._newest[frame.bus] = (frame.time_s, now_s)

    def wait_s(self, longest_s: float) -> float:
        """How long the next frame may be waited for: what is held shall not wait for long."""
        return min(longest_s, PATIENCE_S / 2) if self._held else longest_s

    def take(self, now_s: float) -> list[Frame]:
        """The frames whose turn has come."""
        awaited = [time_s for time_s, arrived_s in self._newest.values() if now_s - arrived_s < PATIENCE_S]
        if self._held:
            until_s = min(awaited, default=float("inf"))
            self._release(
                [frame for frame in self._held if frame.time_s <= until_s],
                [frame for frame in self._held if frame.time_s > until_s],
            )
        free, self._free = self._free, []
        return free

    def _release(self, turn: list[Frame], later: list[Frame]) -> None:
        self._free += sorted(turn, key=lambda frame: frame.time_s)
        self._held = later
