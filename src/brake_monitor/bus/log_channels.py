"""Which bus a channel of a recording stands for."""

from collections.abc import Callable, Sequence

from brake_monitor.settings.config import CanBus


class LogChannels(dict[object, str]):
    """The configured name of the bus by channel, filled as channels turn up; "" for none.

    With one bus every channel stands for it. With several, a channel is the bus whose `channel` or `name` it carries,
    a numbered one the bus in that place, counted from `first`.
    """

    def __init__(self, buses: Sequence[CanBus], first: int, remark: Callable[[str], None]) -> None:
        """`remark` is told what had to be assumed."""
        super().__init__()
        self.first = first
        self._buses = buses
        self._remark = remark

    def __missing__(self, channel: object) -> str:
        name = self[channel] = self._bus_of(channel)
        return name

    def _bus_of(self, channel: object) -> str:
        buses = self._buses
        if len(buses) == 1:
            if len(self) == 1 and channel is not None:
                first, second = (self._told(each) for each in (*self, channel))
                self._remark(f"it has frames of several channels, as {first} and {second}: all taken for the one bus")
            return buses[0].name
        if isinstance(channel, int):
            place = channel - self.first
            return buses[place].name if 0 <= place < len(buses) else ""
        if channel is None:
            self._remark(f"it does not say which of {len(buses)} buses a frame was on: on none")
        return next((bus.name for bus in buses if channel in (bus.channel, bus.name)), "")

    def _told(self, channel: object) -> object:
        """As others name it, who count from 1."""
        return channel - self.first + 1 if isinstance(channel, int) else channel
