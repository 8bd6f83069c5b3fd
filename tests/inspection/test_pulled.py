"""A wagon that gets to speed is pulled, or has motors; one that rolls is not."""

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from brake_monitor.inspection.pulled import remarks_on_pull
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from first_hours import of_readings, speed_channel

TIMES_S = np.arange(0.0, 120.0, 0.05)


def remarks(speeds_mps: NDArray[np.float64], settings: Settings) -> list[str]:
    noisy_mps = speeds_mps + 0.02 * np.random.default_rng(7).normal(size=len(TIMES_S))
    return list(remarks_on_pull(of_readings([speed_channel(0.02)], TIMES_S, noisy_mps), settings))


def settings(vehicle: str = "wagon", preset: str = "wagon") -> Settings:
    loaded = example_settings(vehicle)
    return replace(loaded, estimator=replace(loaded.estimator, preset=preset))


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_start_to_speed_is_remarked(direction: float) -> None:
    """0.2 m/s² from 20 s on, as a goods train starts."""
    (remark,) = remarks(direction * np.clip(0.2 * (TIMES_S - 20.0), 0.0, 15.0), settings())
    assert 'preset = "train"' in remark


@pytest.mark.parametrize(
    ("least_mps", "takes_s", "is_told"), [(0.4, 30.0, True), (0.6, 30.0, False), (0.0, 12.0, True), (0.0, 8.0, False)]
)
def test_a_start_is_from_standstill_and_takes_its_time(least_mps: float, takes_s: float, is_told: bool) -> None:
    """To 10 m/s; a crawl is no standstill, and no train starts as quickly as the last."""
    starts_mps = np.clip(10.0 / takes_s * (TIMES_S - 20.0), least_mps, 15.0)
    assert bool(remarks(starts_mps, settings())) is is_told


@pytest.mark.parametrize(("gained_mps2", "is_told"), [(0.4, True), (0.3, False), (1.3, False)])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_what_gains_more_than_downhill_is_remarked(gained_mps2: float, is_told: bool, direction: float) -> None:
    """A recording that begins on the way, and a locomotive that goes on after a stop signal has cleared."""
    speeds_mps = direction * (12.0 + gained_mps2 * np.clip(TIMES_S - 50.0, 0.0, 12.0))
    assert bool(remarks(speeds_mps, settings())) is is_told
    assert not remarks(speeds_mps, settings(preset="train"))


def test_a_gain_is_not_read_from_a_clock_that_was_set_back() -> None:
    times_s = np.concatenate((TIMES_S, TIMES_S))
    speeds_mps = 12.0 + 0.45 * np.clip(times_s - 50.0, 0.0, 12.0)
    assert not list(remarks_on_pull(of_readings([speed_channel(0.02)], times_s, speeds_mps), settings()))


def test_in_a_train_or_with_motors_it_is_as_told() -> None:
    starts_mps = np.clip(0.2 * (TIMES_S - 20.0), 0.0, 15.0)
    assert not remarks(starts_mps, settings(preset="train"))
    assert not remarks(starts_mps, settings("railcar"))


@pytest.mark.parametrize(
    "speeds_mps",
    [
        np.full_like(TIMES_S, 20.0),
        np.clip(20.0 - 0.5 * TIMES_S, 0.0, 20.0),
        np.clip(0.15 * (TIMES_S - 20.0), 0.0, 6.0),
        np.where((TIMES_S > 30.0) & (TIMES_S < 35.0), 0.0, 20.0),
        np.where(TIMES_S < 35.0, 0.0, 20.0),
        np.where(TIMES_S < 35.0, 12.0, 20.0),
    ],
    ids=["rolls", "stops", "let go from a hump", "a sensor that says 0", "a sensor that says 0 at first", "a jump"],
)
def test_what_rolls_is_not(speeds_mps: NDArray[np.float64]) -> None:
    assert not remarks(speeds_mps, settings())
