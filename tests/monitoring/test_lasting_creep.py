"""In a train a brake that drags unseen shows only in how its wheelset turns, over a way on which no curve lasts."""

import pickle
import random
from collections.abc import Callable, Sequence

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.rules.lasting_creep import CreepDrag, LastingCreepSearch
from estimates import estimate, wheelset

MASS_KG, GRAVITY_MPS2, SPEED_MPS, RADIUS_M = 40e3, 9.81, 20.0, 0.45
STIFFNESS = 60.0  # adhesion over creep
CONTACT_N, LEAST_N, FULL_N = 2000.0, 1200.0, 30e3
BRAKED_S, RELEASED_S = 150.0, 170.0  # 3 km of free rolling before
NOISE = 4e-5  # relative, of a wheel speed as it is estimated
STRAIGHT: Callable[[float], float] = lambda _: 0.0  # noqa: E731

Shifts = Callable[[float], Sequence[float]]  # of each wheelset, by how much it turns more slowly: relative


def drive(
    until_s: float,
    shifts: Shifts,
    *,
    speed_mps: float = SPEED_MPS,
    braked: Callable[[float], float] = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S),
    from_s: float = 0.0,
    shares: Sequence[float] = (),
    changes: Callable[[float], dict[str, object]] = lambda _: {},
) -> list[Estimate]:
    """Ten estimates a second at constant speed; all brakes press alike, or with these shares of the force."""
    rng = random.Random(7)
    drive = []
    for k in range(round(from_s * 10), round(until_s * 10)):
        time_s = k / 10
        force_n = braked(time_s)
        own_shifts = shifts(time_s)
        load_n = MASS_KG * GRAVITY_MPS2 / len(own_shifts)
        creep = 0.2 * force_n / load_n / STIFFNESS
        wheelsets = tuple(
            wheelset(
                omega_radps=speed_mps / RADIUS_M * (1.0 - share * creep - shift) * (1.0 + rng.gauss(0.0, NOISE)),
                pressing_force_n=share * force_n,
            )
            for share, shift in zip(shares or [1.0] * len(own_shifts), own_shifts, strict=True)
        )
        now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, wheelsets=wheelsets, mass_kg=MASS_KG)
        drive.append(replace(now, **changes(time_s)))
    return drive


def seen(drive: Sequence[Estimate], search: LastingCreepSearch | None = None) -> tuple[float | None, float | None]:
    """When one was suspected and found first, s."""
    search = search or LastingCreepSearch(CONTACT_N, LEAST_N)
    suspected_s = found_s = None
    for now in drive:
        found = search.see(now, inputs_are_good=True)
        if search.suspected and suspected_s is None:
            suspected_s = now.time_s
        if found and found_s is None:
            found_s = now.time_s
    return suspected_s, found_s


def drags(force_n: float, count: int, from_s: float = RELEASED_S, until_s: float = 1e9) -> Shifts:
    """The last wheelset's brake retards with this force at the rail, beside what all brakes do."""
    shift = force_n / (MASS_KG * GRAVITY_MPS2 / count) / STIFFNESS
    return lambda t: [0.0] * (count - 1) + [shift * (from_s <= t < until_s)]


@pytest.mark.parametrize(("count", "way_m"), [(2, 1500.0), (3, 1000.0), (4, 1000.0)])
def test_one_that_drags_from_the_release_on_is_doubted_after_250_m_and_found_over_a_longer_way(
    count: int, way_m: float
) -> None:
    """What rolls freely 3 s after the release is seen each 5 s, which are 100 m."""
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    suspected_s, found_s = seen(drive(450.0, drags(8e3, count)), search)
    assert suspected_s is not None
    assert suspected_s - RELEASED_S == pytest.approx(3.0 + 15.0, abs=0.3)
    assert found_s is not None
    assert way_m <= SPEED_MPS * (found_s - RELEASED_S) < way_m + 200.0
    assert search.lasting.keys() == {count - 1}
    now = drive(1.0, drags(0.0, count))[-1]
    assert search.lasting[count - 1].retarding_force_n(now) == pytest.approx(8e3, rel=0.1)


def test_of_two_a_strong_drag_is_found_no_sooner() -> None:
    """R = 200 m would make the two differ as much."""
    _, found_s = seen(drive(450.0, drags(16e3, 2)))
    assert found_s is not None
    assert 1500.0 <= SPEED_MPS * (found_s - RELEASED_S) < 1700.0


def test_that_wheels_differ_in_size_does_not_matter() -> None:
    drag, sizes = drags(8e3, 4), (1e-3, -5e-4, 0.0, 3e-4)
    _, found_s = seen(drive(450.0, lambda t: [own + size for own, size in zip(drag(t), sizes, strict=True)]))
    assert found_s is not None


def test_of_two_a_weak_drag_is_found_as_soon_as_no_curve_could_be_so_long() -> None:
    """R = 980 m would make the two differ as much; over 3.05 km it would have turned the line by 180 degrees."""
    braked_s, released_s = 200.0, 220.0
    braked = lambda t: FULL_N * (braked_s <= t < released_s)  # noqa: E731
    _, found_s = seen(drive(700.0, drags(3.9e3, 2, from_s=released_s), braked=braked))
    assert found_s is not None
    assert 2900.0 < SPEED_MPS * (found_s - released_s) < 3300.0


def curve(begins_s: float, ends_s: float, shift: float, count: int = 2) -> Shifts:
    """Leading wheelsets of each pair turn more slowly in it, trailing ones faster."""
    return lambda t: [shift * (begins_s <= t < ends_s) * (0.6 if i % 2 == 0 else -0.4) for i in range(count)]


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("shift", [4e-4, -4e-4, 1e-3])
@pytest.mark.parametrize(
    ("begins_s", "ends_s"),
    [
        (RELEASED_S, RELEASED_S + 50.0),  # a kilometre from the very release on
        (RELEASED_S - 60.0, RELEASED_S + 20.0),
        (BRAKED_S - 50.0, RELEASED_S),  # ... until the very release
        (0.0, 40.0),
        (RELEASED_S + 30.0, RELEASED_S + 100.0),
    ],
)
def test_a_curve_is_no_drag(count: int, shift: float, begins_s: float, ends_s: float) -> None:
    _, found_s = seen(drive(600.0, curve(begins_s, ends_s, shift, count)))
    assert found_s is None


@pytest.mark.parametrize(("count", "first_m"), [(2, 1800.0), (4, 900.0)])
def test_nor_is_the_end_of_a_curve_in_which_all_was_that_is_known_from_before(count: int, first_m: float) -> None:
    """R = 830 m for two: over 1.8 km it turns the line by 124 degrees. Of four it moves one alone."""
    braked_s = first_m / SPEED_MPS
    released_s = braked_s + 20.0
    braked = lambda t: FULL_N * (braked_s <= t < released_s)  # noqa: E731
    shifts: Shifts = lambda t: [-4e-4 * (t < released_s), *[0.0] * (count - 1)]  # noqa: E731
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    doubted = [
        now.time_s
        for now in drive(600.0, shifts, braked=braked)
        if search.see(now, inputs_are_good=True) is None and search.suspected is not None
    ]
    assert not search.lasting
    assert SPEED_MPS * (doubted[-1] - released_s) == pytest.approx(8000.0, abs=200.0)  # nor will more of it tell


def test_a_winding_line_with_straights_between_its_curves_is_none() -> None:
    """After kilometres of straight track: curves of 400 m, R = 300 m, with 150 m between them."""
    winding = curve(RELEASED_S, 1e9, 1e-3)
    shifts: Shifts = lambda t: winding(t) if (t - RELEASED_S) % 27.5 < 20.0 else (0.0, 0.0)  # noqa: E731
    assert seen(drive(900.0, shifts))[1] is None


@pytest.mark.parametrize("count", [2, 4])
def test_nor_is_one_of_four_or_two_whose_tread_grows_warm_while_it_is_braked(count: int) -> None:
    """12 ppm per kelvin: 30 K more than the others, from the application on."""
    warms = lambda t: 3.6e-4 * min(max((t - BRAKED_S) / 10.0, 0.0), 1.0)  # noqa: E731
    assert seen(drive(600.0, lambda t: [0.0] * (count - 1) + [warms(t)])) == (None, None)


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("others", [0.0, 0.05])
def test_nor_one_that_grows_warm_as_another_brake_is_isolated_or_hardly_presses(count: int, others: float) -> None:
    """Most of the wagon's work is done by one brake."""
    warms = lambda t: 3.6e-4 * min(max((t - BRAKED_S) / 20.0, 0.0), 1.0)  # noqa: E731
    shifts: Shifts = lambda t: [0.0] * (count - 1) + [warms(t)]  # noqa: E731
    told = seen(drive(600.0, shifts, shares=[others] * (count - 1) + [1.0]))
    assert told == (None, None)


@pytest.mark.parametrize("count", [2, 4])
@pytest.mark.parametrize("again_s", [RELEASED_S + 3.0, RELEASED_S + 8.5, RELEASED_S + 14.0])
def test_nor_one_that_grows_warm_in_a_second_application_soon_after_the_first(count: int, again_s: float) -> None:
    """The first did nothing to it."""
    braked = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or again_s <= t < again_s + 20.0)  # noqa: E731
    warms = lambda t: 3.6e-4 * min(max((t - again_s) / 10.0, 0.0), 1.0)  # noqa: E731
    assert seen(drive(600.0, lambda t: [0.0] * (count - 1) + [warms(t)], braked=braked)) == (None, None)


@pytest.mark.parametrize(("count", "way_m"), [(2, 1500.0), (4, 1000.0)])
def test_a_strong_one_that_begins_while_the_wagon_rolls_is_found_as_soon(count: int, way_m: float) -> None:
    """No curve makes wheelsets differ as much."""
    begins_s = 450.0
    suspected_s, found_s = seen(drive(600.0, drags(40e3, count, from_s=begins_s), braked=lambda _: 0.0))
    assert suspected_s is not None
    assert 250.0 <= SPEED_MPS * (suspected_s - begins_s) < 500.0
    assert found_s is not None
    assert way_m <= SPEED_MPS * (found_s - begins_s) < way_m + 200.0


@pytest.mark.parametrize("count", [2, 4])
def test_a_brake_that_is_put_on_soon_after_a_strong_one_has_begun_does_not_hide_it(count: int) -> None:
    begins_s = 450.0
    braked = lambda t: FULL_N * (begins_s + 40.0 <= t < begins_s + 60.0)  # noqa: E731
    _, found_s = seen(drive(700.0, drags(40e3, count, from_s=begins_s), braked=braked))
    assert found_s is not None


@pytest.mark.parametrize("count", [2, 4])
def test_the_tightest_curves_are_no_drag_that_has_begun(count: int) -> None:
    """R = 200 m, at its very speed, for as long as it takes to turn the line by 180 degrees."""
    curve = lambda t: (*[0.0] * (count - 1), 1.4e-3 * (450.0 <= t < 480.0))  # noqa: E731
    assert seen(drive(700.0, curve, braked=lambda _: 0.0)) == (None, None)


def test_a_strong_one_whose_pads_grow_hot_and_rub_less_lasts() -> None:
    """To a third of what it was found with, which is still more than most drags do."""
    shift: Shifts = lambda t: (0.0, 0.0, 0.0, (t >= RELEASED_S) * max(3e-3 - 1e-5 * (t - RELEASED_S), 1e-3))  # noqa: E731
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    assert seen(drive(600.0, shift), search)[1] is not None
    assert search.lasting.keys() == {3}


@pytest.mark.parametrize(("shift", "is_found"), [(2.9e-3, False), (3.1e-3, True)])
def test_one_that_dragged_while_the_brakes_were_on_is_no_warm_tread_if_it_lags_too_far(
    shift: float, is_found: bool
) -> None:
    """Its pads stuck in mid-application: no tread grows so warm that its wheel turns 0.3 % more slowly."""
    _, found_s = seen(drive(450.0, lambda t: (0.0, 0.0, 0.0, shift * (t >= BRAKED_S))))
    assert (found_s is not None) is is_found


def test_where_two_of_four_turn_more_slowly_neither_is_told() -> None:
    shift = drags(8e3, 4)
    assert seen(drive(600.0, lambda t: [shift(t)[-1], 0.0, 0.0, shift(t)[-1]])) == (None, None)


@pytest.mark.parametrize(("shift", "is_told"), [(1.0e-4, False), (2.5e-3, True), (9.6e-3, True), (1.04e-2, False)])
def test_less_is_of_no_account_and_more_is_no_drag(shift: float, is_told: bool) -> None:
    """Brakes that stay on in full retard by 0.3 of the wheel load; at a creep stiffness of 30 that shifts by 1e-2."""
    told = seen(drive(500.0, lambda t: (0.0, 0.0, 0.0, shift * (t >= RELEASED_S))))
    assert (told != (None, None)) is is_told


def test_of_a_light_wagon_the_force_decides() -> None:
    """A quarter of the mass: a shift of 2e-4 is 0.3 kN."""
    light = [replace(now, mass_kg=MASS_KG / 4.0) for now in drive(500.0, lambda t: (0.0, 0.0, 0.0, 2e-4 * (t > 170.0)))]
    assert seen(light) == (None, None)
    assert seen(light, LastingCreepSearch(CONTACT_N, 200.0)) != (None, None)


def test_brakings_meanwhile_do_not_hide_it() -> None:
    """Put on anew each 25 s, for 8 s: 340 m of free rolling at a time."""
    again = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or (t > RELEASED_S and (t - RELEASED_S) % 25.0 > 17.0))  # noqa: E731
    _, found_s = seen(drive(500.0, drags(8e3, 4), braked=again))
    assert found_s is not None


def test_a_curve_after_the_release_before_does_not_delay_it() -> None:
    """400 m of it, which are known to be without a drag once the brakes are put on anew."""
    again_s = 200.0
    braked = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or again_s <= t < again_s + 20.0)  # noqa: E731
    drag, turns = drags(8e3, 4, from_s=again_s + 20.0), curve(RELEASED_S, again_s - 5.0, 1e-3, 4)
    shifts: Shifts = lambda t: [own + turned for own, turned in zip(drag(t), turns(t), strict=True)]  # noqa: E731
    _, found_s = seen(drive(500.0, shifts, braked=braked))
    assert found_s is not None
    assert 1000.0 <= SPEED_MPS * (found_s - again_s - 20.0) < 1200.0


def test_pads_that_stick_press_more_than_is_told_already_while_the_brakes_are_vented() -> None:
    """In position G that takes a minute; what it was like before the release counts."""
    slowly = lambda t: FULL_N * (t >= BRAKED_S) * min(max((RELEASED_S + 60.0 - t) / 60.0, 0.0), 1.0)  # noqa: E731
    sticks_n, per_n = 5e3, drags(1.0, 4, from_s=RELEASED_S)
    shifts: Shifts = lambda t: [max(sticks_n - 0.2 * slowly(t), 0.0) * own for own in per_n(t)]  # noqa: E731
    _, found_s = seen(drive(500.0, shifts, braked=slowly))
    assert found_s is not None


def test_a_brake_that_was_put_on_at_a_station_is_found_after_the_departure() -> None:
    """The wagon stands for less than an hour; after more its wheels may be others."""
    for stood_s, is_found in ((3400.0, True), (3800.0, False)):
        departs_s = RELEASED_S + stood_s
        before = drive(RELEASED_S, drags(0.0, 4))
        after = drive(departs_s + 200.0, drags(8e3, 4), from_s=departs_s)
        assert (seen(before + after)[1] is not None) is is_found


@pytest.mark.parametrize(
    "changes",
    [
        {"saturated": True},
        {"wheelsets": tuple(wheelset(omega_radps=44.0, pressing_force_n=0.0, motor_force_n=-9e3) for _ in range(2))},
    ],
)
def test_of_a_slide_or_a_motor_nothing_is_seen(changes: dict[str, object]) -> None:
    sound = drive(500.0, drags(8e3, 2), changes=lambda t: changes if t >= RELEASED_S else {})
    assert seen(sound) == (None, None)


MOTOR_DRIVES = {"wheelsets": (wheelset(omega_radps=44.0, pressing_force_n=0.0, motor_force_n=-9e3),) * 4}


@pytest.mark.parametrize("changes", [{"saturated": True}, {"speed_mps": 7.0}, MOTOR_DRIVES, {}])
def test_of_what_wheelsets_do_within_3_s_of_a_slide_a_crawl_or_a_motor_nothing_is_seen(
    changes: dict[str, object],
) -> None:
    """Each ten seconds, for a second."""
    drag = drags(8e3, 4)
    acts = lambda t: t % 10.0 < 0.95  # noqa: E731
    shifts: Shifts = lambda t: (*drag(t)[:3], drag(t)[3] - 2e-2 * (t % 10.0 < 3.85))  # noqa: E731
    _, found_s = seen(drive(600.0, shifts, changes=lambda t: changes if acts(t) else {}))
    assert (found_s is not None) is bool(changes)


@pytest.mark.parametrize(("every", "is_found"), [(9, True), (11, False)])
def test_of_what_was_in_gaps_of_more_than_a_second_nothing_is_known(every: int, is_found: bool) -> None:
    assert (seen(drive(600.0, drags(8e3, 4))[::every])[1] is not None) is is_found


@pytest.mark.parametrize(("slow_s", "is_found"), [(30.0, True), (45.0, False)])
def test_it_was_not_so_on_three_quarters_of_the_way_before(slow_s: float, is_found: bool) -> None:
    """Of 150 s: curves in which one of four alone turns as slowly."""
    slow, fast = drags(8e3, 4, from_s=0.0), drags(0.0, 4)
    shifts: Shifts = lambda t: (slow if 40.0 <= t < 40.0 + slow_s or t >= RELEASED_S else fast)(t)  # noqa: E731
    assert (seen(drive(600.0, shifts))[1] is not None) is is_found


def test_it_is_so_on_nine_tenths_of_the_way_since() -> None:
    _, found_s = seen(drive(600.0, drags(8e3, 4, from_s=RELEASED_S + 13.0)))  # two blocks of 5 s, 3 s after the release
    assert found_s is not None
    assert 1900.0 < SPEED_MPS * (found_s - RELEASED_S - 3.0) < 2100.0


@pytest.mark.parametrize(("from_s", "is_found"), [(BRAKED_S - 8.5, False), (BRAKED_S - 60.0, True)])
def test_where_hardly_anything_is_known_from_before_nothing_is_told(from_s: float, is_found: bool) -> None:
    told = seen(drive(400.0, drags(8e3, 4), from_s=from_s))
    assert (told != (None, None)) is is_found


def test_of_several_applications_the_last_before_it_counts() -> None:
    """It has been there since that began; it lasted for 3 s."""
    last_s = 250.0
    braked = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or last_s <= t < last_s + 3.0)  # noqa: E731
    assert seen(drive(500.0, drags(8e3, 4, from_s=last_s), braked=braked))[1] is None


def test_one_that_begins_while_the_wagon_rolls_is_found_after_nine_tenths_of_what_is_remembered() -> None:
    """8 km, of which no curve is so long."""
    begins_s = 450.0
    _, found_s = seen(drive(1000.0, drags(8e3, 4, from_s=begins_s), braked=lambda _: 0.0))
    assert found_s is not None
    assert SPEED_MPS * (found_s - begins_s) == pytest.approx(0.9 * 8000.0, abs=200.0)


@pytest.mark.parametrize("force_n", [0.0, 8e3])
@pytest.mark.parametrize("braked", [lambda _: 0.0, lambda t: FULL_N * (t % 60.0 < 5.0)])
def test_what_is_remembered_does_not_grow(force_n: float, braked: Callable[[float], float]) -> None:
    search, sizes = LastingCreepSearch(CONTACT_N, LEAST_N), []
    for from_s in (0.0, 400.0, 800.0):  # 16 km each
        seen(drive(from_s + 400.0, drags(force_n, 4), speed_mps=40.0, from_s=from_s, braked=braked), search)
        sizes.append(len(pickle.dumps(search)))
    assert sizes[2] < 1.1 * sizes[1]


@pytest.mark.parametrize(("share", "is_found"), [(0.4, True), (0.6, False)])
def test_less_than_half_of_it_was_there_while_the_brakes_were_on(share: float, is_found: bool) -> None:
    drag = drags(8e3, 4, from_s=0.0)
    shifts: Shifts = lambda t: [own * (1.0 if t >= RELEASED_S else share * (t >= BRAKED_S)) for own in drag(t)]  # noqa: E731
    assert (seen(drive(500.0, shifts))[1] is not None) is is_found


@pytest.mark.parametrize(("braked_s", "is_found"), [(0.8, True), (2.0, False)])
def test_brakes_that_were_on_for_less_than_a_second_tell_nothing(braked_s: float, is_found: bool) -> None:
    drag = drags(8e3, 4, from_s=BRAKED_S)
    touch = lambda t: FULL_N * (BRAKED_S <= t < BRAKED_S + braked_s)  # noqa: E731
    assert (seen(drive(500.0, drag, braked=touch))[1] is not None) is is_found


@pytest.mark.parametrize(("share", "is_found"), [(0.3, True), (-0.3, True), (0.6, False), (-0.6, False)])
def test_no_other_moves_by_half_as_much(share: float, is_found: bool) -> None:
    drag = drags(8e3, 4)
    assert (seen(drive(500.0, lambda t: (share * drag(t)[3], *drag(t)[1:])))[1] is not None) is is_found


def test_nor_without_its_inputs() -> None:
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    for now in drive(500.0, drags(8e3, 2)):
        assert search.see(now, inputs_are_good=now.time_s < RELEASED_S) is None
    assert search.suspected is None


@pytest.mark.parametrize(("speed_mps", "is_found"), [(7.5, False), (8.5, True)])
def test_nor_at_a_crawl(speed_mps: float, is_found: bool) -> None:
    assert (seen(drive(400.0, drags(8e3, 4), speed_mps=speed_mps))[1] is not None) is is_found


def test_a_single_wheelset_has_no_others() -> None:
    assert seen(drive(500.0, lambda t: [5e-4 * (t >= RELEASED_S)])) == (None, None)


@pytest.mark.parametrize("restarts", [False, True])
def test_it_lasts_until_the_wagon_has_rolled_so_far_without_it(restarts: bool) -> None:
    freed_s = 300.0
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    shifts = drags(8e3, 4, until_s=freed_s)
    seen(drive(freed_s, shifts), search)
    assert search.lasting
    if restarts:
        (drag,), search = search.lasting.values(), LastingCreepSearch(CONTACT_N, LEAST_N)
        search.lasting[drag.wheelset] = drag
    seen(drive(freed_s + 50.0, shifts, from_s=freed_s), search)
    assert search.lasting
    seen(drive(freed_s + 100.0, shifts, from_s=freed_s + 50.0), search)
    assert not search.lasting
    assert seen(drive(freed_s + 300.0, shifts, from_s=freed_s + 100.0), search) == (None, None)


def test_it_is_over_though_a_curve_does_the_same_on_a_fifth_of_the_way() -> None:
    search, freed_s = LastingCreepSearch(CONTACT_N, LEAST_N), 300.0
    seen(drive(freed_s, drags(8e3, 4)), search)
    shifts = drags(8e3, 4, from_s=freed_s + 30.0, until_s=freed_s + 45.0)
    seen(drive(freed_s + 80.0, shifts, from_s=freed_s), search)
    assert not search.lasting


def test_that_it_shows_and_that_it_is_over_is_seen_between_brakings_as_well() -> None:
    """Put on anew each 25 s, for 8 s."""
    freed_s = 300.0
    again = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or (t > 250.0 and t % 25.0 > 17.0))  # noqa: E731
    whole = drive(600.0, drags(8e3, 4, until_s=freed_s), braked=again)
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    told = {now.time_s: search.see(now, inputs_are_good=True) for now in whole}
    assert told[249.9] is not None
    assert told[275.1] is not None  # as soon as the brakes are off
    assert told[599.9] is None
    assert not search.lasting


@pytest.mark.parametrize(("shift", "lasts"), [(0.6, True), (1.4, True), (0.4, False), (5.0, False)])
def test_it_lasts_while_it_changes_little_and_no_longer_by_another_wheel(shift: float, lasts: bool) -> None:
    """Of 1.4e-3."""
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    seen(drive(300.0, drags(8e3, 4)), search)
    assert search.lasting
    since = drags(shift * 8e3, 4)
    seen(drive(400.0, since, from_s=300.0), search)
    assert bool(search.lasting) is lasts


def test_what_was_found_is_known_and_suspected_no_longer_even_where_a_curve_hides_it() -> None:
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    drag, hides = drags(8e3, 4), curve(300.0, 310.0, 2e-3, 4)
    seen(drive(310.0, lambda t: [own + away for own, away in zip(drag(t), hides(t), strict=True)]), search)
    assert search.lasting
    assert search.suspected is None


@pytest.mark.parametrize(("stood_s", "lasts"), [(1800.0, True), (7200.0, False)])
def test_after_hours_at_a_station_a_wheel_may_be_another_and_nothing_is_known_of_it(
    stood_s: float, lasts: bool
) -> None:
    """A turned wheelset would else be taken for one that drags, for good."""
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    seen(drive(300.0, drags(8e3, 4)), search)
    assert search.lasting
    departs_s = 300.0 + stood_s
    seen(drive(departs_s + 10.0, drags(8e3, 4), from_s=departs_s), search)
    assert bool(search.lasting) is lasts


def test_a_restart_goes_on_with_each_that_drags() -> None:
    """One has been freed meanwhile."""
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    for i in (0, 3):
        search.lasting[i] = CreepDrag(i, 8e-4, 0.0, 1000.0)
    (found_s, *_) = [now.time_s for now in drive(200.0, drags(8e3, 4, from_s=0.0)) if search.see(now, True)]
    assert found_s < 10.0
    assert search.lasting.keys() == {3}


def test_one_that_drags_again_is_found_again() -> None:
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    again_s = 700.0
    braked = lambda t: FULL_N * (BRAKED_S <= t < RELEASED_S or 680.0 <= t < again_s)  # noqa: E731
    first, second = drags(8e3, 4, until_s=300.0), drags(8e3, 4, from_s=again_s)
    _, found_s = seen(drive(680.0, first, braked=braked), search)
    assert found_s is not None
    assert not search.lasting
    _, found_s = seen(drive(900.0, second, braked=braked, from_s=680.0), search)
    assert found_s is not None


def test_a_clock_that_is_set_back_is_survived() -> None:
    before = drive(RELEASED_S, drags(0.0, 4))
    after = [replace(now, time_s=now.time_s - 5000.0) for now in drive(400.0, drags(8e3, 4), from_s=RELEASED_S)]
    assert seen(before + after)[1] is not None


def test_what_was_found_tells_over_which_way() -> None:
    search = LastingCreepSearch(CONTACT_N, LEAST_N)
    seen(drive(450.0, drags(8e3, 4)), search)
    (drag,) = search.lasting.values()
    assert isinstance(drag, CreepDrag)
    assert drag.shown_over_m == pytest.approx(1000.0, abs=150.0)
    assert drag.slip_shift == pytest.approx(8e3 / (MASS_KG * GRAVITY_MPS2 / 4) / STIFFNESS, rel=0.1)
    assert drag.rolled_apart == pytest.approx(0.0, abs=1e-5)
