"""What is said of the buses: of several only those at fault are named."""

import pytest

from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.reports import GOOD, BusReport
from brake_monitor.monitoring.rule import FINE, Finding, Verdict
from brake_monitor.monitoring.rules.buses import BusFault, BusSilent
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import BusFaultRule, BusSilentRule
from estimates import estimate, observation, report


def faults(*seconds: dict[str, int], off: str = "") -> Verdict:
    """What is said after the last of them, each being the error frames of every bus since the start."""
    rule, verdict = BusFault(BusFaultRule()), None
    for time_s, errors in enumerate(seconds):
        buses = tuple(BusReport(name, 0.0, count, name == off) for name, count in errors.items())
        (verdict,) = rule.judge(observation(estimate(time_s=float(time_s)), buses=buses))
    assert verdict is not None
    return verdict


@pytest.mark.parametrize(("count", "is_told"), [(9, False), (10, True)])
def test_ten_error_frames_within_five_seconds_are_a_fault(count: int, is_told: bool) -> None:
    lately = [{"front": 0}, {"front": 3}, {"front": 3}, {"front": 3}, {"front": 3}, {"front": count}]
    assert isinstance(faults(*lately), Finding) is is_told
    assert faults(*lately, *[{"front": count}] * 6) is FINE


def test_a_bus_that_is_off_a_noisy_one_and_a_sound_one() -> None:
    fault = faults({"front": 0, "middle": 0, "rear": 0}, {"front": 2, "middle": 20, "rear": 1}, off="front")
    assert isinstance(fault, Finding)
    assert fault.severity is Severity.ALARM
    assert fault.evidence == {"buses": "front, middle", "error_frames": 20, "bus_off": "yes"}
    assert "bus front is off or down and 20 error frames within 5 s on bus middle;" in fault.message


def test_a_bus_is_silent_after_two_seconds_and_one_with_slow_messages_after_two_of_their_time_outs() -> None:
    rule = BusSilent(BusSilentRule())

    def said(fast_s: float, slow_s: float) -> Verdict:
        buses = (BusReport("fast", fast_s, 0, False, 0.1), BusReport("slow", slow_s, 0, False, 3.0))
        (verdict,) = rule.judge(observation(estimate(), buses=buses))
        return verdict

    assert said(1.9, 5.9) is FINE
    fast, both = said(2.0, 5.9), said(7.0, 6.0)
    assert isinstance(fast, Finding)
    assert fast.evidence == {"buses": "fast", "silent_s": 2.0, "stood": "no"}
    assert isinstance(both, Finding)
    assert both.evidence == {"buses": "fast, slow", "silent_s": 7.0, "stood": "no"}


@pytest.mark.parametrize(("speed_mps", "severity"), [(0.0, Severity.WARNING), (15.0, Severity.ALARM)])
def test_a_bus_that_falls_silent_as_the_wagon_stands_may_have_been_switched_off(
    speed_mps: float, severity: Severity
) -> None:
    """As each evening; what the estimate makes of a speed that is lost does not count."""
    rule = BusSilent(BusSilentRule())
    verdicts = []
    for told_mps, condition, silent_s in ((speed_mps, GOOD, 0.0), (15.0 - speed_mps, InputCondition.LOST, 3.0)):
        inputs = (report(Quantity.SPEED, 0, "GNSS.v", condition),)
        buses = (BusReport("can0", silent_s, 0, False, 0.1),)
        verdicts += rule.judge(observation(estimate(speed_mps=told_mps), inputs, buses))
    silent = verdicts[-1]
    assert isinstance(silent, Finding)
    assert silent.severity is severity
    assert ("switched off" in silent.message) is (severity is Severity.WARNING)


def test_a_bus_of_which_nothing_was_heard_is_not_known_to_be_switched_off() -> None:
    inputs = (report(Quantity.SPEED, 0, "GNSS.v", InputCondition.AWAITED),)
    buses = (BusReport("can0", 3.0, 0, False, 0.1),)
    (silent,) = BusSilent(BusSilentRule()).judge(observation(estimate(speed_mps=0.0), inputs, buses))
    assert isinstance(silent, Finding)
    assert silent.severity is Severity.ALARM


def after_a_restart(alarms: tuple[Alarm, ...], heard_s: float, until_s: float, *, name: str = "can0") -> list[Alarm]:
    """What becomes of open alarms; the bus, of this name now, is heard every tenth of a second from `heard_s` on."""
    monitor = Monitor([BusSilent(BusSilentRule(silent_s=10.0)), BusFault(BusFaultRule())])
    monitor.resume(alarms)
    given: list[Alarm] = []
    inputs = (report(Quantity.SPEED, 0, "GNSS.v", InputCondition.AWAITED),)
    for k in range(round(until_s * 10)):
        time_s = k / 10
        buses = (BusReport(name, min(time_s, time_s % 0.1) if time_s >= heard_s else time_s, 0, False, 0.1),)
        given += monitor.see(observation(estimate(time_s=1000.0 + time_s, speed_mps=0.0), inputs, buses))
    return given


@pytest.mark.parametrize(("speed_mps", "severity"), [(0.0, Severity.WARNING), (15.0, Severity.ALARM)])
def test_a_silent_bus_is_no_graver_for_a_restart_and_not_told_twice(speed_mps: float, severity: Severity) -> None:
    monitor = Monitor([BusSilent(BusSilentRule(silent_s=10.0))])
    for time_s, condition in ((0.0, GOOD), (11.0, InputCondition.LOST)):
        inputs = (report(Quantity.SPEED, 0, "GNSS.v", condition),)
        buses = (BusReport("can0", time_s, 0, False, 0.1),)
        monitor.see(observation(estimate(time_s=time_s, speed_mps=speed_mps), inputs, buses))
    silent = monitor.open_alarms()
    given = after_a_restart(silent, heard_s=60.0, until_s=70.0)
    assert {(one.id, one.severity) for one in given} == {(silent[0].id, severity)}
    assert [one.cleared_time_s for one in given if one.cleared_time_s] == [pytest.approx(1062.0, abs=0.3)]
    (renamed,) = after_a_restart(silent, heard_s=0.0, until_s=70.0, name="front")
    assert renamed.cleared_time_s == pytest.approx(1002.0)


def test_a_noisy_bus_is_not_known_to_be_sound_after_a_restart_before_it_was_heard_for_a_while() -> None:
    monitor = Monitor([BusFault(BusFaultRule())])
    for time_s, count in ((0.0, 0), (1.0, 10)):
        monitor.see(observation(estimate(time_s=time_s), buses=(BusReport("can0", 0.0, count, False),)))
    (cleared,) = after_a_restart(monitor.open_alarms(), heard_s=0.1, until_s=60.0)
    assert cleared.cleared_time_s == pytest.approx(1005.0 + 2.0, abs=0.3)
    given = after_a_restart(monitor.open_alarms(), heard_s=20.0, until_s=60.0)
    (cleared,) = [alarm for alarm in given if alarm.kind == "bus_fault"]
    assert cleared.cleared_time_s == pytest.approx(1020.0 + 2.0, abs=0.3)
