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


def dithering(until_s: float, force: Force) -> Force:
    """By a newton, until its sensor freezes or its air stands still."""
    return lambda time_s: force(time_s) + (round(10.0 * time_s) % 2) * (time_s < until_s)


def frozen_in(
    forces: Sequence[Force],
    *,
    speed_mps: float = 20.0,
    slides_s: tuple[float, float] = (END_S, END_S),
    believed: Sequence[bool] | None = None,
    judged_from_s: float = 0.0,
    every: int = 1,
) -> dict[int, float]:
    """Which were ever said to be frozen, and from when on. A sensor is read in `every` tenth of a second."""
    channels = [
        Channel(Quantity.PRESSING_FORCE, i, "can0", "BCU", f"p_{i}", 50.0, 0.0, 1.0) for i, _ in enumerate(forces)
    ]
    watch, found = FrozenForces(channels, CONTACT_N), dict[int, float]()
    for k in range(round(END_S * 10)):
        time_s = k / 10
        for i, force in enumerate(forces):
            if k % every == 0:
                watch.watchers[Quantity.PRESSING_FORCE, i](time_s, force(time_s))
        if time_s < judged_from_s:
            continue
        sure = believed or [True] * len(forces)
        slides = slides_s[0] <= time_s < slides_s[1]
        found = dict.fromkeys(watch.frozen(time_s, speed_mps, sure, slides=slides), time_s) | found
    return found


@pytest.mark.parametrize("others", [1, 2, 3])
def test_a_force_that_does_not_come_down_with_the_others_is_frozen(others: int) -> None:
    assert frozen_in([frozen_at(12.0), *[driven] * others]).keys() == {0}


@pytest.mark.parametrize("others", [1, 3])
def test_a_force_that_does_not_rise_with_the_others_is_frozen(others: int) -> None:
    assert frozen_in([lambda _: 30e3, *[driven] * others]).keys() == {0}


def test_three_that_have_come_down_tell_of_the_fourth_at_standstill_too() -> None:
    assert frozen_in([frozen_at(12.0), *[driven] * 3], speed_mps=0.0).keys() == {0}


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

    assert frozen_in([light(18.0), *[light(1e9)] * 3]).keys() == ({0} if is_told else set())


@pytest.mark.parametrize(("speed_mps", "is_told"), [(20.0, True), (0.0, False)])
def test_that_the_others_ease_together_tells_of_it_unless_they_may_leak(speed_mps: float, is_told: bool) -> None:
    eased = losing(15e3, 10.0)
    assert frozen_in([held, eased, eased, eased], speed_mps=speed_mps).keys() == ({0} if is_told else set())


def test_at_standstill_one_that_empties_among_others_that_leak_tells_no_more() -> None:
    leaks = losing(15e3, 10.0)
    assert frozen_in([held, losing(FULL_N, 10.0), leaks, leaks], speed_mps=0.0).keys() == set()


def test_no_leak_fills_the_others_at_standstill() -> None:
    fills: Force = lambda time_s: 20e3 + 15e3 * min(max((time_s - CHANGE_S) / 3.0, 0.0), 1.0)  # noqa: E731
    assert frozen_in([lambda _: 20e3, fills, fills, fills], speed_mps=0.0).keys() == {0}


def test_one_that_never_pressed_takes_no_side() -> None:
    assert frozen_in([frozen_at(12.0), driven, lambda _: 0.0]).keys() == {0}


def test_of_two_that_stay_one_that_empties_and_one_that_leaks_tell_nothing() -> None:
    assert frozen_in([held, held, losing(FULL_N, 10.0), losing(15e3, 10.0)]).keys() == set()


def test_two_of_four_that_freeze_together_are_told() -> None:
    assert frozen_in([frozen_at(12.0), frozen_at(12.0), driven, driven]).keys() == {0, 1}


def test_a_brake_that_loses_its_air_says_nothing_of_three_that_are_held() -> None:
    assert not frozen_in([losing(FULL_N, 1.0), held, held, held])


@pytest.mark.parametrize("speed_mps", [0.0, 20.0])
def test_a_brake_that_leaks_says_nothing_of_one_that_is_tight(speed_mps: float) -> None:
    assert not frozen_in([losing(15e3, 10.0), held], speed_mps=speed_mps)


def test_at_standstill_one_that_empties_says_nothing_of_another() -> None:
    assert not frozen_in([losing(FULL_N, 10.0), held], speed_mps=0.0)
    assert not frozen_in([losing(FULL_N, 10.0), losing(15e3, 10.0), held], speed_mps=0.0)  # nor beside one that leaks


@pytest.mark.parametrize("others", [1, 3])
def test_a_brake_that_came_down_with_the_others_and_keeps_a_rest_is_no_frozen_sensor(others: int) -> None:
    assert not frozen_in([keeping(12e3), *[driven] * others])


def test_what_slide_protection_empties_says_nothing_of_a_brake_that_it_leaves() -> None:
    assert not frozen_in([held, losing(FULL_N, 0.2)], slides_s=(CHANGE_S, END_S))


@pytest.mark.parametrize(("slid_until_s", "is_told"), [(18.5, True), (20.5, False)])
def test_what_others_did_until_three_seconds_after_a_slide_says_nothing(slid_until_s: float, is_told: bool) -> None:
    """Until 21.5 s, when they have half of it before them, or 23.5 s, when they are empty."""
    assert bool(frozen_in([frozen_at(12.0), *[driven] * 3], slides_s=(10.0, slid_until_s))) is is_told


@pytest.mark.parametrize(("every", "told_s"), [(1, 23.0), (5, 28.0)], ids=["five seconds", "twenty repetitions"])
def test_a_force_has_to_repeat_itself_for_long(every: int, told_s: float) -> None:
    """From 18 s on; the others empty from 20 to 23 s."""
    forces = [dithering(18.0 - 0.05, held), *[driven] * 3]
    assert frozen_in(forces, every=every) == {0: pytest.approx(told_s, abs=0.15)}


@pytest.mark.parametrize(("moves_n", "is_told"), [(7e3, False), (9e3, True)])
def test_others_have_to_move_by_far_more_than_brakes_differ(moves_n: float, is_told: bool) -> None:
    assert bool(frozen_in([held, *[losing(moves_n, 2.0)] * 3])) is is_told


@pytest.mark.parametrize(("speed_mps", "is_told"), [(1.5, False), (2.5, True)])
def test_of_two_it_is_told_as_soon_as_wheelset_and_wagon_have_shown_which(speed_mps: float, is_told: bool) -> None:
    """The other one is off its disc after 22.85 s, as its third reading bears out; four seconds more suffice.

    At a crawl nothing shows.
    """
    found = frozen_in([frozen_at(12.0), driven], speed_mps=speed_mps)
    assert found == ({0: pytest.approx(23.1 + 4.0, abs=0.05)} if is_told else {})


def test_a_brake_that_keeps_half_of_its_air_came_down_with_one_that_empties_slowly() -> None:
    """Both come down from 20 s on, the other one for six seconds."""
    slow = losing(FULL_N, 6.0)
    assert not frozen_in([lambda time_s: max(slow(time_s), 0.5 * held(time_s)), slow])


def test_a_sensor_that_is_not_believed_says_nothing_of_another() -> None:
    assert not frozen_in([held, losing(FULL_N, 0.2)], believed=[True, False])


def test_a_judgement_that_comes_late_has_seen_all_that_went_before() -> None:
    """Half a minute of four forces."""
    assert frozen_in([frozen_at(12.0), *[driven] * 3], judged_from_s=30.0).keys() == {0}
    assert not frozen_in([losing(FULL_N, 1.0), held, held, held], judged_from_s=30.0)


@pytest.mark.parametrize("readings", [1, 2])
@pytest.mark.parametrize("spike_n", [0.0, 170e3])
@pytest.mark.parametrize("at_s", [CHANGE_S, CHANGE_S + 0.1, 12.0])
def test_a_spike_of_one_sensor_says_nothing_of_another(at_s: float, spike_n: float, readings: int) -> None:
    """Of one reading or of two in a row, while both brakes are held and nothing dithers."""
    spikes: Force = lambda time_s: spike_n if at_s - 0.05 <= time_s < at_s - 0.05 + readings / 10 else held(time_s)  # noqa: E731
    assert frozen_in([spikes, held]) == frozen_in([held, spikes]) == {}
