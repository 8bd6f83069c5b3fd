"""What wheels and motors do, told from what sensors do: by hand-made readings of wagons with motors."""

from collections.abc import Callable, Sequence
from functools import cache

import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.inputs.wheel_state import WheelState
from brake_monitor.monitoring.inputs.wheel_watch import WheelWatch
from brake_monitor.samples import Quality, Quantity, Sample
from brake_monitor.settings.config import Vehicle
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

CONTACT_N = 2000.0
MOTOR_FROM_S = 3.0
BRAKING_NM, DRIVING_NM, SLIDES_FROM_S = -6000.0, 6000.0, 5.0


def show(watch: WheelWatch, sample: Sample) -> None:
    assert sample.quality is Quality.GOOD
    watch.watchers[sample.quantity, sample.wheelset](sample.time_s, sample.value)


def show_all(
    watch: WheelWatch, time_s: float, speed_mps: float, omegas_radps: Sequence[float], *, pressing_n: float
) -> None:
    """What is read of a wagon whose brakes press alike, at one instant."""
    show(watch, Sample(time_s, Quantity.SPEED, 0, speed_mps, Quality.GOOD))
    for i, omega_radps in enumerate(omegas_radps):
        show(watch, Sample(time_s, Quantity.AXLE_SPEED, i, omega_radps, Quality.GOOD))
        show(watch, Sample(time_s, Quantity.PRESSING_FORCE, i, pressing_n, Quality.GOOD))


@cache
def vehicle(name: str) -> Vehicle:
    return example_settings(name).vehicle


def states_of_a_powered_wheelset(
    torque_nm: float, slip_then: float, *, retardation_mps2: float, late_s: float = 0.0
) -> set[WheelState]:
    """What is thought of it from 3 s after its slip begins; no pad ever presses. Estimates are late by `late_s`."""
    wagon = vehicle("rig")
    watch, radius_m, found = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], set()
    for k in range(1200):
        time_s = k / 100
        speed_mps = 25.0 - retardation_mps2 * max(time_s - SLIDES_FROM_S, 0.0)
        slip = slip_then * min(max((time_s - SLIDES_FROM_S) / 0.5, 0.0), 1.0)
        omega_radps = speed_mps * (1.0 - slip) / radius_m
        readings = {
            Quantity.SPEED: speed_mps,
            Quantity.AXLE_SPEED: omega_radps,
            Quantity.PRESSING_FORCE: 0.0,
            Quantity.WHEEL_TORQUE: torque_nm if time_s > MOTOR_FROM_S else 0.0,
        }
        for quantity, value in readings.items():
            show(watch, Sample(time_s, quantity, 0, value, Quality.GOOD))
        if k % 10 == 0:
            own = wheelset(slip=slip, omega_radps=omega_radps, pressing_force_n=0.0)
            (state,) = watch.judge(estimate(time_s=time_s - late_s, speed_mps=speed_mps, wheelsets=(own,)), [True])
            found |= {state} if time_s > SLIDES_FROM_S + 3.0 else set()
    return found


def test_a_wheelset_that_slides_under_its_dynamic_brake_slides() -> None:
    assert states_of_a_powered_wheelset(BRAKING_NM, 0.4, retardation_mps2=0.3) == {WheelState.SLIDING}
    assert states_of_a_powered_wheelset(0.0, 0.4, retardation_mps2=0.0) == {WheelState.CONTRADICTED}


def test_a_wheelset_that_its_dynamic_brake_stops_stands() -> None:
    assert states_of_a_powered_wheelset(BRAKING_NM, 1.0, retardation_mps2=0.3) == {WheelState.STOPPED}


def test_a_wheelset_that_spins_under_its_motor_is_no_sensor_fault() -> None:
    assert states_of_a_powered_wheelset(DRIVING_NM, -0.4, retardation_mps2=-0.3) == {WheelState.ROLLING}
    assert states_of_a_powered_wheelset(DRIVING_NM, -0.4, retardation_mps2=-0.3, late_s=0.3) == {WheelState.ROLLING}
    assert states_of_a_powered_wheelset(BRAKING_NM, -0.4, retardation_mps2=0.3) == {WheelState.CONTRADICTED}


def test_a_wheel_speed_that_dies_while_the_motor_brakes_is_a_sensor() -> None:
    """What the motor takes from the speed is not taken for a stopped wheelset that drags."""
    wagon = vehicle("wagon")
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    states: set[WheelState] = set()
    for k in range(1200):
        time_s = k / 100
        speed_mps = 25.0 - 0.7 * max(time_s - MOTOR_FROM_S, 0.0)
        omega_radps = speed_mps / radius_m
        torque_nm = BRAKING_NM if time_s > MOTOR_FROM_S else 0.0
        said_radps = (0.0 if time_s >= 6.0 else omega_radps, omega_radps)
        show(watch, Sample(time_s, Quantity.SPEED, 0, speed_mps, Quality.GOOD))
        for i in range(2):
            show(watch, Sample(time_s, Quantity.AXLE_SPEED, i, said_radps[i], Quality.GOOD))
            show(watch, Sample(time_s, Quantity.WHEEL_TORQUE, i, torque_nm, Quality.GOOD))
        if k % 10 == 0:
            wheelsets = tuple(wheelset(slip=0.0, omega_radps=said, pressing_force_n=0.0) for said in said_radps)
            states = {watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=wheelsets), [True, True])[0]}
    assert states == {WheelState.CONTRADICTED}


@pytest.mark.parametrize(("drag_mps2", "may_be_locked"), [(0.0, False), (0.14, False), (0.16, True), (0.2, True)])
def test_a_wheelset_that_seizes_while_braked_may_stand_where_the_released_wagon_drags(
    drag_mps2: float, may_be_locked: bool
) -> None:
    """It falls as sensors fall, and takes no more from the speed than its brake did: that shows after the release."""
    wagon = vehicle("wagon")
    watch, radius_m, released_s = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], 9.0
    for k in range(2000):
        time_s = k / 100
        brakes = MOTOR_FROM_S < time_s < released_s
        rolling_mps2 = wagon.resistance_n(20.0) / wagon.mass_kg + drag_mps2
        braked_s = min(max(time_s - MOTOR_FROM_S, 0.0), released_s - MOTOR_FROM_S)
        speed_mps = 25.0 - 0.5 * braked_s - rolling_mps2 * max(time_s - released_s, 0.0)
        said_radps = (0.0 if time_s >= 6.0 else speed_mps / radius_m, speed_mps / radius_m)
        force_n = 20e3 if brakes else 0.0
        show_all(watch, time_s, speed_mps, said_radps, pressing_n=force_n)
        if k % 10 == 0:
            seen = tuple(wheelset(slip=0.0, omega_radps=said, pressing_force_n=force_n) for said in said_radps)
            told = watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen), [True, True])
            assert not (brakes and watch.may_be_locked)
    assert told[0] is WheelState.CONTRADICTED
    assert watch.may_be_locked is may_be_locked


@pytest.mark.parametrize(
    ("drag_mps2", "lasts_s", "is_in_train", "state"),
    [
        (0.5, 12.0, False, WheelState.BLOCKED),  # no brake says that it holds it
        (0.5, 7.0, False, WheelState.CONTRADICTED),  # as of a shove that ends
        (0.32, 12.0, False, WheelState.BLOCKED),
        (0.28, 12.0, False, WheelState.CONTRADICTED),  # or the line climbs by 28 per mille
        (0.5, 12.0, True, WheelState.CONTRADICTED),  # or the train brakes
    ],
)
def test_a_wheelset_that_never_turned_is_believed_to_stand_once_the_wagon_drags_for_long(
    drag_mps2: float, lasts_s: float, *, is_in_train: bool, state: WheelState
) -> None:
    """It was judged as the wagon was pulled, which tells nothing of a drag; then it runs on by itself."""
    wagon, pulled_until_s = vehicle("wagon"), 20.0
    watch, radius_m = WheelWatch(wagon, CONTACT_N, is_in_train=is_in_train), wagon.wheel_radius_m[0]
    states, speed_mps = [], 0.0
    for k in range(3600):
        time_s = k / 100
        drags = pulled_until_s <= time_s < pulled_until_s + lasts_s
        rolling_mps2 = wagon.resistance_n(speed_mps) / wagon.mass_kg
        speed_mps += 0.01 * (0.8 if time_s < pulled_until_s else -rolling_mps2 - drag_mps2 * drags)
        show_all(watch, time_s, speed_mps, (0.0, speed_mps / radius_m), pressing_n=0.0)
        if k % 10 == 0:
            seen = tuple(wheelset(slip=0.0, omega_radps=w, pressing_force_n=0.0) for w in (0.0, speed_mps / radius_m))
            now = estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen)
            states.append(watch.judge(now, [True, True])[0])
    assert states[200 - 1] is WheelState.CONTRADICTED
    assert states[320 - 1] is state


@pytest.mark.parametrize("pressed", [False, True])
@pytest.mark.parametrize(("fall_s", "state"), [(0.02, WheelState.CONTRADICTED), (0.8, WheelState.STOPPED)])
def test_a_wheelset_that_fell_while_the_vehicles_speed_was_lost_is_judged_by_that(
    fall_s: float, state: WheelState, *, pressed: bool
) -> None:
    """In a tunnel its sensor dies, or its brake locks it; it is braked as the vehicle's speed is told again."""
    wagon, fell_s, tunnel_s = vehicle("wagon"), 30.0, (20.0, 50.0)
    watch, radius_m, states, speed_mps = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], [], 25.0
    for k in range(5500):
        time_s = k / 100
        force_n = 30e3 if time_s >= 45.0 or (pressed and time_s >= 29.0) else 0.0
        speed_mps -= 0.01 * 0.3 * (force_n > 0.0)
        turns = min(max(1.0 - (time_s - fell_s) / fall_s, 0.0), 1.0)
        omegas_radps = (turns * speed_mps / radius_m, speed_mps / radius_m)
        is_told = not tunnel_s[0] <= time_s < tunnel_s[1]
        if is_told and k % 5 == 0:
            show(watch, Sample(time_s, Quantity.SPEED, 0, speed_mps, Quality.GOOD))
        for i, omega_radps in enumerate(omegas_radps):
            show(watch, Sample(time_s, Quantity.AXLE_SPEED, i, omega_radps, Quality.GOOD))
            show(watch, Sample(time_s, Quantity.PRESSING_FORCE, i, force_n, Quality.GOOD))
        if k % 10 == 0:
            seen = tuple(wheelset(slip=0.0, omega_radps=own, pressing_force_n=force_n) for own in omegas_radps)
            now = estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen)
            states.append(watch.judge(now, [is_told, is_told])[0])
    assert {*states[: 200 - 1]} == {WheelState.ROLLING}
    assert states[-1] is state


@pytest.mark.parametrize("lost", ["", "its own speed", "both"])
def test_what_drags_before_and_after_speeds_were_lost_does_not_drag_for_long(lost: str) -> None:
    """Three seconds before and three after, in which the wagon is shoved back; a wheel speed never came."""
    wagon, pulled_until_s = vehicle("wagon"), 20.0
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    states, speed_mps = [], 0.0
    for k in range(3600):
        time_s = k / 100
        drags = 20.0 <= time_s < 23.0 or 32.0 <= time_s < 35.0
        is_lost = 22.8 <= time_s < 33.5
        rolling_mps2 = wagon.resistance_n(speed_mps) / wagon.mass_kg
        speed_mps += 0.01 * (0.8 if time_s < pulled_until_s else -rolling_mps2 - 0.5 * drags)
        show_all(watch, time_s, speed_mps, (0.0, speed_mps / radius_m), pressing_n=0.0)
        if k % 10 == 0:
            seen = tuple(wheelset(slip=0.0, omega_radps=w, pressing_force_n=0.0) for w in (0.0, speed_mps / radius_m))
            measured = [not (is_lost and lost), not (is_lost and lost == "both")]
            states.append(watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen), measured)[0])
    assert (WheelState.UNKNOWN in states) is bool(lost)
    assert states[-1] is WheelState.CONTRADICTED


@pytest.mark.parametrize(
    ("others_share", "acts", "thought"),
    [
        (0.0, False, WheelState.SLIDING),
        (1.0, False, WheelState.ROLLING),
        (1.0, True, WheelState.SLIDING),
        (2.0, False, WheelState.SLIDING),
    ],
    ids=["alone", "both alike", "both alike, and protection acts", "both, and the other more"],
)
def test_a_slip_that_grows_slowly_is_a_slide_but_where_it_may_be_the_vehicles_speed_that_lags(
    others_share: float, acts: bool, thought: WheelState
) -> None:
    """That makes all wheelsets slip alike, and no slide protection act."""
    wagon = vehicle("wagon")
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    states: set[WheelState] = set()
    for k in range(900):
        time_s = k / 100
        speed_mps = 20.0 - 0.5 * max(time_s - MOTOR_FROM_S, 0.0)
        slip = min(0.02 * max(time_s - SLIDES_FROM_S, 0.0), 0.08)  # the wheelset loses less than 1 m/s²
        slips = (slip, others_share * slip)
        omega_radps = [speed_mps * (1.0 - own) / radius_m for own in slips]
        show_all(watch, time_s, speed_mps, omega_radps, pressing_n=20e3)
        if k % 10 == 0:
            seen = tuple(
                wheelset(slip=own, omega_radps=turns, pressing_force_n=20e3, wsp_active=acts)
                for own, turns in zip(slips, omega_radps, strict=True)
            )
            told = watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen), [True, True])
            states |= {told[0]} if slip > 0.07 else set()
    assert states == {thought}


@pytest.mark.parametrize(("configured_kg", "told_kg"), [(36e3, 12e3), (12e3, 12e3), (12e3, 36e3)])
def test_what_holds_a_wheelset_goes_by_the_load_that_is_known(configured_kg: float, told_kg: float) -> None:
    """4 kN hold a wheelset of an empty wagon on a rail that gives hardly anything, and none of a laden one."""
    wagon = replace(vehicle("wagon"), mass_kg=configured_kg)
    watch, radius_m, found = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], set()
    for k in range(400):
        time_s, speed_mps = k / 10, min(max(k - 20, 0) * 0.04, 10.0)  # from rest; the first wheelset never turns
        turns_radps = (0.0, speed_mps / radius_m)
        show_all(watch, time_s, speed_mps, turns_radps, pressing_n=4000.0)
        wheelsets = tuple(
            wheelset(slip=float(i == 0 and speed_mps > 1.0), omega_radps=turns_radps[i], pressing_force_n=4000.0)
            for i in range(2)
        )
        now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, mass_kg=told_kg, wheelsets=wheelsets)
        found = {watch.judge(now, [True, True])[0]}
    assert found == {WheelState.STOPPED if told_kg == 12e3 else WheelState.CONTRADICTED}


CUT_OUT_MPS = 2.8  # below it the wheel-speed sensors say 0


@pytest.mark.parametrize("told_again_mps", [2.7, 2.0])
def test_a_vehicle_speed_that_comes_back_beside_sensors_that_have_cut_out_locks_no_wheelset(
    told_again_mps: float,
) -> None:
    """A tunnel hides it while the wagon is braked to a stop: what it was before says nothing of the wheels."""
    wagon, speed_mps, found = vehicle("wagon"), 20.0, set()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(3000):
        time_s = k / 100
        speed_mps = max(speed_mps - 0.01 * 0.8, 0.0) if time_s > 2.0 else speed_mps
        is_told = time_s < 5.0 or speed_mps < told_again_mps
        if is_told:
            show(watch, Sample(time_s, Quantity.SPEED, 0, speed_mps, Quality.GOOD))
        omega_radps = speed_mps / radius_m if speed_mps > CUT_OUT_MPS else 0.0
        for i in range(2):
            show(watch, Sample(time_s, Quantity.AXLE_SPEED, i, omega_radps, Quality.GOOD))
            show(watch, Sample(time_s, Quantity.PRESSING_FORCE, i, 20e3, Quality.GOOD))
        if k % 10 == 0:
            own = wheelset(slip=float(omega_radps == 0.0), omega_radps=omega_radps, pressing_force_n=20e3)
            now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, wheelsets=(own, own))
            found |= set(watch.judge(now, [is_told, is_told]))
    assert found.isdisjoint({WheelState.STOPPED, WheelState.CONTRADICTED, WheelState.SLIDING})


def test_a_wheel_speed_that_dies_as_the_brakes_come_on_is_a_sensor() -> None:
    """It is they that retard the wagon more than before."""
    wagon, speed_mps, states = vehicle("wagon"), 25.0, set()
    watch, radius_m, died_s = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], 6.0
    for k in range(900):
        time_s = k / 100
        force_n = 1e3 + 40e3 * min(max(time_s - died_s, 0.0), 0.5)
        speed_mps -= 0.01 * (0.02 + 0.8 * force_n / 20e3)
        said_radps = (0.0 if time_s >= died_s else speed_mps / radius_m, speed_mps / radius_m)
        show_all(watch, time_s, speed_mps, said_radps, pressing_n=force_n)
        if k % 10 == 0:
            seen = tuple(wheelset(slip=0.0, omega_radps=said, pressing_force_n=force_n) for said in said_radps)
            state, _ = watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=seen), [True, True])
            states |= {state} if time_s > died_s + 0.1 else set()
    assert states == {WheelState.DOUBTFUL, WheelState.CONTRADICTED}


def test_a_sensor_that_cuts_out_before_the_other_under_a_hard_brake_stops_no_wheelset() -> None:
    """The brake might have, as quickly as readings come; but the other sensor cuts out within a second."""
    wagon, speed_mps, found = vehicle("wagon"), 6.0, set()
    watch, radius_m, cuts_out_mps = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0], (2.8, 2.2)
    for k in range(1000):
        time_s = k / 100
        speed_mps = max(speed_mps - 0.01 * 0.8, 0.0)
        omegas_radps = [speed_mps / radius_m if speed_mps > own_mps else 0.0 for own_mps in cuts_out_mps]
        show_all(watch, time_s, speed_mps, omegas_radps, pressing_n=90e3)
        if k % 10 == 0:
            own = tuple(
                wheelset(slip=float(omega == 0.0), omega_radps=omega, pressing_force_n=90e3) for omega in omegas_radps
            )
            found |= set(watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=own), [True, True]))
    assert found <= {WheelState.ROLLING, WheelState.DOUBTFUL}


@pytest.mark.parametrize("cut_out_mps", [2.2, 2.8])
def test_wheel_speed_sensors_that_begin_late_as_the_wagon_departs_contradict_nobody(cut_out_mps: float) -> None:
    wagon, found = vehicle("wagon"), set()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(4000):
        time_s = k / 100
        speed_mps = max(0.25 * (time_s - 5.0), 0.0)
        omega_radps = speed_mps / radius_m if speed_mps > cut_out_mps else 0.0
        show_all(watch, time_s, speed_mps, (omega_radps, omega_radps), pressing_n=0.0)
        if k % 10 == 0:
            slip = float(omega_radps == 0.0 and speed_mps > 1.0)
            own = wheelset(slip=slip, omega_radps=omega_radps, pressing_force_n=0.0)
            now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, wheelsets=(own, own))
            found |= set(watch.judge(now, [True, True]))
            assert not watch.speed_is_contradicted
    assert found <= {WheelState.DOUBTFUL, WheelState.ROLLING, WheelState.UNKNOWN}


@pytest.mark.parametrize(
    ("speed_mps", "off", "rolls_s", "is_told"),
    [
        (4.5, 0.15, 11.0, True),  # as by a radius that is wrong by so much
        (4.5, 0.15, 9.0, False),
        (4.5, 0.25, 3.0, True),
        (3.5, 0.25, 30.0, False),
        (4.5, 0.10, 30.0, False),  # a worn wheel, which is calibrated
    ],
)
def test_a_wheel_speed_in_another_scale_is_told_where_the_wagon_rolls_faster_than_4_mps(
    speed_mps: float, off: float, rolls_s: float, is_told: bool
) -> None:
    wagon = vehicle("wagon")
    watch, states = WheelWatch(wagon, CONTACT_N), (WheelState.ROLLING,) * 2
    slips = (off, 0.0)
    omegas_radps = [speed_mps * (1.0 - slip) / wagon.wheel_radius_m[i] for i, slip in enumerate(slips)]
    wheelsets = [wheelset(slip=slip, omega_radps=omegas_radps[i], pressing_force_n=0.0) for i, slip in enumerate(slips)]
    for k in range(round(rolls_s * 10)):
        show_all(watch, k / 10, speed_mps, omegas_radps, pressing_n=0.0)
        now = estimate(time_s=k / 10, speed_mps=speed_mps, saturated=False, wheelsets=tuple(wheelsets))
        states = watch.judge(now, [True, True])
    assert (states[0] is WheelState.CONTRADICTED) is is_told
    assert states[1] is WheelState.ROLLING


@pytest.mark.parametrize(("share", "state"), [(0.12, WheelState.SLIDING), (0.08, WheelState.STOPPED)])
def test_a_wheelset_stands_that_turns_slower_than_a_tenth_of_the_vehicles_speed(
    share: float, state: WheelState
) -> None:
    """Its brake takes half a second to bring it there."""
    wagon = vehicle("wagon")
    watch, states = WheelWatch(wagon, CONTACT_N), (WheelState.ROLLING,) * 2
    for k in range(500):
        time_s = k / 100
        turns = (1.0 - (1.0 - share) * min(max(time_s - 2.0, 0.0) / 0.5, 1.0), 1.0)
        omegas_radps = [10.0 * own / wagon.wheel_radius_m[i] for i, own in enumerate(turns)]
        show_all(watch, time_s, 10.0, omegas_radps, pressing_n=40e3)
        if k % 10 == 0:
            own = [wheelset(slip=1.0 - turns[i], omega_radps=omegas_radps[i]) for i in range(2)]
            states = watch.judge(estimate(time_s=time_s, speed_mps=10.0, wheelsets=tuple(own)), [True, True])
    assert states == (state, WheelState.ROLLING)


def test_one_reading_of_the_vehicles_speed_that_jumps_contradicts_nobody() -> None:
    """The next one agrees with all wheelsets again."""
    wagon = vehicle("wagon")
    watch = WheelWatch(wagon, CONTACT_N)
    for k in range(100):
        omegas_radps = [20.0 / radius_m for radius_m in wagon.wheel_radius_m]
        show_all(watch, k / 10, 30.0 if k == 50 else 20.0, omegas_radps, pressing_n=0.0)
        own = [wheelset(slip=0.0, omega_radps=omega_radps, pressing_force_n=0.0) for omega_radps in omegas_radps]
        states = watch.judge(estimate(time_s=k / 10, speed_mps=20.0, saturated=False, wheelsets=tuple(own)), [True] * 2)
        assert not watch.speed_is_contradicted
        assert k in range(50, 52) or states == (WheelState.ROLLING,) * 2


def test_a_vehicle_speed_that_leaves_all_wheelsets_behind_is_contradicted_and_none_of_them_is() -> None:
    """By 25 %, of which noise makes more than a fifth of slip to one wheelset and less to the other."""
    wagon, found = vehicle("wagon"), []
    watch = WheelWatch(wagon, CONTACT_N)
    for k in range(1200):
        time_s = k / 100
        speed_mps = 20.0 if time_s < 5.0 else 25.0
        rolling_mps = (19.9, 20.1)
        omegas_radps = [own_mps / radius_m for own_mps, radius_m in zip(rolling_mps, wagon.wheel_radius_m, strict=True)]
        show_all(watch, time_s, speed_mps, omegas_radps, pressing_n=0.0)
        if k % 10 == 0:
            own = [
                wheelset(slip=1.0 - own_mps / speed_mps, omega_radps=omega_radps, pressing_force_n=0.0)
                for own_mps, omega_radps in zip(rolling_mps, omegas_radps, strict=True)
            ]
            now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, wheelsets=tuple(own))
            found += [state for state in watch.judge(now, [True, True]) if state is WheelState.CONTRADICTED]
    assert watch.speed_is_contradicted
    assert len(found) <= 1  # as long as it takes to look at the other one


def states_of_a_locked_wheelset_that_turns_again(*, slid_before: bool) -> set[WheelState]:
    """No brake says that it holds it. Within 20 s it finds back to rolling beside the other wheelset."""
    wagon, speed_mps, found = vehicle("wagon"), 20.0, set()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(4500):
        time_s = k / 100
        braked = slid_before and 3.0 <= time_s < 7.0
        slip = max(min(0.5 * (time_s - 4.0), 0.375 - 0.15 * (time_s - 4.5)), 0.0) if braked and time_s > 4.0 else 0.0
        if time_s >= 20.0:
            slip = 1.0 if time_s < 24.0 else max(0.75 - 0.75 / 20.0 * (time_s - 24.0), 0.0)
        force_n, omegas_radps = 20e3 * braked, (speed_mps * (1.0 - slip) / radius_m, speed_mps / radius_m)
        show_all(watch, time_s, speed_mps, omegas_radps, pressing_n=force_n)
        if k % 10 == 0:
            own = tuple(
                wheelset(slip=own_slip, omega_radps=omega_radps, pressing_force_n=force_n)
                for own_slip, omega_radps in zip((slip, 0.0), omegas_radps, strict=True)
            )
            now = estimate(time_s=time_s, speed_mps=speed_mps, saturated=False, wheelsets=own)
            state, _ = watch.judge(now, [True, True])
            found |= {state} if time_s > 24.1 else set()
    return found


@pytest.mark.parametrize("slid_before", [False, True], ids=["", "after a slide"])
def test_a_wheelset_that_was_locked_may_take_long_to_roll_again(slid_before: bool) -> None:
    assert states_of_a_locked_wheelset_that_turns_again(slid_before=slid_before) == {WheelState.ROLLING}


def test_a_vehicle_speed_that_is_wrong_again_is_believed_as_late_as_the_first_time() -> None:
    wagon = vehicle("wagon")
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    doubted_s = {5.0: 0.0, 25.0: 0.0}  # for how long, by when it became wrong
    for k in range(4000):
        time_s = k / 100
        is_wrong = any(0.0 <= time_s - wrong_s < 0.55 for wrong_s in doubted_s)
        show_all(watch, time_s, 30.0 if is_wrong else 20.0, (20.0 / radius_m, 20.0 / radius_m), pressing_n=0.0)
        if k % 10 == 0:
            own = wheelset(slip=0.0, omega_radps=20.0 / radius_m, pressing_force_n=0.0)
            watch.judge(estimate(time_s=time_s, speed_mps=20.0, wheelsets=(own, own)), [True, True])
            doubted_s[5.0 if time_s < 20.0 else 25.0] += 0.1 * watch.speed_is_contradicted
    assert doubted_s[25.0] == pytest.approx(doubted_s[5.0]) == pytest.approx(3.1)


@pytest.mark.parametrize(("press_n", "is_found"), [(0.0, True), (20e3, False)])
def test_a_vehicle_speed_of_another_scale_is_contradicted_where_the_wheelsets_roll_freely(
    press_n: float, *, is_found: bool
) -> None:
    """Under a brake they creep, and may slide together."""
    wagon, speed_mps, found = vehicle("wagon"), 20.0, []
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(1500):
        time_s = k / 10
        told_mps, pressing_n = (0.95 * speed_mps, press_n) if time_s >= 100.0 else (speed_mps, 0.0)
        omega_radps = speed_mps / radius_m
        show_all(watch, time_s, told_mps, (omega_radps, omega_radps), pressing_n=pressing_n)
        own = wheelset(slip=0.0, omega_radps=omega_radps, pressing_force_n=pressing_n)
        states = watch.judge(estimate(time_s=time_s, speed_mps=told_mps, wheelsets=(own, own)), [True, True])
        assert watch.speed_is_contradicted is (states == (WheelState.UNKNOWN, WheelState.UNKNOWN))
        found += [time_s] if watch.speed_is_contradicted else []
    assert bool(found) is is_found
    assert not is_found or 100.0 < found[0] < 110.0


def states_of_a_wheelset_that_falls(turns_at: Callable[[float], float]) -> list[WheelState]:
    """What is thought of it, ten a second for a minute, where it tells that share of its 20 m/s, and is braked.

    The vehicle's speed and the other wheelset go on.
    """
    wagon, speed_mps, states = vehicle("wagon"), 20.0, []
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(3000):
        time_s = k / 50
        shares = (turns_at(time_s), 1.0)
        omegas_radps = [speed_mps * share / radius_m for share in shares]
        show_all(watch, time_s, speed_mps, omegas_radps, pressing_n=20e3)
        if k % 5 == 0:
            own = tuple(
                wheelset(slip=1.0 - share, omega_radps=omega_radps, pressing_force_n=20e3)
                for share, omega_radps in zip(shares, omegas_radps, strict=True)
            )
            states.append(watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=own), [True, True])[0])
    return states


def test_a_wheel_speed_that_misses_teeth_for_a_moment_tells_of_no_slide() -> None:
    """By 40 per cent from one reading to the next, which no brake can do: it is not believed for half a minute."""
    states = states_of_a_wheelset_that_falls(lambda t: 0.6 if 10.0 <= t < 10.3 else 1.0)
    assert WheelState.SLIDING not in states
    assert set(states[:100]) == set(states[410:]) == {WheelState.ROLLING}
    assert set(states[102:400]) == {WheelState.CONTRADICTED}


def test_a_wheel_speed_that_reads_low_from_one_reading_to_the_next_is_not_believed_until_it_is_back() -> None:
    """By 13 per cent, which no brake can do, and for 45 s: a slide would look like that, but begins more slowly."""
    states = states_of_a_wheelset_that_falls(lambda t: 0.87 if 10.0 <= t < 55.0 else 1.0)
    assert set(states[:100]) == {WheelState.ROLLING}
    assert set(states[102:]) == {WheelState.CONTRADICTED}


@pytest.mark.parametrize(("follows_s", "is_believed"), [(0.0, True), (0.08, True), (0.9, True), (1.3, False)])
def test_a_wheel_speed_that_falls_with_the_vehicles_was_told_again_by_a_gateway(
    follows_s: float, is_believed: bool
) -> None:
    """All fall at once to what they are by then. Later the wagon may have slowed down, and its sensor missed teeth."""
    wagon, states = vehicle("wagon"), []
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(800):
        time_s = k / 50
        speed_mps, rolling_mps = (20.0 if time_s < fall_s else 12.0 for fall_s in (10.0 + follows_s, 10.0))
        show_all(watch, time_s, speed_mps, [rolling_mps / radius_m] * 2, pressing_n=20e3)
        if k % 5 == 0:
            slip = 1.0 - rolling_mps / speed_mps
            own = (wheelset(slip=slip, omega_radps=rolling_mps / radius_m, pressing_force_n=20e3),) * 2
            states += watch.judge(estimate(time_s=time_s, speed_mps=speed_mps, wheelsets=own), [True, True])
    assert set(states[230:]) == {WheelState.ROLLING if is_believed else WheelState.CONTRADICTED}


@pytest.mark.parametrize("fall_s", [0.4, 0.6])
def test_a_wheelset_that_its_brake_slows_down_slides(fall_s: float) -> None:
    """By 8 m/s. In 0.4 s twice the force could do that, with pads of 0.6."""
    states = states_of_a_wheelset_that_falls(lambda t: 1.0 - min(max(t - 10.0, 0.0) / fall_s, 1.0) * 0.4 * (t < 15.0))
    assert WheelState.CONTRADICTED not in states
    assert set(states[108:145]) == {WheelState.SLIDING}


@pytest.mark.parametrize("to", [0.6, 1.4])
@pytest.mark.parametrize("lasts_s", [0.015, 0.075])
def test_a_few_readings_that_are_off_contradict_nothing(to: float, lasts_s: float) -> None:
    """Spikes, up or down; a speed that is back after one has fallen as much."""
    states = states_of_a_wheelset_that_falls(lambda t: to if 10.0 <= t < 10.0 + lasts_s else 1.0)
    assert set(states) == {WheelState.ROLLING}


def speed_is_contradicted(
    name: str, rolling_mps: Sequence[float], told_mps: Sequence[float], pressing_n: float
) -> bool:
    """Whether it is within 6 s, of a wagon whose wheelsets turn so; its speed goes from one to the other value."""
    wagon, contradicted = vehicle(name), False
    watch, (from_mps, to_mps) = WheelWatch(wagon, CONTACT_N), told_mps
    omegas_radps = [own_mps / radius_m for own_mps, radius_m in zip(rolling_mps, wagon.wheel_radius_m, strict=True)]
    for k in range(600):
        speed_mps = from_mps + (to_mps - from_mps) * k / 600
        show_all(watch, k / 100, speed_mps, omegas_radps, pressing_n=pressing_n)
        if k % 10 == 0:
            own = tuple(
                wheelset(slip=1.0 - own_mps / max(speed_mps, 0.1), omega_radps=omega, pressing_force_n=pressing_n)
                for own_mps, omega in zip(rolling_mps, omegas_radps, strict=True)
            )
            now = estimate(time_s=k / 100, speed_mps=speed_mps, saturated=False, wheelsets=own)
            states = set(watch.judge(now, [True] * len(own)))
            contradicted |= watch.speed_is_contradicted
            assert not (watch.speed_is_contradicted and states != {WheelState.UNKNOWN})
    return contradicted


@pytest.mark.parametrize(
    ("told_mps", "pressing_n", "is_contradicted"),
    [
        ((20.0, 20.0), 0.0, True),
        ((20.0, 20.0), 40e3, True),
        ((20.0, 17.0), 0.0, True),
        ((20.0, 17.0), 40e3, False),
        ((0.0, 2.5), 0.0, False),
        ((0.0, 6.0), 0.0, True),
    ],
    ids=["", "braked", "slowing", "slowing as braked", "from rest, slowly", "from rest"],
)
def test_where_no_wheelset_turns_it_is_the_vehicles_speed_that_is_wrong_unless_brakes_hold_them_all(
    told_mps: tuple[float, float], pressing_n: float, is_contradicted: bool
) -> None:
    """None was seen to be stopped. Locked wheelsets retard the wagon; of one that departs sensors tell late."""
    assert speed_is_contradicted("wagon", (0.0, 0.0), told_mps, pressing_n) is is_contradicted


def test_a_vehicle_speed_that_was_wrong_from_the_beginning_stands_alone_against_several_wheelsets_alike() -> None:
    """They have not been seen to roll with it. A single one may be wrong itself, and so may one of two that differ."""
    assert speed_is_contradicted("wagon", (20.0, 20.1), (30.0, 30.0), 0.0)
    assert not speed_is_contradicted("rig", (20.0,), (30.0, 30.0), 0.0)
    assert not speed_is_contradicted("wagon", (12.0, 20.0), (30.0, 30.0), 0.0)
    assert not speed_is_contradicted("wagon", (20.0, 12.0), (30.0, 30.0), 0.0)
    assert not speed_is_contradicted("wagon", (20.0, 30.0), (30.0, 30.0), 0.0)


@pytest.mark.parametrize("acts", [True, False])
def test_a_wheelset_that_its_slide_protection_keeps_vented_slides_however_long_that_takes(acts: bool) -> None:
    """On a rail that gives hardly anything no pad presses for seconds; without any protection none slides so long."""
    wagon, states = vehicle("wagon"), set[WheelState]()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(2000):
        time_s = k / 100
        force_n = 20e3 if MOTOR_FROM_S < time_s < 6.0 else 0.0
        slip = 0.3 * min(max(time_s - SLIDES_FROM_S, 0.0), 1.0)
        omegas_radps = [20.0 * (1.0 - own) / radius_m for own in (slip, 0.0)]
        show_all(watch, time_s, 20.0, omegas_radps, pressing_n=force_n)
        if k % 10 == 0:
            is_vented = acts and time_s > SLIDES_FROM_S
            own = tuple(
                wheelset(slip=one, omega_radps=omega, pressing_force_n=force_n, wsp_active=is_vented and one > 0.0)
                for one, omega in zip((slip, 0.0), omegas_radps, strict=True)
            )
            state, _ = watch.judge(estimate(time_s=time_s, speed_mps=20.0, wheelsets=own), [True, True])
            states = {state}
    assert states == {WheelState.SLIDING if acts else WheelState.CONTRADICTED}


def test_a_unit_that_says_0_of_all_wheelsets_for_a_second_as_it_starts_contradicts_nobody() -> None:
    wagon, found = vehicle("wagon"), set[WheelState]()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(500):
        time_s, omega_radps = 1e9 + k / 100, 0.0 if k < 100 else 20.0 / radius_m
        show_all(watch, time_s, 20.0, (omega_radps, omega_radps), pressing_n=0.0)
        if k % 10 == 0:
            own = wheelset(slip=float(k < 100), omega_radps=omega_radps, pressing_force_n=0.0)
            found |= set(watch.judge(estimate(time_s=time_s, speed_mps=20.0, wheelsets=(own, own)), [True, True]))
            assert not watch.speed_is_contradicted
    assert found == {WheelState.DOUBTFUL, WheelState.ROLLING}


@pytest.mark.parametrize("set_back_s", [0.0, 60.0])
def test_what_is_remembered_does_not_grow_with_time(set_back_s: float) -> None:
    """Nor is anything remembered that is still to come, as a clock that was set back says."""
    wagon, remembered = vehicle("wagon"), list[int]()
    watch, radius_m = WheelWatch(wagon, CONTACT_N), wagon.wheel_radius_m[0]
    for k in range(2000):
        time_s = k / 10 - (set_back_s if k >= 1000 else 0.0)
        show_all(watch, time_s, 20.0, (20.0 / radius_m, 20.0 / radius_m), pressing_n=0.0)
        own = wheelset(slip=0.0, omega_radps=20.0 / radius_m, pressing_force_n=0.0)
        watch.judge(estimate(time_s=time_s, speed_mps=20.0, wheelsets=(own, own)), [True, True])
        remembered.append(len(watch._past._past))
        assert all(past_s <= time_s for past_s, *_ in watch._past._past)
    assert max(remembered) == max(remembered[:200])
