"""Long slides on rails of which what they give changes with slip, under slide protection that vents wholly.

Past the peak of the creep curve slip falls as the brake vents, and the rail gives more; before it the rail takes up a
part of what the brake asks. Taken for the brake's, either made friction and d creep apart, both `valid`. So did pads
that rub less the harder they press: vented and filled, a brake shows how its torque changes. The motion is worked out
here from the force balances alone: m a = -R - sum mu_w F_z, J dω/dt = mu_w F_z r - mu_b F r_B, and a rail
whose mu_w rises to a peak and then stays, or falls with slip speed.
"""

from collections import deque
from functools import cache
from math import exp
from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from brake_monitor.estimation.estimate import Status
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle

MASS_KG, INERTIA_KGM2, RADIUS_M, BRAKE_RADIUS_M = 80_000.0, 118.0, 0.445, 0.247
RESISTANCE_N = 2300.0
POSITIONS_M = (9.4, 7.6, -7.6, -9.4)
N = len(POSITIONS_M)
LOAD_N = MASS_KG * 9.81 / N
FRICTION = (0.355, 0.345, 0.36, 0.34)
FULL_N = 115_000.0  # asks for more than any rail here gives
STEP_S = 2e-3
BRAKE_FROM_S, END_S = 6.0, 36.0
SLOWEST_MPS = 3.0
EARLY_SLIP, LATE_SLIP = 0.015, 0.08  # where the creep curve has its peak
FALL_SPM = 0.4  # by slip speed, as far as to ...
LEAST_SHARE = 0.5
VALVE_S = 0.07  # its delay
FILL_S, VENT_S = 0.4, 0.1  # time constants of the cylinders
VENTS_FROM, VENTS_UNTIL = 0.12, 0.02  # slip
SPEED_STD_MPS, RIM_STD_MPS = 0.02, 0.01
PRESSURES = 5  # every so many steps ...
WHEEL_SPEEDS, VEHICLE_SPEEDS = 2, 5  # ... and every so many of those
SETTLED_S = 9.0
DRAWS = 3, 5, 7  # of the noise: a single one may be a tenth off the mean

VEHICLE = Vehicle(
    id="test",
    mass_kg=MASS_KG,
    axle_positions_m=POSITIONS_M,
    cog_height_m=0.0,
    wheelset_inertia_kgm2=(INERTIA_KGM2,) * N,
    wheel_radius_m=(RADIUS_M,) * N,
    brake_radius_m=(BRAKE_RADIUS_M,) * N,
    track_resistance_n=RESISTANCE_N,
)
CHANNELS = [
    Channel(Quantity.SPEED, 0, "can0", "M", "v", SPEED_STD_MPS, 0.0, 0.5),
    *(Channel(Quantity.AXLE_SPEED, i, "can0", "M", f"n{i}", RIM_STD_MPS / RADIUS_M, 0.0, 0.5) for i in range(N)),
    *(Channel(Quantity.PRESSING_FORCE, i, "can0", "M", f"p{i}", 50.0, 0.0, 0.5) for i in range(N)),
]

Array = NDArray[np.float64]


class Instant(NamedTuple):
    """The truth; of each wheelset."""

    time_s: float
    speed_mps: float
    omega_radps: tuple[float, ...]
    pressing_force_n: tuple[float, ...]
    adhesion: float  # of the wagon
    friction: tuple[float, ...]


class Rail(NamedTuple):
    """What it gives at which slip."""

    peak: float
    peak_slip: float
    falls: bool  # beyond

    def utilised(self, slip_mps: float, speed_mps: float) -> float:
        """mu_w of a wheelset."""
        reached = min(max(slip_mps / speed_mps / self.peak_slip, 0.0), 1.0)
        rise = 1.0 - (1.0 - reached) ** 3
        share = LEAST_SHARE + (1.0 - LEAST_SHARE) * exp(-FALL_SPM * slip_mps) if self.falls else 1.0
        return self.peak * rise * share


class Wheelset:
    """With its brake. Plain numbers: a step takes a quarter of what it takes with arrays of four."""

    def __init__(self, speed_mps: float, friction: float, loss: float) -> None:
        self.omega_radps, self.force_n, self.friction = speed_mps / RADIUS_M, 0.0, friction
        self._level, self._loss = friction, loss
        self._vents = False
        self._valve = deque([False] * round(VALVE_S / STEP_S))  # what it is to do in this long

    def press(self, speed_mps: float, full_n: float) -> None:
        """Vent or fill the cylinder in one step."""
        slip_mps = speed_mps - self.omega_radps * RADIUS_M
        self._vents = slip_mps > (VENTS_UNTIL if self._vents else VENTS_FROM) * speed_mps
        self._valve.popleft()
        self._valve.append(self._vents)
        wanted_n = 0.0 if self._valve[0] else full_n
        self.force_n += (wanted_n - self.force_n) * STEP_S / (FILL_S if wanted_n > self.force_n else VENT_S)
        self.friction = self._level * (1.0 + self._loss * (0.5 - self.force_n / FULL_N))

    def turn(self, speed_mps: float, rail: Rail) -> float:
        """Take one step, implicit in omega, as the flank of the creep curve is steep; mu_w in it."""
        slip_mps, per_radps = speed_mps - self.omega_radps * RADIUS_M, 1e-3
        given = rail.utilised(slip_mps, speed_mps)
        slope = (rail.utilised(slip_mps - per_radps * RADIUS_M, speed_mps) - given) / per_radps
        brake_nm = self.friction * self.force_n * BRAKE_RADIUS_M
        change_radps = (given * LOAD_N * RADIUS_M - brake_nm) * STEP_S
        change_radps /= INERTIA_KGM2 - slope * LOAD_N * RADIUS_M * STEP_S
        self.omega_radps += change_radps
        return given + slope * change_radps


@cache
def told(rail: Rail, loss: float) -> list[Instant]:
    """The instants that any sensor tells of: braked from 36 m/s, down to SLOWEST_MPS where there is the time.

    `loss`: of friction, from no force to full.
    """
    speed_mps, instants = 36.0, []
    wheelsets = [Wheelset(speed_mps, friction, loss) for friction in FRICTION]
    for k in range(round(END_S / STEP_S)):
        if speed_mps < SLOWEST_MPS:
            break
        time_s, omega_radps = k * STEP_S, tuple(own.omega_radps for own in wheelsets)
        for own in wheelsets:
            own.press(speed_mps, FULL_N if time_s >= BRAKE_FROM_S else 0.0)
        used = sum([own.turn(speed_mps, rail) for own in wheelsets])
        if k % PRESSURES == 0:
            forces_n, friction = tuple(own.force_n for own in wheelsets), tuple(own.friction for own in wheelsets)
            instants.append(Instant(time_s, speed_mps, omega_radps, forces_n, used / N, friction))
        speed_mps -= (RESISTANCE_N + LOAD_N * used) / MASS_KG * STEP_S
    return instants


class Judged(NamedTuple):
    """After each reading of the vehicle speed: errors and published deviations; of friction, shapes (K, N)."""

    adhesion: Array
    adhesion_std: Array
    friction: Array
    friction_std: Array
    valid: NDArray[np.bool_]


@cache
def judged(rail: Rail, loss: float = 0.0, draw: int = 3) -> Judged:
    """Brake, and hold what is said against the truth; `draw`: of the sensors' noise."""
    rng = np.random.default_rng(draw)
    estimator = Estimator(VEHICLE, EstimatorSettings(), CHANNELS)
    rows = []

    def tell(now: Instant, quantity: Quantity, wheelset: int, value: float) -> None:
        estimator.take(Sample(now.time_s, quantity, wheelset, float(value), Quality.GOOD))

    for k, now in enumerate(told(rail, loss)):
        for i, force_n in enumerate(now.pressing_force_n):
            tell(now, Quantity.PRESSING_FORCE, i, max(force_n + 50.0 * rng.normal(), 0.0))
        if k % WHEEL_SPEEDS == 0:
            for i, omega_radps in enumerate(now.omega_radps):
                tell(now, Quantity.AXLE_SPEED, i, omega_radps + RIM_STD_MPS / RADIUS_M * rng.normal())
        if k % VEHICLE_SPEEDS == 0:
            tell(now, Quantity.SPEED, 0, now.speed_mps + SPEED_STD_MPS * rng.normal())
            if now.time_s > SETTLED_S:
                said = estimator.estimate()
                friction = np.array([own.friction for own in said.wheelsets]) - now.friction
                friction_std = np.array([own.friction_std for own in said.wheelsets])
                valid = said.status is Status.VALID
                rows.append((said.adhesion - now.adhesion, said.adhesion_std, friction, friction_std, valid))
    return Judged(*map(np.array, zip(*rows, strict=True)))


RAILS = pytest.mark.parametrize("falls", [True, False], ids=["falls", "steady"])
PEAKS = pytest.mark.parametrize("peak", [0.05, 0.10])


@PEAKS
@RAILS
def test_friction_does_not_creep_while_wheelsets_slide(peak: float, falls: bool) -> None:
    seen = judged(Rail(peak, EARLY_SLIP, falls))
    assert seen.valid.all()
    assert np.abs(seen.friction.mean(axis=1)).max() < 0.03
    assert np.mean(np.abs(seen.friction) < 3.0 * seen.friction_std) > 0.98


@PEAKS
@RAILS
def test_adhesion_stays_within_a_twentieth_or_so_of_what_the_rail_gives(peak: float, falls: bool) -> None:
    seen = [judged(Rail(peak, EARLY_SLIP, falls), draw=draw) for draw in DRAWS]
    assert np.sqrt(np.mean([np.mean(one.adhesion**2) for one in seen])) < 0.055 * peak
    assert np.mean([np.mean(np.abs(one.adhesion) < 1.96 * one.adhesion_std) for one in seen]) > 0.8


@PEAKS
def test_what_the_rail_takes_up_before_its_peak_is_not_taken_for_the_brakes(peak: float) -> None:
    seen = judged(Rail(peak, LATE_SLIP, falls=False))
    assert seen.valid.all()
    assert np.abs(seen.friction.mean(axis=1)).max() < 0.03
    assert np.mean(np.abs(seen.friction) < 3.0 * seen.friction_std) > 0.98
    assert np.sqrt(np.mean(seen.adhesion**2)) < 0.055 * peak
    assert np.mean(np.abs(seen.adhesion) < 1.96 * seen.adhesion_std) > 0.8


@RAILS
@pytest.mark.parametrize("loss", [0.1, -0.05])
def test_pads_that_rub_otherwise_the_harder_they_press_are_known_for_it(loss: float, falls: bool) -> None:
    """Organic pads lose some 5 to 10 % up to full force, 0.018 to 0.035 here: at most half of it may be left."""
    seen = judged(Rail(0.08, EARLY_SLIP, falls), loss)
    assert np.sqrt(np.mean(seen.friction**2)) < 0.0175
    assert np.mean(np.abs(seen.friction) < 1.96 * seen.friction_std) > 0.9
    assert np.mean(np.abs(seen.adhesion) < 1.96 * seen.adhesion_std) > 0.85
