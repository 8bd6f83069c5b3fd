"""A wheelset that is stopped, by whatever stops it, loses its speed otherwise than a sensor that dies."""

from math import exp

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.monitoring.inputs.descent import ROLLS, STANDS, WHOLE, Descent
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, drive
from faults import signal_changed

SPEED_MPS = 20.0
CYCLE_S = 0.02
NOISE_STD = 0.003  # of the vehicle's speed
STEP_S = 1e-4
FROM_S = 13.5  # of the drive, which coasts from then on for 3.5 s


def stopped(seizes_within_s: float, rail: float, mass_mps2: float) -> np.ndarray:
    """Shares of the vehicle's speed, every 0.1 ms: J d(omega)/dt = mu L r - T, both over L r.

    `mass_mps2`: by which an adhesion of 1 changes its circumferential speed. T rises to three times the rail's torque.
    """
    shares, share, time_s = [], 1.0, 0.0
    while share > 0.0:
        shares.append(share)
        slip = 1.0 - share
        adhesion = rail * (1.0 - exp(-slip / 0.004)) * (1.0 - 0.4 * slip)  # that falls as it slides
        torque = 3.0 * rail * min(time_s / seizes_within_s, 1.0)
        share = min(share + (adhesion - torque) * mass_mps2 / SPEED_MPS * STEP_S, 1.0)
        time_s += STEP_S
    return np.array(shares)


def came_as_a_wheels(shares: np.ndarray, *, cycle_s: float = CYCLE_S, seed: int = 1) -> bool:
    """Of what a sensor tells of these shares, given every 0.1 ms; before them it rolls, and then it stands."""
    rng = np.random.default_rng(seed)
    told = np.concatenate([np.ones(20), shares[:: round(cycle_s / STEP_S)], np.zeros(20)])
    told += NOISE_STD * rng.standard_normal(len(told))
    descent = Descent()
    for k, share in enumerate(told.tolist()):
        if share > ROLLS:
            descent.rolls(k * cycle_s, k * cycle_s if share >= WHOLE else None)
        else:
            descent.see(k * cycle_s, share)
        if share < STANDS:
            return descent.is_a_wheels()
    raise AssertionError("it does not come to stand")


FALLS = {
    f"within {seizes_within_s} s on {rail}, {mass_mps2:.0f} m/s²": stopped(seizes_within_s, rail, mass_mps2)
    for seizes_within_s in (0.2, 0.5, 2.0, 5.0)
    for rail in (0.1, 0.2)
    for mass_mps2 in (60.0, 150.0)  # heavy wheels under an empty wagon, light ones under a loaded one
}


def lasts_s(shares: np.ndarray) -> float:
    return STEP_S * float(np.count_nonzero((shares < ROLLS) & (shares > STANDS)))


@pytest.mark.parametrize("cycle_s", [0.01, 0.02, 0.05])
@pytest.mark.parametrize("fall", [name for name, shares in FALLS.items() if lasts_s(shares) > 0.5])
def test_a_wheelset_that_seizes_is_told_by_its_fall(fall: str, cycle_s: float) -> None:
    assert came_as_a_wheels(FALLS[fall], cycle_s=cycle_s)


@pytest.mark.parametrize("cycle_s", [0.01, 0.02])
@pytest.mark.parametrize("fall", [name for name, shares in FALLS.items() if 0.28 < lasts_s(shares) < 0.4])
def test_so_is_one_that_seizes_quickly_where_its_speed_is_told_often(fall: str, cycle_s: float) -> None:
    """By how softly it began: no filter that would fall as quickly to its end does so."""
    assert [came_as_a_wheels(FALLS[fall], cycle_s=cycle_s, seed=seed) for seed in range(20)] == [True] * 20


def _dies_at_once() -> np.ndarray:
    return np.ones(1)


def _behind_a_filter(time_constant_s: float) -> np.ndarray:
    return np.exp(-np.arange(0.0, 5.0 * time_constant_s, STEP_S) / time_constant_s)


def _behind_a_mean_of(span_s: float) -> np.ndarray:
    return np.linspace(1.0, 0.0, round(span_s / STEP_S))


def _behind_two_means_of(span_s: float) -> np.ndarray:
    """One after the other: it begins softly, and ends so."""
    falls = _behind_a_mean_of(span_s)
    steps = -np.diff(np.concatenate([falls, [0.0]]))
    return 1.0 - np.cumsum(np.convolve(steps, np.full(len(falls), 1.0 / len(falls))))


def _misses_teeth(seed: int) -> np.ndarray:
    """More and more of them, in groups."""
    rng = np.random.default_rng(seed)
    cycles = np.clip(np.linspace(1.0, 0.0, 60) + 0.2 * rng.standard_normal(60), 0.0, 1.0)
    return np.repeat(cycles, round(CYCLE_S / STEP_S))


@pytest.mark.parametrize(
    "shares",
    [
        _dies_at_once(),
        *(_behind_a_filter(time_constant_s) for time_constant_s in (0.05, 0.2, 0.5, 1.0)),
        *(_behind_a_mean_of(span_s) for span_s in (0.1, 0.2, 0.3, 0.4)),
        *(_behind_two_means_of(span_s) for span_s in (0.1, 0.15, 0.2, 0.3)),
        *(_misses_teeth(seed) for seed in range(5)),
    ],
)
@pytest.mark.parametrize("cycle_s", [0.01, 0.02])
def test_a_sensor_that_dies_is_not_taken_for_one(shares: np.ndarray, cycle_s: float) -> None:
    assert not any(came_as_a_wheels(shares[k:], cycle_s=cycle_s, seed=k) for k in range(0, 100, 10))


@pytest.mark.parametrize("preset", ["train", "wagon"])
def test_a_bearing_that_seizes_while_the_train_coasts_stops_the_train_and_accuses_no_sensor(preset: str) -> None:
    """The train hides how it drags, and nothing says that a brake presses."""
    recording = drive(DRY)
    shares = stopped(2.0, 0.15, 120.0)
    times_s = FROM_S + STEP_S * np.arange(len(shares))
    seized = signal_changed(
        "wheel speed", lambda at_s, kmh: kmh * np.interp(at_s, times_s, shares, right=0.0), FROM_S, 99.0
    )
    estimator = replace(recording.settings.estimator, preset=preset)
    pipeline = Pipeline.from_settings(replace(recording.settings, estimator=estimator))
    alarms = [alarm for frame in seized(recording.frames) for alarm in pipeline.step(frame).alarms]
    (told, *_) = [alarm for alarm in alarms if alarm.kind == "wheelset_not_rotating"]
    assert told.wheelset == 1
    assert told.raised_time_s - EPOCH_S < times_s[-1] + 1.5
    assert not [alarm for alarm in alarms if alarm.kind == "input_implausible"]
