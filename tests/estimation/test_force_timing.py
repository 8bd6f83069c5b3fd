"""Whether pressing force and wheel speed are told of the same moment, on wheelsets that obey (6) of the paper."""

from math import inf, isnan, nan

import numpy as np
import pytest
from numpy.typing import NDArray

from brake_monitor.estimation.doubts.force_timing import LAGS, ForceTiming

Floats = NDArray[np.float64]
INERTIA_KGM2, WHEEL_RADIUS_M, BRAKE_RADIUS_M = 120.0, 0.46, 0.25
WHEEL_LOAD_N, FRICTION = 100e3, 0.35
WHEEL_SPEED_STD_RADPS = 0.02
STEP_S = 0.001


def cycling_force_n(times_s: Floats, period_s: float) -> Floats:
    """Slide protection vents a brake within tenths of a second and fills it again."""
    force_n, valve_open = 40e3, False
    told = np.empty(len(times_s))
    for k, time_s in enumerate(times_s):
        valve_open = time_s % period_s < 0.3 * period_s
        force_n += ((0.0 if valve_open else 50e3) - force_n) * STEP_S / (0.1 if valve_open else 0.4)
        told[k] = force_n
    return told


def wheel_speeds_radps(force_n: Floats, adhesion: Floats) -> Floats:
    """(6) integrated: J dω/dt = r mu_w N - r_b mu_b F."""
    torque_nm = WHEEL_RADIUS_M * adhesion * WHEEL_LOAD_N - BRAKE_RADIUS_M * FRICTION * force_n
    spins: Floats = 60.0 + np.cumsum(torque_nm / INERTIA_KGM2) * STEP_S
    return spins


def lag_found_s(
    lag_s: float,
    *,
    period_s: float = 1.3,
    seconds: float = 8.0,
    spacing_s: float = 0.02,
    lost: float = 0.0,
    rolls: bool = False,
    slides_s: float = inf,
    wandering: float = 0.0,
    speed_std_radps: float = WHEEL_SPEED_STD_RADPS,
) -> float:
    """What is found of a force told late by so much; NaN where it says that it knows nothing.

    `slides_s`: how long the wheelset slides in each period.
    """
    rng = np.random.default_rng(3)
    times_s = np.arange(0.0, seconds, STEP_S)
    force_n = cycling_force_n(times_s, period_s)
    mean_n = BRAKE_RADIUS_M * FRICTION * force_n.mean() / (WHEEL_RADIUS_M * WHEEL_LOAD_N)
    adhesion = mean_n + wandering * np.cumsum(rng.normal(size=len(times_s))) * STEP_S**0.5
    omega_radps = wheel_speeds_radps(force_n, adhesion)
    timing, late = ForceTiming(), max(round(lag_s / STEP_S), 0)
    early = max(round(-lag_s / STEP_S), 0)
    told_n = np.concatenate((np.full(late, force_n[0]), force_n[: len(force_n) - late]))
    told_radps = np.concatenate((np.full(early, omega_radps[0]), omega_radps[: len(force_n) - early]))
    every = round(spacing_s / STEP_S)
    for k in range(every, len(times_s), every):
        timing.press(float(told_n[k - every : k].sum()) * STEP_S)
        if rng.random() >= lost:
            noisy_radps = told_radps[k] + rng.normal() * speed_std_radps
            slides = not rolls and times_s[k] % period_s < slides_s
            timing.see(float(times_s[k]), float(noisy_radps), 1.0 if slides else 0.0)
    return timing.lag_s if timing.is_known else nan


@pytest.mark.parametrize("lag_s", [0.0, 0.03, 0.05, 0.1])
def test_slides_that_last_for_less_than_the_longest_lag_tell_it_too(lag_s: float) -> None:
    """A quick slide protection ends them within two tenths of a second; the force is told all the time."""
    assert lag_found_s(lag_s, period_s=0.7, slides_s=0.2) == pytest.approx(lag_s, abs=0.012)


@pytest.mark.parametrize("period_s", [0.7, 1.3, 2.5])
@pytest.mark.parametrize("lag_s", [-0.1, -0.05, -0.03, 0.0, 0.01, 0.02, 0.03, 0.05, 0.1])
def test_a_lag_is_found_as_it_is(lag_s: float, period_s: float) -> None:
    assert lag_found_s(lag_s, period_s=period_s) == pytest.approx(lag_s, abs=0.005)


@pytest.mark.parametrize("lag_s", [0.0, 0.05, 0.1])
@pytest.mark.parametrize("spacing_s", [0.01, 0.02, 0.04, 0.05])
def test_whatever_the_wheel_speeds_spacing(lag_s: float, spacing_s: float) -> None:
    assert lag_found_s(lag_s, spacing_s=spacing_s) == pytest.approx(lag_s, abs=0.008)


@pytest.mark.parametrize("lag_s", [0.0, 0.05])
def test_although_every_fifth_wheel_speed_is_lost(lag_s: float) -> None:
    """Then the readings' distance is not the lag's measure for each of them."""
    assert lag_found_s(lag_s, lost=0.2, seconds=20.0) == pytest.approx(lag_s, abs=0.015)


@pytest.mark.parametrize("lag_s", [0.0, 0.05])
def test_on_a_rail_whose_adhesion_wanders(lag_s: float) -> None:
    """By 0.01 within a second."""
    assert lag_found_s(lag_s, wandering=0.01, seconds=20.0) == pytest.approx(lag_s, abs=0.008)


@pytest.mark.parametrize(("lag_s", "period_s", "speed_std_radps"), [(0.05, 0.2, 0.03), (0.1, 0.3, 0.06)])
def test_on_a_wheelset_that_shakes_as_much_as_its_brake_moves_it(
    lag_s: float, period_s: float, speed_std_radps: float
) -> None:
    """As on an axle that twists. A force in step explains as little, so nothing is said of it."""
    shaking = {"period_s": period_s, "speed_std_radps": speed_std_radps, "seconds": 20.0}
    assert lag_found_s(lag_s, **shaking) == pytest.approx(lag_s, abs=0.005)
    assert isnan(lag_found_s(0.0, **shaking))


def test_a_force_that_is_in_step_again_is_taken_to_be_although_its_wheelset_shakes() -> None:
    rng = np.random.default_rng(3)
    times_s = np.arange(0.0, 40.0, STEP_S)
    force_n = cycling_force_n(times_s, 0.3)
    omega_radps = wheel_speeds_radps(force_n, np.full(len(times_s), 0.0628))
    timing, answers = ForceTiming(), []
    for k in range(200, len(times_s), 20):
        late = 100 if times_s[k] < 15.0 else 0
        timing.press(float(force_n[k - late - 20 : k - late].sum()) * STEP_S)
        answers.append(timing.see(float(times_s[k]), float(omega_radps[k]) + 0.06 * rng.normal(), 1.0))
    assert all(answers[400:700])
    assert not any(answers[-400:])


def test_a_wheelset_that_rolls_tells_nothing() -> None:
    assert isnan(lag_found_s(0.05, rolls=True))


def test_nor_does_a_slide_that_is_short() -> None:
    assert isnan(lag_found_s(0.05, seconds=0.5))


def said(omega_radps: Floats, force_n: Floats) -> list[bool]:
    """Whether they are out of step, reading by reading."""
    timing, answers = ForceTiming(), []
    for k, (speed_radps, told_n) in enumerate(zip(omega_radps.tolist(), force_n.tolist(), strict=True)):
        timing.press(told_n * 0.02)
        answers.append(timing.see(0.02 * k, speed_radps, 1.0))
    return answers


def test_a_force_that_has_nothing_to_do_with_its_wheel_is_in_no_doubt_here() -> None:
    """Nor one that stands still, nor a wheel speed that does."""
    rng = np.random.default_rng(5)
    still, wild = np.full(1000, 40.0), rng.normal(size=1000)
    assert not any(said(40.0 + wild, 40e3 + 1e3 * rng.normal(size=1000)))
    assert not any(said(40.0 + wild, still))
    assert not any(said(still, 40e3 + wild))
    assert not any(said(still, still))


def test_it_goes_on_saying_so_while_the_wheelset_slides_and_is_silent_while_it_rolls() -> None:
    times_s = np.arange(0.0, 30.0, STEP_S)
    force_n = cycling_force_n(times_s, 1.3)
    omega_radps = wheel_speeds_radps(force_n, np.full(len(times_s), 0.0628))
    timing, answers = ForceTiming(), []
    for k in range(100, len(times_s), 20):
        timing.press(float(force_n[k - 90 : k - 70].sum()) * STEP_S)  # 0.07 s late
        slides = 1.0 if times_s[k] < 20.0 else 0.0
        answers.append(timing.see(float(times_s[k]), float(omega_radps[k]), slides))
    assert all(answers[100:950])
    assert not any(answers[1000:])
    assert timing.lag_s == pytest.approx(0.07, abs=0.005)


@pytest.mark.parametrize("lag_s", [-0.1, 0.05, 0.1])
def test_one_slide_of_some_tenths_of_a_second_says_plainly_that_they_are_apart(lag_s: float) -> None:
    """As long as slide protection takes for a cycle; in step it says nothing."""
    times_s = np.arange(0.0, 1.9, STEP_S)
    force_n = cycling_force_n(times_s, 0.7)
    omega_radps = wheel_speeds_radps(force_n, np.full(len(times_s), 0.0628))
    late, sliding = round(lag_s / STEP_S), range(1000, 1700, 20)
    told_n = np.array([[force_n[k - by - 20 : k - by].mean() for by in (late, 0)] for k in sliding])
    assert any(said(omega_radps[sliding], told_n[:, 0]))
    assert not any(said(omega_radps[sliding], told_n[:, 1]))


def vented_once(adhesion: float, fades_m: float, seed: int) -> tuple[Floats, Floats]:
    """Wheel speeds and force every 20 ms of a wheelset at 130 km/h on a rail that fades from dry to this adhesion.

    It slides on for a while after slide protection has vented its brake, at 4 % of slip.
    """
    rng, speed_mps, every, force_n, vents = np.random.default_rng(seed), 36.0, 20, 80e3, False
    omega_radps, forces_n, slides = [speed_mps * 0.997 / WHEEL_RADIUS_M], [], []
    for k in range(3000):
        rail = max(0.3 - (0.3 - adhesion) * k * STEP_S * speed_mps / fades_m, adhesion)
        slip = 1.0 - omega_radps[-1] * WHEEL_RADIUS_M / speed_mps
        vents = vents or slip > 0.04
        force_n += ((10e3 if vents else 80e3) - force_n) * STEP_S / 0.12
        used = rail * min(max(slip, 0.0) / 0.01, 1.0)
        torque_nm = WHEEL_RADIUS_M * used * WHEEL_LOAD_N - BRAKE_RADIUS_M * FRICTION * force_n
        omega_radps.append(omega_radps[-1] + torque_nm / INERTIA_KGM2 * STEP_S)
        forces_n.append(force_n)
        slides.append(slip > 0.05)
    chosen = [k for k in range(every, 3000, every) if slides[k]]
    told_n = np.array([np.mean(forces_n[k - every : k]) for k in chosen])
    told_radps = np.array(omega_radps)[chosen]
    return told_radps + WHEEL_SPEED_STD_RADPS * rng.normal(size=len(told_radps)), told_n


@pytest.mark.parametrize("fades_m", [20.0, 22.0, 24.0])
def test_one_vent_while_the_rail_fades_tells_nothing(fades_m: float) -> None:
    """What the rail takes away meanwhile looks like a force that fell before: a lag of 0.05 s fits better than none."""
    assert not any(any(said(*vented_once(0.02, fades_m, seed))) for seed in range(8))


def test_a_clock_that_is_set_back_or_a_gap_begins_anew() -> None:
    timing = ForceTiming()
    for time_s in (5.0, 5.02, 3.0, 3.02, 9.0, 9.02):
        timing.press(1000.0)
        assert not timing.see(time_s, 40.0, 1.0)
    assert timing.readings == 0


@pytest.mark.parametrize("pause", [1, 5])
def test_a_force_that_was_not_told_all_the_time_between_two_wheel_speeds_is_not_compared(pause: int) -> None:
    """It is told from the slide on, which begins somewhere between them: what it did before is not known."""
    timing, compared, resumes = ForceTiming(), [0], LAGS + pause + 1
    for k in range(resumes + LAGS + 1):
        if not LAGS < k < resumes:
            timing.press(1000.0)
        timing.see(0.02 * k, 40.0, 1.0)
        compared.append(timing.readings)
    assert np.flatnonzero(np.diff(compared)).tolist() == [LAGS, resumes + LAGS]  # as long after the first one of each


@pytest.mark.parametrize("rise_s", [0.2, 0.4, 0.8])
@pytest.mark.parametrize("rising_per_radps", [0.0, 0.002])
def test_a_brake_that_is_only_put_on_is_in_no_doubt(rise_s: float, rising_per_radps: float) -> None:
    """It fits with any lag, and on a rail that gives more the faster it slides best with one of some hundredths."""
    rng, timing, times_s = np.random.default_rng(1), ForceTiming(), np.arange(0.0, 1.5, STEP_S)
    force_n = 50e3 * (1.0 - np.exp(-times_s / rise_s))
    nearly_enough = 0.8 * BRAKE_RADIUS_M * FRICTION * force_n[-1] / (WHEEL_RADIUS_M * WHEEL_LOAD_N)
    omega_radps, answers = [60.0], []
    for pressed_n in force_n.tolist():
        adhesion = nearly_enough + rising_per_radps * (60.0 - omega_radps[-1])
        torque_nm = WHEEL_RADIUS_M * adhesion * WHEEL_LOAD_N - BRAKE_RADIUS_M * FRICTION * pressed_n
        omega_radps.append(omega_radps[-1] + torque_nm / INERTIA_KGM2 * STEP_S)
    for slide in range(6):
        for k in range(20, len(times_s), 20):
            timing.press(float(force_n[k - 20 : k].sum()) * STEP_S)
            told_radps = omega_radps[k] + rng.normal() * WHEEL_SPEED_STD_RADPS
            answers.append(timing.see(100.0 * slide + float(times_s[k]), told_radps, 1.0))
    assert timing.readings > 300
    assert not any(answers)
