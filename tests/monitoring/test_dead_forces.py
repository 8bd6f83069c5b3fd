"""A pressing force whose sensor died in one brake application says nothing of the brake in the next one."""

from collections.abc import Sequence

import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.dead_forces import DIED_S, DeadForces
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.samples import InputCondition, Measurand, Quantity
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

FULL_N, REST_N = 40e3, 500.0
SOUND = (FULL_N, FULL_N, FULL_N, FULL_N)
RELEASED = (0.0, REST_N, REST_N, REST_N)
ONE_SAYS_0 = (0.0, FULL_N, FULL_N, FULL_N)


def watched(*moments: tuple[float, Sequence[float], Sequence[int]]) -> list[set[int]]:
    """What is told at each of them: time, forces, and which of these are impossible."""
    watch = DeadForces(2000.0)
    return [set(watch.see(time_s, forces_n, impossible)) for time_s, forces_n, impossible in moments]


DIED = ((10.0, SOUND, [0]), (10.0 + DIED_S, SOUND, [0]))  # the estimate goes on with what was believed last


def test_one_that_died_is_not_believed_as_the_others_press_again() -> None:
    assert watched(*DIED, (20.0, RELEASED, []), (30.0, ONE_SAYS_0, [])) == [set(), set(), set(), {0}]


def test_until_the_others_let_go_as_well_it_is_left_to_what_is_thought_of_it_alone() -> None:
    easing = (0.0, 0.3 * FULL_N, 0.3 * FULL_N, 0.3 * FULL_N)
    assert watched(*DIED, (18.0, easing, []), (20.0, RELEASED, [])) == [set()] * 4


@pytest.mark.parametrize(("others_n", "is_told"), [(900.0, False), (1100.0, True), (5e3, True)])
def test_nor_while_the_others_press_lightly_or_are_being_released(others_n: float, is_told: bool) -> None:
    light = (0.0, others_n, others_n, others_n)
    *_, lightly, fully, easing = watched(
        *DIED, (20.0, RELEASED, []), (30.0, light, []), (40.0, ONE_SAYS_0, []), (50.0, light, [])
    )
    assert (lightly, fully, easing) == ({0} if is_told else set(), {0}, {0} if is_told else set())


def test_nor_while_one_of_the_others_presses_alone() -> None:
    alone = (0.0, FULL_N, 0.0, 0.0)
    assert watched(*DIED, (20.0, RELEASED, []), (30.0, alone, []), (40.0, ONE_SAYS_0, []))[-2:] == [set(), {0}]


def test_that_it_died_is_not_forgotten_while_the_application_goes_on() -> None:
    died = (*DIED, (14.0, (0.0, *SOUND[1:]), []), (15.0, (0.0, *SOUND[1:]), []))
    assert watched(*died, (20.0, RELEASED, []), (30.0, ONE_SAYS_0, []))[-1] == {0}


def test_one_that_presses_again_lives() -> None:
    *_, now, later = watched(*DIED, (20.0, RELEASED, []), (30.0, SOUND, []), (50.0, ONE_SAYS_0, []))
    assert (now, later) == (set(), set())


def test_one_that_presses_again_in_the_same_application_has_not_died() -> None:
    *_, now = watched(*DIED, (15.0, SOUND, []), (20.0, RELEASED, []), (30.0, ONE_SAYS_0, []))
    assert now == set()


def test_a_wire_that_touches_another_for_a_moment_has_not_died() -> None:
    moments = ((10.0, SOUND, [0]), (10.0 + 0.5 * DIED_S, SOUND, [0]), (12.0, RELEASED, []), (30.0, ONE_SAYS_0, []))
    assert watched(*moments)[-1] == set()


def test_nor_has_one_that_touches_another_twice() -> None:
    touches = ((10.0, SOUND, [0]), (10.1, SOUND, []), (10.0 + 2.0 * DIED_S, SOUND, [0]))
    low = (10.1 + 2.0 * DIED_S, (0.0, *SOUND[1:]), [])
    assert watched(*touches, low, (20.0, RELEASED, []), (30.0, ONE_SAYS_0, []))[-1] == set()


def test_a_brake_that_does_not_come_and_whose_sensor_was_sound_is_told_by_others() -> None:
    assert watched((10.0, SOUND, []), (20.0, RELEASED, []), (30.0, ONE_SAYS_0, [])) == [set()] * 3


def test_where_all_died_there_is_nobody_to_compare_with() -> None:
    every = [0, 1, 2, 3]
    moments = ((10.0, SOUND, every), (10.0 + DIED_S, SOUND, every), (30.0, (0.0,) * 4, []))
    assert watched(*moments)[-1] == set()


def test_its_signal_is_contradicted_then() -> None:
    settings, dead = example_settings("bogie"), (Quantity.PRESSING_FORCE, 0)
    channels = SignalDecoder.from_settings(settings).channels
    judge = InputJudge(settings, channels, CreepMeter(settings.estimator.contact_force_n))
    conditions = dict.fromkeys([channel.measurand for channel in channels], InputCondition.GOOD)

    def told(time_s: float, forces_n: Sequence[float], condition: InputCondition) -> InputCondition:
        conditions[dead] = condition
        wheelsets = tuple(wheelset(pressing_force_n=force_n, slip=0.0) for force_n in forces_n)
        now = estimate(time_s=time_s, saturated=False, wheelsets=wheelsets)
        reports, _ = judge.judge(now, conditions.__getitem__, changes=round(10 * time_s))
        return next(report.condition for report in reports if report.measurand == dead)

    good, impossible = InputCondition.GOOD, InputCondition.IMPOSSIBLE
    assert told(10.0, SOUND, impossible) is told(10.0 + DIED_S, SOUND, impossible) is impossible
    assert told(20.0, RELEASED, good) is good
    assert told(30.0, ONE_SAYS_0, good) is InputCondition.CONTRADICTED
    assert told(40.0, RELEASED, good) is good


@pytest.mark.parametrize(
    ("place", "condition"),
    [((Quantity.AXLE_SPEED, 0), InputCondition.IMPOSSIBLE), ((Quantity.PRESSING_FORCE, 0), InputCondition.LOST)],
    ids=["its wheel speed is impossible", "it is lost"],
)
def test_it_has_not_died_where_it_did_not_say_what_is_impossible(place: Measurand, condition: InputCondition) -> None:
    settings = example_settings("bogie")
    channels = SignalDecoder.from_settings(settings).channels
    judge = InputJudge(settings, channels, CreepMeter(settings.estimator.contact_force_n))
    conditions = dict.fromkeys([channel.measurand for channel in channels], InputCondition.GOOD)
    moments = ((10.0, SOUND, True), (10.0 + DIED_S, SOUND, True), (20.0, RELEASED, False), (30.0, ONE_SAYS_0, False))
    for k, (time_s, forces_n, is_bad) in enumerate(moments):
        conditions[place] = condition if is_bad else InputCondition.GOOD
        wheelsets = tuple(wheelset(pressing_force_n=force_n, slip=0.0) for force_n in forces_n)
        now = estimate(time_s=time_s, saturated=False, wheelsets=wheelsets)
        reports, _ = judge.judge(now, conditions.__getitem__, changes=k)
    assert {report.condition for report in reports} == {InputCondition.GOOD}
