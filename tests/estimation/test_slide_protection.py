"""Slide protection is known by what it does to a brake, and a driver is not taken for it."""

from collections.abc import Callable
from math import exp

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.inputs.slide_protection import SlideProtection
from brake_monitor.samples import Quantity
from brake_monitor.settings.example_vehicles import example_settings

FULL_N, SPEED_MPS = 40e3, 20.0
SLIPS, CREEPS = 0.03, 0.004


def acts_at_s(force_n: Callable[[float], float], slip: Callable[[float], float], flag: bool = False) -> list[float]:
    """When it is said to act, of ten observations a second; `flag`: the control unit says when it empties a brake."""
    protection, found = SlideProtection(), []
    for k in range(100):
        time_s = k / 10
        emptied = flag and force_n(time_s) < FULL_N
        shown_n = FULL_N if flag else force_n(time_s)
        protection.see(time_s, slip(time_s), SPEED_MPS, shown_n, emptied)
        if protection.is_acting:
            found.append(time_s)
    return found


def dumps(time_s: float) -> float:
    """Emptied at 2, 3 and 4 s, and filled again within half a second."""
    return 0.3 * FULL_N if any(at_s <= time_s < at_s + 0.3 for at_s in (2.0, 3.0, 4.0)) else FULL_N


def test_it_acts_from_its_second_act_on_until_it_has_not_for_a_while() -> None:
    found = acts_at_s(dumps, lambda _: SLIPS)
    assert found[0] == 3.0
    assert 5.0 < found[-1] < 6.0


def test_its_flag_tells_the_same_where_the_pressure_is_measured_before_its_valve() -> None:
    assert acts_at_s(dumps, lambda _: SLIPS, flag=True)[0] == 3.0


def test_a_driver_releases_once() -> None:
    assert acts_at_s(lambda t: FULL_N if t < 3.0 else 0.0, lambda _: SLIPS) == []


def test_a_brake_that_is_emptied_while_its_wheelset_only_creeps_is_a_driver_at_work() -> None:
    assert acts_at_s(dumps, lambda _: CREEPS) == []


def acts(force_n: Callable[[float], float], slip: float = SLIPS, speed_mps: float = SPEED_MPS) -> int:
    """How often it acts in six seconds, of nine observations a second."""
    protection = SlideProtection()
    return sum(protection.see(k * 0.11, slip, speed_mps, force_n(k * 0.11), False) for k in range(55))


def test_a_brake_that_hardly_presses_is_not_worth_emptying() -> None:
    assert acts(dumps) == 3
    assert acts(lambda t: 0.1 * dumps(t)) == 0


def test_neither_a_slip_that_is_creep_nor_one_of_a_wagon_that_hardly_moves_is_a_slide() -> None:
    assert acts(dumps, slip=0.012, speed_mps=50.0) == 0
    assert acts(dumps, slip=SLIPS, speed_mps=5.0) == 0


def test_a_brake_that_is_let_go_slowly_is_not_emptied() -> None:
    assert acts(lambda t: FULL_N * exp(-max(t - 2.0, 0.0) / 2.3)) == 0


def test_a_brake_that_is_kept_empty_was_emptied_once() -> None:
    assert acts(lambda t: FULL_N if t < 3.0 else 0.0) == 1


def test_a_brake_that_is_emptied_in_steps_and_filled_a_little_was_filled_again() -> None:
    def steps(time_s: float) -> float:
        shares = ((2.0, 1.0), (2.2, 0.7), (2.5, 0.0), (2.8, 0.3))
        return FULL_N * next((share for until_s, share in shares if time_s < until_s), 0.0)

    assert acts(steps) == 2


def test_a_flag_that_stays_tells_of_one_act() -> None:
    protection = SlideProtection()
    assert sum(protection.see(k / 10, SLIPS, SPEED_MPS, FULL_N, 20 <= k < 40) for k in range(50)) == 1


def test_what_flag_and_pressure_tell_of_one_after_the_other_is_one_act() -> None:
    protection = SlideProtection()
    told = [protection.see(k / 10, SLIPS, SPEED_MPS, dumps(k / 10), 22 <= k < 25) for k in range(28)]
    assert [k for k, begins in enumerate(told) if begins] == [20]


def test_by_a_clock_that_is_set_back_it_acts_as_before() -> None:
    protection = SlideProtection()
    rounds = [[protection.see(k / 10, SLIPS, SPEED_MPS, dumps(k / 10), False) for k in range(45)] for _ in range(2)]
    assert sum(rounds[0]) == 3
    assert rounds[1] == rounds[0]


def test_one_flag_for_all_wheelsets_speaks_for_the_one_that_slides_most() -> None:
    settings = example_settings("wagon")
    channels = SignalDecoder.from_settings(settings).channels
    one_flag = [channel for channel in channels if channel.measurand != (Quantity.WSP_ACTIVE, 1)]
    core = Estimator(settings.vehicle, settings.estimator, one_flag).core
    core.filter.x[core.wheelset_count] = SPEED_MPS
    for i, (wheel, slip) in enumerate(zip(core.wheels, (2 * SLIPS, SLIPS), strict=True)):
        wheel.axle_speed_lost, wheel.force.value = False, FULL_N
        core.filter.x[i] = SPEED_MPS * (1.0 - slip) / wheel.radius.radius_m
    for k in range(40):
        core.now.time_s = k / 10
        core.set_flag(0, dumps(k / 10) < FULL_N)
        core.look_at_slide_protections()
    assert [wheel.protection.is_acting for wheel in core.wheels] == [True, False]
    assert [wheel.work.wsp_actions for wheel in core.wheels] == [2, 0]
