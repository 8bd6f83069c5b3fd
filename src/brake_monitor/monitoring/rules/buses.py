"""Bus silent, bus fault: what is wrong is the CAN bus, not what is connected to it."""

from math import inf

from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.reports import BusReport
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Rule, Settings, Verdict
from brake_monitor.monitoring.rules.earlier_count import EarlierCount
from brake_monitor.plural import plural
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import BusFaultRule, BusSilentRule

STANDS_MPS = 0.3
SWITCHED_OFF = "the wagon stood, and the train may have been switched off; else "
SHORTEST_TIMEOUTS = 2.0  # a bus with slow messages may be quiet for this many of their time-outs


class _BusRule(Rule[Settings]):
    """Knows the buses that an earlier run of the program has told of, until they are heard in this one."""

    def __init__(self, settings: Settings, unsure_s: float = 0.0) -> None:
        """`unsure_s`: so long after this run has begun they tell nothing yet."""
        super().__init__(settings)
        self._unsure_s = unsure_s
        self._begun_s = inf
        self._unheard: set[str] = set()

    def resume(self, _: int, evidence: Values) -> None:
        """Go on with the buses of an open alarm."""
        self._unheard.update(str(evidence.get("buses", "")).split(", "))

    def _nothing_found(self, seen: Observation) -> Verdict:
        """FINE as soon as all of them have been heard, or are watched no more."""
        self._begun_s = min(self._begun_s, seen.time_s)
        until_s = self._begun_s + self._unsure_s
        self._unheard &= {bus.name for bus in seen.buses if seen.time_s - bus.silent_s <= until_s}
        return UNKNOWN if self._unheard else FINE


class BusSilent(_BusRule[BusSilentRule]):
    """Judges how long no frame has come from each bus.

    Of a wagon that stood before, the train may have been switched off.
    """

    kind = "bus_silent"

    def __init__(self, settings: BusSilentRule) -> None:
        super().__init__(settings)
        self._stood = False  # the wagon, when its speed was last told

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """All buses together."""
        if all(report.channel.quantity is not Quantity.SPEED for report in seen.inputs.not_good):
            self._stood = seen.estimate.speed_mps < STANDS_MPS
        otherwise = self._nothing_found(seen)
        silent = [bus for bus in seen.buses if bus.silent_s >= self._limit_s(bus)]
        if not silent:
            return (otherwise,)
        longest_s = max(bus.silent_s for bus in silent)
        return (
            Finding(
                Severity.WARNING if self._stood else Severity.ALARM,
                f"No frame for at least {longest_s:.0f} s on {names(silent)}: "
                f"{SWITCHED_OFF if self._stood else ''}check power, wiring and the gateway's interface.",
                {
                    "buses": ", ".join(bus.name for bus in silent),
                    "silent_s": longest_s,
                    "stood": "yes" if self._stood else "no",
                },
            ),
        )

    def resume(self, i: int, evidence: Values) -> None:
        """Go on with buses that were silent, perhaps of a train that was switched off."""
        super().resume(i, evidence)
        self._stood = evidence.get("stood") == "yes"

    def _limit_s(self, bus: BusReport) -> float:
        return max(self.settings.silent_s, SHORTEST_TIMEOUTS * bus.expected_within_s)


class BusFault(_BusRule[BusFaultRule]):
    """Judges how many error frames came lately, and whether the controller or the interface is off."""

    kind = "bus_fault"

    def __init__(self, settings: BusFaultRule) -> None:
        super().__init__(settings, settings.window_s)
        self._earlier: dict[str, EarlierCount[int]] = {}  # error frames since the start, per bus

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """All buses together."""
        otherwise = self._nothing_found(seen)
        lately = [self._error_frames_lately(bus, seen.time_s) for bus in seen.buses]
        off = [bus for bus in seen.buses if bus.is_off]
        noisy = [bus for bus, count in zip(seen.buses, lately, strict=True) if count >= self.settings.error_frames]
        if not off and not noisy:
            return (otherwise,)
        most = max(lately)
        said = [f"{names(off)} is off or down"] if off else []
        if noisy:
            said.append(f"{plural(most, 'error frame')} within {self.settings.window_s:g} s on {names(noisy)}")
        return (
            Finding(
                Severity.ALARM if off else Severity.WARNING,
                f"CAN fault: {' and '.join(said)}; check wiring, termination and bit rate.",
                {
                    "buses": ", ".join(bus.name for bus in seen.buses if bus in off or bus in noisy),
                    "error_frames": most,
                    "bus_off": "yes" if off else "no",
                },
                is_all=True,
            ),
        )

    def _error_frames_lately(self, bus: BusReport, time_s: float) -> int:
        earlier = self._earlier.get(bus.name)
        if earlier is None:
            earlier = self._earlier[bus.name] = EarlierCount(self.settings.window_s)
            earlier.see(time_s, 0)
        return bus.error_frames - earlier.see(time_s, bus.error_frames)


def names(buses: list[BusReport]) -> str:
    """For a person."""
    return f"bus {', '.join(bus.name for bus in buses)}"
