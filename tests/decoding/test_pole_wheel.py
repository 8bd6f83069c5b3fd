"""What a pole wheel's run-out adds to a wheel speed is found and taken out, and nothing where there is none."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from brake_monitor.arrays import Floats
from brake_monitor.decoding.pole_wheel import LEAST_RADPS, PoleWheel
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import Quantity
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from drives import SLIDE, drive

NOISE_STD_RADPS = 0.0225  # 0.01 m/s
RADIUS_M = 0.445
CYCLE_S = 0.02
LEARNT_S = 10.0


def rolling(duration_s: float, *, cycle_s: float = CYCLE_S) -> tuple[Floats, Floats]:
    """Times, and a wheel's speed, which rises and falls between 35 and 100 km/h."""
    time_s = np.arange(0.0, duration_s, cycle_s)
    return time_s, (18.75 + 9.0 * np.sin(time_s / 12.0)) / RADIUS_M


def told(
    time_s: Floats,
    speed_radps: Floats,
    *,
    share: float,
    ratio: float = 0.0,
    lag_s: float = 0.0,
    noise_std: float = NOISE_STD_RADPS,
    step: float = 0.0,
) -> Floats:
    """What its sensor says; `ratio`: it turns by so much more than its own speed says, as of a smaller wheel."""
    rng = np.random.default_rng(7)
    angle_rad = np.concatenate(([0.0], np.cumsum(0.5 * (speed_radps[1:] + speed_radps[:-1]) * np.diff(time_s))))
    turn = (1.0 + ratio) * angle_rad + 2.0 - lag_s * speed_radps
    said = speed_radps * (1.0 + share * np.cos(turn)) + noise_std * rng.standard_normal(len(time_s))
    return np.round(said / step) * step if step else said


def true(time_s: Floats, readings_radps: Floats, noise_std: float = NOISE_STD_RADPS) -> Floats:
    pole_wheel = PoleWheel(noise_std)
    return np.array(list(map(pole_wheel.true, time_s.tolist(), readings_radps.tolist())))


def rms(error: Floats) -> float:
    return float(np.sqrt(np.mean(error**2)))


@pytest.mark.parametrize("share", [0.0005, 0.001, 0.003, 0.01])
@pytest.mark.parametrize("ratio", [0.0, 0.01, -0.04], ids=["", "its sender knows the wheel", "a worn wheel"])
def test_hardly_more_than_the_noise_is_left(share: float, ratio: float) -> None:
    time_s, speed_radps = rolling(120.0)
    readings = told(time_s, speed_radps, share=share, ratio=ratio)
    learnt = time_s > LEARNT_S
    noise = rms((told(time_s, speed_radps, share=0.0) - speed_radps)[learnt])
    assert rms((true(time_s, readings) - speed_radps)[learnt]) < 1.06 * noise
    assert rms((readings - speed_radps)[learnt]) > 1.15 * noise


def _with_gaps(time_s: Floats) -> np.ndarray:
    return np.asarray(time_s % 10.0 > 0.4)


def _a_fifth_lost(time_s: Floats) -> np.ndarray:
    return np.random.default_rng(1).random(len(time_s)) > 0.2


@pytest.mark.parametrize("arrive", [_with_gaps, _a_fifth_lost])
def test_readings_that_are_lost_leave_the_angle_known(arrive: Callable[[Floats], np.ndarray]) -> None:
    time_s, speed_radps = rolling(120.0)
    readings = told(time_s, speed_radps, share=0.002)
    here = arrive(time_s)
    error = true(time_s[here], readings[here]) - speed_radps[here]
    assert rms(error[time_s[here] > LEARNT_S]) < 1.1 * NOISE_STD_RADPS


@pytest.mark.parametrize("lag_s", [0.05, 0.15])
def test_a_sensor_that_lags_tells_of_an_angle_that_depends_on_the_speed(lag_s: float) -> None:
    time_s, speed_radps = rolling(120.0)
    readings = told(time_s, speed_radps, share=0.002, lag_s=lag_s)
    assert rms((true(time_s, readings) - speed_radps)[time_s > LEARNT_S]) < 1.1 * NOISE_STD_RADPS


@pytest.mark.parametrize("noise_std", [0.0, 0.0225, 0.1])
@pytest.mark.parametrize("step", [0.0062, 0.0624, 0.312])  # 0.01, 0.1 and 0.5 km/h
def test_where_there_is_none_readings_stay_what_they_are(noise_std: float, step: float) -> None:
    time_s, speed_radps = rolling(1800.0)
    readings = told(time_s, speed_radps, share=0.0, noise_std=noise_std, step=step)
    changed = np.abs(true(time_s, readings, float(np.hypot(noise_std, step / 12**0.5))) - readings)
    assert changed.max() < 0.1 * np.hypot(noise_std, step)
    assert np.mean(changed > 0.0) < 0.01


def test_a_slide_and_what_protection_does_hides_it_for_a_while_and_does_not_unlearn_it() -> None:
    time_s, speed_radps = rolling(100.0)
    slides = (time_s > 60.0) & (time_s < 70.0)
    speed_radps = np.where(slides, speed_radps * (1.0 - 0.1 * np.sin((time_s - 60.0) * 2.0 * np.pi) ** 2), speed_radps)
    error = true(time_s, told(time_s, speed_radps, share=0.004)) - speed_radps
    assert rms(error[slides]) < 1.5 * NOISE_STD_RADPS
    assert rms(error[(time_s > 70.0) & (time_s < 73.0)]) < 1.5 * NOISE_STD_RADPS


def test_after_a_stop_the_pole_wheel_stands_elsewhere() -> None:
    """The sensor says 0 below 2 km/h, and the wheel turns on by nobody knows how much."""
    time_s = np.arange(0.0, 120.0, CYCLE_S)
    speed_radps = np.maximum(30.0 * np.cos(time_s * np.pi / 60.0), 0.0)
    said = told(time_s, speed_radps, share=0.004)
    wakes = time_s >= 90.0
    said[wakes] = told(time_s[wakes], speed_radps[wakes], share=0.004)
    readings = np.where(speed_radps < 1.25, 0.0, said)
    error = true(time_s, readings) - speed_radps
    asleep = readings < LEAST_RADPS
    assert np.all(true(time_s, readings)[asleep] == readings[asleep])
    assert rms(error[(time_s > 100.0) & ~asleep]) < 1.1 * NOISE_STD_RADPS


def test_readings_that_come_too_seldom_to_tell_of_a_turn_stay_what_they_are() -> None:
    time_s, speed_radps = rolling(120.0, cycle_s=0.1)
    readings = told(time_s, speed_radps, share=0.004)
    fast = speed_radps > 25.5  # two and a half readings a turn
    assert np.array_equal(true(time_s, readings)[fast], readings[fast])


def test_a_frame_that_comes_twice_or_late_is_no_turn() -> None:
    time_s, speed_radps = rolling(60.0)
    readings = told(time_s, speed_radps, share=0.004)
    in_order = true(time_s, readings)
    order = np.arange(len(time_s)).reshape(-1, 2)
    disturbed = np.concatenate([order, order[:, ::-1]], axis=1).ravel()  # 0 1 1 0  2 3 3 2 ...
    again = true(time_s[disturbed], readings[disturbed])
    twice = again.reshape(-1, 4)
    assert np.allclose(twice[:, :2].ravel(), in_order, rtol=0.0, atol=1e-12)
    assert np.allclose(twice[:, 2], twice[:, 1], rtol=0.0, atol=1e-12)
    assert rms((twice[:, 3] - speed_radps[::2])[time_s[::2] > LEARNT_S]) < 1.1 * NOISE_STD_RADPS


def test_a_sensor_that_freezes_is_seen_to_repeat_itself() -> None:
    """What turns with the angle alone would look alive."""
    time_s, speed_radps = rolling(60.0)
    readings = told(time_s, speed_radps, share=0.004)
    frozen = (time_s >= 40.0) & (time_s < 42.0)
    readings[frozen] = readings[frozen][0]
    found = true(time_s, readings)
    assert len(set(found[frozen][2:].tolist())) == 1
    assert rms((found - speed_radps)[(time_s > 45.0) & (time_s < 60.0)]) < 1.1 * NOISE_STD_RADPS


@pytest.mark.parametrize("spike_radps", [150.0, 1e300, float("inf"), float("nan")])
def test_after_a_spike_it_is_learned_anew(spike_radps: float) -> None:
    """The wheel did not turn on by that."""
    time_s, speed_radps = rolling(60.0)
    readings = told(time_s, speed_radps, share=0.004)
    readings[1500] = spike_radps
    found = true(time_s, readings)
    later = time_s > 33.0
    assert rms((found - speed_radps)[later]) < 1.1 * NOISE_STD_RADPS
    soon = (time_s > 30.0) & (time_s < 33.0)
    assert rms((found - speed_radps)[soon]) <= rms((readings - speed_radps)[soon])


@pytest.fixture(scope="module")
def recording() -> Recording:
    return drive(SLIDE, Modifiers(run_out=0.003))


def test_the_simulated_wagons_wheel_speeds_come_out_true(recording: Recording) -> None:
    decoder = SignalDecoder.from_settings(recording.settings)
    samples = decoder.decode_block(FrameBlock.of(recording.frames))
    trace = recording.trace
    for wheelset in range(trace.wheelset_count):
        good = samples.good(Quantity.AXLE_SPEED, wheelset)
        truth = trace.wheelset(wheelset, "omega_radps")
        error = good.value - np.interp(good.time_s - EPOCH_S, np.arange(len(truth)) * trace.step_s, truth)
        rolls = (good.time_s - EPOCH_S > 3.0) & (good.time_s - EPOCH_S < 5.0)
        assert rms(error[rolls]) < 1.3 * NOISE_STD_RADPS  # 0.16 before
        assert decoder.pole_wheels[Quantity.AXLE_SPEED, wheelset].run_out.share == pytest.approx(0.003, rel=0.2)


def test_blocks_of_any_length_give_what_single_frames_do_to_the_last_bit(recording: Recording) -> None:
    settings, frames = example_settings("wagon"), recording.frames
    one_by_one, in_blocks = SignalDecoder.from_settings(settings), SignalDecoder.from_settings(settings)
    single = [sample for frame in frames for sample in one_by_one.decode(frame)]
    begins = [0, 1, 500, 501, len(frames)]
    blocks = [FrameBlock.of(frames[begin:end]) for begin, end in pairwise(begins)]
    assert [sample for block in blocks for sample in in_blocks.decode_block(block).samples] == single
