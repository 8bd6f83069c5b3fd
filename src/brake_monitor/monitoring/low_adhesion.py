"""Low adhesion: the rail gives less than it should, and the wheels have asked for more."""

from collections import deque

from brake_monitor.alarm_settings import LowAdhesionRule
from brake_monitor.estimator import Estimate, Status
from brake_monitor.monitoring.alarm import Severity, Values
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict


class LowAdhesion:
    """Judges the most that the rail gave within the debounce time, while braking with `saturated` above walking pace.

    The utilised adhesion dips towards zero whenever the WSP releases the brake, which says nothing; the greatest
    within the debounce time is what the rail has to give. An event ends when the rail gives more than level +
    margin for `clear_s`, or when nothing more was asked for during the merging gap.
    """

    kind = "low_adhesion"
    places = (None,)

    def __init__(self, settings: LowAdhesionRule) -> None:
        self.settings = settings
        self._levels = (
            (settings.extremely_low, "extremely low", Severity.ALARM),
            (settings.very_low, "very low", Severity.WARNING),
            (settings.low, "low", Severity.INFO),
        )
        self._asked: deque[tuple[float, float]] = deque()  # (time, adhesion) while more was asked for
        self._least = 1.0
        self._asked_s = 0.0  # when more was last asked for

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """Judge the wagon."""
        return (self._judge(seen.estimate),)

    def closing_evidence(self, place: int | None) -> Values:
        """The least the rail gave."""
        evidence: Values = {"least_adhesion": self._least}
        self._least = 1.0
        return evidence

    def _judge(self, estimate: Estimate) -> Verdict:
        asked_for_more = (
            estimate.saturated
            and estimate.speed_mps > self.settings.min_speed_mps
            and estimate.status in {Status.VALID, Status.CONVERGING}
        )
        if not asked_for_more:
            self._asked.clear()
            return UNKNOWN if estimate.time_s - self._asked_s < self.settings.merge_gap_s else FINE
        self._asked_s = estimate.time_s
        self._asked.append((estimate.time_s, estimate.adhesion))
        window_start_s = estimate.time_s - self.settings.debounce_s
        while len(self._asked) > 1 and self._asked[1][0] <= window_start_s:
            self._asked.popleft()
        best = max(adhesion for _, adhesion in self._asked)
        if best >= self.settings.low:
            return FINE if best > self.settings.low + self.settings.clear_margin else UNKNOWN
        self._least = min(self._least, best)
        return self._finding(estimate, best)

    def _finding(self, estimate: Estimate, best: float) -> Finding:
        limit, name, severity = next(level for level in self._levels if best < level[0])
        return Finding(
            severity,
            f"Adhesion is {name}: the rail gave no more than {best:.3f} (limit {limit:g}) "
            f"at {estimate.speed_mps * 3.6:.0f} km/h while the brake asked for more.",
            {
                "adhesion": best,
                "adhesion_std": estimate.adhesion_std,
                "speed_mps": estimate.speed_mps,
                "greatest_slip": max(wheelset.slip for wheelset in estimate.wheelsets),
            },
        )
