"""A wheelset that turns slowly in a slide: its sensor, which counts teeth, is read more often than one passes.

The motion is worked out here from the force balances alone, of one wheelset: m a = -R - mu_w m g and
J dω/dt = mu_w m g r - mu_b F r_B.
"""

from collections.abc import Iterator
from dataclasses import replace
from math import floor, tau
from typing import NamedTuple

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

WEIGHT_N, MASS_KG, INERTIA_KGM2, RADIUS_M, BRAKE_RADIUS_M = 176_580.0, 18_000.0, 118.0, 0.445, 0.247
RESISTANCE_N, FRICTION, FULL_N = 900.0, 0.35, 45_000.0
ROLLING_KG = INERTIA_KGM2 / RADIUS_M**2
SLIPPERY = 0.02
STEP_S = 1e-3
INITIAL_MPS, BRAKE_FROM_S, SLIPPERY_FROM_S, JUDGED_FROM_S, END_S = 22.0, 4.0, 6.0, 6.5, 14.0
AIR_S = 0.1  # in which a brake is vented or filled
VENTED_BELOW_MPS, FILLED_ABOVE_MPS = 1.1, 1.0
SPEED_STD_MPS, OMEGA_STD_RADPS = 0.02, 0.0225
LARGE_ERROR = 0.02

VEHICLE = Vehicle(
    id="test",
    mass_kg=MASS_KG,
    axle_positions_m=(0.0,),
    cog_height_m=0.0,
    wheelset_inertia_kgm2=(INERTIA_KGM2,),
    wheel_radius_m=(RADIUS_M,),
    brake_radius_m=(BRAKE_RADIUS_M,),
    track_resistance_n=RESISTANCE_N,
)
CHANNELS = [
    Channel(Quantity.SPEED, 0, "can0", "M", "v", SPEED_STD_MPS, 0.0, 0.5),
    Channel(Quantity.AXLE_SPEED, 0, "can0", "M", "n", OMEGA_STD_RADPS, 0.0, 0.5),
    Channel(Quantity.PRESSING_FORCE, 0, "can0", "M", "p", 50.0, 0.0, 0.5),
]


class Instant(NamedTuple):
    """The truth, and what the pole wheel's sensor says."""

    time_s: float
    speed_mps: float
    omega_radps: float
    told_radps: float
    pressing_force_n: float
    adhesion: float


class PoleWheel:
    """The time from tooth to tooth gives its reading; while none passes, that is at most what their distance allows."""

    def __init__(self, teeth: int, omega_radps: float) -> None:
        self._tooth_rad = tau / teeth
        self._took_s, self._passed_s = self._tooth_rad / omega_radps, 0.0
        self._teeth_passed = 0.0

    def turn(self, time_s: float, by_rad: float) -> float:
        """Turn by so much until this time; what is read then."""
        before = self._teeth_passed
        self._teeth_passed += by_rad / self._tooth_rad
        if passed := floor(self._teeth_passed) - floor(before):
            since = (self._teeth_passed % 1.0) / (self._teeth_passed - before)
            edge_s = time_s - since * STEP_S
            self._took_s, self._passed_s = (edge_s - self._passed_s) / passed, edge_s
        return self._tooth_rad / max(self._took_s, time_s - self._passed_s)


def motion(teeth: int) -> Iterator[Instant]:
    """It rolls until slide protection, which acts late, has to keep it turning, at about 1 m/s."""
    speed_mps, omega_radps, force_n, vents = INITIAL_MPS, INITIAL_MPS / RADIUS_M, 0.0, False
    wheel = PoleWheel(teeth, omega_radps)
    for k in range(round(END_S / STEP_S)):
        time_s, slides = k * STEP_S, k * STEP_S >= SLIPPERY_FROM_S
        vents = omega_radps * RADIUS_M < (FILLED_ABOVE_MPS if vents else VENTED_BELOW_MPS)
        wanted_n = FULL_N if time_s >= BRAKE_FROM_S and not vents else 0.0
        force_n += (wanted_n - force_n) * STEP_S / AIR_S
        asked = FRICTION * force_n * BRAKE_RADIUS_M / RADIUS_M / WEIGHT_N
        rolling_mps2 = (RESISTANCE_N + asked * WEIGHT_N) / (MASS_KG + ROLLING_KG)
        adhesion = SLIPPERY if slides else asked - ROLLING_KG * rolling_mps2 / WEIGHT_N
        speed_mps -= (RESISTANCE_N + adhesion * WEIGHT_N) / MASS_KG * STEP_S
        if slides:
            omega_radps = max(omega_radps + (adhesion - asked) * WEIGHT_N * RADIUS_M / INERTIA_KGM2 * STEP_S, 0.0)
        else:
            omega_radps = speed_mps / RADIUS_M
        told_radps = wheel.turn(time_s, omega_radps * STEP_S)
        yield Instant(time_s, speed_mps, omega_radps, told_radps, force_n, adhesion)


def samples(truth: list[Instant]) -> Iterator[Sample]:
    """Wheel speeds every 20 ms, the vehicle's every 50 ms, forces every 10 ms."""
    rng = np.random.default_rng(1)
    for k, now in enumerate(truth):
        if k % 10 == 0:
            yield Sample(now.time_s, Quantity.PRESSING_FORCE, 0, now.pressing_force_n, Quality.GOOD)
        if k % 20 == 0:
            yield Sample(now.time_s, Quantity.AXLE_SPEED, 0, now.told_radps, Quality.GOOD)
        if k % 50 == 0:
            yield Sample(now.time_s, Quantity.SPEED, 0, now.speed_mps + rng.normal() * SPEED_STD_MPS, Quality.GOOD)


def estimates(teeth: int, delay_s: float = 0.0) -> Iterator[tuple[float, Estimate]]:
    """Of the time in which it slides, by when; all readings come so late, and wait for each other."""
    estimator = Estimator(VEHICLE, EstimatorSettings(), [replace(channel, delay_s=delay_s) for channel in CHANNELS])
    for sample in samples(list(motion(teeth))):
        late = sample._replace(time_s=sample.time_s + delay_s)
        if estimator.take(late) and sample.time_s > JUDGED_FROM_S:
            yield sample.time_s, estimator.estimate()


@pytest.mark.parametrize("teeth", [60, 80, 100])
def test_a_reading_that_waits_for_a_tooth_tells_nothing_new(teeth: int) -> None:
    """Taken for true, it would say that the wheelset falls no further: that the rail gives all that its brake asks."""
    found = list(estimates(teeth))
    assert found[-1][0] > END_S - 3.0
    for _, told in found:
        assert told.status is Status.VALID
        assert abs(told.adhesion - SLIPPERY) < LARGE_ERROR


def test_nor_does_one_that_has_waited_for_others() -> None:
    at_once, late = list(estimates(60)), list(estimates(60, delay_s=0.05))
    assert [at_s for at_s, _ in at_once] == [at_s for at_s, _ in late]
    for (_, told), (_, told_late) in zip(at_once, late, strict=True):
        assert told_late.adhesion == pytest.approx(told.adhesion, abs=1e-9)
