"""All rules on one wagon."""

from collections.abc import Iterable

from msgspec.structs import replace

from brake_monitor.alarm_settings import AlarmSettings
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.alarm_cycle import AlarmCycle
from brake_monitor.monitoring.buses import BusFault, BusSilent
from brake_monitor.monitoring.inputs import InputImplausible, InputLost
from brake_monitor.monitoring.low_adhesion import LowAdhesion
from brake_monitor.monitoring.memory_failing import MemoryFailing
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import NoFinding, Rule
from brake_monitor.monitoring.slide import Slide
from brake_monitor.monitoring.wheelset_not_rotating import WheelsetNotRotating


class Monitor:
    """Shows every observation to every rule and keeps the alarms."""

    def __init__(self, settings: AlarmSettings, wheelset_count: int, brake_rules: tuple[Rule, ...] = ()) -> None:
        """`brake_rules`: those on the brake units."""
        rules: tuple[Rule, ...] = (
            WheelsetNotRotating(settings.wheelset_not_rotating, wheelset_count),
            LowAdhesion(settings.low_adhesion),
            Slide(settings.slide, wheelset_count),
            InputLost(settings.input_lost, wheelset_count),
            InputImplausible(settings.input_implausible, wheelset_count),
            BusSilent(settings.bus_silent),
            BusFault(settings.bus_fault),
            MemoryFailing(settings.memory_failing),
            *brake_rules,
        )
        self._rules = {
            rule: tuple(AlarmCycle(rule.kind, place, rule.settings) for place in rule.places)
            for rule in rules
            if rule.settings.enabled
        }
        self._cycles = {(cycle.kind, cycle.place): cycle for cycles in self._rules.values() for cycle in cycles}

    def see(self, seen: Observation) -> tuple[Alarm, ...]:
        """Take the next observation and give the alarms that changed."""
        changed = []
        time_s = seen.time_s
        for rule, cycles in self._rules.items():
            for cycle, verdict in zip(cycles, rule.judge(seen), strict=True):
                if cycle.is_idle and isinstance(verdict, NoFinding):  # as nearly always
                    continue
                alarm = cycle.see(time_s, verdict)
                if alarm is None:
                    continue
                if alarm.cleared_time_s is not None:
                    alarm = replace(alarm, evidence=alarm.evidence | rule.closing_evidence(cycle.place))
                changed.append(alarm)
        return tuple(changed)

    def acknowledge(self, alarm_id: str, time_s: float) -> Alarm | None:
        """Note that a person has seen the open alarm of this id; None when there is none or it was seen before."""
        for cycle in self._cycles.values():
            if cycle.open is not None and cycle.open.id == alarm_id:
                return cycle.acknowledge(time_s)
        return None

    def open_alarms(self) -> tuple[Alarm, ...]:
        """Every open alarm."""
        return tuple(cycle.open for cycle in self._cycles.values() if cycle.open is not None)

    def resume(self, alarms: Iterable[Alarm]) -> None:
        """Go on with the alarms that were open when the program ended; those of rules that are off are left out."""
        for alarm in alarms:
            if cycle := self._cycles.get((alarm.kind, alarm.wheelset)):
                cycle.resume(alarm)
