"""The life of an alarm: what it tells while it stands, how often, and when it is over."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.alarm_cycle import AlarmCycle
from brake_monitor.monitoring.misled import MisledBy
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Suspicion, Verdict
from brake_monitor.settings.alarm_settings import RuleSettings
from estimates import estimate

DAY_S = 86400


def at(time_s: float, clock_ahead_s: float = 0.0) -> Estimate:
    return estimate(time_s=float(time_s), clock_ahead_s=clock_ahead_s)


@pytest.mark.parametrize("doubts", [(False,), (False, True, False)])
def test_what_was_never_beyond_doubt_does_not_latch(doubts: tuple[bool, ...]) -> None:
    cycle = AlarmCycle("dragging_brake", 1, RuleSettings(debounce_s=0.0, clear_s=2.0, latched=True))
    for second, latches in enumerate(doubts):
        cycle.see(at(second), Finding(Severity.ALARM, "It drags.", {"force_n": 1.0 + second}, latches=latches))
    for second in range(10, 20):
        cycle.see(at(second), FINE)
    assert (cycle.open is not None) is any(doubts)


@pytest.mark.parametrize(("is_all", "told_n"), [(False, 9e3), (True, 2e3)], ids=["the gravest", "all that is"])
def test_what_is_less_grave_takes_the_place_of_the_graver_only_where_it_is_all_there_is(
    is_all: bool, told_n: float
) -> None:
    cycle = AlarmCycle("dragging_brake", 1, RuleSettings(debounce_s=0.0))
    cycle.see(at(0), Finding(Severity.ALARM, "It drags.", {"force_n": 9e3}))
    cycle.see(at(20), Finding(Severity.WARNING, "It drags a little.", {"force_n": 2e3}, is_all=is_all))
    assert cycle.open is not None
    assert (cycle.open.severity, cycle.open.evidence) == (Severity.ALARM, {"force_n": told_n})


def test_of_what_lasts_the_weightiest_is_told_whatever_is_left_of_it_in_the_end() -> None:
    """As a brake drags with less and less force; also when something else is found meanwhile."""
    cycle = AlarmCycle("dragging_brake", 1, RuleSettings(debounce_s=0.0, clear_s=1.0))

    def told_of(time_s: float, force_n: float, *names: str) -> dict[str, float | str | None]:
        cycle.see(at(time_s), Finding(Severity.ALARM, "", dict.fromkeys(names, force_n), weighed_by="force_n"))
        assert cycle.open is not None
        return dict(cycle.open.evidence)

    assert told_of(0, 4e3, "force_n") == {"force_n": 4e3}
    assert told_of(20, 5e3, "force_n") == {"force_n": 5e3}
    assert told_of(30, 4.8e3, "force_n") == {"force_n": 4.8e3}  # as much, and newer
    assert told_of(35, 4.4e3, "force_n") == {"force_n": 4.8e3}
    assert told_of(40, 2e3, "force_n") == {"force_n": 4.8e3}
    assert told_of(60, 1e3, "retarding_force_n") == {"retarding_force_n": 1e3}
    assert told_of(80, 2e3, "force_n") == {"force_n": 2e3}
    cycle.see(at(100), FINE)
    cleared = cycle.see(at(102), FINE)
    assert cleared is not None
    assert told_of(120, 3e3, "force_n") == {"force_n": 3e3}  # another alarm


def test_the_weightiest_is_told_after_a_restart_as_well() -> None:
    def drags(force_n: float) -> Finding:
        return Finding(Severity.ALARM, f"{force_n:.0f} N", {"force_n": force_n}, weighed_by="force_n")

    alarm = AlarmCycle("dragging_brake", 1, RuleSettings(debounce_s=0.0)).see(at(0), drags(20e3))
    assert alarm is not None
    cycle = AlarmCycle("dragging_brake", 1, RuleSettings())
    cycle.resume(alarm)
    assert [cycle.see(at(60 + second), drags(5e3)) for second in range(60)] == [None] * 60
    harder = cycle.see(at(120), drags(21e3))
    assert harder is not None
    assert (harder.message, harder.evidence) == ("21000 N", {"force_n": 21e3})


@pytest.mark.parametrize("by_s", [3600.0, -3600.0])
def test_a_clock_that_is_set_is_no_time_that_passes(by_s: float) -> None:
    """Debounced for 3 s, of which one has passed, and later cleared after 2 s, of which one has."""
    cycle = AlarmCycle("hot_disc", 1, RuleSettings(debounce_s=3.0, clear_s=2.0))

    def changed_s(verdict: Verdict) -> list[float]:
        """Seconds after the verdict came first, the clock being set after one."""
        begun_s = 10_000.0
        cycle.see(at(begun_s), verdict)
        changed = {k / 10: cycle.see(at(begun_s + k / 10, by_s), verdict) for k in range(10, 100)}
        told_s = {after_s: alarm.updated_time_s - begun_s - by_s for after_s, alarm in changed.items() if alarm}
        assert list(told_s.values()) == pytest.approx(list(told_s))
        return list(told_s)

    assert changed_s(Finding(Severity.WARNING, "It is hot.", {})) == [3.0]
    assert changed_s(FINE) == [2.0]


def test_an_alarm_is_no_older_for_a_clock_that_was_set_ahead() -> None:
    """And goes on to be told every ten seconds."""
    cycle = AlarmCycle("hot_disc", 1, RuleSettings())
    told_s = []
    for second in range(60):
        hot = Finding(Severity.WARNING, "It is hot.", {"temperature_c": 300.0 + second})
        if cycle.see(at(second, 86400.0 * (second >= 5)), hot):
            told_s.append(second)
    assert np.diff(told_s).max() <= 11


@pytest.mark.parametrize("by_s", [50e6, -50e6], ids=["in the past", "in the future"])
def test_nor_after_a_restart_for_one_that_was_wrong_as_it_was_raised(by_s: float) -> None:
    """It is told at once, and then less and less often."""
    begun_s = 1.7e9
    alarm = AlarmCycle("bus_silent", None, RuleSettings(debounce_s=0.0)).see(at(begun_s - by_s), silent(0))
    assert alarm is not None
    cycle = AlarmCycle("bus_silent", None, RuleSettings())
    cycle.resume(alarm)
    told_s = [second for second in range(1, 3600) if cycle.see(at(begun_s + second), silent(second))]
    assert told_s[0] == 1
    assert np.diff(told_s).max() < 600
    assert len(told_s) < 60


def silent(second: int) -> Finding:
    return Finding(Severity.ALARM, "It is silent.", {"silent_s": 3.0 + second})


def test_only_what_is_known_to_be_gone_all_the_time_clears_an_alarm() -> None:
    cycle = AlarmCycle("hot_disc", 1, RuleSettings(debounce_s=0.0, clear_s=10.0))
    cycle.see(at(0.0), Finding(Severity.WARNING, "It is hot.", {}))

    def cleared_s(verdicts: Callable[[int], Verdict]) -> list[int]:
        return [second for second in range(1, 60) if cycle.see(at(second), verdicts(second))]

    assert cleared_s(lambda second: UNKNOWN if second % 9 else FINE) == []
    assert cleared_s(lambda second: UNKNOWN if second < 20 else FINE) == [30]


def test_an_alarm_that_stands_for_days_is_told_ever_less_often_but_at_once_when_it_gets_graver() -> None:
    cycle = AlarmCycle("bus_silent", None, RuleSettings())
    told_s = []
    for second in range(3 * DAY_S):
        finding = Finding(Severity.WARNING, f"Silent for {second} s.", {"silent_s": float(second)})
        if cycle.see(at(second), finding):
            told_s.append(second)
    begun_s = told_s[0]
    assert [second - begun_s for second in told_s[:8]] == [0, 10, 20, 30, 40, 50, 60, 70]
    assert all(later - earlier <= max(11, 0.101 * later) for earlier, later in pairwise(told_s))
    assert len(told_s) < 100
    graver = cycle.see(at(3.0 * DAY_S), Finding(Severity.ALARM, "Silent.", {}))
    assert graver is not None
    assert graver.severity is Severity.ALARM


def test_what_is_told_last_is_what_stands() -> None:
    """It changed too soon after the raising to be told at once, and never again."""
    cycle = AlarmCycle("input_lost", None, RuleSettings(debounce_s=0.0))
    told = []
    for second in range(60):
        named = "speed, latitude" if second < 5 else "speed"
        if given := cycle.see(at(second), Finding(Severity.WARNING, named, {"inputs": named})):
            told.append((second, given.message))
    assert told == [(0, "speed, latitude"), (10, "speed")]


def test_what_is_suspected_doubts_the_estimates_and_neither_raises_nor_clears() -> None:
    cycle = AlarmCycle("dragging_brake", 1, RuleSettings(debounce_s=2.0, clear_s=2.0))
    suspected = Suspicion(MisledBy.SILENT)
    assert [cycle.see(at(second), suspected) for second in range(10)] == [None] * 10
    assert cycle.misled_by is MisledBy.SILENT
    cycle.see(at(10), Finding(Severity.ALARM, "It drags.", {}, misled_by=MisledBy.DRAG))
    cycle.see(at(11), suspected)
    assert cycle.see(at(12), Finding(Severity.ALARM, "It drags.", {})) is None  # debounced anew
    assert cycle.see(at(14), Finding(Severity.ALARM, "It drags.", {})) is not None
    assert [cycle.see(at(second), suspected) for second in range(15, 30)] == [None] * 15
    assert cycle.open is not None
    assert cycle.misled_by is MisledBy.SILENT
    cycle.see(at(30), FINE)
    assert cycle.misled_by is None


def _raised(cycle: AlarmCycle, gone_s: float, *, rounds: int) -> int:
    """How often it is raised where its condition is there for 6 s and gone for so long, again and again."""
    count = 0
    for second in range(int(rounds * (6 + gone_s))):
        is_there = second % (6 + gone_s) < 6
        alarm = cycle.see(at(second), Finding(Severity.WARNING, "Lost.", {}) if is_there else FINE)
        count += alarm is not None and alarm.cleared_time_s is None
    return count


@pytest.mark.parametrize(("gone_s", "most"), [(11, 4), (30, 5), (55, 6)])
def test_a_condition_that_comes_and_goes_is_one_alarm_and_not_one_each_time(gone_s: float, most: int) -> None:
    """2 s, then 4, 8, ... until the condition is never gone for long enough."""
    settings = RuleSettings(debounce_s=1.0, clear_s=2.0)
    cycle = AlarmCycle("input_lost", None, settings)
    assert _raised(cycle, gone_s, rounds=40) == most
    assert cycle.open is not None
    for second in range(10_000, 10_000 + 128 + 1):
        cycle.see(at(second), FINE)
    assert cycle.open is None
    assert _raised(AlarmCycle("slide", 1, settings, is_event=True), gone_s, rounds=40) == 40


def test_what_comes_back_after_a_long_time_is_new_and_over_as_soon_as_ever() -> None:
    cycle = AlarmCycle("input_lost", None, RuleSettings(debounce_s=1.0, clear_s=2.0))
    assert _raised(cycle, 64, rounds=40) == 40


@pytest.mark.parametrize(("clear_s", "longest_s"), [(100.0, 600.0), (900.0, 900.0)])
def test_however_often_it_comes_back_it_is_over_after_ten_minutes_or_what_was_set(
    clear_s: float, longest_s: float
) -> None:
    cycle = AlarmCycle("input_lost", None, RuleSettings(debounce_s=0.0, clear_s=clear_s))
    second = 0
    for _ in range(6):
        cycle.see(at(second), Finding(Severity.WARNING, "Lost.", {}))
        assert cycle.open is not None
        began = second
        while cycle.open is not None:
            second += 1
            cycle.see(at(second), FINE)
    assert second - began == longest_s + 1
