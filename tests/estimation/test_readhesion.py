"""A wheelset that slides comes onto dry rail, which pulls it up to rolling harder than any brake, and then no more.

The motion is worked out here from the force balances alone: m a = -R - sum mu_w F_z, J dω/dt = mu_w F_z r - mu_b F r_B.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

MASS_KG, INERTIA_KGM2, RADIUS_M, BRAKE_RADIUS_M = 36_000.0, 118.0, 0.445, 0.247
RESISTANCE_N, FRICTION, PRESSING_FORCE_N = 1800.0, 0.35, 40_000.0
LOAD_N = MASS_KG * 9.81 / 2.0
ASKED_PN = FRICTION * BRAKE_RADIUS_M / RADIUS_M / LOAD_N  # of the rail, per pressing force
ROLLING_KG = INERTIA_KGM2 / RADIUS_M**2
STEP_S = 2e-4
TOLD = 50  # every so many steps
BRAKE_FROM_S, JUDGED_FROM_S = 4.0, 6.0
SLIPPERY = 0.03
VENTED_N = 8_000.0  # as slide protection leaves it
VENTED_SLIP = 0.1
DEEP_SLIP = 0.3
REFILLED_S = 0.5  # after it has found hold
SPEED_STD_MPS, OMEGA_STD_RADPS = 0.02, 0.0225
LONGEST_S = 0.05  # of an adhesion that is wrong by more than ...
LONGEST_ON_PATCHES_S = 0.065  # three readings: pulls begin and end between two
LARGE_ERROR = 0.02

VEHICLE = Vehicle(
    id="test",
    mass_kg=MASS_KG,
    axle_positions_m=(4.5, -4.5),
    cog_height_m=0.0,
    wheelset_inertia_kgm2=(INERTIA_KGM2, INERTIA_KGM2),
    wheel_radius_m=(RADIUS_M, RADIUS_M),
    brake_radius_m=(BRAKE_RADIUS_M, BRAKE_RADIUS_M),
    track_resistance_n=RESISTANCE_N,
)
CHANNELS = [
    Channel(Quantity.SPEED, 0, "can0", "M", "v", SPEED_STD_MPS, 0.0, 0.5),
    *(Channel(Quantity.AXLE_SPEED, i, "can0", "M", f"n{i}", OMEGA_STD_RADPS, 0.0, 0.5) for i in range(2)),
    *(Channel(Quantity.PRESSING_FORCE, i, "can0", "M", f"p{i}", 50.0, 0.0, 0.5) for i in range(2)),
]


class Instant(NamedTuple):
    """The truth."""

    time_s: float
    speed_mps: float
    omega_radps: tuple[float, float]
    pressing_force_n: tuple[float, float]
    adhesion: float  # of the wagon


def motion(
    slippery_s: Sequence[tuple[float, float]], dry: float, end_s: float, vented_slip: float = VENTED_SLIP
) -> list[Instant]:
    """The leading wheelset slides where its rail is slippery; elsewhere that gives as much as `dry`."""
    slippery = {k for from_s, to_s in slippery_s for k in range(round(from_s / STEP_S), round(to_s / STEP_S))}
    speed_mps, omega_radps, force_n = 30.0, 30.0 / RADIUS_M, 0.0
    slides, vents, slid_s, instants = False, False, -np.inf, []
    for k in range(round(end_s / STEP_S)):
        time_s = k * STEP_S
        full_n = PRESSING_FORCE_N if time_s >= BRAKE_FROM_S else 0.0
        vents = vents or 1.0 - omega_radps * RADIUS_M / speed_mps > vented_slip
        force_n += ((VENTED_N if vents else full_n) - force_n) * STEP_S / 0.1
        is_slippery = k in slippery
        slides = slides or is_slippery
        # what rolls uses of the rail what brake and inertia ask for
        given = SLIPPERY if is_slippery else dry
        leading, other = given if slides else ASKED_PN * force_n, ASKED_PN * full_n
        retardation_mps2 = (RESISTANCE_N + LOAD_N * (leading + other)) / (MASS_KG + ROLLING_KG * (1 if slides else 2))
        turning = ROLLING_KG * retardation_mps2 / LOAD_N  # what a rolling wheelset's inertia gives
        other -= turning
        speed_mps -= retardation_mps2 * STEP_S
        if slides:
            torque_nm = leading * LOAD_N * RADIUS_M - FRICTION * force_n * BRAKE_RADIUS_M
            omega_radps += torque_nm / INERTIA_KGM2 * STEP_S
            slides = omega_radps * RADIUS_M < speed_mps
        else:
            leading -= turning
        if slides:
            slid_s = time_s
        else:
            omega_radps, vents = speed_mps / RADIUS_M, vents and time_s < slid_s + REFILLED_S
        if k % TOLD == 0:
            turns = (omega_radps, speed_mps / RADIUS_M)
            instants.append(Instant(time_s, speed_mps, turns, (force_n, full_n), (leading + other) / 2.0))
    return instants


def samples(truth: list[Instant], seed: int) -> Iterator[Sample]:
    """Wheel speeds every 20 ms, the vehicle's every 50 ms, forces every 10 ms."""
    rng = np.random.default_rng(seed)
    for k, now in enumerate(truth):
        for i in range(2):
            yield Sample(now.time_s, Quantity.PRESSING_FORCE, i, now.pressing_force_n[i], Quality.GOOD)
        if k % 2 == 0:
            for i in range(2):
                omega_radps = now.omega_radps[i] + rng.normal() * OMEGA_STD_RADPS
                yield Sample(now.time_s, Quantity.AXLE_SPEED, i, omega_radps, Quality.GOOD)
        if k % 5 == 0:
            speed_mps = now.speed_mps + rng.normal() * SPEED_STD_MPS
            yield Sample(now.time_s, Quantity.SPEED, 0, speed_mps, Quality.GOOD)


def estimates(truth: list[Instant]) -> list[Estimate]:
    """After each speed."""
    estimator = Estimator(VEHICLE, EstimatorSettings(), CHANNELS)
    told: list[Estimate] = []
    for sample in samples(truth, seed=1):
        if estimator.take(sample):
            told.append(estimator.estimate())
    return told


def longest_wrong_s(truth: list[Instant]) -> float:
    """How long adhesion is wrong by more than LARGE_ERROR at a time, once brakes are on."""
    told = estimates(truth)
    assert told[-1].status is Status.VALID
    wrong_s, since_s = 0.0, None
    for now in told:
        error = now.adhesion - truth[round(now.time_s / STEP_S / TOLD)].adhesion
        if now.time_s < JUDGED_FROM_S or abs(error) <= LARGE_ERROR:
            since_s = None
            continue
        since_s = now.time_s if since_s is None else since_s
        wrong_s = max(wrong_s, now.time_s - since_s)
    return wrong_s


@pytest.mark.parametrize("dry", [0.12, 0.17, 0.22, 0.28, 0.36, 0.44])
@pytest.mark.parametrize("phase_s", [0.0, 0.004, 0.008, 0.012, 0.016])
def test_the_end_of_a_pull_is_no_outlier(dry: float, phase_s: float) -> None:
    truth = motion([(10.0, 11.0 + phase_s)], dry, end_s=12.5)
    assert min(now.omega_radps[0] * RADIUS_M / now.speed_mps for now in truth) < 1.0 - VENTED_SLIP  # it slid
    assert longest_wrong_s(truth) <= LONGEST_S


@pytest.mark.parametrize("dry", [0.28, 0.36, 0.44])
@pytest.mark.parametrize("phase_s", [0.0, 0.004, 0.008, 0.012, 0.016])
def test_what_a_pull_takes_from_the_wagon_is_known_with_it(dry: float, phase_s: float) -> None:
    """Else the speed contradicts the forces afterwards, and friction and line are learned of what never was."""
    truth = motion([(10.0, 11.0 + phase_s)], dry, end_s=13.0, vented_slip=DEEP_SLIP)
    after = [now for now in estimates(truth) if now.time_s > 11.1]
    off_mps = [now.speed_mps - truth[round(now.time_s / STEP_S / TOLD)].speed_mps for now in after]
    assert np.abs(off_mps).max() < 2.0 * SPEED_STD_MPS
    assert {now.status for now in after} == {Status.VALID}
    assert max(abs(own.friction - FRICTION) for now in after for own in now.wheelsets) < 0.02


@pytest.mark.parametrize("dry", [0.17, 0.22, 0.28])
@pytest.mark.parametrize("phase_s", [0.0, 0.008, 0.016])
def test_nor_is_it_a_spike_on_a_rail_of_patches(dry: float, phase_s: float) -> None:
    """A pull that ends is not where it was foretold to be, again and again, but does not come back either."""
    truth = motion([(from_s, from_s + 1.0 + phase_s) for from_s in (6.0, 8.0, 10.0)], dry, end_s=13.0)
    assert longest_wrong_s(truth) <= LONGEST_ON_PATCHES_S
