"""A pressing force is believed by what its brake does: by hand-made wagons whose brakes and sensors differ."""

from collections.abc import Callable, Collection, Sequence
from math import inf, pi, sin

import pytest

from brake_monitor.estimation.brake_work import WheelsetWork
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.force_watch import ForceWatch
from brake_monitor.monitoring.inputs.watched_force import ForceState
from brake_monitor.settings.config import EstimatorSettings, Preset, Vehicle
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

FRICTION, CONTACT_N, FULL_N = 0.35, 1000.0, 40e3
CREEP_PER_N = 2.5e-8
PULL_MPS2 = 0.8
UNMEASURED_MPS = 5.0  # by which the estimated speed is off while none is measured
BRAKE_S, RELEASE_S, END_S = 10.0, 20.0, 30.0
UNKNOWN, BORNE_OUT, CONTRADICTED = ForceState

Forces = Callable[[float], Sequence[float]]


def vehicle(name: str = "wagon") -> Vehicle:
    return example_settings(name).vehicle


def watch_of(wagon: Vehicle, preset: Preset = "wagon", sensors: Sequence[Sequence[int]] | None = None) -> ForceWatch:
    estimator = EstimatorSettings(preset=preset, friction_nominal=FRICTION, contact_force_n=CONTACT_N)
    sensors = sensors or [[i] for i in range(wagon.wheelset_count)]
    return ForceWatch(wagon, estimator, sensors, CreepMeter(CONTACT_N))


def braked(time_s: float) -> float:
    return FULL_N if BRAKE_S <= time_s < RELEASE_S else 0.0


def judged(
    said: Forces,
    real: Forces,
    wagon: Vehicle,
    *,
    gradient_mps2: float = 0.05,
    pulled_until_s: float = 0.0,
    pulled_from_s: float = inf,
    creeps: bool = True,
    slides_until_s: float = 0.0,
    train_mps2: float | None = None,
    train_is_told: bool = True,
    speed_err: float = 0.0,
    speed_errs: Callable[[float], float] = lambda _: 0.0,
    late_s: float = 0.0,
    motor_n: float = 0.0,
    unmeasured_until_s: float = 0.0,
    frozen: Collection[int] = (),
    untold_s: tuple[float, float] = (inf, inf),
    omega_noise: float = 1e-5,
    until_s: float = END_S,
    watch: ForceWatch | None = None,
) -> list[tuple[ForceState, ...]]:
    """Ten a second; sensors say `said` while brakes press with `real`; a train retards by `train_mps2` with them.

    `speed_err`: by so much of it the vehicle's speed is told too high while they press; `speed_errs`: at any time. It
    comes `late_s`.
    `motor_n`: with which each wheelset's motor brakes as well, at the rail. From the application until
    `unmeasured_until_s` no speed is measured, and what is estimated is too high. Within `untold_s` the force of the
    first wheelset is not measured: `said` is what it is held at.
    """
    is_in_train = train_mps2 is not None and train_is_told
    watch = watch or watch_of(wagon, "train" if is_in_train else "wagon")
    speed_mps, found = 25.0, []
    for k in range(round(until_s * 10)):
        time_s = k / 10
        pressing, works = said(time_s), real(time_s)
        brakes_n = sum(
            FRICTION * force_n * brake_m / wheel_m
            for force_n, brake_m, wheel_m in zip(works, wagon.brake_radius_m, wagon.wheel_radius_m, strict=True)
        )
        motors = [motor_n * (max(works) > 0.0)] * len(works)
        before_mps = speed_mps
        track_n = wagon.track_resistance_n + wagon.drag_n_per_mps2 * speed_mps**2 + sum(motors)
        if train_mps2 is None:
            pull_mps2 = PULL_MPS2 if time_s < pulled_until_s or time_s >= pulled_from_s else 0.0
            speed_mps -= 0.1 * ((brakes_n + track_n) / wagon.mass_kg + gradient_mps2 - pull_mps2)
        else:
            speed_mps -= 0.1 * train_mps2 * (max(works) > 0.0)
        wheelsets = tuple(
            wheelset(
                omega_radps=speed_mps / wheel_m * (1.0 - CREEP_PER_N * force_n * creeps),
                omega_noise=omega_noise,
                slip=CREEP_PER_N * force_n * creeps,
                pressing_force_n=said_n,
                motor_force_n=by_motor_n,
            )
            for force_n, said_n, by_motor_n, wheel_m in zip(works, pressing, motors, wagon.wheel_radius_m, strict=True)
        )
        is_measured = not BRAKE_S <= time_s < unmeasured_until_s
        err = speed_err * (max(works) > 0.0) + speed_errs(time_s)
        retardation_mps2 = 10.0 * (before_mps - speed_mps)
        told_mps = speed_mps * (1.0 + err) + late_s * retardation_mps2 + (0.0 if is_measured else UNMEASURED_MPS)
        now = estimate(
            time_s=time_s,
            speed_mps=told_mps,
            adhesion=brakes_n / wagon.mass_kg / GRAVITY_MPS2,
            deceleration_mps2=retardation_mps2 - brakes_n / wagon.mass_kg,
            saturated=time_s < slides_until_s,
            wheelsets=wheelsets,
            mass_kg=wagon.mass_kg,
        )
        measured = [not (i == 0 and untold_s[0] <= time_s < untold_s[1]) for i in range(len(wheelsets))]
        found.append(watch.judge(now, measured, frozen=frozen, speeds_are_good=is_measured))
    return found


def since_s(found: list[tuple[ForceState, ...]], wheelset_index: int, state: ForceState) -> float | None:
    """When it was first said of this wheelset."""
    return next((k / 10 for k, states in enumerate(found) if states[wheelset_index] is state), None)


@pytest.mark.parametrize("creeps", [True, False])
def test_a_sensor_that_says_nothing_of_a_brake_that_works_is_contradicted_within_3_s(creeps: bool) -> None:
    """By its wheelset's creep or, on rail so stiff that it does not creep, by the wagon's retardation."""
    found = judged(lambda t: (0.0, braked(t)), lambda t: (braked(t), braked(t)), vehicle(), creeps=creeps)
    told_s = since_s(found, 0, CONTRADICTED)
    assert told_s is not None
    assert BRAKE_S + 1.75 < told_s < BRAKE_S + 3.0  # before, means are still of free rolling as well
    assert since_s(found, 1, CONTRADICTED) is None


@pytest.mark.parametrize(
    ("force_n", "creeps", "is_told"),
    [
        (14e3, True, True),
        (10e3, True, False),  # the wheelset creeps by 2.5e-4, as in curves
        (25e3, False, True),
        (18e3, False, False),  # it takes 0.09 m/s² from the speed, as gradients do
    ],
)
def test_of_a_silent_brake_that_hardly_brakes_nothing_is_said(force_n: float, creeps: bool, is_told: bool) -> None:
    works: Forces = lambda t: (force_n * (braked(t) > 0.0),) * 2  # noqa: E731
    found = judged(lambda t: (0.0, works(t)[1]), works, vehicle(), creeps=creeps, omega_noise=1e-6)
    assert {states[0] for states in found} == ({UNKNOWN, CONTRADICTED} if is_told else {UNKNOWN})


@pytest.mark.parametrize(("train_mps2", "is_told"), [(None, True), (0.5, False)])
def test_of_a_silent_brake_whose_wheel_speeds_are_rough_the_retardation_decides(
    train_mps2: float | None, *, is_told: bool
) -> None:
    """Within a second they are as uncertain as 0.7 of what it creeps, within ten as 0.2. A train retards anyhow."""
    lies: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    found = judged(lies, lambda t: (braked(t), braked(t)), vehicle(), omega_noise=1e-3, train_mps2=train_mps2)
    assert {states[0] for states in found} == ({UNKNOWN, CONTRADICTED} if is_told else {UNKNOWN})


def test_of_a_silent_brake_beside_motors_that_take_far_more_nothing_is_said() -> None:
    """They err by a tenth of what they tell, which is a quarter of what it would take."""
    lies: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    found = judged(lies, lambda t: (braked(t), braked(t)), vehicle(), creeps=False, motor_n=12e3)
    assert {states[0] for states in found} == {UNKNOWN}


def test_of_one_silent_brake_of_four_the_retardation_says_nothing() -> None:
    """The friction of the other three is not known so well."""
    bogie = vehicle("bogie")
    force_n = 0.15 * bogie.mass_kg / FRICTION * bogie.wheel_radius_m[0] / bogie.brake_radius_m[0]
    works: Forces = lambda t: [force_n * (braked(t) > 0.0)] * 4  # noqa: E731
    found = judged(lambda t: (0.0, *works(t)[1:]), works, bogie, creeps=False)
    assert {state for states in found for state in states} == {UNKNOWN}


def test_of_two_of_four_that_press_on_nothing_is_said() -> None:
    """They are not alone: which of them retards the wagon nobody can tell."""
    stays: Forces = lambda t: (*[FULL_N if t >= BRAKE_S else 0.0] * 2, *[braked(t)] * 2)  # noqa: E731
    found = judged(stays, lambda t: [braked(t)] * 4, vehicle("bogie"), creeps=False)
    assert {state for states in found for state in states[:2]} == {UNKNOWN}


@pytest.mark.parametrize(("presses", "idle"), [(False, {0}), (True, {1})])
def test_a_brake_that_is_borne_out_is_idle_unless_it_presses(presses: bool, idle: set[int]) -> None:
    """The first one does not come, or it stays, and the second one is released."""
    forces: Forces = lambda t: (FULL_N * (presses and t >= BRAKE_S), braked(t))  # noqa: E731
    watch = watch_of(vehicle())
    found = judged(forces, forces, vehicle(), until_s=END_S if presses else RELEASE_S, watch=watch)
    assert found[-1][0] is BORNE_OUT
    assert watch.idle == idle


@pytest.mark.parametrize("works", [True, False])
def test_what_motors_take_from_the_speed_is_no_work_of_a_silent_brake(works: bool) -> None:
    said: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    real: Forces = lambda t: (braked(t) if works else 0.0, braked(t))  # noqa: E731
    found = judged(said, real, vehicle(), creeps=False, motor_n=4e3)
    assert since_s(found, 0, CONTRADICTED if works else BORNE_OUT) is not None
    assert since_s(found, 0, BORNE_OUT if works else CONTRADICTED) is None


@pytest.mark.parametrize("works", [True, False])
def test_a_speed_that_is_put_right_as_it_is_measured_again_is_no_work_of_a_silent_brake(works: bool) -> None:
    said: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    real: Forces = lambda t: (braked(t) if works else 0.0, braked(t))  # noqa: E731
    found = judged(said, real, vehicle(), creeps=works, unmeasured_until_s=BRAKE_S + 4.0)
    assert (since_s(found, 0, CONTRADICTED) is not None) is works


@pytest.mark.parametrize(("frozen", "is_told"), [(0, True), (1, False)])
def test_a_frozen_force_is_judged_and_tells_nothing_of_another(frozen: int, is_told: bool) -> None:
    found = judged(lambda t: (0.0, braked(t)), lambda t: (braked(t), braked(t)), vehicle(), frozen={frozen})
    assert (since_s(found, 0, CONTRADICTED) is not None) is is_told


@pytest.mark.parametrize("creeps", [True, False])
def test_a_brake_that_does_not_come_is_borne_out(creeps: bool) -> None:
    forces: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    found = judged(forces, forces, vehicle(), creeps=creeps)
    assert since_s(found, 0, BORNE_OUT) is not None
    assert since_s(found, 0, CONTRADICTED) is since_s(found, 1, CONTRADICTED) is None


def test_of_four_the_creep_tells() -> None:
    bogie = vehicle("bogie")
    found = judged(lambda t: (0.0, *[braked(t)] * 3), lambda t: [braked(t)] * 4, bogie)
    assert since_s(found, 0, CONTRADICTED) is not None
    assert all(since_s(found, i, CONTRADICTED) is None for i in (1, 2, 3))
    sound = judged(lambda t: (0.0, *[braked(t)] * 3), lambda t: (0.0, *[braked(t)] * 3), bogie)
    assert all(since_s(sound, i, CONTRADICTED) is None for i in range(4))


def test_a_bogie_whose_sensor_says_nothing_is_contradicted_by_what_both_its_brakes_do() -> None:
    """One cylinder and one sensor for both: what one of them takes from the speed would be lost in gradients."""
    bogie = vehicle("bogie")
    light_n = 0.09 * bogie.mass_kg / FRICTION * bogie.wheel_radius_m[0] / bogie.brake_radius_m[0]
    works: Forces = lambda t: [light_n * (braked(t) > 0.0)] * 4  # noqa: E731
    said: Forces = lambda t: (0.0, 0.0, *works(t)[2:])  # noqa: E731
    silent = judged(said, works, bogie, creeps=False)
    assert [since_s(silent, i, CONTRADICTED) is not None for i in range(4)] == [True, True, False, False]
    isolated = judged(said, said, bogie, creeps=False)
    assert [since_s(isolated, i, BORNE_OUT) is not None for i in range(4)] == [True, True, False, False]


def test_of_two_silent_brakes_of_which_one_works_the_retardation_says_nothing() -> None:
    """It cannot tell which: both would seem to work."""
    said: Forces = lambda t: (0.0, 0.0, *[braked(t)] * 2)  # noqa: E731
    silent = judged(said, lambda t: (0.0, *[braked(t)] * 3), vehicle("bogie"), creeps=False)
    assert {state for states in silent for state in states[:2]} == {UNKNOWN}


@pytest.mark.parametrize("creeps", [True, False])
def test_a_sensor_stuck_high_is_contradicted_and_a_brake_that_stays_is_not(creeps: bool) -> None:
    stays: Forces = lambda t: (FULL_N if t >= BRAKE_S else 0.0, braked(t))  # noqa: E731
    stuck = judged(stays, lambda t: (braked(t), braked(t)), vehicle(), creeps=creeps)
    told_s = since_s(stuck, 0, CONTRADICTED)
    assert told_s is not None
    assert RELEASE_S < told_s < RELEASE_S + 4.0
    drags = judged(stays, stays, vehicle(), creeps=creeps)
    assert since_s(drags, 0, CONTRADICTED) is None
    assert since_s(drags, 0, BORNE_OUT) is not None


def test_a_brake_that_stays_while_its_wagon_is_pulled_away_is_not_contradicted() -> None:
    """The pull hides what it takes from the speed."""
    stays: Forces = lambda t: (FULL_N if t >= BRAKE_S else 0.0, braked(t))  # noqa: E731
    drags = judged(stays, stays, vehicle(), creeps=False, pulled_from_s=RELEASE_S)
    assert since_s(drags, 0, CONTRADICTED) is None


def test_a_pull_that_ended_before_the_brake_was_applied_is_no_free_rolling() -> None:
    """Against it every wagon that coasts seems to brake: a sensor that is stuck high would be borne out."""
    stuck: Forces = lambda t: (FULL_N if t >= BRAKE_S else 0.0, braked(t))  # noqa: E731
    found = judged(stuck, lambda t: (braked(t), braked(t)), vehicle(), creeps=False, pulled_until_s=5.0)
    assert since_s(found, 0, BORNE_OUT) is None
    assert since_s(found, 0, CONTRADICTED) is not None


@pytest.mark.parametrize("count", [1, 2])
def test_a_force_that_dies_in_mid_brake_is_contradicted_where_the_wagon_does_not_notice(count: int) -> None:
    """Also of a single wheelset: a brake that is really released takes its retardation along."""
    wagon = example_settings("rig").vehicle if count == 1 else vehicle()
    real: Forces = lambda t: (FULL_N if t >= BRAKE_S else 0.0,) * count  # noqa: E731
    dead: Forces = lambda t: (braked(t), *real(t)[1:])  # noqa: E731
    died = judged(dead, real, wagon, creeps=False, until_s=24.0)
    told_s = since_s(died, 0, CONTRADICTED)
    assert told_s is not None
    assert told_s < RELEASE_S + 3.0
    released = judged(dead, dead, wagon, creeps=False, until_s=24.0)
    assert all(since_s(released, i, CONTRADICTED) is None for i in range(count))


@pytest.mark.parametrize("vents_s", [11.5, 12.0, 14.0, 15.0])
@pytest.mark.parametrize("fill_s", [2.0, 4.0, 6.0, 8.0])
def test_a_brake_that_is_cut_out_while_the_others_still_fill_has_not_died(vents_s: float, fill_s: float) -> None:
    """They make up for what it took: for a while the wagon retards as before, as if it had not noticed."""

    def fills(time_s: float) -> float:
        return 2.0 * FULL_N * min(max((time_s - BRAKE_S) / fill_s, 0.0), 1.0)

    cut_out: Forces = lambda t: (fills(t) if t < vents_s else 0.0, *(fills(t),) * 3)  # noqa: E731
    found = judged(cut_out, cut_out, vehicle("bogie"), creeps=False, until_s=19.0)
    assert since_s(found, 0, CONTRADICTED) is None


@pytest.mark.parametrize("said_on", [2, 4], ids=["three times a second", "as often as it is looked at"])
def test_a_brake_whose_force_came_and_went_has_not_died_as_it_is_released(said_on: int) -> None:
    """Slide protection that chops on a dry rail, of one wheelset: its brake is on for less than half of the time."""
    wagon = vehicle("rig")

    def said(time_s: float) -> Sequence[float]:
        return [braked(time_s) if round(10 * time_s) % 4 < said_on else 0.0]

    def real(time_s: float) -> Sequence[float]:
        return [0.4 * braked(time_s)]

    assert {state for (state,) in judged(said, real, wagon, creeps=False)} == {UNKNOWN}


@pytest.mark.parametrize("lags_s", [0.0, 0.1], ids=["at once", "one observation later"])
def test_a_force_that_was_lost_over_the_release_has_not_died_when_it_is_back(lags_s: float) -> None:
    """It was held meanwhile at what it said last, and says 0 as it should."""
    held: Forces = lambda t: (FULL_N if BRAKE_S <= t < RELEASE_S + 4.0 + lags_s else 0.0, braked(t))  # noqa: E731
    real: Forces = lambda t: (braked(t),) * 2  # noqa: E731
    for untold_s, is_told in (((RELEASE_S - 0.5, RELEASE_S + 4.0), False), ((inf, inf), True)):
        found = judged(held, real, vehicle(), creeps=False, untold_s=untold_s, until_s=29.0)
        assert (since_s(found, 0, CONTRADICTED) is not None) is is_told


@pytest.mark.parametrize("count", [1, 2])
def test_in_a_train_the_retardation_says_nothing_of_one_brake(count: int) -> None:
    """The others go on braking the train with a wagon whose own brake does not come, or fails meanwhile."""
    wagon = example_settings("rig").vehicle if count == 1 else vehicle()
    isolated: Forces = lambda t: (0.0, braked(t))[-count:]  # noqa: E731
    fails: Forces = lambda t: (braked(t) if t < 15.0 else 0.0, braked(t))[:count]  # noqa: E731
    for forces in (isolated, fails):
        found = judged(forces, forces, wagon, creeps=False, train_mps2=0.8)
        assert {state for states in found for state in states} == {UNKNOWN}


def test_in_a_train_the_creep_tells() -> None:
    works: Forces = lambda t: (braked(t), braked(t))  # noqa: E731
    lies: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    assert since_s(judged(lies, works, vehicle(), train_mps2=0.8), 0, CONTRADICTED) is not None
    isolated = judged(lies, lies, vehicle(), train_mps2=0.8)
    assert since_s(isolated, 0, BORNE_OUT) is not None
    assert since_s(isolated, 0, CONTRADICTED) is since_s(isolated, 1, CONTRADICTED) is None


@pytest.mark.parametrize("name", ["wagon", "bogie"])
@pytest.mark.parametrize("phase", range(8))
def test_a_speed_that_errs_by_more_than_wheelsets_creep_says_nothing_against_a_brake_that_is_cut_out(
    name: str, phase: int
) -> None:
    """That of a satellite receiver, which errs for some seconds alike: both wheelsets seem to creep alike then."""
    wagon = vehicle(name)
    isolated: Forces = lambda t: (0.0, *(braked(t) for _ in wagon.wheel_radius_m[1:]))  # noqa: E731
    errs = lambda t: 2.0 * CREEP_PER_N * FULL_N * sin(2.0 * pi * (t / 14.0 + phase / 8.0))  # noqa: E731
    found = judged(isolated, isolated, wagon, train_mps2=0.4, speed_errs=errs)
    assert since_s(found, 0, CONTRADICTED) is None


@pytest.mark.parametrize("train_mps2", [None, 0.8, 1.3])
@pytest.mark.parametrize("late_s", [0.03, 0.08])
def test_a_speed_that_comes_late_says_nothing_against_a_brake_that_is_cut_out(
    late_s: float, train_mps2: float | None
) -> None:
    """As behind a radar's filter: all four wheelsets seem to creep more under the brake, by as much as they do."""
    wagon = vehicle("bogie")
    isolated: Forces = lambda t: (0.0, *(braked(t),) * 3)  # noqa: E731
    found = judged(isolated, isolated, wagon, train_mps2=train_mps2, late_s=late_s)
    assert since_s(found, 0, CONTRADICTED) is None


@pytest.mark.parametrize("late_s", [0.0, 0.03])
def test_and_nothing_for_a_sensor_that_says_nothing_of_a_brake_that_works(late_s: float) -> None:
    wagon = vehicle("bogie")
    said: Forces = lambda t: (0.0, *(braked(t),) * 3)  # noqa: E731
    real: Forces = lambda t: (braked(t),) * 4  # noqa: E731
    assert since_s(judged(said, real, wagon, train_mps2=0.8, late_s=late_s), 0, CONTRADICTED) is not None


@pytest.mark.parametrize("works", [True, False])
def test_of_two_brakes_of_one_sensor_the_same_is_said(works: bool) -> None:
    """Though one of their wheelsets rolls on another part of its tread since the brakes came on.

    The train hardly retards: else a speed that may come late would leave it open.
    """
    wagon, braking = vehicle("bogie"), braked(BRAKE_S)
    said: Forces = lambda t: (braked(t), braked(t), 0.0, 0.0)  # noqa: E731
    by_curve_n = 0.6 * braking
    real: Forces = lambda t: tuple(  # noqa: E731
        braked(t) * share + by_curve_n * (t >= BRAKE_S) * off
        for share, off in zip((1.0, 1.0, works, works), (0.0, 0.0, 0.0, -1.0 if works else 1.0), strict=True)
    )
    watch = watch_of(wagon, "train", sensors=[[0, 1], [0, 1], [2, 3], [2, 3]])
    found = judged(said, real, wagon, train_mps2=0.02, watch=watch)
    expected = CONTRADICTED if works else BORNE_OUT
    assert {states[2:] for states in found} == {(UNKNOWN, UNKNOWN), (expected, expected)}


def test_a_train_that_is_not_told_of_is_not_taken_for_a_brake_while_creep_is_in_doubt() -> None:
    """It retards a wagon one of whose brakes is cut out as if all braked; a pull upsets the vehicle's speed as well."""
    isolated: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    told = judged(
        isolated, isolated, vehicle(), train_mps2=0.8, train_is_told=False, speed_err=0.9 * CREEP_PER_N * FULL_N
    )
    assert since_s(told, 0, CONTRADICTED) is None


def test_nothing_is_said_while_something_slides() -> None:
    lies: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    found = judged(lies, lambda t: (braked(t), braked(t)), vehicle(), slides_until_s=END_S)
    assert {state for states in found for state in states} == {UNKNOWN}


def test_nor_until_three_seconds_after_it_has_slid() -> None:
    lies: Forces = lambda t: (0.0, braked(t))  # noqa: E731
    found = judged(lies, lambda t: (braked(t), braked(t)), vehicle(), slides_until_s=13.0)
    told_s = since_s(found, 0, CONTRADICTED)
    assert told_s is not None
    assert 15.85 < told_s < 17.0


def test_what_a_sensor_says_later_is_judged_anew() -> None:
    said: Forces = lambda t: (0.0 if t < 15.0 else braked(t), braked(t))  # noqa: E731
    found = judged(said, lambda t: (braked(t), braked(t)), vehicle())
    assert found[149][0] is CONTRADICTED
    assert found[151][0] is UNKNOWN


PROTECTED = WheelsetWork(wsp_actions=2)


@pytest.mark.parametrize(("said_n", "slides"), [(0.0, 1), (FULL_N, 3)], ids=["dead", "frozen"])
def test_a_force_that_stands_still_while_its_wheelset_slides_time_and_again_is_contradicted(
    said_n: float, slides: int
) -> None:
    """A brake at the limit of the rail may stay as it is for once; one that is said to be off stops no wheelset."""
    watch, found = watch_of(vehicle()), []
    for count in (0, slides - 1, slides):
        for force_n in (1.1 * FULL_N, said_n):
            own = wheelset(pressing_force_n=force_n, renewed_slides=count if force_n == said_n else 0)
            now = estimate(time_s=float(len(found)), wheelsets=(own, wheelset(work=PROTECTED)))
            found.append(watch.judge(now, [True, True], speeds_are_good=True))
    assert [states[0] for states in found] == [*[UNKNOWN] * 5, CONTRADICTED]
    moved = (wheelset(pressing_force_n=1.02 * said_n + 10.0), wheelset())
    assert watch.judge(estimate(time_s=9.0, wheelsets=moved), [True, True], speeds_are_good=True)[0] is UNKNOWN


def test_a_steady_brake_without_slide_protection_may_slide_time_and_again() -> None:
    """On a rail that is slippery in places."""
    watch = watch_of(vehicle())
    for count in range(6):
        own = wheelset(pressing_force_n=FULL_N, renewed_slides=count)
        now = estimate(time_s=float(count), wheelsets=(own, wheelset()))
        assert watch.judge(now, [True, True], speeds_are_good=True) == (UNKNOWN, UNKNOWN)


def slides_anew(watch: ForceWatch, said_n: float, wsp_actions: int, from_s: float) -> list[ForceState]:
    """What is said of the first wheelset, which slides anew each second."""
    found = []
    for count in range(6):
        work = WheelsetWork(wsp_actions=wsp_actions)
        own = wheelset(pressing_force_n=said_n, renewed_slides=count, work=work)
        now = estimate(time_s=from_s + count, wheelsets=(own, wheelset()))
        found.append(watch.judge(now, [True, True], speeds_are_good=True)[0])
    return found


@pytest.mark.parametrize("passed_s", [10.0, 70.0])
def test_a_brake_that_sticks_and_drags_its_wheelset_along_is_no_sensor_that_failed(passed_s: float) -> None:
    """Its sensor has not said for more than a minute that it presses."""
    watch = watch_of(vehicle())
    pressed = (wheelset(pressing_force_n=FULL_N), wheelset())
    watch.judge(estimate(time_s=0.0, wheelsets=pressed), [True, True], speeds_are_good=True)
    expected = CONTRADICTED if passed_s < 60.0 - 6.0 else UNKNOWN
    assert slides_anew(watch, 0.0, 2, passed_s)[-1] is expected


@pytest.mark.parametrize("said_n", [0.0, FULL_N])
@pytest.mark.parametrize(("wsp_actions", "expected"), [(1, UNKNOWN), (2, CONTRADICTED)])
def test_what_may_be_the_drivers_release_is_no_slide_protection(
    said_n: float, wsp_actions: int, expected: ForceState
) -> None:
    watch = watch_of(vehicle())
    pressed = (wheelset(pressing_force_n=FULL_N + 10.0), wheelset())
    watch.judge(estimate(time_s=0.0, wheelsets=pressed), [True, True], speeds_are_good=True)
    assert slides_anew(watch, said_n, wsp_actions, 5.0)[-1] is expected


@pytest.mark.parametrize("has_come_on", [False, True])
def test_a_brake_that_has_not_come_on_with_the_other_may_press_though_wheelsets_slide(has_come_on: bool) -> None:
    """One that has may be vented by its slide protection, and says so rightly."""
    watch = watch_of(vehicle())
    may_press_unseen = {}
    for k in range(round(RELEASE_S * 10)):
        time_s = k / 10
        own_n = braked(time_s) if has_come_on and time_s < BRAKE_S + 0.5 else 0.0
        wheelsets = (wheelset(pressing_force_n=own_n), wheelset(pressing_force_n=braked(time_s)))
        now = estimate(time_s=time_s, speed_mps=20.0, saturated=time_s >= BRAKE_S, wheelsets=wheelsets)
        watch.judge(now, [True, True], speeds_are_good=True)
        may_press_unseen[time_s] = watch.may_press_unseen
    assert may_press_unseen[BRAKE_S + 2.0] is not has_come_on
    assert not may_press_unseen[BRAKE_S - 1.0]
    assert not may_press_unseen[RELEASE_S - 1.0]


def test_a_brake_that_is_released_while_the_other_takes_over_has_no_dead_sensor() -> None:
    """The wagon does not notice, and that is right."""
    forces: Forces = lambda t: (braked(t), braked(t) if t < RELEASE_S else 2.0 * FULL_N)  # noqa: E731
    found = judged(forces, forces, vehicle(), creeps=False)
    assert since_s(found, 0, CONTRADICTED) is since_s(found, 1, CONTRADICTED) is None


def test_a_brake_that_came_on_in_the_application_before_may_press_unseen_in_this_one() -> None:
    watch = watch_of(vehicle())
    for k in range(520):
        time_s = k / 10
        again = time_s >= 50.0
        forces_n = (braked(time_s), FULL_N if again else braked(time_s))
        wheelsets = tuple(wheelset(pressing_force_n=force_n) for force_n in forces_n)
        now = estimate(time_s=time_s, speed_mps=20.0, saturated=again, wheelsets=wheelsets)
        watch.judge(now, [True, True], speeds_are_good=True)
    assert watch.may_press_unseen


def test_brakes_that_come_on_one_after_the_other_are_not_suspected_of_pressing_unseen() -> None:
    """As by a distributor at one end: until all others press it is too early to suspect one that does not."""
    wagon = vehicle("bogie")
    watch = watch_of(wagon)
    for k in range(round(RELEASE_S * 10)):
        time_s = k / 10
        forces_n = [braked(time_s) if time_s >= BRAKE_S + 0.5 * i else 0.0 for i in range(4)]
        wheelsets = tuple(wheelset(pressing_force_n=force_n) for force_n in forces_n)
        now = estimate(time_s=time_s, speed_mps=20.0, saturated=False, wheelsets=wheelsets)
        watch.judge(now, [True] * 4, speeds_are_good=True)
        only_the_last_is_silent = BRAKE_S + 1.0 <= time_s < BRAKE_S + 1.5
        assert watch.may_press_unseen is only_the_last_is_silent, time_s


@pytest.mark.parametrize(("share_of_friction", "works"), [(1.0, True), (0.75, True), (1.0, False), (1.25, False)])
def test_a_silent_brake_of_many_is_in_doubt_while_the_wagon_may_retard_by_it(
    share_of_friction: float, *, works: bool
) -> None:
    """Four brakes, of which creep tells nothing; what they make of their forces shows in an application before."""

    def braked_twice(time_s: float) -> float:
        return FULL_N * (10.0 <= time_s < 20.0 or 40.0 <= time_s < 50.0)

    def said(time_s: float) -> Sequence[float]:
        return (braked_twice(time_s) * (time_s < 30.0), *(braked_twice(time_s),) * 3)

    def real(time_s: float) -> Sequence[float]:
        first = 1.0 if works or time_s < 30.0 else 0.0
        return [share * share_of_friction * braked_twice(time_s) for share in (first, 1.0, 1.0, 1.0)]

    wagon = vehicle("bogie")
    watch = watch_of(wagon)
    found = judged(said, real, wagon, creeps=False, until_s=49.0, watch=watch)
    assert watch.may_press_unseen is works
    assert {states[0] for states in found} == {UNKNOWN}


def test_brakes_that_did_nothing_before_are_no_measure_of_what_they_do() -> None:
    """All of them read as pressing, and the wagon rolled on: of two that is their sensors, or their gear."""

    def said(time_s: float) -> Sequence[float]:
        presses = 10.0 <= time_s < 20.0 or 40.0 <= time_s < 50.0
        return (FULL_N * presses * (time_s < 30.0), FULL_N * presses)

    def real(time_s: float) -> Sequence[float]:
        return (0.0, 0.0) if time_s < 30.0 else (braked(time_s - 30.0),) * 2

    found = judged(said, real, vehicle(), gradient_mps2=0.0, creeps=False, until_s=49.0)
    assert found[-1][0] is CONTRADICTED
