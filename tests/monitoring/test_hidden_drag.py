"""A brake that drags unseen brakes from the release on: what comes later is the track."""

from math import log, pi, sin

import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.rules.hidden_drag import HiddenDrag, HiddenDragSearch
from test_clock_set_back import CONTACT_N, CREEP_PER_N, FULL_N, MASS_KG, RADIUS_M, rolling

BRAKED_S, RELEASED_S, END_S = 20.0, 60.0, 90.0
LEAST_N, DRAG_N = 1200.0, 3e3


def found(
    *,
    brakes_from_s: float,
    eases_from_s: float = END_S,
    pause_s: tuple[float, float] = (END_S, END_S),
    drives_until_s: float = 0.0,
) -> list[HiddenDrag]:
    """What is found after a release in a curve that makes one wheelset creep as DRAG_N would.

    The wagon is retarded by as much, but only from a while after the release, and until a while after. In the pause
    the brake is released for a moment. Motors may drive for a while after the release.
    """
    search, drags = HiddenDragSearch(CONTACT_N, LEAST_N), list[HiddenDrag]()
    for k in range(round(END_S * 10)):
        time_s = k / 10
        if time_s < BRAKED_S or pause_s[0] <= time_s < pause_s[1]:
            now = rolling(time_s)
        elif time_s < RELEASED_S:
            now = rolling(time_s, pressing_n=(FULL_N, FULL_N), rail_n=(8e3, 8e3))
        else:
            retards = RELEASED_S + brakes_from_s <= time_s < RELEASED_S + eases_from_s
            now = rolling(time_s, rail_n=(DRAG_N, 0.0), more_mps2=retards * DRAG_N / MASS_KG)
            if time_s < RELEASED_S + drives_until_s:
                now = replace(now, wheelsets=tuple(replace(own, motor_force_n=-5e3) for own in now.wheelsets))
        if drag := search.see(now, inputs_are_good=True):
            drags.append(drag)
    return drags


def test_what_retards_from_the_release_on_is_found() -> None:
    drags = found(brakes_from_s=0.0)
    assert drags
    assert {drag.wheelset for drag in drags} == {0}
    assert drags[-1].retarding_force_n == pytest.approx(DRAG_N)


def test_an_application_that_was_eased_for_a_moment_ends_with_its_last_release() -> None:
    drags = found(brakes_from_s=0.0, pause_s=(BRAKED_S + 5.0, BRAKED_S + 7.0))
    assert drags == found(brakes_from_s=0.0, pause_s=(BRAKED_S + 36.0, BRAKED_S + 38.0))
    assert drags[-1].retarding_force_n == pytest.approx(DRAG_N)


def test_what_shows_after_motors_have_driven_did_not_begin_with_the_release() -> None:
    assert not found(brakes_from_s=0.0, drives_until_s=12.0)


@pytest.mark.parametrize("brakes_from_s", [12.0, 15.0])
def test_a_gradient_that_sets_in_later_is_none(brakes_from_s: float) -> None:
    assert not found(brakes_from_s=brakes_from_s)


def test_a_gradient_that_ends_is_given_up() -> None:
    """Its mean over all that was rolled falls to 0.56 of the force before it fits the creep no more."""
    assert min(drag.retarding_force_n for drag in found(brakes_from_s=0.0, eases_from_s=15.0)) > 0.65 * DRAG_N


@pytest.mark.parametrize(
    ("creeps_n", "creeps_from_s", "is_found"),
    [
        (DRAG_N, 0.0, True),
        (3.0 * DRAG_N, 0.0, False),  # a narrow curve: no brake makes a wheelset creep more than it retards
        (0.4 * DRAG_N, 0.0, False),  # a steep gradient
        (DRAG_N, 14.0, False),  # the curve begins later
    ],
)
def test_a_gradient_and_a_curve_that_do_not_fit_together_are_no_drag(
    creeps_n: float, creeps_from_s: float, is_found: bool
) -> None:
    """The wagon is retarded by DRAG_N from the release on, and one wheelset creeps as under `creeps_n`."""
    search, drags = HiddenDragSearch(CONTACT_N, LEAST_N), list[HiddenDrag]()
    for k in range(round(END_S * 10)):
        time_s = k / 10
        if time_s < BRAKED_S:
            now = rolling(time_s)
        elif time_s < RELEASED_S:
            now = rolling(time_s, pressing_n=(FULL_N, FULL_N), rail_n=(8e3, 8e3))
        else:
            own_n = creeps_n * (time_s >= RELEASED_S + creeps_from_s)
            now = rolling(time_s, rail_n=(own_n, 0.0), more_mps2=DRAG_N / MASS_KG)
        if drag := search.see(now, inputs_are_good=True):
            drags.append(drag)
    assert bool(drags) == is_found


def test_of_a_single_wheelset_nothing_can_be_told() -> None:
    """There is no other that it could be compared with."""
    search = HiddenDragSearch(CONTACT_N, LEAST_N)
    for k in range(round(END_S * 10)):
        time_s = k / 10
        pressing_n = FULL_N * (BRAKED_S <= time_s < RELEASED_S)
        both = rolling(
            time_s,
            pressing_n=(pressing_n, pressing_n),
            rail_n=(0.2 * pressing_n, 0.0),
            more_mps2=DRAG_N / MASS_KG * (time_s >= RELEASED_S),
        )
        assert search.see(replace(both, wheelsets=both.wheelsets[:1]), inputs_are_good=True) is None


def after_a_release(
    *,
    rolls_s: float = 20.0,
    brakes_s: float = 10.0,
    released_s: float = 20.0,
    speed_mps: float = 20.0,
    brake_n: float = 8e3,
    retards_n: float = DRAG_N,
    creeps_n: float = DRAG_N,
    other_creeps_n: float = 0.0,
    until_s: float = END_S,
    curve_until_s: float = 0.0,
    climbs_until_s: float = END_S,
    speed_errs: float = 0.0,
    speed_errs_anew_s: float = 7.0,
    slides_at_s: float = END_S,
    lost_at_s: float = END_S,
) -> HiddenDrag | None:
    """What is found last, of three wheelsets on a gradient.

    After the release the wagon is retarded by `retards_n` until so long after it, and the first wheelset creeps as
    under `creeps_n`. Before there may be a curve for a while, and the gradient may end. The vehicle's speed may err to
    and fro in so many seconds, by so much of what the brake makes wheelsets creep. For a moment a wheelset may slide,
    or an input may be lost.
    """
    search, drag, climbs_mps2 = HiddenDragSearch(CONTACT_N, LEAST_N), None, 0.05
    release_s = rolls_s + brakes_s
    for k in range(round(10.0 * (release_s + released_s))):
        time_s = k / 10
        brakes, drags = rolls_s <= time_s < release_s, release_s <= time_s < release_s + until_s
        own_n = brakes * brake_n
        curve_n = DRAG_N * (time_s < curve_until_s)
        now = rolling(
            time_s,
            pressing_n=(FULL_N * brakes,) * 3,
            rail_n=(own_n + drags * creeps_n + curve_n, own_n + drags * other_creeps_n, own_n),
            more_mps2=drags * retards_n / MASS_KG + climbs_mps2 * (time_s < climbs_until_s),
            radius_m=(RADIUS_M, 0.99 * RADIUS_M, 0.99 * RADIUS_M),
            speed_mps=speed_mps,
        )
        err = speed_errs * brake_n * CREEP_PER_N * sin(2.0 * pi * time_s / speed_errs_anew_s)
        now = replace(now, speed_mps=now.speed_mps * (1.0 + err), saturated=time_s == slides_at_s)
        drag = search.see(now, inputs_are_good=time_s != lost_at_s) or drag
    return drag


def test_what_is_found_tells_how_the_wagon_rolled_before() -> None:
    drag = after_a_release()
    assert drag is not None
    assert drag.retarding_force_n == pytest.approx(DRAG_N)
    assert drag.slip_shift == pytest.approx(CREEP_PER_N * DRAG_N, rel=1e-3)
    assert drag.rolled_deceleration_mps2 == pytest.approx(0.05)
    assert drag.rolled_apart == pytest.approx(log(0.99))


@pytest.mark.parametrize(
    ("drive", "is_found"),
    [
        ({"speed_mps": 9.0}, True),
        ({"speed_mps": 7.0}, False),  # the speeds' own noise counts too much
        ({"rolls_s": 8.0}, True),
        ({"rolls_s": 6.0}, False),  # nobody knows how it rolled before
        ({"brakes_s": 4.0}, True),
        ({"brakes_s": 2.0}, False),  # nor how stiffly it creeps
        ({"released_s": 13.5}, True),
        ({"released_s": 11.5}, False),  # nor whether it lasts
        ({"brake_n": 0.0}, False),  # brakes that made nothing creep
        ({"speed_errs": 0.2}, True),
        ({"speed_errs": 1.4, "speed_errs_anew_s": 2.2}, True),  # a radar, of which little is left in ten seconds
        ({"speed_errs": 1.4}, False),  # that of a satellite receiver: it is not known how stiffly it creeps
        ({"retards_n": 1.5e3, "creeps_n": 1.5e3}, True),
        ({"retards_n": 1.1e3, "creeps_n": 1.1e3}, False),  # as good as none
        ({"retards_n": 1.3e3, "creeps_n": 0.9e3}, False),  # tyres and curves make as much creep
        ({"slides_at_s": 25.0}, False),  # what a wheelset crept under the brake is not what it creeps by a drag ...
        ({"lost_at_s": 25.0}, False),  # ... nor is it known to be, where it was not measured all the time
        ({"other_creeps_n": 0.75 * DRAG_N}, False),  # a curve, in which the others come apart as well
    ],
)
def test_what_shows_a_drag_and_what_does_not(drive: dict[str, float], is_found: bool) -> None:
    assert (after_a_release(**drive) is not None) is is_found


@pytest.mark.parametrize(
    "drive",
    [
        {"released_s": 45.0, "until_s": 31.0},  # the track may have changed
        {"rolls_s": 40.0, "curve_until_s": 26.0},  # it lies behind
        {"rolls_s": 40.0, "climbs_until_s": 33.0},  # a gradient counts while it is the same
    ],
)
def test_what_is_long_past_or_comes_late_has_no_say(drive: dict[str, float]) -> None:
    drag = after_a_release(**drive)
    assert drag is not None
    assert drag.retarding_force_n == pytest.approx(DRAG_N)
    assert drag.slip_shift == pytest.approx(CREEP_PER_N * DRAG_N, rel=1e-3)


def test_a_drag_is_gone_when_the_wagon_rolls_on_its_gradient_as_it_did_before() -> None:
    search = HiddenDragSearch(CONTACT_N, LEAST_N)
    search.lasting[0] = HiddenDrag(
        0, DRAG_N, CREEP_PER_N * DRAG_N, 1e-5, rolled_deceleration_mps2=0.05, rolled_apart=0.0
    )
    for k in range(150):
        search.see(rolling(k / 10, more_mps2=0.05), inputs_are_good=True)
    assert not search.lasting


AGAIN_S, FREED_S, SEEN_S = 100.0, 110.0, 125.0


@pytest.mark.parametrize("restarts", [False, True])
@pytest.mark.parametrize(
    ("drag_n", "more_n", "lasts"),
    [
        (DRAG_N, DRAG_N, True),  # it sticks at each release
        (0.0, 0.0, False),
        (0.0, DRAG_N, True),  # on a steeper gradient nothing shows that it is gone ...
        (DRAG_N, 0.0, True),  # ... nor in a curve
        (0.4 * DRAG_N, 0.4 * DRAG_N, False),  # gradients and curves do as much
        (0.6 * DRAG_N, 0.4 * DRAG_N, True),
        (0.4 * DRAG_N, 0.6 * DRAG_N, True),
    ],
)
def test_a_drag_lasts_until_the_wagon_rolls_without_either_trace(
    drag_n: float, more_n: float, lasts: bool, restarts: bool
) -> None:
    """It is found after the first release; then the brakes are put on again, and released.

    The program may end in between, and go on with what it has told of.
    """
    search = HiddenDragSearch(CONTACT_N, LEAST_N)
    for k in range(round(SEEN_S * 10)):
        time_s = k / 10
        if time_s < BRAKED_S:
            now = rolling(time_s)
        elif time_s < RELEASED_S or AGAIN_S <= time_s < FREED_S:
            now = rolling(time_s, pressing_n=(FULL_N, FULL_N), rail_n=(8e3, 8e3))
        elif time_s < AGAIN_S:
            now = rolling(time_s, rail_n=(DRAG_N, 0.0), more_mps2=DRAG_N / MASS_KG)
        else:
            now = rolling(time_s, rail_n=(drag_n, 0.0), more_mps2=more_n / MASS_KG)
        search.see(now, inputs_are_good=True)
        if RELEASED_S + 15.0 < time_s < FREED_S:
            assert set(search.lasting) == {0}
        if restarts and time_s == AGAIN_S - 1.0:
            (drag,) = search.lasting.values()
            search = HiddenDragSearch(CONTACT_N, LEAST_N)
            search.lasting[drag.wheelset] = drag
    assert set(search.lasting) == ({0} if lasts else set())


@pytest.mark.parametrize(("turned_to", "lasts"), [(0.997, False), (0.9985, False), (0.999, True)])
def test_a_drag_that_was_told_before_tyres_were_turned_does_not_last_for_ever(turned_to: float, lasts: bool) -> None:
    """In the workshop the brake was mended, and the other wheelset turned: this one turns slowly ever after.

    A narrow curve does as much as a thousandth.
    """
    search = HiddenDragSearch(CONTACT_N, LEAST_N)
    search.lasting[0] = HiddenDrag(
        0, DRAG_N, CREEP_PER_N * DRAG_N, 1e-5, rolled_deceleration_mps2=0.0, rolled_apart=0.0
    )
    for k in range(150):
        search.see(rolling(k / 10, radius_m=(RADIUS_M, turned_to * RADIUS_M)), inputs_are_good=True)
    assert bool(search.lasting) is lasts


FIRST_BRAKED_S, BEGINS_S, FIRST_RELEASED_S = 20.0, 30.0, 40.0
SECOND_BRAKED_S, SECOND_RELEASED_S, LAST_S = 62.0, 70.0, 90.0


def found_of_what_begins_while_braking(*, shift_ends_s: float, force_ends_s: float) -> dict[float, HiddenDrag]:
    """What is found when, where force and creep begin in the midst of the first of two applications."""
    search, drags = HiddenDragSearch(CONTACT_N, LEAST_N), dict[float, HiddenDrag]()
    for k in range(round(LAST_S * 10)):
        time_s = k / 10
        braked = FIRST_BRAKED_S <= time_s < FIRST_RELEASED_S or SECOND_BRAKED_S <= time_s < SECOND_RELEASED_S
        creeps_n = DRAG_N * (BEGINS_S <= time_s < shift_ends_s)
        retards_n = DRAG_N * (BEGINS_S <= time_s < force_ends_s)
        own_n = 8e3 * braked
        pressing_n = FULL_N * braked
        now = rolling(
            time_s,
            pressing_n=(pressing_n, pressing_n),
            rail_n=(own_n + creeps_n, own_n),
            more_mps2=retards_n / MASS_KG,
        )
        if drag := search.see(now, inputs_are_good=True):
            drags[time_s] = drag
    return drags


def test_a_drag_that_begins_while_braking_is_found_once_it_outlasts_the_next_application() -> None:
    """A curve that begins meanwhile looks the same until then."""
    drags = found_of_what_begins_while_braking(shift_ends_s=LAST_S, force_ends_s=LAST_S)
    assert min(drags) > SECOND_RELEASED_S
    assert min(drags) < SECOND_RELEASED_S + 8.0
    assert {drag.wheelset for drag in drags.values()} == {0}
    assert drags[max(drags)].retarding_force_n == pytest.approx(DRAG_N)


@pytest.mark.parametrize(
    ("shift_ends_s", "force_ends_s"),
    [
        (SECOND_BRAKED_S, SECOND_BRAKED_S),  # a curve on a gradient that ends
        (SECOND_BRAKED_S, LAST_S),  # the curve does
        (LAST_S, SECOND_BRAKED_S),  # the gradient does
        (SECOND_RELEASED_S + 1.0, LAST_S),
    ],
)
def test_a_curve_that_began_while_braking_and_ends_is_no_drag(shift_ends_s: float, force_ends_s: float) -> None:
    assert not found_of_what_begins_while_braking(shift_ends_s=shift_ends_s, force_ends_s=force_ends_s)


@pytest.mark.parametrize(("pulls_until_s", "is_found"), [(BRAKED_S, False), (BRAKED_S - 3.0, False), (0.0, True)])
def test_the_end_of_a_pull_is_no_drag(pulls_until_s: float, is_found: bool) -> None:
    """As the driver stops pulling and brakes, in a curve after the release, both traces show."""
    pull_mps2 = 0.12
    assert pull_mps2 / 2.0 * MASS_KG > LEAST_N
    search, drags = HiddenDragSearch(CONTACT_N, LEAST_N), list[HiddenDrag]()
    for k in range(round(END_S * 10)):
        time_s = k / 10
        if time_s < BRAKED_S:
            now = rolling(time_s, more_mps2=-pull_mps2 * (time_s < pulls_until_s))
        elif time_s < RELEASED_S:
            now = rolling(time_s, pressing_n=(FULL_N, FULL_N), rail_n=(8e3, 8e3))
        else:
            now = rolling(time_s, rail_n=(DRAG_N, 0.0), more_mps2=(pulls_until_s == 0.0) * DRAG_N / MASS_KG)
        if drag := search.see(now, inputs_are_good=True):
            drags.append(drag)
    assert bool(drags) == is_found
