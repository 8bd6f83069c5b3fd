"""A memory that cannot be written is told as an alarm, which ends when it can be again."""

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.settings.alarm_settings import AlarmSettings
from estimates import estimate, observation

FAILS_S, WRITTEN_S = 10.0, 30.0
ROLLING = (WheelState.ROLLING, WheelState.ROLLING)


def alarms(fails_until_s: float, *, works_for_s: float = 0.0) -> list[Alarm]:
    """`works_for_s`: after each second in which it fails."""
    monitor, changed = Monitor(wagon_rules(AlarmSettings(), 2)), []
    for k in range(600):
        fails = FAILS_S <= k / 10 < fails_until_s and (k / 10 - FAILS_S) % (1.0 + works_for_s) < 1.0
        failure = "the disk is full" if fails else ""
        changed += monitor.see(observation(estimate(time_s=k / 10), wheels=ROLLING, memory_failure=failure))
    return [alarm for alarm in changed if alarm.kind == "memory_failing"]


def test_it_is_raised_while_it_fails_and_cleared_when_it_is_written() -> None:
    raised, cleared = alarms(WRITTEN_S)
    assert raised.severity == "warning"
    assert "the disk is full" in raised.message
    assert FAILS_S < raised.raised_time_s < FAILS_S + 10.0
    assert cleared.cleared_time_s is not None
    assert WRITTEN_S < cleared.cleared_time_s < WRITTEN_S + 10.0


def test_a_disk_that_hesitates_is_none() -> None:
    assert alarms(FAILS_S + 2.0) == []
    assert alarms(60.0, works_for_s=20.0) == []


def test_a_disk_that_has_room_now_and_then_fails_until_it_has_room_for_good() -> None:
    raised, cleared = alarms(WRITTEN_S, works_for_s=4.0)
    assert FAILS_S < raised.raised_time_s < FAILS_S + 12.0
    assert cleared.cleared_time_s is not None
    assert WRITTEN_S < cleared.cleared_time_s < WRITTEN_S + 15.0
