"""Whether the published interval of d is as wide as d is uncertain, where the line does what the filter believes of it.

To the filter d is a random walk: a line undulates. On one that does, 95 of 100 intervals have to hold the truth. On a
level line nothing wanders, and the same intervals hold it nearly always. How much more often follows from theory: the
stationary filter of v' = -d with noise r of v and density q of d has the gains sqrt(2) w and w², w⁴ = q / r, and of its
variance sqrt(2) r w³ the sensors' noise makes r w³ / (2 sqrt(2)), a quarter. The rest is what it expects to have missed
of the walk. No filter that follows gradients is narrower.
"""

from collections.abc import Iterator
from math import sqrt

import numpy as np
import pytest

from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

MASS_KG, INERTIA_KGM2, RADIUS_M, RESISTANCE_N = 18_000.0, 118.0, 0.445, 1800.0
SPEED_MPS = 40.0
SPEED_STD_MPS, OMEGA_STD_RADPS = 0.02, 0.0225
TICK_S, DURATION_S, SETTLED_S, EVERY_S = 0.01, 60.0, 10.0, 2.0
RUNS = 24
VEHICLE = Vehicle(
    id="coasting",
    mass_kg=MASS_KG,
    axle_positions_m=(0.0,),
    cog_height_m=0.0,
    wheelset_inertia_kgm2=(INERTIA_KGM2,),
    wheel_radius_m=(RADIUS_M,),
    brake_radius_m=(0.247,),
    track_resistance_n=RESISTANCE_N,
)
CHANNELS = (
    Channel(Quantity.SPEED, 0, "can0", "M", "v", SPEED_STD_MPS, 0.0, 0.5),
    Channel(Quantity.AXLE_SPEED, 0, "can0", "M", "n", OMEGA_STD_RADPS, 0.0, 0.5),
    Channel(Quantity.PRESSING_FORCE, 0, "can0", "M", "p", 50.0, 0.0, 0.5),
)


def coasting(density: float, rng: np.random.Generator) -> Iterator[tuple[float, list[Sample]]]:
    """d and what the sensors say of a wheelset that rolls on a line whose d wanders by `density` (m/s²)²/s."""
    inert_kg = MASS_KG + INERTIA_KGM2 / RADIUS_M**2
    speed_mps, deceleration_mps2 = SPEED_MPS, 0.0
    for tick in range(round(DURATION_S / TICK_S)):
        time_s = tick * TICK_S
        samples = []
        if tick % 2 == 0:
            omega_radps = speed_mps / RADIUS_M + OMEGA_STD_RADPS * rng.standard_normal()
            samples.append(Sample(time_s, Quantity.AXLE_SPEED, 0, omega_radps, Quality.GOOD))
        if tick % 5 == 0:
            told_mps = speed_mps + SPEED_STD_MPS * rng.standard_normal()
            samples.append(Sample(time_s, Quantity.PRESSING_FORCE, 0, 0.0, Quality.GOOD))
            samples.append(Sample(time_s, Quantity.SPEED, 0, told_mps, Quality.GOOD))
        yield deceleration_mps2, samples
        speed_mps -= (RESISTANCE_N + MASS_KG * deceleration_mps2) / inert_kg * TICK_S
        deceleration_mps2 += sqrt(density * TICK_S) * rng.standard_normal()


def normalised_errors(density: float) -> np.ndarray:
    """Errors of d over their published standard deviation, every two seconds of all runs."""
    found = []
    for seed in range(RUNS):
        estimator = Estimator(VEHICLE, EstimatorSettings(), CHANNELS)
        for tick, (deceleration_mps2, samples) in enumerate(coasting(density, np.random.default_rng(seed))):
            for sample in samples:
                estimator.take(sample)
            if tick * TICK_S >= SETTLED_S and tick % round(EVERY_S / TICK_S) == 0:
                now = estimator.estimate(tick * TICK_S)
                found.append((now.deceleration_mps2 - deceleration_mps2) / now.deceleration_std_mps2)
    return np.array(found)


def test_where_the_line_undulates_as_believed_the_interval_is_as_wide_as_need_be() -> None:
    errors = normalised_errors(WAGON.deceleration + WAGON.deceleration_per_metre * SPEED_MPS)
    assert 0.90 <= np.mean(np.abs(errors) < 1.96) <= 0.985
    assert np.mean(errors**2) == pytest.approx(1.0, abs=0.2)


def test_on_a_level_line_three_quarters_of_its_variance_are_for_what_does_not_happen() -> None:
    errors = normalised_errors(0.0)
    assert np.mean(errors**2) == pytest.approx(0.25, abs=0.05)
    assert np.mean(np.abs(errors) < 1.96) > 0.995
