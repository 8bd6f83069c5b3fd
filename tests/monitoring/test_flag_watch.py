"""A WSP flag that stays set over a wheelset that rolls is stuck; one that is set because the WSP acts is not."""

from collections.abc import Callable, Iterator

import pytest

from brake_monitor.estimation.estimate import WheelsetEstimate
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.flag_watch import STUCK_S, FlagWatch
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import run as simulate
from estimates import estimate, wheelset

CONTACT_N = 500.0
FOUND = frozenset({0})
NONE: frozenset[int] = frozenset()
ROLLS = wheelset(slip=0.002, pressing_force_n=0.0)
BRAKED = wheelset(slip=0.002, pressing_force_n=40e3)
Course = Callable[[float], tuple[WheelsetEstimate, ...]]


def show(watch: FlagWatch, sample: Sample) -> None:
    watch.watchers[sample.measurand](sample.time_s, sample.value)


def watch(flags: int = 2) -> FlagWatch:
    channels = [Channel(Quantity.WSP_ACTIVE, i, "can0", "WSP", "on", 0.0, 0.0, 0.5) for i in range(flags)]
    return FlagWatch(channels, 2, CONTACT_N)


def said(value: float, place: int = 0) -> Sample:
    return Sample(0.0, Quantity.WSP_ACTIVE, place, value, Quality.GOOD)


def judged(
    watched: FlagWatch, course: Course, until_s: float, *, speed_mps: float = 20.0, known: bool = True
) -> Iterator[tuple[float, frozenset[int]]]:
    """What is said of the flags, every 0.1 s."""
    for k in range(round(until_s * 10)):
        now = estimate(time_s=0.1 * k, speed_mps=speed_mps, wheelsets=course(0.1 * k))
        yield 0.1 * k, watched.judge(now, [known, known])


def first(verdicts: Iterator[tuple[float, frozenset[int]]]) -> tuple[float, frozenset[int]] | None:
    return next(((time_s, places) for time_s, places in verdicts if places), None)


def both(own: WheelsetEstimate) -> Course:
    return lambda _: (own, own)


def slides(time_s: float) -> tuple[WheelsetEstimate, ...]:
    """Its WSP empties and refills the brake of wheelset 1 every second and a half; wheelset 2 rolls."""
    emptied = time_s % 1.5 < 0.7
    return wheelset(slip=0.12 if emptied else 0.01, pressing_force_n=10e3 if emptied else 40e3), ROLLS


@pytest.mark.parametrize("flags", [1, 2], ids=["one for all", "one each"])
def test_a_flag_that_stays_set_over_rolling_wheelsets_without_brake_is_stuck(flags: int) -> None:
    watched = watch(flags)
    show(watched, said(1.0))
    found = first(judged(watched, both(ROLLS), 30.0))
    assert found is not None
    assert found[1] == FOUND
    assert STUCK_S <= found[0] <= STUCK_S + 0.3


def test_it_is_believed_again_once_it_falls() -> None:
    watched = watch()
    show(watched, said(1.0))
    assert first(judged(watched, both(ROLLS), 30.0))
    show(watched, said(0.0))
    assert first(judged(watched, both(ROLLS), 30.0)) is None


@pytest.mark.parametrize(
    ("course", "until_s"),
    [(slides, 120.0), (both(BRAKED), 55.0), (both(wheelset(slip=0.3, pressing_force_n=0.0)), 120.0)],
    ids=["acts", "braked for less than a minute", "released while it slides"],
)
def test_a_flag_is_believed_while_there_may_be_something_to_protect(course: Course, until_s: float) -> None:
    watched = watch()
    show(watched, said(1.0))
    assert first(judged(watched, course, until_s)) is None


def test_rolling_between_slides_does_not_add_up() -> None:
    watched = watch()
    show(watched, said(1.0))
    course: Course = lambda t: (wheelset(slip=0.12 * (t % 7.0 < 1.0), pressing_force_n=0.0), ROLLS)  # noqa: E731
    assert all(0 not in places for _, places in judged(watched, course, 120.0))


def test_no_protection_leaves_slip_and_force_alone_for_a_minute() -> None:
    watched = watch()
    show(watched, said(1.0))
    found = first(judged(watched, both(BRAKED), 90.0))
    assert found is not None
    assert found[0] == pytest.approx(60.0, abs=0.5)


@pytest.mark.parametrize(("eases_by_n", "found_s"), [(4.8e3, 60.0), (5.4e3, 90.0)])
def test_a_brake_is_left_alone_as_long_as_it_moves_by_no_more_than_a_tenth_and_a_kilonewton(
    eases_by_n: float, found_s: float
) -> None:
    """It presses with 40 kN, and after half a minute with less."""
    watched = watch()
    show(watched, said(1.0))
    eased = wheelset(slip=0.002, pressing_force_n=40e3 - eases_by_n)
    found = first(judged(watched, lambda t: (BRAKED if t < 30.0 else eased,) * 2, 120.0))
    assert found is not None
    assert found[0] == pytest.approx(found_s, abs=0.5)


@pytest.mark.parametrize(("step_s", "is_told"), [(0.8, True), (1.2, False)])
def test_nobody_knows_what_a_flag_did_between_estimates_that_are_far_apart(step_s: float, is_told: bool) -> None:
    watched = watch()
    show(watched, said(1.0))
    told = [watched.judge(estimate(time_s=step_s * k, wheelsets=(ROLLS, ROLLS)), [True, True]) for k in range(50)]
    assert any(told) is is_told


def test_a_flag_for_all_wheelsets_is_about_a_brake_as_long_as_any_presses() -> None:
    watched = watch(1)
    show(watched, said(1.0))
    assert first(judged(watched, lambda _: (ROLLS, BRAKED), 55.0)) is None


def test_a_flag_for_all_wheelsets_may_be_about_the_one_that_slides() -> None:
    watched = watch(1)
    show(watched, said(1.0))
    assert first(judged(watched, slides, 120.0)) is None


@pytest.mark.parametrize(
    ("speed_mps", "known", "is_told"), [(0.0, True, False), (2.5, True, False), (3.5, True, True), (20.0, False, False)]
)
def test_what_crawls_or_is_not_measured_says_nothing_of_the_flag(speed_mps: float, known: bool, is_told: bool) -> None:
    """Valves are tested while the wagon stands, and slower than 3 m/s slip shows nothing."""
    watched = watch()
    show(watched, said(1.0))
    assert (first(judged(watched, both(ROLLS), 120.0, speed_mps=speed_mps, known=known)) is not None) is is_told


def test_a_stuck_flag_excuses_no_brake() -> None:
    """A brake that never fills is told of although its flag says all the while that the WSP keeps it empty."""
    scenario = Scenario(
        name="two brakings",
        summary="coast, brake from 20 to 26 s and from 34 to 42 s",
        initial_speed_mps=25.0,
        duration_s=45.0,
        demand=steps((20.0, 0.5), (26.0, 0.0), (34.0, 0.5), (42.0, 0.0)),
        rail_over_time=Profile(((0.0, 0.4),)),
    )
    settings = example_settings("wagon")
    stuck = SensorFault("wsp_active", 0, SensorFailure.STUCK, 1.0, value=1.0)
    modifiers = Modifiers(brake_faults=(BrakeFault(0, isolated=True),), sensor_faults=(stuck,))
    pipeline = Pipeline.from_settings(settings)
    raised, claims = set(), []
    for frame in simulate(scenario, settings, seed=3, modifiers=modifiers).frames:
        outputs = pipeline.step(frame)
        raised |= {(alarm.kind, alarm.wheelset) for alarm in outputs.alarms}
        if outputs.estimate is not None:
            claims.append(outputs.estimate.wheelsets[0].wsp_active)
    assert raised == {("input_implausible", 1), ("brake_not_applied", 1)}
    assert any(claims[: len(claims) // 4])  # believed at first
    assert not any(claims[len(claims) // 2 :])


def test_a_wheel_speed_that_is_not_believed_shows_nothing_of_its_flag() -> None:
    """The slide protection hears of a wheelset that stands, as its sensor says, and acts."""
    scenario = Scenario(
        name="coasting",
        summary="coast for 40 s",
        initial_speed_mps=25.0,
        duration_s=40.0,
        demand=Profile(((0.0, 0.0),)),
        rail_over_time=Profile(((0.0, 0.4),)),
    )
    settings = example_settings("wagon")
    dead = SensorFault("axle_speed", 0, SensorFailure.STUCK, 10.0, value=0.0)
    acts = SensorFault("wsp_active", 0, SensorFailure.STUCK, 10.0, value=1.0)
    pipeline = Pipeline.from_settings(settings)
    told = set()
    for frame in simulate(scenario, settings, seed=3, modifiers=Modifiers(sensor_faults=(dead, acts))).frames:
        told |= {(alarm.kind, alarm.evidence["inputs"]) for alarm in pipeline.step(frame).alarms}
    assert told == {("input_implausible", "axle_speed")}


@pytest.mark.parametrize("quality", [Quality.STALE, Quality.OUT_OF_RANGE, Quality.NOT_AVAILABLE])
def test_a_flag_and_a_torque_that_are_not_told_any_more_are_taken_for_none(quality: Quality) -> None:
    flag = Channel(Quantity.WSP_ACTIVE, 0, "can0", "WSP", "on", 0.0, 0.0, 0.5)
    torque = Channel(Quantity.WHEEL_TORQUE, 0, "can0", "TCU", "torque", 0.0, 0.0, 0.5)
    judge = InputJudge(example_settings("railcar"), [flag, torque], CreepMeter(CONTACT_N))
    for channel, value in ((flag, 1.0), (torque, -5000.0)):
        judge.see(Sample(0.0, *channel.measurand, value, Quality.GOOD))
    holding = judge._wheels.wheels[0].holding
    assert judge._flags.flags[0].is_set
    assert holding.largest_n == holding.motor_force_n > 0.0
    for channel in (flag, torque):
        judge.see(Sample(0.1, *channel.measurand, 1.0, quality))
    assert not judge._flags.flags[0].is_set
    assert holding.motor_force_n == 0.0
