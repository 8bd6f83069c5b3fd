"""A vehicle speed that is made of the wheel speeds is found by slides, in which it is as slow as they are."""

from collections.abc import Callable

import numpy as np
import pytest

from brake_monitor.inspection.wheels_mean import remarks_on_wheels_mean
from first_hours import Floats, of_each, of_readings, speed_channel, wheel_channel

Made = Callable[[Floats, Floats], Floats]  # a vehicle speed, of the true one and those of the wheels
RADII_M, NOISE_MPS, SPACING_S = (0.46, 0.45), 0.01, 0.05
CHANNELS = [speed_channel(NOISE_MPS), wheel_channel(0, NOISE_MPS), wheel_channel(1, NOISE_MPS)]


def mean(_: Floats, wheels: Floats) -> Floats:
    return wheels.mean(axis=0)


def remarks(made: Made, *, slips: tuple[float, float] = (0.15, 0.02)) -> list[str]:
    """Of a wagon that loses a metre per second and second, and slides from 10 to 16 s."""
    rng, times_s = np.random.default_rng(5), np.arange(0.0, 30.0, SPACING_S)
    true_mps = 35.0 - times_s
    slides = (times_s > 10.0) & (times_s < 16.0)
    wheels = true_mps * np.array([1.0 - slip * slides for slip in slips]) + NOISE_MPS * rng.normal(
        size=(2, len(times_s))
    )
    told = [made(true_mps, wheels), *(own / radius_m for own, radius_m in zip(wheels, RADII_M, strict=True))]
    return list(remarks_on_wheels_mean(of_readings(CHANNELS, times_s, *told), RADII_M))


def test_the_mean_of_the_wheel_speeds_is_found() -> None:
    (remark,) = remarks(mean)
    assert remark.startswith("speed is the mean of the wheel speeds, also while they slide")


def late(true_mps: Floats, _: Floats) -> Floats:
    return true_mps + 0.5


@pytest.mark.parametrize("made", [lambda true_mps, _: true_mps, late, lambda _, wheels: wheels.max(axis=0)])
def test_a_speed_that_wheels_do_not_hold_back_is_none(made: Made) -> None:
    """The fastest wheelset's may be right: it may roll."""
    assert not remarks(made)


@pytest.mark.parametrize(("slip", "is_told"), [(0.01, False), (0.035, False), (0.07, True)])
def test_where_nothing_slides_nothing_is_said(slip: float, is_told: bool) -> None:
    """Radii that are not known well set wheel speeds apart by as much as a slip of some hundredths."""
    assert bool(remarks(mean, slips=(0.0, slip))) is is_told


@pytest.mark.parametrize(("share", "is_told"), [(0.15, True), (0.3, False)])
def test_a_speed_that_lies_well_beyond_the_mean_is_none(share: float, is_told: bool) -> None:
    """By so much of the way to the fastest wheelset, which a wagon's own speed is at, or beyond."""
    beyond = remarks(lambda _, wheels: (1.0 - share) * wheels.mean(axis=0) + share * wheels.max(axis=0))
    assert any("is the mean of the wheel speeds" in remark for remark in beyond) is is_told


def again_and_again(made: Made, count: int, late_s: float = 0.0) -> list[str]:
    """Of a braked wagon all of whose wheelsets lose a tenth of their speed and gain it again, in slides of a second."""
    rng, times_s = np.random.default_rng(6), np.arange(0.0, 30.0, SPACING_S)
    true_mps = 35.0 - times_s
    slips = [0.1 * np.maximum(np.sin(np.pi * times_s * (0.8 + 0.15 * own)), 0.0) ** 2 for own in range(count)]
    slides = (times_s > 10.0) & (times_s < 20.0)
    wheels = np.array([true_mps * (1.0 - slip * slides) for slip in slips]) + NOISE_MPS * rng.normal(
        size=(count, len(times_s))
    )
    radii_m = [0.45] * count
    channels = [speed_channel(NOISE_MPS), *(wheel_channel(own, NOISE_MPS) for own in range(count))]
    earlier = np.array([np.interp(times_s - late_s, times_s, own) for own in wheels])
    told = [made(true_mps, earlier), *(own / 0.45 for own in wheels)]
    return list(remarks_on_wheels_mean(of_readings(channels, times_s, *told), radii_m))


@pytest.mark.parametrize("late_s", [0.0, 0.08])
@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize(
    "made", [lambda _, wheels: wheels.max(axis=0), lambda _, wheels: np.sort(wheels, axis=0)[-2:][0]]
)
def test_a_speed_that_slides_with_the_wheels_is_found(made: Made, count: int, late_s: float) -> None:
    """The fastest of them, or the second fastest; of a single one that it is."""
    (remark,) = again_and_again(made, count, late_s)
    assert remark.startswith("speed jumps as wheel speeds do in slides, and no vehicle can: it is made of them")


@pytest.mark.parametrize(("share", "is_told"), [(0.8, True), (0.5, False)])
def test_a_speed_that_follows_slides_by_half_may_come_from_elsewhere(share: float, is_told: bool) -> None:
    made = again_and_again(lambda true_mps, wheels: true_mps + share * (wheels[0] - true_mps), 1)
    assert bool(made) is is_told


@pytest.mark.parametrize("count", [1, 2, 4])
@pytest.mark.parametrize("made", [lambda true_mps, _: true_mps, late])
def test_a_speed_that_goes_on_steadily_is_not(made: Made, count: int) -> None:
    assert not again_and_again(made, count)


def test_nor_is_one_of_a_tram_that_rolls_to_a_stop_by_its_track_brakes() -> None:
    """They take up to 2.8 m/s² from wheels and vehicle alike, and nothing slides."""
    rng, times_s = np.random.default_rng(7), np.arange(0.0, 8.0, SPACING_S)
    true_mps = 20.0 - 2.8 * np.maximum(times_s - 1.0, 0.0)
    wheels = true_mps + NOISE_MPS * rng.normal(size=(2, len(times_s)))
    told = [true_mps, *(own / radius_m for own, radius_m in zip(wheels, RADII_M, strict=True))]
    assert not list(remarks_on_wheels_mean(of_readings(CHANNELS, times_s, *told), RADII_M))


@pytest.mark.parametrize("lost_s", [(5.0, 30.0), (5.0, 20.0)], ids=["for good", "for a while"])
def test_a_wheel_speed_that_is_lost_shows_no_slide(lost_s: tuple[float, float]) -> None:
    """Eight wheels slow down and speed up with the vehicle, but one of them is not told of."""
    times_s = np.arange(0.0, 30.0, SPACING_S)
    true_mps = 20.0 - np.clip(times_s - 4.0, 0.0, 6.0) + np.clip(times_s - 15.0, 0.0, 6.0)
    channels = [speed_channel(NOISE_MPS), *(wheel_channel(own, NOISE_MPS) for own in range(8))]
    told = (times_s < lost_s[0]) | (times_s > lost_s[1])
    wheels = [(times_s, true_mps / 0.45)] * 7 + [(times_s[told], true_mps[told] / 0.45)]
    assert not list(remarks_on_wheels_mean(of_each(channels, (times_s, true_mps), *wheels), [0.45] * 8))
