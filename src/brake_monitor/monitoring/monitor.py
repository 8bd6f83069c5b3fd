"""Rules on one wagon, and the lives of their alarms."""

from collections.abc import Iterable

from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.alarm_cycle import AlarmCycle
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import AnyRule, Verdict


class _WatchedRule:
    """A rule, and the life of its alarm of each of its wheelsets."""

    def __init__(self, rule: AnyRule) -> None:
        self._rule = rule
        self.judge, kind, settings = rule.judge, rule.kind, rule.settings
        self.cycles = tuple(AlarmCycle(kind, i, settings, is_event=rule.is_event) for i in rule.wheelsets)
        self.quiet: tuple[Verdict, ...] = ()  # verdicts that left no alarm open or about to be raised

    def go_on(self, now: Estimate, verdicts: tuple[Verdict, ...]) -> list[Alarm]:
        """The alarms that the next verdicts changed."""
        changed = []
        for i, (cycle, verdict) in enumerate(zip(self.cycles, verdicts, strict=True)):
            alarm = cycle.see(now, verdict)
            if alarm is None:
                continue
            if alarm.cleared_time_s is not None:
                closing = self._rule.closing_evidence(i)
                if closing.get("started_time_s") in (None, alarm.evidence.get("started_time_s")):  # of the same event
                    alarm = replace(alarm, evidence=alarm.evidence | closing)
            changed.append(alarm)
        self.quiet = verdicts if all(cycle.is_idle for cycle in self.cycles) else ()
        return changed

    def resume(self, alarm: Alarm) -> None:
        """Go on with an alarm of this rule that was open when the program ended."""
        for i, cycle in enumerate(self.cycles):
            if cycle.wheelset == alarm.wheelset:
                cycle.resume(alarm, self._rule.resume(i, alarm.evidence))
                self.quiet = ()


class Monitor:
    """Shows every observation to every rule and keeps the alarms."""

    def __init__(self, rules: Iterable[AnyRule]) -> None:
        """Those that are off are left out."""
        self._rules = {rule.kind: _WatchedRule(rule) for rule in rules if rule.settings.enabled}
        self._cycles = tuple(cycle for rule in self._rules.values() for cycle in rule.cycles)
        self.misled_by: frozenset[MisledBy] = frozenset()  # why estimates err, by the observation seen last

    def see(self, seen: Observation) -> tuple[Alarm, ...]:
        """Take the next observation and give the alarms that changed."""
        changed: list[Alarm] = []
        for rule in self._rules.values():
            verdicts = rule.judge(seen)
            if verdicts != rule.quiet:  # the same ones again change nothing
                changed += rule.go_on(seen.estimate, verdicts)
                self.misled_by = frozenset([cycle.misled_by for cycle in self._cycles if cycle.misled_by is not None])
        return tuple(changed)

    def acknowledge(self, alarm_id: str, time_s: float) -> Alarm | None:
        """Note that a person has seen the open alarm of this id; None when there is none or it was seen before."""
        for cycle in self._cycles:
            if cycle.open is not None and cycle.open.id == alarm_id:
                return cycle.acknowledge(time_s)
        return None

    def open_alarms(self) -> tuple[Alarm, ...]:
        """Every open alarm."""
        return tuple(cycle.open for cycle in self._cycles if cycle.open is not None)

    def resume(self, alarms: Iterable[Alarm]) -> None:
        """Go on with the alarms that were open when the program ended; those of rules that are off are left out."""
        for alarm in alarms:
            if rule := self._rules.get(alarm.kind):
                rule.resume(alarm)
