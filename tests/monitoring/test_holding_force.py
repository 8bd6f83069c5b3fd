"""What could hold a wheelset: the torque of its pads and motor against that of the poorest rail."""

from math import inf

import pytest

from brake_monitor.monitoring.inputs.holding_force import HoldingForce
from brake_monitor.settings.bounds import LARGEST_FRICTION
from brake_monitor.settings.example_vehicles import example_settings

VEHICLE = example_settings("wagon").vehicle
CONTACT_N = 100.0
NM_PER_N = LARGEST_FRICTION * VEHICLE.brake_radius_m[0]  # the most that pads make of a force
POOREST_NM = 0.01 * VEHICLE.mass_kg * 9.81 / VEHICLE.wheelset_count * VEHICLE.wheel_radius_m[0]  # adhesion of 0.01


def holding(contact_n: float = CONTACT_N) -> HoldingForce:
    return HoldingForce(VEHICLE, 0, contact_n)


def test_the_least_force_holds_a_wheelset_on_the_poorest_rail() -> None:
    force = holding()
    assert force.least_n * NM_PER_N == pytest.approx(POOREST_NM, rel=1e-3)
    force.bear(2.0 * VEHICLE.mass_kg)
    assert force.least_n * NM_PER_N == pytest.approx(2.0 * POOREST_NM, rel=1e-3)


def test_pads_that_do_not_touch_hold_nothing() -> None:
    assert holding(contact_n=50e3).least_n == 50e3


@pytest.mark.parametrize(
    ("by_pads", "by_motor", "suffices"), [(1.01, 0.0, True), (0.0, 1.01, True), (0.6, 0.5, True), (0.5, 0.4, False)]
)
def test_pads_and_motor_hold_it_together(by_pads: float, by_motor: float, suffices: bool) -> None:
    """By so many parts of what is needed."""
    force = holding()
    force.see_force(0.0, by_pads * POOREST_NM / NM_PER_N)
    force.see_torque(0.0, -by_motor * POOREST_NM)
    assert force.suffices is suffices
    assert force.largest_n * NM_PER_N == pytest.approx((by_pads + by_motor) * POOREST_NM)


@pytest.mark.parametrize(("torque", "drives"), [(1.01, True), (0.9, False), (-1.01, False)])
def test_a_motor_drives_a_wheelset_that_it_could_turn_against_its_pads(torque: float, drives: bool) -> None:
    force = holding()
    assert (force.driven_s, force.told_s, force.largest_n) == (-inf, -inf, 0.0)
    force.see_torque(7.0, torque * POOREST_NM)
    assert (force.driven_s, force.told_s) == (7.0 if drives else -inf, 7.0)
    assert (force.motor_force_n > 0.0) is (torque < 0.0)


@pytest.mark.parametrize(("released_for_s", "is_left"), [(1.25, True), (1.75, False)])
def test_a_brake_that_has_pressed_just_now_may_have_stopped_it(released_for_s: float, is_left: bool) -> None:
    force = holding()
    force.see_force(0.0, 40e3)
    force.remember(0.0)
    force.see_force(0.05, 0.0)
    for k in range(1, round(4.0 * released_for_s) + 1):
        force.remember(0.25 * k)
    assert force.largest_n == (40e3 if is_left else 0.0)


def test_a_brake_that_has_come_on_since_the_last_observation_may_have_stopped_it() -> None:
    force = holding()
    force.remember(0.0)
    force.see_force(0.05, 40e3)
    assert force.largest_n == 40e3


def test_a_clock_that_is_set_back_leaves_no_force_ahead() -> None:
    force = holding()
    force.see_force(100.0, 40e3)
    force.remember(100.0)
    force.see_force(50.0, 0.0)
    force.remember(50.0)
    assert force.largest_n == 0.0
