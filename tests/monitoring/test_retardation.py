"""What brakes take from the speed, against how the wagon rolled just before."""

import pytest

from brake_monitor.monitoring.inputs.retardation import EXPIRES_S, Retardation
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

BRAKES_MPS2 = 0.5
STEP_S = 0.1


def by_brakes_mps2(*legs: tuple[float, float, float]) -> float | None:
    """At the end of these, one after the other: how long each lasts, what line and brakes take from the speed."""
    vehicle = example_settings("wagon").vehicle
    retardation, time_s, speed_mps = Retardation(vehicle), 0.0, 40.0
    own = wheelset(motor_force_n=0.0)
    for lasts_s, line_mps2, brakes_mps2 in legs:
        for _ in range(round(lasts_s / STEP_S)):
            now = estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=(own, own), mass_kg=vehicle.mass_kg)
            retardation.see(now, rolls_freely=brakes_mps2 == 0.0)
            time_s += STEP_S
            speed_mps -= STEP_S * (vehicle.resistance_n(speed_mps) / vehicle.mass_kg + line_mps2 + brakes_mps2)
    return retardation.by_brakes_mps2


def test_it_is_told_against_what_the_line_took_before() -> None:
    assert by_brakes_mps2((20.0, 0.1, 0.0), (5.0, 0.1, BRAKES_MPS2)) == pytest.approx(BRAKES_MPS2, abs=0.01)


def test_of_a_line_that_has_changed_only_what_came_after_counts() -> None:
    found = by_brakes_mps2((20.0, -0.1, 0.0), (8.0, 0.15, 0.0), (5.0, 0.15, BRAKES_MPS2))
    assert found == pytest.approx(BRAKES_MPS2, abs=0.02)


def test_a_line_that_was_long_ago_says_nothing() -> None:
    braked_s = 4.0
    for creeping_s, is_told in ((EXPIRES_S - braked_s - 5.0, True), (EXPIRES_S, False)):
        found = by_brakes_mps2((20.0, 0.1, 0.0), (creeping_s, 0.1, 0.01), (braked_s, 0.1, BRAKES_MPS2))
        assert (found is not None) is is_told
