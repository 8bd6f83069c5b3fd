"""A pressing force that trembled and stands still to the last bit; and those that stand still by right."""

import numpy as np
import pytest
from msgspec.structs import replace as struct_replace

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.doubts.dead_force import DEAD_S, DeadForce
from brake_monitor.estimation.estimate import Status
from drives import DRY, Judged, drive, play
from faults import told_again

PERIOD_S, STEP_N, STEADY_N = 0.01, 40.0, 40e3
FROZEN_S, MOVES_S = 11.0, 16.0  # in mid-brake; the brake is released meanwhile


def told(true_n: np.ndarray, noise_steps: float) -> np.ndarray:
    """What a sensor says of a force over time, with its noise, in steps."""
    noise = noise_steps * np.random.default_rng(3).normal(size=len(true_n))
    return np.maximum(np.round(true_n / STEP_N + noise), 0.0) * STEP_N


def dead_after(
    force: DeadForce, forces_n: np.ndarray, from_s: float = 0.0, *, period_s: float = PERIOD_S
) -> float | None:
    """When it is told to be dead, in s; None: never."""
    for k, force_n in enumerate(forces_n):
        force.see(from_s + k * period_s, force_n)
        if force.is_dead:
            return from_s + k * period_s
    return None


def applications() -> np.ndarray:
    """Brakes put on in steps that are held for seconds, vented and filled by slide protection, and let go."""
    levels = [0.0, 0.3, 0.71, 1.0, 0.55, 0.0, 0.83, *([0.2, 0.9] * 10), 0.62, 0.0]
    holds_s = [3.0, 4.0, 4.0, 5.0, 4.0, 3.0, 5.0, *([0.08, 0.12] * 10), 6.0, 2.0]
    times_s, forces_n, time_s = [0.0], [0.0], 0.0
    for level, hold_s in zip(levels, holds_s, strict=True):
        ramp_s = max(abs(level * STEADY_N - forces_n[-1]) / (STEADY_N if hold_s > 1.0 else 10.0 * STEADY_N), PERIOD_S)
        times_s += [time_s + ramp_s, time_s + ramp_s + hold_s]
        forces_n += [level * STEADY_N] * 2
        time_s = times_s[-1]
    return np.interp(np.arange(0.0, time_s, PERIOD_S), times_s, forces_n)


def test_what_trembled_and_repeats_itself_is_dead() -> None:
    force = DeadForce()
    assert dead_after(force, told(np.full(300, STEADY_N), 1.5)) is None
    found_s = dead_after(force, np.full(100, STEADY_N), 3.0)
    assert found_s is not None
    assert found_s - 3.0 < DEAD_S + 3 * PERIOD_S


@pytest.mark.parametrize(("period_s", "found_s"), [(0.002, 0.5), (0.01, 0.5), (0.1, 5.0)])
def test_it_takes_half_a_second_and_fifty_readings(period_s: float, found_s: float) -> None:
    """Noise repeats a reading now and then, at any cycle."""
    force = DeadForce()
    assert dead_after(force, told(np.full(300, STEADY_N), 1.5), period_s=period_s) is None
    assert dead_after(force, np.full(300, STEADY_N), 100.0, period_s=period_s) == pytest.approx(
        100.0 + found_s, abs=1.5 * period_s
    )


@pytest.mark.parametrize("by_s", [4.0, 8.0])
def test_readings_that_come_in_another_order_do_not_tremble_by_that(by_s: float) -> None:
    """A force without any noise is filled and held; each two of its frames have changed places."""
    forces_n = np.interp(np.arange(0.0, 16.0, PERIOD_S), (1.0, 1.0 + by_s), (0.0, STEADY_N))
    force = DeadForce()
    for k in np.arange(len(forces_n)).reshape(-1, 2)[:, ::-1].ravel():
        force.see(k * PERIOD_S, forces_n[k])
        assert not force.is_dead


def test_it_lives_as_soon_as_it_says_something_else() -> None:
    force = DeadForce()
    dead_after(force, told(np.full(300, STEADY_N), 1.5))
    dead_after(force, np.full(100, STEADY_N), 3.0)
    force.see(5.0, STEADY_N + STEP_N)
    assert not force.is_dead


def test_what_seemed_dead_and_lives_has_to_tremble_anew() -> None:
    """Noise may have been another's, as that of motors."""
    force = DeadForce()
    dead_after(force, told(np.full(300, STEADY_N), 1.5))
    dead_after(force, np.full(100, STEADY_N), 3.0)
    assert dead_after(force, np.full(500, STEADY_N + STEP_N), 5.0) is None


@pytest.mark.parametrize("noise_steps", [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 1.5, 3.0])
def test_no_live_sensor_is_dead(noise_steps: float) -> None:
    """Neither one coarser than its noise, which stands still for seconds or goes to and fro between two values."""
    assert dead_after(DeadForce(), told(applications(), noise_steps)) is None


def test_a_released_brake_says_0_by_right() -> None:
    force = DeadForce()
    dead_after(force, told(np.full(300, STEADY_N), 1.5))
    assert dead_after(force, np.zeros(1000), 3.0) is None


def test_a_clock_that_is_set_back_does_not_hide_that_a_force_repeats_itself() -> None:
    force = DeadForce()
    dead_after(force, told(np.full(300, STEADY_N), 1.5), 1000.0)
    force.see(1003.0, STEADY_N)
    found_s = dead_after(force, np.full(100, STEADY_N), 5.0)
    assert found_s is not None
    assert DEAD_S <= found_s - 5.0 < DEAD_S + 3 * PERIOD_S


@pytest.mark.parametrize("preset", ["wagon", "train"])
def test_pressing_forces_that_all_freeze_as_they_are_held_are_lost_until_they_move(preset: str) -> None:
    """In a train nothing contradicts them as the brake is let go: a coupler may do what they leave unexplained."""
    recording = drive(DRY)
    settings = struct_replace(recording.settings, estimator=struct_replace(recording.settings.estimator, preset=preset))
    frames = list(recording.frames)
    for signal in ("p_A", "p_B"):
        frames = told_again("BCU", signal, FROZEN_S, MOVES_S)(frames)
    judged = Judged.of(recording, play(settings, frames))
    judged.assert_honest()
    frozen = judged.during(FROZEN_S + 1.0, MOVES_S)
    assert frozen.statuses == {Status.INVALID}
    assert {"pressing_force 1 frozen", "pressing_force 2 frozen"} <= frozen.reasons
    assert not any("frozen" in reason for reason in judged.during(0.0, FROZEN_S).reasons)
    assert not any("frozen" in reason for reason in judged.during(MOVES_S + 0.5).reasons)
    assert Doubt.DEAD not in judged.during(0.0, FROZEN_S).reasons
    assert Doubt.DEAD not in judged.during(MOVES_S + 4.0).reasons
