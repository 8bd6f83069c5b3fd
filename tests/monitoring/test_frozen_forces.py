"""A pressing force that repeats itself is frozen when the others' common movement passes it by, and only then."""

import random
from collections.abc import Callable, Sequence

import pytest

from brake_monitor.monitoring.inputs.frozen_forces import FrozenForces
from brake_monitor.samples import Channel, Quantity

CONTACT_N, FULL_N = 2000.0, 40e3
BRAKE_S, CHANGE_S, END_S = 5.0, 20.0, 40.0

Force = Callable[[float], float]


def driven(time_s: float) -> float:
    """Brake from 5 s to 20 s; filling and emptying take 3 s, and nothing dithers while it is held."""
    filling = min(max((time_s - BRAKE_S) / 3.0, 0.0), 1.0)
    emptied = min(max((time_s - CHANGE_S) / 3.0, 0.0), 1.0)
    return FULL_N * max(filling - emptied, 0.0)


def frozen_at(freezes_s: float) -> Force:
    return lambda time_s: driven(min(time_s, freezes_s))


def held(time_s: float) -> float:
    return driven(min(time_s, CHANGE_S))


def losing(lost_n: float, lasts_s: float) -> Force:
    """Held, but from 20 s on it loses air."""
    return lambda time_s: held(time_s) - lost_n * min(max((time_s - CHANGE_S) / lasts_s, 0.0), 1.0)


def keeping(rest_n: float) -> Force:
    """It does not empty below a rest."""
    return lambda time_s: max(driven(time_s), rest_n if time_s > BRAKE_S + 3.0 else 0.0)


def frozen_in(
    forces: Sequence[Force],
    *,
    speed_mps: float = 20.0,
    slides: bool = False,
    believed: Sequence[bool] | None = None,
    judged_from_s: float = 0.0,
) -> set[int]:
    """Which were ever said to be frozen."""
    channels = [
        Channel(Quantity.PRESSING_FORCE, i, "can0", "BCU", f"p_{i}", 50.0, 0.0, 1.0) for i, _ in enumerate(forces)
    ]
    watch, found = FrozenForces(channels, CONTACT_N), set()
    for k in range(round(END_S * 10)):
        time_s = k / 10
        for i, force in enumerate(forces):
            watch.watchers[Quantity.PRESSING_FORCE, i](time_s, force(time_s))
        if time_s < judged_from_s:
            continue
        sure = believed or [True] * len(forces)
        found |= watch.frozen(time_s, speed_mps, sure, slides=slides and time_s >= CHANGE_S)
    return found


@pytest.mark.parametrize("others", [1, 2, 3])
def test_a_force_that_does_not_come_down_with_the_others_is_frozen(others: int) -> None:
    assert frozen_in([frozen_at(12.0), *[driven] * others]) == {0}


@pytest.mark.parametrize("others", [1, 3])
def test_a_force_that_does_not_rise_with_the_others_is_frozen(others: int) -> None:
    assert frozen_in([lambda _: 30e3, *[driven] * others]) == {0}


def test_three_that_have_come_down_tell_of_the_fourth_at_standstill_too() -> None:
    assert frozen_in([frozen_at(12.0), *[driven] * 3], speed_mps=0.0) == {0}


@pytest.mark.parametrize(
    ("share", "trembles", "is_told"), [(0.125, True, True), (0.125, False, False), (0.06, True, False)]
)
def test_in_a_light_braking_a_force_that_trembled_and_no_longer_does_is_frozen_if_it_does_not_come_down(
    share: float, trembles: bool, is_told: bool
) -> None:
    """5 kN; a coarse sensor that never trembled may stand by right, and brakes differ by 2 kN."""
    rng = random.Random(3)
    steps_n = [trembles * 12.0 * round(rng.gauss(0.0, 1.5)) for _ in range(round(END_S * 10))]

    def light(freezes_s: float) -> Force:
        told_s = lambda time_s: min(time_s, freezes_s)  # noqa: E731
        return lambda time_s: (f := share * driven(told_s(time_s))) + steps_n[round(told_s(time_s) * 10)] * (f > 0.0)

    assert frozen_in([light(18.0), *[light(1e9)] * 3]) == ({0} if is_told else set())


def test_two_of_four_that_freeze_together_are_told() -> None:
    assert frozen_in([frozen_at(12.0), frozen_at(12.0), driven, driven]) == {0, 1}


def test_a_brake_that_loses_its_air_says_nothing_of_three_that_are_held() -> None:
    assert frozen_in([losing(FULL_N, 1.0), held, held, held]) == set()


@pytest.mark.parametrize("speed_mps", [0.0, 20.0])
def test_a_brake_that_leaks_says_nothing_of_one_that_is_tight(speed_mps: float) -> None:
    assert frozen_in([losing(15e3, 10.0), held], speed_mps=speed_mps) == set()


def test_at_standstill_one_that_empties_says_nothing_of_another() -> None:
    assert frozen_in([losing(FULL_N, 10.0), held], speed_mps=0.0) == set()


@pytest.mark.parametrize("others", [1, 3])
def test_a_brake_that_came_down_with_the_others_and_keeps_a_rest_is_no_frozen_sensor(others: int) -> None:
    assert frozen_in([keeping(12e3), *[driven] * others]) == set()


def test_what_slide_protection_empties_says_nothing_of_a_brake_that_it_leaves() -> None:
    assert frozen_in([held, losing(FULL_N, 0.2)], slides=True) == set()


def test_a_sensor_that_is_not_believed_says_nothing_of_another() -> None:
    assert frozen_in([held, losing(FULL_N, 0.2)], believed=[True, False]) == set()


def test_a_judgement_that_comes_late_has_seen_all_that_went_before() -> None:
    """Half a minute of four forces."""
    assert frozen_in([frozen_at(12.0), *[driven] * 3], judged_from_s=30.0) == {0}
    assert frozen_in([losing(FULL_N, 1.0), held, held, held], judged_from_s=30.0) == set()


@pytest.mark.parametrize("readings", [1, 2])
@pytest.mark.parametrize("spike_n", [0.0, 170e3])
@pytest.mark.parametrize("at_s", [CHANGE_S, CHANGE_S + 0.1, 12.0])
def test_a_spike_of_one_sensor_says_nothing_of_another(at_s: float, spike_n: float, readings: int) -> None:
    """Of one reading or of two in a row, while both brakes are held and nothing dithers."""
    spikes: Force = lambda time_s: spike_n if at_s - 0.05 <= time_s < at_s - 0.05 + readings / 10 else held(time_s)  # noqa: E731
    assert frozen_in([spikes, held]) == frozen_in([held, spikes]) == set()
