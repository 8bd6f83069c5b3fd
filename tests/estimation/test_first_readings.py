"""A recording, or a daemon, may begin with any message of a wagon that runs: no coarse sensor is frozen by it."""

from collections.abc import Iterator
from dataclasses import replace
from math import sqrt

import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.processing.estimate_table import header, values
from brake_monitor.samples import Quality, Quantity, Sample
from brake_monitor.settings.example_vehicles import example_settings

START_S = 1.7e9
SETTINGS = example_settings("wagon")
RADIUS_M = SETTINGS.vehicle.wheel_radius_m[0]
STEP_MPS = 1.0 / 3.6


def coarse(speed_mps: float) -> float:
    """In steps of 1 km/h."""
    return round(speed_mps / STEP_MPS) * STEP_MPS


def sample(time_s: float, quantity: Quantity, value: float, wheelset: int = 0) -> Sample:
    return Sample(START_S + time_s, quantity, wheelset, value, Quality.GOOD)


def coasting(
    lead_s: float,
    *,
    begin_s: float = 0.0,
    speed_mps: float = 18.03,
    retardation_mps2: float = 0.02,
    stuck: bool = False,
) -> Iterator[Sample]:
    """Half a minute of wheel speeds every 20 ms, and a vehicle speed every 50 ms that comes `lead_s` before them."""
    told = []
    for k in range(1500):
        now_mps = speed_mps - retardation_mps2 * k * 0.02
        wheels = [sample(begin_s + k * 0.02, Quantity.AXLE_SPEED, coarse(now_mps) / RADIUS_M, i) for i in range(2)]
        told += wheels + [sample(begin_s + k * 0.02, Quantity.PRESSING_FORCE, 0.0, i) for i in range(2)]
    for k in range(600):
        now_mps = speed_mps if stuck else speed_mps - retardation_mps2 * k * 0.05
        told.append(sample(begin_s - lead_s + k * 0.05, Quantity.SPEED, coarse(now_mps)))
    return iter(sorted(told, key=lambda one: one.time_s))


def taken(estimator: Estimator, samples: Iterator[Sample]) -> list[Estimate]:
    estimates = []
    for one in samples:
        if estimator.take(one):
            estimates.append(estimator.estimate())
    return estimates


@pytest.fixture
def estimator() -> Estimator:
    """Of a wagon whose DBC tells speeds in these steps."""
    channels = [
        replace(one, noise_std=STEP_MPS / sqrt(12.0) / (RADIUS_M if one.quantity is Quantity.AXLE_SPEED else 1.0))
        if one.quantity in (Quantity.SPEED, Quantity.AXLE_SPEED)
        else one
        for one in SignalDecoder.from_settings(SETTINGS).channels
    ]
    return Estimator(SETTINGS.vehicle, SETTINGS.estimator, channels)


@pytest.mark.parametrize("lead_s", [0.013, -0.013], ids=["vehicle speed first", "wheel speeds first"])
def test_no_order_of_the_first_readings_makes_a_coarse_sensor_frozen(estimator: Estimator, lead_s: float) -> None:
    estimates = taken(estimator, coasting(lead_s))
    assert not any("frozen" in reason for now in estimates for reason in now.reasons)
    assert not any(now.status is Status.INVALID for now in estimates if now.time_s > START_S + 1.0)


@pytest.mark.parametrize("lead_s", [0.013, -0.013], ids=["vehicle speed first", "wheel speeds first"])
def test_nor_after_a_gap_in_which_the_wagon_became_faster(estimator: Estimator, lead_s: float) -> None:
    taken(estimator, coasting(lead_s, speed_mps=8.03))
    estimates = taken(estimator, coasting(lead_s, begin_s=90.0))
    assert not any("frozen" in reason for now in estimates for reason in now.reasons)


@pytest.mark.parametrize("lead_s", [0.013, -0.013], ids=["vehicle speed first", "wheel speeds first"])
def test_a_vehicle_speed_that_was_frozen_before_the_start_is_found_out(estimator: Estimator, lead_s: float) -> None:
    estimates = taken(estimator, coasting(lead_s, retardation_mps2=0.3, stuck=True))
    late = [now for now in estimates if now.time_s > START_S + 8.0]
    assert late
    assert all(now.status is Status.INVALID and any("frozen" in why for why in now.reasons) for now in late)


def test_a_wheelset_that_has_not_spoken_yet_neither_turns_nor_slides(estimator: Estimator) -> None:
    silent = [now for now in taken(estimator, coasting(0.213)) if not now.knows(Quantity.AXLE_SPEED)]
    assert len(silent) == 5
    for now in silent:
        row = dict(zip(header(2), values(now), strict=True))
        assert row["speed_mps"] > 17.0
        assert [row[name] for name in ("omega_1_radps", "omega_2_radps", "slip_1", "slip_2")] == [0.0] * 4
        assert not row["saturated"]


def test_a_wagon_that_runs_is_at_no_instant_said_to_stand(estimator: Estimator) -> None:
    statuses = [estimate.status for estimate in taken(estimator, coasting(0.01))]
    assert Status.HELD not in statuses
    assert statuses[-1] is Status.VALID
