"""The low-adhesion rule: only when the wheels asked for more than the rail gave, and once per event."""

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import Finding
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.monitoring.rules.low_adhesion import LowAdhesion
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.alarm_settings import AlarmSettings, LowAdhesionRule, SlideRule
from estimates import estimate, observation, report, wheelset


def moment(
    time_s: float,
    adhesion: float,
    *,
    saturated: bool = True,
    speed_mps: float = 20.0,
    status: Status = Status.VALID,
) -> Estimate:
    own = wheelset(slip=0.15 if saturated else 0.002, adhesion=adhesion, wsp_active=saturated)
    return estimate(
        time_s=time_s,
        speed_mps=speed_mps,
        adhesion=adhesion,
        saturated=saturated,
        wheelsets=(own,),
        status=status,
    )


def play(estimates: list[Estimate], rule: LowAdhesionRule | None = None) -> list[Alarm]:
    settings = AlarmSettings(low_adhesion=rule or LowAdhesionRule(), slide=SlideRule(enabled=False))
    monitor = Monitor(wagon_rules(settings, 1))
    return [alarm for e in estimates for alarm in monitor.see(observation(e, wheels=(state(e),)))]


def state(e: Estimate) -> WheelState:
    return WheelState.SLIDING if e.saturated else WheelState.ROLLING


def stretch(start_s: float, end_s: float, adhesion: float, **kind: object) -> list[Estimate]:
    """Ten estimates a second."""
    return [moment(k / 10, adhesion, **kind) for k in range(round(start_s * 10), round(end_s * 10))]  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("adhesion", "severity"), [(0.08, Severity.INFO), (0.03, Severity.WARNING), (0.015, Severity.ALARM)]
)
def test_raised_half_a_second_after_it_qualifies(adhesion: float, severity: Severity) -> None:
    (alarm,) = play(stretch(10.0, 12.0, adhesion))
    assert alarm.raised_time_s == pytest.approx(10.5)
    assert alarm.severity == severity
    assert alarm.cleared_time_s is None
    assert alarm.evidence["adhesion"] == pytest.approx(adhesion)


def test_never_from_a_brake_that_did_not_ask_for_more() -> None:
    assert play(stretch(0.0, 60.0, 0.03, saturated=False)) == []


def test_never_at_walking_pace_nor_from_an_invalid_estimate() -> None:
    assert play(stretch(0.0, 10.0, 0.03, speed_mps=1.0)) == []
    assert play(stretch(0.0, 10.0, 0.03, status=Status.INVALID)) == []


def test_a_released_brake_between_wsp_cycles_is_not_low_adhesion() -> None:
    """Good rail with WSP cycling: the utilised adhesion dips to nothing each time, the rail gives 0.15."""
    cycles = [moment(k / 10, 0.15 if k % 3 else 0.0) for k in range(200)]
    assert play(cycles) == []


def test_a_clock_that_is_set_back_in_an_event_makes_it_no_graver() -> None:
    """The estimate starts anew and knows nothing yet; the event goes on, and what was told of it holds."""
    anew = [replace(e, time_s=e.time_s - 0.2) for e in stretch(13.0, 16.0, 0.0, status=Status.CONVERGING)]
    after = [replace(e, time_s=e.time_s - 0.2) for e in stretch(16.0, 20.0, 0.06)]
    told = play(stretch(10.0, 13.0, 0.06) + anew + after + stretch(20.0, 28.0, 0.15))
    assert {alarm.id for alarm in told} == {told[0].id}
    assert told[-1].severity is Severity.INFO
    assert told[-1].evidence["least_adhesion"] == pytest.approx(0.06)
    assert told[-1].evidence["ended_time_s"] == pytest.approx(19.7)


def test_a_clock_that_is_set_back_by_a_minute_does_not_keep_an_event_open_for_as_long() -> None:
    after = [replace(e, time_s=e.time_s - 60.0) for e in stretch(103.0, 110.0, 0.02, saturated=False)]
    raised, cleared = play(stretch(100.0, 103.0, 0.06) + after)
    assert cleared.id == raised.id
    assert cleared.cleared_time_s == pytest.approx(103.0 - 60.0 + LowAdhesionRule().merge_gap_s, abs=1.5)


def test_what_estimates_in_doubt_told_of_the_rail_is_no_part_of_its_median() -> None:
    doubted, valid = stretch(10.0, 13.0, 0.01, status=Status.CONVERGING), stretch(13.0, 15.0, 0.06)
    told = play(doubted + valid + stretch(15.0, 20.0, 0.15))
    assert told[-1].evidence["median_adhesion"] == pytest.approx(0.06)


def unsure(estimates: list[Estimate], adhesion_std: float) -> list[Estimate]:
    return [replace(e, wheelsets=(replace(e.wheelsets[0], adhesion_std=adhesion_std),)) for e in estimates]


def test_an_estimate_that_is_in_doubt_tells_no_more_than_its_interval() -> None:
    (alarm,) = play(unsure(stretch(10.0, 13.0, 0.0, status=Status.CONVERGING), 0.03))
    assert alarm.severity is Severity.INFO
    assert alarm.evidence["least_adhesion"] == pytest.approx(1.96 * 0.03)


def test_nor_does_a_wheelset_that_stands_of_which_nothing_but_the_wagon_tells() -> None:
    """Its brake may do more than its pressing force says: it slid on 0.04, and seems to take less from then on."""
    standing = unsure(stretch(12.0, 15.0, 0.01), 0.013)
    monitor = Monitor(wagon_rules(AlarmSettings(slide=SlideRule(enabled=False)), 1))
    told = []
    for e in stretch(10.0, 12.0, 0.04) + standing + stretch(15.0, 20.0, 0.15):
        wheel = WheelState.STOPPED if e in standing else WheelState.SLIDING
        told += [alarm for alarm in monitor.see(observation(e, wheels=(wheel,))) if alarm.kind == "low_adhesion"]
    raised, cleared = told
    assert raised.severity is cleared.severity is Severity.WARNING
    assert cleared.evidence["least_adhesion"] == pytest.approx(0.01 + 1.96 * 0.013)


def test_an_event_goes_on_while_wheelsets_stand_and_nobody_knows_any_more_what_the_rail_gives() -> None:
    """While they stand nothing tells of it but the wagon's speed: the interval grows, the estimate does not."""
    standing = [unsure([e], 0.004 * k)[0] for k, e in enumerate(stretch(12.0, 25.0, 0.03))]
    monitor = Monitor(wagon_rules(AlarmSettings(slide=SlideRule(enabled=False)), 1))
    told = []
    for e in stretch(10.0, 12.0, 0.04) + standing + stretch(25.0, 30.0, 0.0, saturated=False):
        wheel = WheelState.STOPPED if e in standing else state(e)
        told += [alarm for alarm in monitor.see(observation(e, wheels=(wheel,))) if alarm.kind == "low_adhesion"]
    (cleared,) = [alarm for alarm in told if alarm.cleared_time_s is not None]
    assert cleared.evidence["ended_time_s"] == pytest.approx(25.0, abs=0.45)  # one that was released still tells
    assert cleared.severity is Severity.WARNING


def test_what_a_slide_begins_with_is_no_news_of_the_rail_until_there_is_half_a_second_of_it() -> None:
    """A wheelset that another force holds slides before its brake is on, and its adhesion seems to rise with that."""
    (alarm,) = play(stretch(10.0, 10.1, 0.003) + stretch(10.1, 10.2, 0.016) + stretch(10.2, 13.0, 0.03))
    assert alarm.severity is Severity.WARNING
    assert alarm.evidence["least_adhesion"] == pytest.approx(0.03)


def test_what_is_in_doubt_makes_no_event_graver() -> None:
    """A pressing force that freezes in a slide: what is missing of the brake seems to be missing of the rail."""
    doubted = stretch(13.0, 16.0, 0.015, status=Status.CONVERGING)
    *_, alarm = play(stretch(10.0, 13.0, 0.034) + doubted + stretch(16.0, 18.0, 0.034) + stretch(18.0, 25.0, 0.15))
    assert alarm.severity is Severity.WARNING
    assert alarm.cleared_time_s is not None
    assert alarm.evidence["least_adhesion"] == alarm.evidence["median_adhesion"] == 0.034


def test_an_event_that_begins_in_doubt_is_told_and_then_graded_by_what_is_sure() -> None:
    raised, worse = play(stretch(10.0, 13.0, 0.08, status=Status.CONVERGING) + stretch(13.0, 16.0, 0.03))
    assert (raised.severity, worse.severity) == (Severity.INFO, Severity.WARNING)
    (raised,) = play(stretch(10.0, 13.0, 0.03, status=Status.CONVERGING) + stretch(13.0, 16.0, 0.08))
    assert raised.severity is Severity.WARNING  # and stays: an alarm is as grave as it has been


def test_worse_later_is_an_update_of_the_same_alarm() -> None:
    raised, worse = play(stretch(0.0, 3.0, 0.08) + stretch(3.0, 6.0, 0.03) + stretch(6.0, 8.0, 0.07))
    assert worse.id == raised.id
    assert worse.raised_time_s == raised.raised_time_s
    assert (raised.severity, worse.severity) == (Severity.INFO, Severity.WARNING)


def test_the_speed_that_is_told_is_that_at_which_the_rail_gave_least() -> None:
    (alarm,) = play(stretch(0.0, 0.6, 0.06, speed_mps=30.0) + stretch(0.6, 0.9, 0.09, speed_mps=20.0))
    assert "no more than 0.060 (limit 0.1) at 108 km/h" in alarm.message


def test_cleared_after_two_seconds_above_the_level_and_its_margin() -> None:
    _, cleared = play(stretch(0.0, 3.0, 0.06) + stretch(3.0, 6.0, 0.20))
    assert cleared.cleared_time_s == pytest.approx(5.0)
    assert cleared.evidence["least_adhesion"] == pytest.approx(0.06)


def test_within_the_hysteresis_it_stays_open() -> None:
    assert len(play(stretch(0.0, 3.0, 0.06) + stretch(3.0, 30.0, 0.11))) == 1


def test_a_short_gap_does_not_make_two_events() -> None:
    gap = stretch(3.0, 5.5, 0.02, saturated=False)
    assert len(play(stretch(0.0, 3.0, 0.06) + gap + stretch(5.5, 8.0, 0.06))) == 1


def test_a_long_gap_makes_two_events_with_ids_of_their_own() -> None:
    gap = stretch(3.0, 10.0, 0.02, saturated=False)
    alarms = play(stretch(0.0, 3.0, 0.06) + gap + stretch(10.0, 13.0, 0.06))
    assert [a.cleared_time_s is None for a in alarms] == [True, False, True]
    assert alarms[0].id == alarms[1].id != alarms[2].id
    assert alarms[1].cleared_time_s == pytest.approx(2.9 + LowAdhesionRule().merge_gap_s)


def test_can_be_switched_off() -> None:
    assert play(stretch(0.0, 10.0, 0.01), LowAdhesionRule(enabled=False)) == []


def test_a_brake_that_is_filled_again_does_not_take_yet_what_the_rail_has_to_give() -> None:
    """Between two slides on 0.08 its slip passes 2 %, where a rail gives half of that."""
    refilled = [moment(k / 10, 0.04) for k in (140, 141)]
    *_, alarm = play(stretch(10.0, 12.0, 0.08) + refilled + stretch(14.2, 16.0, 0.08))
    assert alarm.severity is Severity.INFO
    assert alarm.evidence["least_adhesion"] == 0.08


def seen_of(e: Estimate, *wheels: WheelState) -> Observation:
    return observation(e, wheels=wheels)


def watched(observations: list[Observation]) -> list[Alarm]:
    count = len(observations[0].wheels)
    monitor = Monitor(wagon_rules(AlarmSettings(slide=SlideRule(enabled=False)), count))
    return [alarm for seen in observations for alarm in monitor.see(seen)]


def test_who_rolls_beside_one_that_slides_tells_nothing_of_the_rail() -> None:
    """Its slip is within what a good rail needs for its own brake."""
    sliding, rolling = wheelset(slip=0.15, adhesion=0.03), wheelset(slip=0.02, adhesion=0.14)
    told = [estimate(time_s=k / 10, wheelsets=(sliding, rolling)) for k in range(10)]
    raised, *_ = watched([seen_of(now, WheelState.SLIDING, WheelState.ROLLING) for now in told])
    assert raised.severity is Severity.WARNING
    assert raised.evidence["adhesion"] == pytest.approx(0.03)
    assert (raised.evidence["greatest_slip_1"], raised.evidence["greatest_slip_2"]) == (0.15, 0.02)


def test_the_rail_gives_what_those_that_slide_take_on_average() -> None:
    both = wheelset(slip=0.15, adhesion=0.03), wheelset(slip=0.15, adhesion=0.05)
    told = [estimate(time_s=k / 10, wheelsets=both) for k in range(10)]
    raised, *_ = watched([seen_of(now, WheelState.SLIDING, WheelState.SLIDING) for now in told])
    assert raised.evidence["adhesion"] == pytest.approx(0.04)


@pytest.mark.parametrize(("beside", "is_told"), [(WheelState.ROLLING, True), (WheelState.BLOCKED, False)])
def test_beside_one_that_is_blocked_a_wheelset_that_stands_tells_nothing(beside: WheelState, is_told: bool) -> None:
    """How much of what retards the wagon is whose, nobody knows."""
    both = wheelset(slip=1.0, adhesion=0.03), wheelset(slip=0.0, adhesion=0.03)
    told = [estimate(time_s=k / 10, wheelsets=both) for k in range(20)]
    given = watched([seen_of(now, WheelState.STOPPED, beside) for now in told])
    assert ("low_adhesion" in {alarm.kind for alarm in given}) is is_told


@pytest.mark.parametrize(("then", "told_until_s"), [(WheelState.ROLLING, 0.4), (WheelState.PROTECTED, 1.5)])
def test_for_a_while_a_slide_tells_of_the_rail_after_it(then: WheelState, told_until_s: float) -> None:
    """What its protection releases slides again at once, and what it keeps from sliding far tries in a second."""
    rule = LowAdhesion(LowAdhesionRule(), 1)
    found_s = []
    for k in range(40):
        own = wheelset(slip=0.15 if k == 0 else 0.01, adhesion=0.03 if k == 0 else 0.01)
        now = estimate(time_s=k / 10, wheelsets=(own,))
        (verdict,) = rule.judge(seen_of(now, then if k else WheelState.SLIDING))
        found_s += [k / 10] * isinstance(verdict, Finding)
    assert found_s[-1] == told_until_s


@pytest.mark.parametrize("sands", [False, True])
def test_an_event_tells_of_what_slide_protection_and_driver_did_in_it(sands: bool) -> None:
    """Of five acts, three were in an application before it; sand is strewn for a moment."""
    drive = stretch(0.0, 10.0, 0.15, saturated=False) + stretch(10.0, 14.0, 0.03) + stretch(14.0, 25.0, 0.2)
    acts = [WheelsetWork(wsp_actions=3 + (e.time_s >= 10.5) + (e.time_s >= 12.0)) for e in drive]
    own = [replace(e.wheelsets[0], work=work) for e, work in zip(drive, acts, strict=True)]
    *_, last = play(
        [
            replace(e, wheelsets=(wheel,), sanding=sands and e.time_s == 11.0)
            for e, wheel in zip(drive, own, strict=True)
        ]
    )
    assert last.cleared_time_s is not None
    assert last.evidence["wsp_actions"] == 2
    assert last.evidence["sanding"] == ("yes" if sands else "no")


def test_slides_that_protection_ends_at_once_tell_of_the_rail_until_it_tries_again() -> None:
    """Below the peak, between two of them, the wheelset takes but what its brake asks for."""
    given = []
    for k in range(60):
        slides = k % 12 == 0
        own = wheelset(slip=0.03 if slides else 0.01, adhesion=0.04 if slides else 0.01, is_protected=True)
        given.append(seen_of(estimate(time_s=k / 10, wheelsets=(own,)), WheelState.PROTECTED))
    (raised,) = watched(given)
    assert raised.raised_time_s == pytest.approx(0.5)
    assert raised.evidence["least_adhesion"] == pytest.approx(0.04)


def test_a_vehicle_speed_that_is_lost_clears_nothing() -> None:
    slide = [seen_of(e, WheelState.SLIDING) for e in stretch(10.0, 12.0, 0.03)]
    blind = stretch(12.0, 60.0, 0.03, status=Status.INVALID)
    given = watched(slide + [seen_of(e, WheelState.UNKNOWN) for e in blind])
    assert {alarm.cleared_time_s for alarm in given} == {None}


def test_an_event_too_short_to_be_told_lets_no_invalid_estimate_tell_one_an_hour_later() -> None:
    short = stretch(10.0, 10.1, 0.03) + stretch(10.1, 30.0, 0.02, saturated=False)
    assert play(short + stretch(3600.0, 3610.0, 0.03, status=Status.INVALID)) == []


def test_a_wheel_speed_that_is_lost_does_not_end_what_the_other_wheelset_tells() -> None:
    def both(e: Estimate) -> Estimate:
        lost = replace(e.wheelsets[0], friction_status=Status.INVALID, adhesion=0.2)
        return replace(e, wheelsets=(lost, e.wheelsets[0]))

    slide = [seen_of(both(e), WheelState.SLIDING, WheelState.SLIDING) for e in stretch(10.0, 12.0, 0.03)]
    lame = [both(e) for e in stretch(12.0, 60.0, 0.03, status=Status.INVALID)]
    given = watched(slide + [seen_of(e, WheelState.UNKNOWN, WheelState.SLIDING) for e in lame])
    assert {(alarm.cleared_time_s, alarm.evidence["least_adhesion"]) for alarm in given} == {(None, 0.03)}


@pytest.mark.parametrize(("missed", "is_told"), [(Quantity.AXLE_SPEED, True), (Quantity.SPEED, False)])
def test_an_invalid_estimate_begins_an_event_only_where_the_vehicles_speed_is_known(
    missed: Quantity, is_told: bool
) -> None:
    """Without it nobody knows what slides; a wheelset that misses an input of its own leaves the others."""
    inputs = (report(missed, 0, "M.s", InputCondition.LOST),)
    slide = stretch(10.0, 12.0, 0.03, status=Status.INVALID)
    given = watched([observation(e, inputs, wheels=(WheelState.SLIDING,)) for e in slide])
    assert bool(given) is is_told


def test_an_event_adds_up_over_a_restart() -> None:
    """The rail gave 0.03 and then 0.06; the program was started anew between, and counts way and WSP from 0."""
    settings = AlarmSettings(slide=SlideRule(enabled=False))
    before, after = Monitor(wagon_rules(settings, 1)), Monitor(wagon_rules(settings, 1))
    low = [replace(e, distance_m=20.0 * (e.time_s - 10.0), sanding=True) for e in stretch(10.0, 13.0, 0.03)]
    higher = [replace(e, distance_m=20.0 * (e.time_s - 13.0)) for e in stretch(13.0, 16.0, 0.06, speed_mps=10.0)]
    rolls = stretch(16.0, 30.0, 0.15)
    for e in low:
        own = replace(e.wheelsets[0], work=WheelsetWork(wsp_actions=2 * (e.time_s >= 11.0)))
        before.see(observation(replace(e, wheelsets=(own,)), wheels=(state(e),)))
    after.resume(before.open_alarms())
    given = [alarm for e in higher + rolls for alarm in after.see(observation(e, wheels=(state(e),)))]
    last = given[-1]
    assert last.id == before.open_alarms()[0].id
    assert last.cleared_time_s is not None
    assert last.severity is Severity.WARNING
    assert last.evidence["least_adhesion"] == pytest.approx(0.03)
    assert (last.evidence["started_time_s"], last.evidence["ended_time_s"]) == (10.0, pytest.approx(15.9))
    assert last.evidence["distance_m"] == pytest.approx(20.0 * 5.8, abs=4.0)
    assert (last.evidence["speed_start_mps"], last.evidence["speed_end_mps"]) == (20.0, 10.0)
    assert (last.evidence["sanding"], last.evidence["wsp_actions"]) == ("yes", 2)
    assert "no more than 0.030 (limit 0.05) at 72 km/h" in last.message


def test_an_event_goes_on_over_a_restart_until_the_wheelsets_are_known_again() -> None:
    """The new run hears of no wheelset for its first minute: what was told stands, and then goes."""
    settings = AlarmSettings(slide=SlideRule(enabled=False))
    before, after = Monitor(wagon_rules(settings, 1)), Monitor(wagon_rules(settings, 1))
    for e in stretch(10.0, 13.0, 0.03):
        before.see(observation(e, wheels=(state(e),)))
    (alarm,) = before.open_alarms()
    after.resume([alarm])
    for e in stretch(14.0, 74.0, 0.0, saturated=False, status=Status.INVALID):
        after.see(observation(e, wheels=(WheelState.UNKNOWN,)))
    assert [still.id for still in after.open_alarms()] == [alarm.id]
    for e in stretch(74.0, 79.0, 0.15):
        after.see(observation(e, wheels=(state(e),)))
    assert not after.open_alarms()


def test_an_event_that_an_earlier_run_told_by_higher_limits_goes_on() -> None:
    """The limits were lowered by a reload while wheelsets slid; before any estimate is valid again, nothing changes."""
    before = Monitor(wagon_rules(AlarmSettings(slide=SlideRule(enabled=False)), 1))
    lowered = LowAdhesionRule(low=0.05, very_low=0.03, extremely_low=0.01)
    after = Monitor(wagon_rules(AlarmSettings(low_adhesion=lowered, slide=SlideRule(enabled=False)), 1))
    for e in stretch(10.0, 13.0, 0.08):
        before.see(observation(e, wheels=(state(e),)))
    after.resume(before.open_alarms())
    for e in stretch(13.0, 15.0, 0.04, status=Status.CONVERGING):
        after.see(observation(e, wheels=(state(e),)))
    (alarm,) = after.open_alarms()
    assert alarm.severity is Severity.INFO
    assert alarm.evidence["least_adhesion"] == pytest.approx(0.08)
