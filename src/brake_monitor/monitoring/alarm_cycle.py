"""The life of an alarm: debounced, raised, updated, acknowledged, cleared. The same for every kind."""

from math import inf

from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Alarm, number_in
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.rule import UNKNOWN, Finding, NoFinding, Suspicion, Verdict
from brake_monitor.settings.alarm_settings import RuleSettings

# An open alarm's new values are given out after 10 s at the soonest, later after a tenth of its age (as far as this run
# saw it); at once if it gets graver. Otherwise one that stands for days, as where a parked wagon's bus is silent, would
# push all others out of every memory.
REFRESH_S = 10.0
REFRESH_SHARE = 0.1
LIGHTER = 0.9  # of what was told: less is lighter, and no longer noise

# A condition that comes and goes is one alarm: each time it is raised again soon after it was cleared it must be gone
# for twice as long as before.
SOON_S = 60.0
LONGEST_CLEAR_S = 600.0


class AlarmCycle:
    """One kind of alarm, of one wheelset or of the wagon."""

    def __init__(self, kind: str, wheelset: int | None, settings: RuleSettings, *, is_event: bool = False) -> None:
        """`is_event`: each time it is raised is an event of its own, however soon one follows the other."""
        self.kind = kind
        self.wheelset = wheelset
        self._settings = settings
        self._is_event = is_event
        self._cleared_s = -inf
        self._clear_s = settings.clear_s  # how long the condition must be gone
        self._since_s = inf  # since when the condition is there (while none is open) or gone (while one is)
        self._begun_s = self._given_s = -inf  # since when the open alarm is told of, and when it was given out last
        self._given: Alarm | None = None  # ... as what
        self._latches = True  # the open alarm was, at least once, found beyond doubt
        self._weight = -inf  # the greatest in this run
        self.open: Alarm | None = None  # as it stands now, newer than what was given out
        self.misled_by: MisledBy | None = None  # why estimates err, by the last verdict that says anything

    @property
    def is_idle(self) -> bool:
        """Whether nothing is open or about to be raised: no finding then changes nothing."""
        return self.open is None and self._since_s == inf

    def resume(self, alarm: Alarm, misled_by: MisledBy | None = None) -> None:
        """Go on with an alarm that was open when the program ended; it latches: whether it did is not remembered."""
        self.open, self._given, self._begun_s = alarm, alarm, inf  # by a clock that may have been set since
        self._since_s, self._latches, self.misled_by = inf, True, misled_by

    def see(self, now: Estimate, verdict: Verdict) -> Alarm | None:
        """Take the next verdict; the alarm when it was raised, updated or cleared, which it tells by the clock."""
        if verdict is not UNKNOWN:
            self.misled_by = None if isinstance(verdict, NoFinding) else verdict.misled_by
        if self.open is None:
            return self._see_quiet(now, verdict)
        if verdict is UNKNOWN or isinstance(verdict, Suspicion):
            self._since_s = inf
            return None
        return self._see_open(self.open, now, verdict)

    def acknowledge(self, time_s: float) -> Alarm | None:
        """Note that a person has seen it; None when there is nothing to acknowledge."""
        if self.open is None or self.open.acknowledged_time_s is not None:
            return None
        self.open = self._given = replace(self.open, acknowledged_time_s=time_s, updated_time_s=time_s)
        return self.open

    def _see_quiet(self, now: Estimate, verdict: Verdict) -> Alarm | None:
        if not isinstance(verdict, Finding):
            self._since_s = inf
            return None
        self._since_s = min(self._since_s, now.time_s)
        if now.time_s - self._since_s < self._settings.debounce_s:
            return None
        self._since_s, self._latches, self._weight = inf, verdict.latches, -inf
        self._begun_s = self._given_s = now.time_s
        comes_back = now.time_s - self._cleared_s < SOON_S and not self._is_event
        longer_s = min(2.0 * self._clear_s, LONGEST_CLEAR_S) if comes_back else 0.0
        self._clear_s = max(self._settings.clear_s, longer_s)
        name = self.kind if self.wheelset is None else f"{self.kind}-{self.wheelset}"
        self.open = self._given = Alarm(
            id=f"{name}-{round(now.clock_s * 1000)}",
            kind=self.kind,
            wheelset=self.wheelset,
            severity=verdict.severity,
            raised_time_s=now.clock_s,
            updated_time_s=now.clock_s,
            acknowledged_time_s=None,
            cleared_time_s=None,
            message=verdict.message,
            evidence=verdict.evidence,
        )
        return self.open

    def _see_open(self, alarm: Alarm, now: Estimate, verdict: Verdict) -> Alarm | None:
        if isinstance(verdict, Finding):
            self._since_s = inf
            self._latches |= verdict.latches
            return self._update(alarm, now, verdict)
        self._since_s = min(self._since_s, now.time_s)
        waits = self._settings.latched and self._latches and alarm.acknowledged_time_s is None
        if waits or now.time_s - self._since_s < self._clear_s:
            return None
        self._since_s, self.open, self._cleared_s = inf, None, now.time_s
        return replace(alarm, updated_time_s=now.clock_s, cleared_time_s=now.clock_s)

    def _update(self, alarm: Alarm, now: Estimate, finding: Finding) -> Alarm | None:
        """Keep the weightiest of what is not less grave than before, or the newest, or all that is left of it."""
        less_grave = finding.severity.rank < alarm.severity.rank
        is_likewise = finding.evidence.keys() == alarm.evidence.keys()
        weight = number_in(finding.evidence, finding.weighed_by)
        greatest = max(self._weight, number_in(alarm.evidence, finding.weighed_by)) if is_likewise else -inf
        lighter = weight < LIGHTER * greatest
        graver = finding.severity.rank > alarm.severity.rank
        is_news = finding.is_all or graver or not (less_grave or lighter)
        if is_news and finding.evidence != alarm.evidence:
            self._weight = max(weight, greatest)
            self.open = replace(
                alarm,
                severity=alarm.severity if less_grave else finding.severity,
                updated_time_s=now.clock_s,
                message=finding.message,
                evidence=finding.evidence,
            )
        if self.open is self._given:
            return None
        self._begun_s = min(self._begun_s, now.time_s)
        refresh_s = max(REFRESH_S, REFRESH_SHARE * (self._given_s - self._begun_s))
        if not graver and 0.0 <= now.time_s - self._given_s < refresh_s:
            return None
        self._given, self._given_s = self.open, now.time_s
        return self.open
