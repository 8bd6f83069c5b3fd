"""What each CAN bus does, whatever its frames mean."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

from brake_monitor.frame import CLOCK_STEP_S, YEAR_S, Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.reports import BusReport
from brake_monitor.samples import Channel

BUS_OFF = 0x40  # class bit of SocketCAN's error frames: the controller has left the bus


@dataclass(slots=True)
class _Bus:
    expected_within_s: float  # a frame comes at least so often, by the time-outs of what is mapped
    heard_s: float | None = None  # None before the watch began
    error_frames: int = 0
    is_off: bool = False  # by the controller's own word, until the next frame
    is_down: bool = False  # by whoever reads the bus


class BusWatch:
    """Sees every frame; knows every configured bus, also one that never says anything."""

    def __init__(self, names: Iterable[str], channels: Iterable[Channel]) -> None:
        timeouts_s: dict[str, float] = {}
        for channel in channels:
            timeouts_s[channel.bus] = min(timeouts_s.get(channel.bus, inf), channel.timeout_s)
        self._buses = {name: _Bus(timeouts_s.get(name, 0.0)) for name in names}

    def see(self, frame: Frame) -> None:
        """Take a frame of any kind."""
        bus = self._buses.get(frame.bus)
        if bus is None:
            return
        if frame.kind is FrameKind.ERROR:
            bus.error_frames += 1
            bus.is_off |= bool(frame.can_id & BUS_OFF)
            return
        bus.heard_s, bus.is_off = frame.time_s, False

    def pass_over(self, block: FrameBlock, begin: int, end: int) -> None:
        """Take the data frames of a block from one place to before another."""
        for name, last in block.last_on_bus:
            place = last[end - 1]
            bus = self._buses.get(name)
            if bus is not None and place >= begin:
                bus.heard_s, bus.is_off = float(block.time_s[place]), False

    def down(self, name: str, is_down: bool) -> None:
        """Note that the interface of a bus went down or came back."""
        self._buses[name].is_down = is_down

    def reports(self, time_s: float) -> tuple[BusReport, ...]:
        """How each bus is; one that has said nothing so far counts from the first call."""
        found = []
        for name, bus in self._buses.items():
            if bus.heard_s is None or not -CLOCK_STEP_S <= time_s - bus.heard_s <= YEAR_S:  # or the clock was set
                bus.heard_s = time_s
            silent_s = max(time_s - bus.heard_s, 0.0)
            is_off = bus.is_off or bus.is_down
            found.append(BusReport(name, silent_s, bus.error_frames, is_off, bus.expected_within_s))
        return tuple(found)
