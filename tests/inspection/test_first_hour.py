"""What is asked of a recording's first hour, of readings made by hand."""

import numpy as np
import pytest

from brake_monitor.inspection.first_hour import FirstHour, Readings, change_per_s
from brake_monitor.samples import Channel, Quantity
from first_hours import Floats, good_samples, of_each, of_readings, speed_channel

FORCE = Channel(Quantity.PRESSING_FORCE, 0, "can0", "BCU", "p_A", 50.0, 0.0, 1.0)
TIMES_S = np.arange(0.0, 30.0, 0.05)
BRAKED_MPS = 25.0 - np.clip(TIMES_S - 10.0, 0.0, 5.0) - 2.0 * np.clip(TIMES_S - 15.0, 0.0, 4.0)  # by 1, then 2 m/s²


def of_speeds(speeds_mps: Floats) -> FirstHour:
    return of_readings([speed_channel(0.02)], TIMES_S[: len(speeds_mps)], speeds_mps)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_hardest_slowing_is_found_where_it_begins(direction: float) -> None:
    slowing_mps2, begin_s = of_speeds(direction * BRAKED_MPS).hardest_slowing()
    assert slowing_mps2 == pytest.approx(2.0)
    assert 15.0 - 1e-6 <= begin_s <= 16.0 + 1e-6


@pytest.mark.parametrize("spike_mps", [0.0, 80.0])
def test_two_readings_in_a_row_that_are_wrong_are_no_slowing(spike_mps: float) -> None:
    spiked_mps = BRAKED_MPS.copy()
    spiked_mps[[100, 101]] = spike_mps
    slowing_mps2, _ = of_speeds(spiked_mps).hardest_slowing()
    assert slowing_mps2 == pytest.approx(2.0)


@pytest.mark.parametrize(
    "speeds_mps",
    [BRAKED_MPS[::-1], BRAKED_MPS[:60], BRAKED_MPS[:62], BRAKED_MPS[:1], BRAKED_MPS[:0]],
    ids=["gets faster", "too short", "for two readings", "one reading", "none"],
)
def test_where_nothing_slows_down_for_three_seconds_there_is_no_slowing(speeds_mps: Floats) -> None:
    slowing_mps2, _ = of_speeds(speeds_mps).hardest_slowing()
    assert slowing_mps2 == 0.0


def test_readings_of_a_clock_that_was_set_back_in_between_tell_nothing() -> None:
    set_back_s = np.where(TIMES_S < 20.0, TIMES_S, TIMES_S - 0.5)
    first_hour = of_readings([speed_channel(0.02)], set_back_s, BRAKED_MPS)
    assert first_hour.readings(Quantity.SPEED) is None
    assert first_hour.hardest_slowing() == (0.0, 0.0)


@pytest.mark.parametrize(
    ("begin_s", "greatest_n"),
    [
        (1.5, None),  # before it was told at all
        (3.0, 10e3),
        (19.0, 30e3),
        (23.5, 15e3),  # it is told as it changes: so it is still
        (27.5, 40e3),
        (31.0, 0.0),  # a sensor that is not quite at 0
    ],
)
def test_a_pressing_force_lasts_until_it_is_told_anew(begin_s: float, greatest_n: float | None) -> None:
    told_s, told_n = np.array([5.0, 20.0, 22.0, 30.0, 30.5]), np.array([10e3, 30e3, 15e3, 40e3, -200.0])
    assert of_readings([FORCE], told_s, told_n).greatest_force_n(0, begin_s) == greatest_n


def test_of_a_force_that_was_never_told_nothing_is_known() -> None:
    assert of_each([FORCE]).greatest_force_n(0, 0.0) is None


def test_how_far_the_nearest_reading_is() -> None:
    told = Readings(np.array([0.0, 1.0, 4.0]), np.zeros(3))
    assert told.apart_s(np.array([-1.0, 0.4, 0.6, 3.0, 4.0, 9.0])) == pytest.approx([1.0, 0.4, 0.4, 1.0, 0.0, 5.0])


def test_how_fast_something_changes() -> None:
    times_s = np.array([1.0, 3.0])
    assert change_per_s(lambda at_s: 5.0 + 2.0 * at_s, times_s) == pytest.approx([2.0, 2.0])
    assert change_per_s(lambda at_s: at_s**2, times_s) == pytest.approx([2.0, 6.0])


def test_what_a_clock_says_that_is_set_ahead_by_years_is_not_of_the_first_hour() -> None:
    """Nor is there room in memory for a grid over years."""
    times_s = np.array([0.0, 1.0, 3e8, 3e8 + 1.0])
    kept = of_readings([speed_channel(0.02)], times_s, times_s).readings(Quantity.SPEED)
    assert kept is not None
    assert list(kept.times_s) == [0.0, 1.0]


def test_only_the_first_hour_is_kept() -> None:
    channels = [speed_channel(0.02)]
    parts = [np.arange(begin_s, begin_s + 10.0) for begin_s in (50.0, 3500.0, 3700.0, 7000.0)]
    first_hour = FirstHour(channels)
    for times_s in parts:
        first_hour.see(good_samples(channels, 0, times_s, times_s))
    kept = first_hour.readings(Quantity.SPEED)
    assert kept is not None
    assert list(kept.times_s) == [*parts[0], *parts[1]]
