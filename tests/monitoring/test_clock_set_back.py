"""A clock that is set back by ten minutes: what the rules remember is not ahead of them for as long."""

import pytest
from msgspec.structs import replace

from brake_monitor.estimation.doubts.frozen_reading import FROZEN_S, FrozenReading
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.inputs.held_input import HeldInput
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.inputs.wheel_watch import WheelWatch
from brake_monitor.monitoring.rule import Finding
from brake_monitor.monitoring.rules.brake_not_applied import BrakeNotApplied
from brake_monitor.monitoring.rules.hidden_drag import HiddenDrag, HiddenDragSearch
from brake_monitor.samples import Quantity
from brake_monitor.settings.alarm_settings import BrakeNotAppliedRule
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, observation, wheelset

SET_BACK_S = 600.0
FULL_N, CONTACT_N, NOMINAL = 40e3, 2000.0, 0.35
MASS_KG, GRAVITY_MPS2 = 36e3, 9.81
SPEED_MPS, RADIUS_M = 20.0, 0.45
CREEP_PER_N = 1e-7  # of force at the rail
NONE = (0.0, 0.0)


def rolling(
    time_s: float,
    *,
    pressing_n: tuple[float, ...] = NONE,
    rail_n: tuple[float, ...] = NONE,
    more_mps2: float = 0.0,
    radius_m: tuple[float, ...] = (RADIUS_M, RADIUS_M),
    speed_mps: float = SPEED_MPS,
) -> Estimate:
    """At constant speed; `rail_n` retards each wheelset, `more_mps2` is what the pressing forces do not explain."""
    turns = [speed_mps / own_m * (1.0 - CREEP_PER_N * own_n) for own_n, own_m in zip(rail_n, radius_m, strict=True)]
    wheelsets = tuple(
        wheelset(omega_radps=turn, slip=CREEP_PER_N * own_n, pressing_force_n=pressed_n)
        for turn, own_n, pressed_n in zip(turns, rail_n, pressing_n, strict=True)
    )
    return estimate(
        time_s=time_s,
        speed_mps=speed_mps,
        adhesion=sum(rail_n) / (MASS_KG * GRAVITY_MPS2),
        saturated=False,
        deceleration_mps2=more_mps2,
        wheelsets=wheelsets,
        mass_kg=MASS_KG,
    )


def clock(set_back_at_s: float) -> list[tuple[float, float]]:
    """True and shown time, ten times a second for two minutes."""
    true_s = [1000.0 + k / 10 for k in range(1200)]
    return [(t - 1000.0, t - SET_BACK_S * (t - 1000.0 >= set_back_at_s)) for t in true_s]


def test_creep_is_told_though_a_motor_acted_ten_minutes_ahead() -> None:
    meter, creeps = CreepMeter(CONTACT_N), None
    for true_s, time_s in clock(set_back_at_s=10.0):
        if true_s > 35.0:
            break
        brakes_n = FULL_N * (true_s >= 30.0)
        now = rolling(time_s, pressing_n=(brakes_n, brakes_n), rail_n=(0.2 * brakes_n, 0.2 * brakes_n))
        if true_s < 10.0:
            now = replace(now, wheelsets=tuple(replace(own, motor_force_n=-5e3) for own in now.wheelsets))
        meter.note(now, (True, True))
        creeps = meter.creep(now)
    assert creeps is not None
    assert creeps[0].value == pytest.approx(0.2 * FULL_N * CREEP_PER_N, rel=0.05)


@pytest.mark.parametrize("set_back_at_s", [20.0, 31.0, 45.0])
def test_free_rolling_is_seen_anew(set_back_at_s: float) -> None:
    """The wheelset that was turned meanwhile creeps no more than before."""
    meter, found = CreepMeter(CONTACT_N), None
    for true_s, time_s in clock(set_back_at_s):
        braked = 10.0 <= true_s < 30.0
        radius_m = (RADIUS_M, RADIUS_M if true_s < 30.0 else 0.998 * RADIUS_M)
        force_n = (FULL_N, FULL_N) if braked else NONE
        now = rolling(time_s, pressing_n=force_n, radius_m=radius_m)
        meter.note(now, (True, True))
        found = meter.creep(now)
    assert found is not None
    assert [creep.value for creep in found] == pytest.approx([0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("set_back_at_s", [10.0, 200.0], ids=["set back", "not set"])
def test_a_hidden_drag_is_found_after_the_next_release(set_back_at_s: float) -> None:
    search, found = HiddenDragSearch(CONTACT_N, 1200.0), list[HiddenDrag]()
    for true_s, time_s in clock(set_back_at_s):
        if true_s < 40.0:
            now = rolling(time_s)
        elif true_s < 60.0:
            now = rolling(time_s, pressing_n=(FULL_N, FULL_N), rail_n=(8e3, 8e3))
        else:
            now = rolling(time_s, rail_n=(3e3, 0.0), more_mps2=3e3 / MASS_KG)
        if drag := search.see(now, inputs_are_good=True):
            found.append(drag)
    assert found
    assert found[-1].wheelset == 0
    assert found[-1].retarding_force_n == pytest.approx(3e3)


def test_a_brake_that_does_not_come_is_told_though_slide_protection_acted_ten_minutes_ahead() -> None:
    rule, found_s = (
        BrakeNotApplied(BrakeNotAppliedRule(), CONTACT_N, NOMINAL, 2, CreepMeter(CONTACT_N)),
        [],
    )
    for true_s, time_s in clock(20.0):
        now = rolling(time_s)
        if 10.0 <= true_s < 15.0:
            acting = tuple(wheelset(wsp_active=True, slip=0.03) for _ in range(2))
            now = estimate(time_s=time_s, speed_mps=SPEED_MPS, wheelsets=acting)
        elif true_s >= 40.0:
            now = rolling(time_s, pressing_n=(FULL_N, 0.0), rail_n=(8e3, 0.0))
        if isinstance(rule.judge(observation(now))[1], Finding):
            found_s.append(true_s)
    assert found_s
    assert found_s[0] < 41.5


def test_a_reading_that_goes_on_repeating_itself_is_frozen_again_as_soon_as_ever() -> None:
    reading = FrozenReading(0.01)
    frozen_s = [true_s for true_s, time_s in clock(5.0) if reading.see(time_s, SPEED_MPS, SPEED_MPS - true_s, True)]
    again_s = [true_s for true_s in frozen_s if true_s >= 5.0]
    assert frozen_s[0] == pytest.approx(FROZEN_S)
    assert again_s[0] == pytest.approx(5.0 + FROZEN_S)


class Wheels:
    """A wagon at constant speed whose first wheelset, or both, may read something else than they do."""

    def __init__(self) -> None:
        vehicle = example_settings("wagon").vehicle
        self.watch, self.rolling_radps = WheelWatch(vehicle, CONTACT_N), SPEED_MPS / vehicle.wheel_radius_m[0]

    def told(self, time_s: float, turn: tuple[float, float], pressing_n: float) -> tuple[WheelState, ...]:
        """`turn`: of each wheelset, as a share of rolling."""
        omega = [share * self.rolling_radps for share in turn]
        self.watch.watchers[Quantity.SPEED, 0](time_s, SPEED_MPS)
        for i in range(2):
            self.watch.watchers[Quantity.AXLE_SPEED, i](time_s, omega[i])
            self.watch.watchers[Quantity.PRESSING_FORCE, i](time_s, pressing_n)
        seen = tuple(
            wheelset(slip=1.0 - share, omega_radps=own, pressing_force_n=pressing_n)
            for share, own in zip(turn, omega, strict=True)
        )
        return self.watch.judge(estimate(time_s=time_s, speed_mps=SPEED_MPS, wheelsets=seen), [True, True])


def test_a_wheel_sensor_that_died_before_is_told_all_the_same() -> None:
    wheels, states = Wheels(), (WheelState.UNKNOWN,)
    for true_s, time_s in clock(set_back_at_s=6.5):
        if true_s > 10.0:
            break
        states = wheels.told(time_s, (float(true_s < 6.0), 1.0), pressing_n=0.0)
    assert states[0] is WheelState.CONTRADICTED


def test_a_slide_before_does_not_make_a_slide_of_a_speed_that_lags() -> None:
    wheels, states = Wheels(), set()
    for true_s, time_s in clock(set_back_at_s=15.0):
        lag = min(max(0.05 * (true_s - 30.0), 0.0), 0.08)
        turn = 0.6 if 10.0 <= true_s < 10.6 else 1.0 - lag
        told = wheels.told(time_s, (turn, turn), pressing_n=FULL_N)
        if true_s > 30.0:
            states |= set(told)
    assert states == {WheelState.ROLLING}


def test_a_wheel_speed_that_is_wrong_is_told_though_the_brake_was_on_ten_minutes_ahead() -> None:
    wheels, states = Wheels(), (WheelState.UNKNOWN,)
    for true_s, time_s in clock(set_back_at_s=15.0):
        if true_s > 25.0:
            break
        braked = 5.0 <= true_s < 15.0
        states = wheels.told(time_s, (0.7 if true_s >= 20.0 else 1.0, 1.0), pressing_n=FULL_N * braked)
    assert states[0] is WheelState.CONTRADICTED


def test_the_force_that_was_lately_is_no_larger() -> None:
    before, after = HeldInput(), HeldInput()
    for k in range(100):
        for held in (before, after):
            held.sample(1000.0 + 0.05 * k, FULL_N, 0.5)
    after.sample(400.0, FULL_N, 0.5)
    before.sample(1005.0, FULL_N, 0.5)
    assert after.unseen_std_until(400.2) <= 1.01 * before.unseen_std_until(1005.2)
