"""With which moment of steady braking a later one may be compared."""

import pytest

from brake_monitor.estimation.doubts.braking_reference import BrakingReference

BEGAN_S, COMPARED_S = 10.0, 11.0
GIVEN_MPS2 = 0.8  # by the brakes, per unit of friction


def reference() -> BrakingReference:
    made = BrakingReference(lasts_s=2.0)
    made.began_s, made.compared_s, made.per_friction_mps2 = BEGAN_S, COMPARED_S, GIVEN_MPS2
    return made


@pytest.mark.parametrize(("time_s", "is_held"), [(COMPARED_S, True), (11.4, True), (11.6, False), (12.1, False)])
def test_it_holds_while_it_is_young_and_was_compared_with_just_now(time_s: float, is_held: bool) -> None:
    assert reference().holds(time_s, GIVEN_MPS2) is is_held


def test_it_ends_with_its_age_however_lately_it_was_compared_with() -> None:
    made = reference()
    made.compared_s = 12.1
    assert not made.holds(12.1, GIVEN_MPS2)


@pytest.mark.parametrize(("given_mps2", "is_held"), [(0.87, True), (0.73, True), (0.9, False), (0.7, False)])
def test_it_holds_while_the_brakes_press_as_they_did(given_mps2: float, is_held: bool) -> None:
    assert reference().holds(COMPARED_S, given_mps2) is is_held


def test_it_is_no_reference_for_what_a_clock_that_was_set_back_puts_before_it() -> None:
    """The time since the last comparison would count negatively, and what may have changed by now would shrink."""
    assert not reference().holds(10.8, GIVEN_MPS2)
    assert not BrakingReference(lasts_s=2.0).holds(BEGAN_S, GIVEN_MPS2)
