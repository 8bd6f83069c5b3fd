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


class LowAdhesion:
    """The rail gives less than it should, and the wheels have asked for more (design ladder, GB practice).

    While braking with `saturated` above walking pace, the most the rail gave within the debounce time is what it
    has to give: the utilised adhesion dips towards zero whenever the WSP releases the brake, which says
    nothing. Below a level for that long → raised; worse later → updated; above level + margin, or no longer asked
    for, for `clear_s` plus the merging gap → cleared.
    """

    kind = "low_adhesion"

    def __init__(self, rule: LowAdhesionRule) -> None:
        self._rule = rule
        self._asked: deque[tuple[float, float]] = deque()  # (time, adhesion) while more was asked for
        self._open: Alarm | None = None
        self._bad_s = 0.0  # when adhesion was last seen low
        self._clear_since_s: float | None = None
        self._seen: list[float] = []  # adhesion over the event

    def see(self, estimate: Estimate) -> Alarm | None:
        """Take the next estimate; the alarm when it was raised, got worse or was cleared."""
        if not self._rule.enabled:
            return None
        best = self._best_of_window(estimate)
        if best is not None and best < self._rule.low:
            return self._low(estimate, best)
        return self._not_low(estimate, best)

    def _best_of_window(self, estimate: Estimate) -> float | None:
        """The greatest adhesion within the debounce time; None before it has passed without interruption."""
        asked_for_more = (
            estimate.saturated
            and estimate.speed_mps > self._rule.min_speed_mps
            and estimate.status is Status.VALID
            and any(wheelset.friction_status in {Status.VALID, Status.HELD} for wheelset in estimate.wheelsets)
        )
        if not asked_for_more:
            self._asked.clear()
            return None
        self._asked.append((estimate.time_s, estimate.adhesion))
        while len(self._asked) > 1 and self._asked[1][0] <= estimate.time_s - self._rule.debounce_s:
            self._asked.popleft()
        if estimate.time_s - self._asked[0][0] < self._rule.debounce_s:
            return None
        return max(adhesion for _, adhesion in self._asked)

    def _low(self, estimate: Estimate, best: float) -> Alarm | None:
        self._clear_since_s = None
        self._seen.append(best)
        severity, level = self._severity(best)
        if self._open is not None and severity == self._open.severity:
            return None
        greatest_slip = max(wheelset.slip for wheelset in estimate.wheelsets)
        worse = self._open is not None and _RANK[severity] > _RANK[self._open.severity]
        if self._open is not None and not worse:
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
                f"The rail gave an adhesion of only {best:.3f} at {estimate.speed_mps * 3.6:.0f} km/h "
                f"while the brake asked for more ({level}, below {self._limit(severity):g})."
            ),
            evidence={
                "adhesion": best,
                "adhesion_std": estimate.adhesion_std,
                "speed_mps": estimate.speed_mps,
                "greatest_slip": greatest_slip,
            },
        )
        return self._open

    def _not_low(self, estimate: Estimate, best: float | None) -> Alarm | None:
        if self._open is None:
            return None
        if self._clear_since_s is None:
            self._clear_since_s = estimate.time_s
        recovered = best is not None and best > self._rule.low + self._rule.clear_margin
        wait_s = self._rule.clear_s if recovered else max(self._rule.clear_s, self._rule.merge_gap_s)
        if estimate.time_s - self._clear_since_s < wait_s:
            return None
        cleared = replace(
            self._open,
            updated_time_s=estimate.time_s,
            cleared_time_s=estimate.time_s,
            evidence=self._open.evidence | {"least_adhesion": min(self._seen)},
        )
        self._open, self._clear_since_s, self._seen = None, None, []
        return cleared

    def _severity(self, adhesion: float) -> tuple[Severity, str]:
        if adhesion < self._rule.extremely_low:
            return Severity.ALARM, "extremely low"
        if adhesion < self._rule.very_low:
            return Severity.WARNING, "very low"
        return Severity.INFO, "low"

    def _limit(self, severity: Severity) -> float:
        rule = self._rule
        return {Severity.ALARM: rule.extremely_low, Severity.WARNING: rule.very_low, Severity.INFO: rule.low}[severity]


_RANK = {severity: rank for rank, severity in enumerate(Severity)}


class AlarmRules:
    """Every rule, fed with every estimate."""

    def __init__(self, settings: AlarmSettings) -> None:
        self._rules = (LowAdhesion(settings.low_adhesion),)

    def see(self, estimate: Estimate) -> tuple[Alarm, ...]:
        """Take the next estimate and give the alarms that changed."""
        return tuple(alarm for rule in self._rules if (alarm := rule.see(estimate)) is not None)
