"""Whether anything arrives on a bus at all: else the bus is to blame, not the senders of the signals that are lost."""

from collections.abc import Mapping

from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.reports import BusReport

QUIET_S = 0.5  # or as long as its slowest senders may take
PACE_S = 10.0  # for so long a bus is known to go on after such a silence
LONGER = 1.5  # times as long as that, it is another one


def is_quiet(bus: BusReport, paused_s: float = 0.0) -> bool:
    """Whether nothing arrives on it for longer than it pauses between frames."""
    return bus.is_off or bus.silent_s > max(QUIET_S, bus.expected_within_s, LONGER * paused_s)


class BusPace:
    """Sees every observation; knows which buses go on, if only by what slow senders are left on them."""

    def __init__(self) -> None:
        self._silent_s: dict[str, float] = {}  # at the last observation
        self._paused: dict[str, tuple[float, float]] = {}  # when it was heard again lately, after which silence

    def heard_s(self, seen: Observation) -> Mapping[str, float]:
        """When each bus that goes on was heard last."""
        pauses_s = [self._pause_s(bus, seen.time_s) for bus in seen.buses]
        pairs = zip(seen.buses, pauses_s, strict=True)
        return {bus.name: seen.time_s - bus.silent_s for bus, paused_s in pairs if not is_quiet(bus, paused_s)}

    def _pause_s(self, bus: BusReport, time_s: float) -> float:
        """The longest silence after which it was heard again lately; 0 if there was none."""
        silent_s, self._silent_s[bus.name] = self._silent_s.get(bus.name, 0.0), bus.silent_s
        heard_s, longest_s = self._paused.get(bus.name, (time_s, 0.0))
        if not 0.0 <= time_s - heard_s <= PACE_S:
            longest_s = 0.0
        if bus.silent_s < silent_s and silent_s >= longest_s:
            self._paused[bus.name] = time_s, silent_s
            return silent_s
        return longest_s
