"""A brake that holds the wagon on a mountain line: curves come and go, which no inclinometer sees.

Who holds the speed lets the brake go by what a curve takes from it. Read as tests of the pads, such forces say that
friction does less and less.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.validation.scores import longest_s

GRAVITY_MPS2 = 9.80665
VEHICLE = example_settings("wagon").vehicle
FRICTION, HELD_MPS, STEEP_FROM_M, SETTLED_S, END_S = 0.36, 8.0, 80.0, 20.0, 200.0
CURVE_M = 130.0  # so long are curves and straights in turn
STEP_N = 1500.0  # of a pressure that is regulated, per brake
SPEED_STD_MPS, FORCE_STD_N = 0.02, 100.0


def channels() -> list[Channel]:
    def channel(quantity: Quantity, i: int, std: float) -> Channel:
        return Channel(quantity, i, "can0", "M", f"{quantity}{i}", std, 0.0, 0.5)

    return [
        channel(Quantity.SPEED, 0, SPEED_STD_MPS),
        *(channel(Quantity.AXLE_SPEED, i, SPEED_STD_MPS) for i in range(2)),
        *(channel(Quantity.PRESSING_FORCE, i, FORCE_STD_N) for i in range(2)),
        channel(Quantity.GRADIENT, 0, 0.002),
    ]


def resistance(radius_m: float) -> float:
    """Of a curve, over the weight (Roeckl)."""
    return 0.65 / (radius_m - 55.0)


def held_down(gradient: float, radius_m: float, seed: int) -> Iterator[tuple[Estimate, float]]:
    """What is said ten times a second of a wagon that a driver holds, and the adhesion that it uses."""
    estimator, rng = Estimator(VEHICLE, EstimatorSettings(preset="wagon"), channels()), np.random.default_rng(seed)
    wheel_m = VEHICLE.wheel_radius_m[0]
    lever = VEHICLE.brake_radius_m[0] / wheel_m
    turning_kg = sum(inertia / wheel_m**2 for inertia in VEHICLE.wheelset_inertia_kgm2)
    speed_mps, position_m, wanted_n, force_n = HELD_MPS, 0.0, 0.0, 0.0
    for k in range(round(END_S * 100)):
        time_s = k / 100
        falls = gradient if position_m > STEEP_FROM_M else 0.0
        bends = resistance(radius_m) if (position_m / CURVE_M) % 2.0 > 1.0 else 0.0
        if k % 100 == 0:  # the driver
            needed_n = wanted_n + 4e3 * (speed_mps - HELD_MPS)
            wanted_n = max(STEP_N * round(needed_n / STEP_N), 0.0) if position_m > STEEP_FROM_M else 0.0
        force_n += (wanted_n - force_n) * 0.01 / 0.6
        braking_n = 2.0 * FRICTION * force_n * lever
        against_n = VEHICLE.resistance_n(speed_mps) + VEHICLE.mass_kg * GRAVITY_MPS2 * (falls + bends)
        deceleration_mps2 = (braking_n + against_n) / (VEHICLE.mass_kg + turning_kg)
        speed_mps -= 0.01 * deceleration_mps2
        position_m += 0.01 * speed_mps
        told = [(Quantity.PRESSING_FORCE, i, force_n, FORCE_STD_N) for i in range(2)]
        if k % 2 == 0:
            told += [(Quantity.AXLE_SPEED, i, speed_mps / wheel_m, SPEED_STD_MPS) for i in range(2)]
        if k % 5 == 0:
            told += [(Quantity.SPEED, 0, speed_mps, SPEED_STD_MPS), (Quantity.GRADIENT, 0, falls, 0.0)]
        for quantity, i, value, std in told:
            estimator.take(Sample(time_s, quantity, i, value + std * rng.standard_normal(), Quality.GOOD))
        if k % 10 == 0 and time_s > SETTLED_S:
            at_the_rail_n = braking_n - turning_kg * deceleration_mps2
            yield estimator.estimate(time_s), at_the_rail_n / VEHICLE.mass_kg / GRAVITY_MPS2


@pytest.mark.parametrize(("gradient", "radius_m"), [(-0.065, 150.0), (-0.05, 150.0), (-0.03, 300.0)])
@pytest.mark.parametrize("seed", [1, 2])
def test_what_curves_take_is_not_taken_for_pads_that_rub_less(gradient: float, radius_m: float, seed: int) -> None:
    said = list(held_down(gradient, radius_m, seed))
    time_s = np.array([now.time_s for now, _ in said])
    valid = np.array([now.status is Status.VALID for now, _ in said])
    off = np.array([now.adhesion - truth for now, truth in said])
    std = np.array([now.adhesion_std for now, _ in said])
    assert valid.mean() > 0.9
    assert longest_s(time_s, valid & (np.abs(off) > 3.0 * std)) < 1.0
    pads = [now.wheelsets[0] for now, _ in said]
    known = np.array([own.friction_status is Status.VALID for own in pads])
    friction_off, friction_std = (
        np.array(column) for column in zip(*((own.friction - FRICTION, own.friction_std) for own in pads), strict=True)
    )
    assert longest_s(time_s, known & (np.abs(friction_off) > 3.0 * friction_std)) < 1.0
