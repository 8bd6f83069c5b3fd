"""When a slide is over, and how often slide protection acted in it."""

from functools import cache

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.alarm_cycle import AlarmCycle
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.monitor import Monitor
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Finding, Verdict
from brake_monitor.monitoring.rules.all_rules import wagon_rules
from brake_monitor.monitoring.rules.slide import Slide
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.alarm_settings import AlarmSettings, SlideRule
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.physics.pneumatics import Valve
from brake_monitor.simulator.physics.wsp import WheelSlideProtection
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from estimates import estimate, observation, wheelset

STOPPED = Scenario(
    name="stop on leaves",
    summary="coast, full brake on a slippery rail until it stands, and stand",
    initial_speed_mps=10.0,
    duration_s=60.0,
    demand=LegJourney((Leg(Act.COAST, lasts_s=5.0), Leg(Act.STAND, lasts_s=30.0, demand=1.0)), 500.0),
    rail_over_time=Profile(((3.0, 0.3), (4.0, 0.06))),
)
CLEAR_S = 2.0  # of the rule, and of low speed before


@cache
def locked_stop() -> Recording:
    return simulate(STOPPED, example_settings("wagon"), 3, Modifiers(slide_protection=False))


def last_of(recording: Recording, kind: str) -> dict[int | None, Alarm]:
    """The last state of each alarm of a kind, by wheelset."""
    pipeline = Pipeline.from_settings(recording.settings)
    given = [alarm for frame in recording.frames for alarm in pipeline.step(frame).alarms if alarm.kind == kind]
    return {alarm.wheelset: alarm for alarm in given}


def test_a_slide_with_locked_wheelsets_ends_where_the_wagon_stands() -> None:
    """Its wheelsets do not turn before the wagon does, perhaps hours later."""
    recording = locked_stop()
    speed_mps = recording.trace.wagon("speed_mps")
    stood_s = next(k for k, speed in enumerate(speed_mps) if k * recording.trace.step_s > 5.0 and speed < 0.02)
    stood_s *= recording.trace.step_s
    slides = last_of(recording, "slide")
    assert set(slides) == {1, 2}
    for slide in slides.values():
        assert slide.cleared_time_s is not None
        assert abs(slide.cleared_time_s - EPOCH_S - stood_s - CLEAR_S) < 1.0
        assert slide.evidence["speed_end_mps"] < 1.5  # walking pace, below which wheel-speed sensors cut out


@pytest.mark.parametrize(("set_s", "by_s"), [(5.5, 3600.0), (5.5, -3600.0), (1.0, 3600.0)])
def test_a_slide_goes_on_over_a_clock_that_is_set(set_s: float, by_s: float) -> None:
    """Set while protection lets the wheelset roll for a second, after which it slides on; or before it slid."""
    pipeline = Pipeline.from_settings(example_settings("wagon"))
    changed: list[tuple[float, Alarm]] = []
    for k in range(250):
        slip = 0.3 if 20 <= k < 50 or 60 <= k < 100 else 0.0
        own = wheelset(slip=slip)
        now = estimate(
            time_s=5000.0 + k / 10, clock_ahead_s=by_s * (k / 10 >= set_s), speed_mps=20.0, wheelsets=(own, own)
        )
        states = (WheelState.SLIDING if slip else WheelState.ROLLING, WheelState.ROLLING)
        alarms = pipeline.monitor.see(observation(now, wheels=states))
        changed += [(k / 10, alarm) for alarm in alarms if alarm.kind == "slide"]
    assert {alarm.id for _, alarm in changed} == {changed[0][1].id}
    cleared_s, cleared = changed[-1]
    assert cleared.cleared_time_s is not None
    assert cleared_s == pytest.approx(9.9 + CLEAR_S, abs=0.15)
    assert cleared.evidence["started_time_s"] == pytest.approx(5002.0 + by_s * (set_s < 2.0))  # as it was told
    assert cleared.evidence["ended_time_s"] == pytest.approx(5009.9 + by_s)
    assert cleared.evidence["sliding_distance_m"] == pytest.approx(0.3 * 20.0 * 7.0, rel=0.05)


def test_a_slide_that_was_too_short_to_be_told_is_no_part_of_a_later_one() -> None:
    settings = SlideRule(debounce_s=1.0)
    rule, cycle = Slide(settings, 1), AlarmCycle("slide", 1, settings)
    given: list[Alarm] = []
    for k in range(1200):
        slides = 100 <= k < 105 or 1000 <= k < 1030  # half a second, and three
        now = estimate(time_s=k / 10, speed_mps=20.0, wheelsets=(wheelset(slip=0.5 * slides),))
        state = WheelState.SLIDING if slides else WheelState.ROLLING
        if alarm := cycle.see(now, rule.judge(observation(now, wheels=(state,)))[0]):
            given.append(alarm)
    assert given[0].evidence["started_time_s"] == 100.0
    assert rule.closing_evidence(0)["sliding_distance_m"] == pytest.approx(30.0, rel=0.05)


@pytest.mark.parametrize(("gap_s", "is_one"), [(1.0, True), (90.0, False)])
@pytest.mark.parametrize("between", [WheelState.ROLLING, WheelState.UNKNOWN, WheelState.DOUBTFUL])
def test_nor_where_nothing_was_known_in_between(between: WheelState, gap_s: float, *, is_one: bool) -> None:
    """2 m twice, of which 3 are told."""
    rule, verdicts = Slide(SlideRule(), 1), []
    for k in range(1200):
        slides = k in (100, 101) or 0 <= k - 102 - round(10 * gap_s) < 2
        state = WheelState.SLIDING if slides else between
        now = estimate(time_s=k / 10, speed_mps=20.0, wheelsets=(wheelset(slip=0.5 * slides),))
        verdicts += rule.judge(observation(now, wheels=(state,)))
    assert any(isinstance(verdict, Finding) for verdict in verdicts) is is_one


def test_a_slide_that_is_not_told_yet_is_not_over_before_it_has_rolled_for_a_while() -> None:
    """2.5 m, of which 3 are told; then the wheelset rolls, and then nobody knows."""
    rule, verdicts = Slide(SlideRule(), 1), []
    for k in range(100):
        state = WheelState.SLIDING if k in (20, 21) else WheelState.DOUBTFUL if k >= 90 else WheelState.ROLLING
        now = estimate(time_s=k / 8, speed_mps=20.0, wheelsets=(wheelset(slip=0.5 * (state is WheelState.SLIDING)),))
        verdicts += rule.judge(observation(now, wheels=(state,)))
    over = 21 + round(8 * SlideRule().clear_s)
    assert verdicts == [FINE] * 20 + [UNKNOWN] * (over - 20) + [FINE] * (90 - over) + [UNKNOWN] * 10


def test_an_act_of_slide_protection_just_before_the_slide_shows_is_one_of_it() -> None:
    """A good one lets the brake go before the wheelset slips by much."""
    rule, seen = Slide(SlideRule(), 1), []
    for k in range(100):
        slides, acts = 30 <= k < 60, (k >= 5) + (k >= 25) + (k >= 45)  # the first one is of something else
        own = wheelset(slip=0.3 * slides, work=WheelsetWork(wsp_actions=acts))
        state = WheelState.SLIDING if slides else WheelState.ROLLING
        seen += rule.judge(observation(estimate(time_s=k / 10, speed_mps=20.0, wheelsets=(own,)), wheels=(state,)))
    assert max(v.evidence["wsp_actions"] for v in seen if isinstance(v, Finding)) == 2


LEAVES = Scenario(
    name="full brake on leaves",
    summary="coast, full brake from 8 s on a rail that is slippery from then until 24 s, released at 26 s",
    initial_speed_mps=28.0,
    duration_s=30.0,
    demand=steps((8.0, 1.0), (26.0, 0.0)),
    rail_over_time=Profile(((7.0, 0.3), (8.0, 0.04), (24.0, 0.04), (25.0, 0.3))),
)
MISCOUNTED = 0.2  # seen ten times a second, two acts may look like one, or a refilling in steps like two


class Counting(WheelSlideProtection):
    """Counts how often it lets each brake go."""

    acts: list[int]
    _was: list[Valve]

    def step(self, wheel_speeds_mps: list[float]) -> list[Valve]:
        valves = super().step(wheel_speeds_mps)
        if not hasattr(self, "_was"):
            type(self).acts, self._was = [0] * len(valves), valves
        for i, (valve, was) in enumerate(zip(valves, self._was, strict=True)):
            type(self).acts[i] += valve is Valve.DUMP and was is not Valve.DUMP
        self._was = valves
        return valves


@pytest.mark.parametrize("flags", ["each its own", "one for all", "none"])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_the_acts_of_slide_protection_are_counted_by_what_it_does(
    vehicle: str, flags: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its flag stays up throughout the slide, rises before the slide shows, and may be missing or shared."""
    monkeypatch.setattr("brake_monitor.simulator.plant.WheelSlideProtection", Counting)
    settings = example_settings(vehicle)
    recording = simulate(LEAVES, settings, 3)
    mapped = {"each its own": settings.signals.wsp_active, "one for all": settings.signals.wsp_active[:1], "none": ()}
    signals = replace(settings.signals, wsp_active=mapped[flags])
    pipeline = Pipeline.from_settings(replace(settings, signals=signals))
    given = [alarm for frame in recording.frames for alarm in pipeline.step(frame).alarms]
    found = {(alarm.kind, alarm.wheelset): alarm.evidence for alarm in given}
    assert min(Counting.acts) > 10
    assert found["low_adhesion", None]["wsp_actions"] == pytest.approx(sum(Counting.acts), rel=MISCOUNTED)


def after_steps(count: int, slip: float, step_s: float = 0.1) -> Verdict:
    """What is said of a wheelset that has slid for so many steps, at 20 m/s."""
    rule = Slide(SlideRule(), 1)
    for k in range(count + 1):
        now = estimate(time_s=k * step_s, speed_mps=20.0, wheelsets=(wheelset(slip=slip if k else 0.0),))
        (verdict,) = rule.judge(observation(now, wheels=(WheelState.SLIDING if k else WheelState.ROLLING,)))
    return verdict


@pytest.mark.parametrize(
    ("steps", "slip", "severity"),
    [
        (1, 0.9, None),  # 1.8 m
        (2, 0.9, Severity.INFO),  # 3.6 m
        (5, 0.9, Severity.INFO),  # 9.0 m
        (6, 0.9, Severity.WARNING),  # 10.8 m
        (27, 0.9, Severity.WARNING),  # 48.6 m
        (28, 0.9, Severity.ALARM),  # 50.4 m
        (100, 0.7, Severity.INFO),  # 140 m, but always another part of its treads
    ],
)
def test_a_slide_is_as_grave_as_the_way_on_one_part_of_the_treads(
    steps: int, slip: float, severity: Severity | None
) -> None:
    verdict = after_steps(steps, slip)
    assert (verdict.severity if isinstance(verdict, Finding) else None) is severity
    assert isinstance(verdict, Finding) or verdict is UNKNOWN


def test_what_nobody_saw_is_no_way() -> None:
    assert after_steps(20, 0.9, step_s=1.5) is UNKNOWN


def test_what_is_told_of_a_slide() -> None:
    """From 20 to 15 m/s, half as fast as the wagon; the protection had acted five times before it, and does thrice."""
    rule = Slide(SlideRule(), 1)
    for k in range(101):
        slides = k >= 51
        speed_mps = 20.0 - max(k - 51, 0) * 5.0 / 49.0
        work = WheelsetWork(wsp_actions=(5 if k else 0) + (k > 60) + (k > 70) + (k > 80))
        own = wheelset(slip=(0.4 if k < 60 else 0.5) if slides else 0.0, work=work)
        now = estimate(time_s=k / 10, clock_ahead_s=1000.0, speed_mps=speed_mps, wheelsets=(own,))
        (verdict,) = rule.judge(observation(now, wheels=(WheelState.SLIDING if slides else WheelState.ROLLING,)))
    assert isinstance(verdict, Finding)
    told = verdict.evidence
    assert [told[name] for name in ("started_time_s", "ended_time_s")] == pytest.approx([1005.1, 1010.0])
    assert [told[name] for name in ("speed_start_mps", "speed_end_mps")] == pytest.approx([20.0, 15.0])
    assert [told[name] for name in ("wsp_actions", "greatest_slip")] == [3, 0.5]
    assert told["sliding_distance_m"] == pytest.approx(0.4 * 0.9 * 19.59 + 0.5 * 4.1 * 17.04, rel=0.01)
    assert told["nearly_stopped_distance_m"] == 0.0
    assert "slid 42 m across the rail, 0 m of that nearly stopped, from 72 to 54 km/h; no flat" in verdict.message


def test_a_slide_adds_up_over_a_restart() -> None:
    """Four seconds before the program ended, half a second since, at 20 m/s and a slip of 0.9."""
    moments = [estimate(time_s=k / 10, speed_mps=20.0, wheelsets=(wheelset(slip=0.9),)) for k in range(45)]
    seen = [observation(now, wheels=(WheelState.SLIDING,)) for now in moments]
    before, after = Monitor(wagon_rules(AlarmSettings(), 1)), Monitor(wagon_rules(AlarmSettings(), 1))
    for one in seen[:40]:
        before.see(one)
    after.resume(before.open_alarms())
    for one in seen[40:]:
        after.see(one)
    (slide,) = [alarm for alarm in after.open_alarms() if alarm.kind == "slide"]
    assert slide.evidence["started_time_s"] == 0.0
    assert slide.evidence["sliding_distance_m"] == pytest.approx(0.9 * 20.0 * 4.4, abs=4.0)
    assert slide.evidence["nearly_stopped_distance_m"] == slide.evidence["sliding_distance_m"]
    assert slide.severity is Severity.ALARM


def test_a_milder_slide_while_a_graver_one_is_not_yet_acknowledged_is_not_its_extent() -> None:
    monitor = Monitor(wagon_rules(AlarmSettings(slide=SlideRule(latched=True)), 1))
    given: list[Alarm] = []
    for k in range(7100):
        time_s = k / 10
        slip = 0.95 if 10.0 <= time_s < 16.0 else 0.3 if 600.0 <= time_s < 601.0 else 0.0
        now = estimate(time_s=time_s, speed_mps=18.0, wheelsets=(wheelset(slip=slip, adhesion=0.15),))
        state = WheelState.SLIDING if slip else WheelState.ROLLING
        if k == 7000:
            monitor.acknowledge(next(a.id for a in monitor.open_alarms() if a.kind == "slide"), time_s)
        given += [a for a in monitor.see(observation(now, wheels=(state,))) if a.kind == "slide"]
    assert given[-1].cleared_time_s is not None
    assert given[-1].severity is Severity.ALARM
    assert given[-1].evidence["nearly_stopped_distance_m"] == pytest.approx(0.95 * 18.0 * 6.0, abs=4.0)
