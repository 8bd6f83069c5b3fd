"""What is due of a truth written down by hand: where an alarm must come, where it may, and where it must not."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from math import inf, nan
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.due import brakes, friction, pads, rail, sensors
from brake_monitor.simulator.due.alarm import DELAY_S, Due
from brake_monitor.simulator.due.applications import Application, brake_applications
from brake_monitor.simulator.due.truth import STEP_S, Truth, spans
from brake_monitor.simulator.physics.pad import AMBIENT_C, NOMINAL_FRICTION, steady_friction
from brake_monitor.simulator.physics.pneumatics import BrakeGear
from brake_monitor.simulator.plant import GRAVITY_MPS2, Modifiers
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.trace import WHEELSET_COLUMNS

Over = Callable[[float], float]
END_S = 100.0
RADIUS_M = 0.46
GEAR = BrakeGear(15e3, -3e3)
FORCE_N, FORCE_BAR = 30e3, 2.2


def truth(
    n: int = 2,
    *,
    speed: Over = lambda t: 20.0,
    supplied: Over = lambda t: True,
    adhesion: Over = lambda t: 0.05,
    faults: tuple[SensorFault, ...] = (),
    gradient: float = 0.0,
    **first: Over,
) -> Truth:
    """A wagon that rolls freely but for what is given: columns of the first wheelset, or of `all_` of them."""
    time_s = np.arange(round(END_S / STEP_S) + 1) * STEP_S

    def over(of_time: Over, kind: type = float) -> np.ndarray[Any, Any]:
        return np.array([of_time(t) for t in time_s.tolist()], dtype=kind)

    speed_mps = over(speed)
    wheels = {name: np.zeros((n, len(time_s))) for name in WHEELSET_COLUMNS}
    wheels["omega_radps"][:] = speed_mps / RADIUS_M
    for name, of_time in first.items():
        wheels[name.removeprefix("all_")][slice(n if name.startswith("all_") else 1)] = over(of_time)
    settings = example_settings("wagon")
    recording: Any = SimpleNamespace(settings=settings, modifiers=Modifiers(sensor_faults=faults), gears=(GEAR,) * n)
    radius_m = np.full((n, 1), RADIUS_M)
    gradients = np.full_like(time_s, gradient)
    return Truth(recording, time_s, speed_mps, over(supplied, bool), over(adhesion), gradients, radius_m, wheels)


def must(found: Iterable[Due]) -> list[tuple[str, int | None, float]]:
    """What must come: its kind, its wheelset and when it qualifies, from the start."""
    return [
        (due.kind, due.wheelset, round(due.by_s - DELAY_S[due.kind] - EPOCH_S, 2))
        for due in found
        if due.by_s is not None
    ]


def between(begin_s: float, end_s: float, inside: float, outside: float = 0.0) -> Over:
    return lambda t: inside if begin_s <= t < end_s else outside


def test_runs_of_rows_are_bridged_where_gaps_are_short_and_left_out_where_they_are() -> None:
    flags = np.array([0, 1, 1, 0, 0, 1, 1, 1, 0, 0, 0, 1, 0], dtype=bool)
    assert list(spans(flags)) == [(1, 2), (5, 7), (11, 11)]
    assert list(spans(flags, gap_s=2.5 * STEP_S)) == [(1, 7), (11, 11)]
    assert list(spans(flags, least_s=2.5 * STEP_S)) == [(5, 7)]


# -- brakes --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("force_n", "until_s", "omega", "expected"),
    [
        (5e3, 60.0, None, [("dragging_brake", 1, 20.0)]),
        (5e3, 60.0, lambda t: 0.0, [("dragging_brake", 1, 20.0)]),
        (5e3, 60.0, between(0.0, 30.0, 40.0), []),  # it turns for a while, and then no more
        (5e3, 60.0, between(45.0, 60.0, 40.0), [("dragging_brake", 1, 20.0)]),  # it stood for long enough before
        (5e3, 45.0, None, []),  # for less than an alarm may take
        (3e3, 60.0, None, []),
    ],
)
def test_a_brake_drags_that_presses_for_long_after_the_release(
    force_n: float, until_s: float, omega: Over | None, expected: list[tuple[str, int | None, float]]
) -> None:
    wheel = {"omega_radps": omega} if omega else {}
    released = truth(supplied=lambda t: t < 20.0, pressing_force_n=between(20.0, until_s, force_n), **wheel)
    found = list(brakes.dragging_brake(released))
    assert must(found) == expected
    assert [due.wheelset for due in found] == [1]  # it may come in any case


def test_a_brake_that_presses_while_the_wagon_stands_or_the_driver_brakes_does_not_drag() -> None:
    presses = {"pressing_force_n": lambda t: 5e3}
    assert list(brakes.dragging_brake(truth(**presses))) == []
    assert list(brakes.dragging_brake(truth(supplied=lambda t: False, speed=lambda t: 2.0, **presses))) == []


@pytest.mark.parametrize(
    ("n", "own_n", "expected"),
    [
        (2, lambda t: 0.0, [("brake_not_applied", 1, 10.0)]),
        (2, between(0.0, 40.0, 30e3), []),  # as well may the other one drag
        (4, between(0.0, 40.0, 30e3), [("brake_not_applied", 1, 40.0)]),
        (2, between(14.0, 60.0, 30e3), []),  # not for long
        (2, lambda t: 5e3, []),  # it presses, if but weakly
    ],
)
def test_a_brake_is_not_applied_that_does_not_press_beside_half_of_all(
    n: int, own_n: Over, expected: list[tuple[str, int | None, float]]
) -> None:
    def others_n(t: float) -> float:
        return 30e3 if 10.0 <= t < 60.0 else 0.0

    shown = truth(
        n,
        supplied=between(10.0, 60.0, True, False),
        all_pressing_force_n=others_n,
        pressing_force_n=lambda t: min(own_n(t), others_n(t)),
    )
    assert must(brakes.brake_not_applied(shown)) == expected


def test_no_brake_is_amiss_that_a_motor_or_slide_protection_holds_off() -> None:
    held_off = {"all_pressing_force_n": lambda t: 30e3, "pressing_force_n": lambda t: 0.0}
    assert must(brakes.brake_not_applied(truth(**held_off)))
    assert list(brakes.brake_not_applied(truth(**held_off, motor_torque_nm=lambda t: -500.0))) == []
    assert list(brakes.brake_not_applied(truth(**held_off, all_wsp=lambda t: 1.0))) == []


def test_discs_are_hot_beyond_what_their_heat_is_known_to() -> None:
    """400 °C, and a tenth of what that is above 15 °C more or less."""
    warming = truth(disc_temperature_c=lambda t: 350.0 + 2.0 * t)
    (due,) = brakes.hot_disc(warming)
    assert due.from_s - EPOCH_S == pytest.approx((400.0 - 38.5 - 350.0) / 2.0, abs=0.02)
    ((kind, wheelset, qualified_s),) = must([due])
    assert (kind, wheelset) == ("hot_disc", 1)
    assert qualified_s == pytest.approx((400.0 + 38.5 - 350.0) / 2.0, abs=0.02)
    assert list(brakes.hot_disc(truth(disc_temperature_c=lambda t: 350.0))) == []


# -- rail ----------------------------------------------------------------------------------------------------------


def test_a_slide_is_due_once_it_is_clearly_twenty_metres_across_the_rail() -> None:
    """0.1 of 20 m/s are 2 m/s: 26 m, 20 and three tenths more, after 13 s."""
    assert must(rail.slide(truth(slip=between(10.0, 60.0, 0.1)))) == [("slide", 1, 23.0)]
    (short,) = rail.slide(truth(slip=between(10.0, 22.0, 0.1)))
    assert short.by_s is None
    assert list(rail.slide(truth(slip=between(10.0, 60.0, 0.04)))) == []
    assert list(rail.slide(truth(speed=lambda t: 1.0, slip=between(10.0, 60.0, 0.1)))) == []


@pytest.mark.parametrize(
    ("speed_mps", "stands", "expected"),
    [
        (20.0, between(10.0, 60.0, True, False), [("wheelset_not_rotating", 1, 10.0)]),
        (20.0, between(0.0, 60.0, True, False), [("wheelset_not_rotating", 1, 4.01)]),  # once settled
        (20.0, between(10.0, 12.5, True, False), []),
        (2.0, between(10.0, 60.0, True, False), []),
    ],
)
def test_a_wheelset_does_not_turn(
    speed_mps: float, stands: Over, expected: list[tuple[str, int | None, float]]
) -> None:
    def omega(t: float) -> float:
        return (0.02 if stands(t) else 1.0) * speed_mps / RADIUS_M

    assert must(rail.wheelset_not_rotating(truth(speed=lambda t: speed_mps, omega_radps=omega))) == expected


def low_adhesion(**given: Over) -> list[tuple[str, int | None, float]]:
    return must(rail.low_adhesion(truth(past_peak=between(10.0, 60.0, 1.0), **given)))


def test_the_rail_gives_too_little_for_half_a_second_while_more_is_asked_for() -> None:
    assert low_adhesion() == [("low_adhesion", None, 10.5)]
    assert low_adhesion(adhesion=lambda t: 0.12 if t % 0.4 < 0.05 else 0.05) == []
    assert low_adhesion(adhesion=lambda t: 0.05 if t >= 30.0 else 0.095) == [("low_adhesion", None, 30.5)]
    assert low_adhesion(supplied=lambda t: False) == []
    assert low_adhesion(speed=lambda t: 2.0) == []
    assert must(rail.low_adhesion(truth())) == []


# -- sensors -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("quantity", "failure", "braked_from_s", "expected"),
    [
        ("pressing_force", SensorFailure.LOST, 50.0, [("input_lost", 2, 20.0)]),
        ("pressing_force", SensorFailure.ERROR_CODE, 50.0, [("input_implausible", 2, 20.0)]),
        ("pressing_force", SensorFailure.FROZEN, 50.0, [("input_implausible", 2, 50.0)]),
        ("pressing_force", SensorFailure.FROZEN, 10.0, [("input_implausible", 2, 20.0)]),
        ("pressing_force", SensorFailure.FROZEN, inf, []),
        ("axle_speed", SensorFailure.FROZEN, 50.0, [("input_implausible", 2, 20.0)]),
        ("axle_speed", SensorFailure.BIASED, 50.0, []),
        ("speed", SensorFailure.LOST, 50.0, [("input_lost", None, 20.0)]),
    ],
)
def test_what_a_sensor_says_wrongly_is_due_once_it_can_be_seen(
    quantity: str, failure: SensorFailure, braked_from_s: float, expected: list[tuple[str, int | None, float]]
) -> None:
    fault = SensorFault(quantity, 0 if quantity == "speed" else 1, failure, 20.0, 90.0)
    assert must(sensors.failed_sensors(truth(supplied=lambda t: t >= braked_from_s, faults=(fault,)))) == expected


@pytest.mark.parametrize(("flags", "wheelset"), [(1, None), (2, 2)])
def test_one_flag_of_slide_protection_for_all_is_no_wheelsets_own(flags: int, wheelset: int | None) -> None:
    fault = SensorFault("wsp_active", 1, SensorFailure.LOST, 20.0, 90.0)
    shown = truth(faults=(fault,))
    signals = shown.recording.settings.signals
    told = structs.replace(signals, wsp_active=(signals.wsp_active[0],) * flags)
    shown.recording.settings = structs.replace(shown.recording.settings, signals=told)
    assert must(sensors.failed_sensors(shown)) == [("input_lost", wheelset, 20.0)]


def test_a_force_that_says_the_wrong_thing_beside_no_other_is_never_seen_and_nothing_before_it_settles() -> None:
    fault = SensorFault("pressing_force", 0, SensorFailure.FROZEN, 1.0, 90.0)
    assert must(sensors.failed_sensors(truth(1, faults=(fault,)))) == []
    assert must(sensors.failed_sensors(truth(2, faults=(fault,)))) == [("input_implausible", 1, 4.0)]


# -- brake applications --------------------------------------------------------------------------------------------


def applied(
    friction: float = 1.0, until_s: float = 60.0, speed: Over = lambda t: 20.0, **given: Any
) -> list[Application]:
    """From 20 s on, by all brakes alike; the first wheelset's cold pads have that friction over that of sound ones."""
    settings = example_settings("wagon")
    brake_m = settings.vehicle.brake_radius_m[0]

    def sound_nm(t: float) -> float:
        sliding_mps = speed(t) / RADIUS_M * brake_m
        return steady_friction(sliding_mps, FORCE_N / GEAR.full_force_n, AMBIENT_C) * FORCE_N * brake_m

    during = between(20.0, until_s, 1.0)
    shown = {
        "supplied": during,
        "all_pressing_force_n": lambda t: FORCE_N * during(t),
        "all_pressure_bar": lambda t: FORCE_BAR * during(t),
        "all_brake_torque_nm": lambda t: sound_nm(t) * during(t),
        "brake_torque_nm": lambda t: friction * sound_nm(t) * during(t),
        "all_disc_temperature_c": lambda t: 80.0 + t,
    }
    return brake_applications(truth(speed=speed, **{**shown, **given}))


def test_an_application_tells_friction_over_that_of_sound_pads() -> None:
    (one,) = applied(0.7)
    assert one.start_s == pytest.approx(20.0, abs=0.02)
    assert one.end_s == pytest.approx(60.0, abs=0.02)
    assert one.told_s == (one.start_s, one.end_s + 15.0)
    assert one.effect == pytest.approx([0.7, 1.0], abs=1e-3)
    assert one.torque_nm[0] / one.torque_nm[1] == pytest.approx(0.7, abs=1e-3)
    assert one.of_nominal[0] / one.of_nominal[1] == pytest.approx(0.7, abs=1e-3)
    assert one.of_nominal[1] == pytest.approx(one.torque_nm[1] / (NOMINAL_FRICTION * FORCE_N * 0.247), rel=1e-3)
    assert one.pressed.all()
    assert one.hottest_c == pytest.approx(140.0, abs=0.1)


def test_a_light_application_and_one_that_slides_nearly_always_tell_nothing() -> None:
    """30 kN with 0.247 m and 20 m/s at the rim give some 110 kW: 300 kJ within three seconds."""
    assert len(applied(until_s=24.0)) == 1
    assert applied(until_s=22.0) == []
    assert len(applied(all_past_peak=between(22.5, 60.0, 1.0))) == 1
    assert applied(all_past_peak=between(21.5, 60.0, 1.0)) == []
    assert applied(all_motor_torque_nm=lambda t: -500.0) == []


def test_what_slides_and_what_a_brake_does_not_press_does_not_count() -> None:
    (one,) = applied(0.5, past_peak=between(30.0, 60.0, 1.0), all_brake_torque_nm=between(30.0, 60.0, 9e3))
    assert one.effect == pytest.approx([0.5, 0.0], abs=1e-3)  # all of the second one's torque fell into the slide
    (late,) = applied(pressing_force_n=between(30.0, 60.0, FORCE_N))
    assert late.pressed.tolist() == [False, True]


def test_friction_is_as_doubtful_as_a_gradient_that_may_have_changed_until_the_wagon_rolls_on() -> None:
    """0.2 m/s² beside the 0.05 g that it brakes with."""
    (rolls_on,) = applied()
    assert rolls_on.gradient_doubt == 0.0
    (stops,) = applied(speed=lambda t: max(20.0 - max(t - 20.0, 0.0) / 2.0, 0.6) if t < 60.0 else 0.0)
    assert stops.gradient_doubt == pytest.approx(0.2 / (0.05 * GRAVITY_MPS2))
    (steep,) = applied(gradient=-0.031)
    assert steep.gradient_doubt == inf


def application(k: int = 0, torque: tuple[float, float] = (10e3, 10e3), effect: float = 1.0) -> Application:
    """The k-th one, of two wheelsets, the first of which has that friction."""
    return Application(
        start_s=k + 1.0,
        end_s=k + 2.0,
        torque_nm=np.array(torque),
        pressed=np.array([True, True]),
        effect=np.array([effect, 1.0]),
        of_nominal=np.array([effect, 1.0]),
        hottest_c=100.0,
        gradient_doubt=0.0,
    )


@pytest.mark.parametrize(
    ("own_nm", "weak", "may"),
    [(7.0e3, [1], [1, 2]), (7.6e3, [], [1, 2]), (8.7e3, [], [2]), (9.0e3, [], []), (14e3, [2], [1, 2])],
)
def test_the_weak_one_of_two_is_due(own_nm: float, weak: list[int], may: list[int]) -> None:
    """By 26 % of the other's torque; what is within 14 % is even. The other's of the weak one's is more than that."""
    found = list(friction.uneven_braking(truth(), [application(torque=(own_nm, 10e3))]))
    assert [wheelset for _, wheelset, _ in must(found)] == weak
    assert [due.wheelset for due in found] == may


def test_one_that_does_not_press_is_not_uneven_and_alone_none_is() -> None:
    idle = replace(application(torque=(5e3, 10e3)), pressed=np.array([False, True]))
    assert must(friction.uneven_braking(truth(), [idle])) == []
    assert list(friction.uneven_braking(truth(1), [application(torque=(5e3, 10e3))])) == []


@pytest.mark.parametrize(
    ("effect", "nominal", "doubt", "is_due"),
    [
        (0.7, 0.7, 0.0, True),
        (1.3, 1.3, 0.0, True),
        (0.7, 0.7, inf, False),
        (0.82, 0.7, 0.0, False),  # within the margin
        (0.8, 0.7, 0.0, False),  # what mass and force are known to, beside sound friction
        (0.7, 0.8, 0.0, False),  # ... and beside nominal one
        (nan, nan, 0.0, False),
    ],
)
def test_friction_is_out_of_its_band_beyond_doubt(effect: float, nominal: float, doubt: float, is_due: bool) -> None:
    one = replace(application(effect=effect), of_nominal=np.array([nominal, 1.0]), gradient_doubt=doubt)
    found = must(friction.friction_out_of_band(truth(), [one]))
    assert found == ([("friction_out_of_band", 1, 2.0)] if is_due else [])


def test_gradients_that_differ_show_friction_over_several_applications_and_one_that_is_sound_ends_it() -> None:
    """0.3 off beside 0.15 and 0.1 leaves room for a doubt of 0.11, which 0.25 of 0.7 is over three of them."""
    weak = [replace(application(k, effect=0.7), gradient_doubt=0.25) for k in range(6)]
    assert must(friction.friction_out_of_band(truth(), weak))[0] == ("friction_out_of_band", 1, 4.0)
    sound = [*weak[:2], application(2), *weak[3:]]
    assert must(friction.friction_out_of_band(truth(), sound))[0] == ("friction_out_of_band", 1, 7.0)
    once = [application(k, effect=effect) for k, effect in enumerate((0.3, 1.0, 0.8))]
    assert must(friction.friction_out_of_band(truth(), once)) == [("friction_out_of_band", 1, 2.0)]


def drifting(change: float, count: int, hottest_c: float = 100.0) -> list[tuple[str, int | None, float]]:
    """Friction that changes by so much over so many applications."""
    effects = np.linspace(1.0, 1.0 + change, count)
    stops = [replace(application(k, effect=float(e)), hottest_c=hottest_c) for k, e in enumerate(effects)]
    return must(friction.friction_drift(truth(), stops))


def test_friction_drifts_over_ten_applications_or_twenty_unless_they_are_hot() -> None:
    assert drifting(-0.25, 9) == []
    assert drifting(-0.25, 10) == [("friction_drift", 1, 11.0)]
    assert drifting(0.25, 10) == [("friction_drift", 1, 11.0)]
    assert drifting(-0.17, 20) == []
    assert drifting(-0.25, 20)[-1] == ("friction_drift", 1, 21.0)
    assert drifting(-0.25, 60) == []  # a third of it over twenty
    assert drifting(-0.25, 10, hottest_c=350.0) == []


# -- pads ----------------------------------------------------------------------------------------------------------


def test_pads_are_worn_by_the_energy_they_took_as_well_as_that_is_known() -> None:
    """They reach their limit after 60 s by the configured wear, and 3 mm above it sooner; a fifth of it is in doubt."""
    wear = example_settings("wagon").wear
    to_wear_mm = wear.new_pad_thickness_mm - wear.pad_limit_mm
    lost_cm3 = to_wear_mm / 10.0 * wear.pad_area_cm2 * wear.pads_per_wheelset
    power_w = lost_cm3 / wear.specific_wear_cm3_per_mj * 1e6 / 60.0
    wearing = truth(brake_torque_nm=lambda t: power_w / 20.0 * RADIUS_M)
    near, at_limit = pads.worn_pads(wearing, [])
    near_s = 60.0 * (to_wear_mm - 3.0) / to_wear_mm
    assert near.from_s - EPOCH_S == pytest.approx(near_s / 1.2, abs=0.02)
    assert at_limit.from_s - EPOCH_S == pytest.approx(60.0 / 1.2, abs=0.02)
    for due, kind, reached_s in ((near, "pad_near_limit", near_s), (at_limit, "pad_at_limit", 60.0)):
        ((*what, qualified_s),) = must([due])
        assert what == [kind, 1]
        assert qualified_s == pytest.approx(reached_s / 0.8, abs=0.02)
    ends = [replace(application(), end_s=end_s) for end_s in (70.0, 80.0, 90.0)]
    assert [told_s for *_, told_s in must(pads.worn_pads(wearing, ends))] == [70.0, 80.0]
    assert list(pads.worn_pads(truth(), [])) == []
