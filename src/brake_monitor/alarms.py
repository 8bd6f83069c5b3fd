"""Estimates → alarms: rules with hysteresis and debounce. Time is the estimates'."""

from collections import deque
from enum import StrEnum

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.config import AlarmSettings, LowAdhesionRule
from brake_monitor.estimator import Estimate, Status


class Severity(StrEnum):
    """Ordered by what a person should do: look, plan, act."""

    INFO = "info"
    WARNING = "warning"
    ALARM = "alarm"


class Alarm(Struct, frozen=True):
    """One alarm as it stands now; published anew at each change (raised, updated, cleared)."""

    id: str  # "<kind>[-<wheelset>]-<raised time in ms>", unique per vehicle
    kind: str  # "low_adhesion", ...
    wheelset: int | None  # from 1; None when it concerns the wagon
    severity: Severity
    raised_time_s: float
    updated_time_s: float
    cleared_time_s: float | None  # None while open
    message: str  # one sentence for a person
    evidence: dict[str, float | str | None]  # the values that raised it, units in the names


_SEVERITY_ORDER = tuple(Severity)


class LowAdhesion:
    """The rail gives less than it should, and the wheels have asked for more.

    While braking with `saturated` above walking pace, the most the rail gave within the debounce time is what it
    has to give: the utilised adhesion dips towards zero whenever the WSP releases the brake, which says
    nothing. Below a level for that long → raised; worse later → updated; cleared when the rail gives more than
    level + margin for `clear_s`, or when nothing more was asked for during the merging gap.
    """

    kind = "low_adhesion"

    def __init__(self, rule: LowAdhesionRule) -> None:
        self._rule = rule
        self._levels = (
            (rule.extremely_low, "extremely low", Severity.ALARM),
            (rule.very_low, "very low", Severity.WARNING),
            (rule.low, "low", Severity.INFO),
        )
        self._asked: deque[tuple[float, float]] = deque()  # (time, adhesion) while more was asked for
        self._open: Alarm | None = None
        self._least = 1.0
        self._not_low_since_s: float | None = None

    def see(self, estimate: Estimate) -> Alarm | None:
        """Take the next estimate; the alarm when it was raised, got worse or was cleared."""
        if not self._rule.enabled:
            return None
        best = self._best_of_window(estimate)
        if best is not None and best < self._rule.low:
            return self._low(estimate, best)
        return self._not_low(estimate.time_s, best)

    def _best_of_window(self, estimate: Estimate) -> float | None:
        """The greatest adhesion within the debounce time; None before that has passed without interruption."""
        asked_for_more = (
            estimate.saturated
            and estimate.speed_mps > self._rule.min_speed_mps
            and estimate.status in {Status.VALID, Status.CONVERGING}
        )
        if not asked_for_more:
            self._asked.clear()
            return None
        self._asked.append((estimate.time_s, estimate.adhesion))
        window_start_s = estimate.time_s - self._rule.debounce_s
        while len(self._asked) > 1 and self._asked[1][0] <= window_start_s:
            self._asked.popleft()
        if self._asked[0][0] > window_start_s:
            return None
        return max(adhesion for _, adhesion in self._asked)

    def _low(self, estimate: Estimate, best: float) -> Alarm | None:
        self._not_low_since_s = None
        self._least = min(self._least, best)
        limit, name, severity = next(level for level in self._levels if best < level[0])
        if self._open is not None and _SEVERITY_ORDER.index(severity) <= _SEVERITY_ORDER.index(self._open.severity):
            return None
        raised_s = estimate.time_s if self._open is None else self._open.raised_time_s
        self._open = Alarm(
            id=f"{self.kind}-{round(raised_s * 1000)}",
            kind=self.kind,
            wheelset=None,
            severity=severity,
            raised_time_s=raised_s,
            updated_time_s=estimate.time_s,
            cleared_time_s=None,
            message=(
                f"Adhesion is {name}: the rail gave no more than {best:.3f} (limit {limit:g}) "
                f"at {estimate.speed_mps * 3.6:.0f} km/h while the brake asked for more."
            ),
            evidence={
                "adhesion": best,
                "adhesion_std": estimate.adhesion_std,
                "speed_mps": estimate.speed_mps,
                "greatest_slip": max(wheelset.slip for wheelset in estimate.wheelsets),
            },
        )
        return self._open

    def _not_low(self, time_s: float, best: float | None) -> Alarm | None:
        if self._open is None:
            return None
        if best is not None and best <= self._rule.low + self._rule.clear_margin:
            self._not_low_since_s = None  # within the hysteresis
            return None
        if self._not_low_since_s is None:
            self._not_low_since_s = time_s
        wait_s = self._rule.merge_gap_s if best is None else self._rule.clear_s
        if time_s - self._not_low_since_s < wait_s:
            return None
        cleared = replace(
            self._open,
            updated_time_s=time_s,
            cleared_time_s=time_s,
            evidence=self._open.evidence | {"least_adhesion": self._least},
        )
        self._open, self._not_low_since_s, self._least = None, None, 1.0
        return cleared


class AlarmRules:
    """Every rule, fed with every estimate."""

    def __init__(self, settings: AlarmSettings) -> None:
        self._rules = (LowAdhesion(settings.low_adhesion),)

    def see(self, estimate: Estimate) -> tuple[Alarm, ...]:
        """Take the next estimate and give the alarms that changed."""
        return tuple(alarm for rule in self._rules if (alarm := rule.see(estimate)) is not None)
