"""Friction is known for the force that it was learned at."""

import pytest

from brake_monitor.estimation.doubts.force_departure import CONTACT_S, RELATIVE_STD, ForceDeparture

FULL_N, LIGHT_N = 60_000.0, 6_000.0
STEP_S = 0.02


def after(departure: ForceDeparture, duration_s: float, pressing_force_n: float, observable: float = 1.0) -> float:
    for _ in range(round(duration_s / STEP_S)):
        departure.see(STEP_S, pressing_force_n, observable)
    return departure.relative_std


def test_a_steady_force_leaves_nothing_in_doubt() -> None:
    assert after(ForceDeparture(), 20.0, FULL_N) < 0.01 * RELATIVE_STD


def test_before_any_brake_nothing_has_departed() -> None:
    assert after(ForceDeparture(), 20.0, 0.0, observable=0.0) == 0.0


def test_a_rising_force_teaches_as_it_acts() -> None:
    """From a light to a full braking: the pads grow into the force as fast as their friction shows itself."""
    departure = ForceDeparture()
    after(departure, 20.0, LIGHT_N)
    assert max(after(departure, STEP_S, FULL_N) for _ in range(500)) < 0.1 * RELATIVE_STD


def test_a_force_at_which_friction_does_not_show_teaches_nothing() -> None:
    departure = ForceDeparture()
    after(departure, 20.0, LIGHT_N)
    gone = 1.0 - LIGHT_N / FULL_N
    assert after(departure, 20.0, FULL_N, observable=0.0) == pytest.approx(gone * RELATIVE_STD, rel=0.01)


@pytest.mark.parametrize("observable", [0.0, 1.0])
def test_a_vented_brake_rubs_otherwise_within_the_pads_own_time(observable: float) -> None:
    """It is nearly all in doubt after three of their time constants, and stays so for as long as a slide takes."""
    departure = ForceDeparture()
    after(departure, 20.0, FULL_N)
    assert after(departure, 0.1, LIGHT_N, observable) < 0.1 * RELATIVE_STD
    gone = 1.0 - LIGHT_N / FULL_N
    assert after(departure, 3.0 * CONTACT_S, LIGHT_N, observable) == pytest.approx(gone * RELATIVE_STD, rel=0.1)
    assert after(departure, 3.0, LIGHT_N, observable) > 0.8 * gone * RELATIVE_STD


def test_the_force_is_back_and_with_it_what_was_known() -> None:
    departure = ForceDeparture()
    after(departure, 20.0, FULL_N)
    after(departure, 5.0, 0.0, observable=0.0)
    assert departure.relative_std > 0.9 * RELATIVE_STD
    assert after(departure, 5.0 * CONTACT_S, FULL_N) < 0.02 * RELATIVE_STD
