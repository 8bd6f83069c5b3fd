"""What the paper's covariances (20) cost: the adhesion they give is as noisy as their own gain makes it.

With (19) and (20) to the letter the filter expects friction and adhesion to jump in every step of 10 ms, so it follows
the noise of its sensors. How far follows from theory, without any run: the gain of the stationary filter (Riccati), and
what that gain makes of the noise that R states when nothing moves at all (Lyapunov). Of n such errors the largest is
about sqrt(2 ln n) standard deviations (extreme values of a normal distribution): no implementation of (20) does better.
"""

from math import log, sqrt

import numpy as np
import pytest

from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.brake_step import Conditions, StepLength, literal_step
from brake_monitor.estimation.model.regime import FixedDensities
from brake_monitor.estimation.model.tuning import PAPER_STEP_S, RIG
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.validation.cases import Case
from brake_monitor.validation.runs import drive, estimate
from brake_monitor.validation.scores import judged
from brake_monitor.validation.vehicles import PAPER_OMEGA_STD_RADPS, PAPER_SPEED_STD_MPS, campaign_settings
from wagons import jacobian

SPEED_MPS, FRICTION = 15.0, 0.35


def noise_of_adhesion() -> float:
    """Standard deviation of mu_w while the rig's wheelset rolls, from the sensors' noise alone."""
    wagon = Wagon.from_vehicle(campaign_settings("laboratory").vehicle)
    s, u = wagon.layout, wagon.inputs()
    x = np.zeros(s.size)
    x[0], x[s.speed], x[s.friction] = SPEED_MPS / wagon.wheelsets[0].wheel_radius_m, SPEED_MPS, FRICTION
    known = slice(0, s.deceleration)  # (19) has no d
    transition = np.eye(4) + jacobian(wagon, x, u)[known, known] * PAPER_STEP_S
    step_noise = np.diag([RIG.omega, RIG.speed, RIG.friction, RIG.adhesion]) * PAPER_STEP_S
    seen = np.eye(4)[:2]
    sensor_noise = np.diag([PAPER_OMEGA_STD_RADPS**2, PAPER_SPEED_STD_MPS**2])
    covariance, error = np.eye(4), np.zeros((4, 4))
    for _ in range(2000):
        covariance = transition @ covariance @ transition.T + step_noise
        gain = covariance @ seen.T @ np.linalg.inv(seen @ covariance @ seen.T + sensor_noise)
        covariance = (np.eye(4) - gain @ seen) @ covariance
    closed = (np.eye(4) - gain @ seen) @ transition
    for _ in range(2000):
        error = closed @ error @ closed.T + gain @ sensor_noise @ gain.T
    return float(sqrt(error[3, 3]))


def test_a_step_of_the_rig_adds_the_printed_q_and_nothing_else() -> None:
    wagon = Wagon.from_vehicle(campaign_settings("laboratory").vehicle)
    rubs = Acting(*[0.0] * len(Acting._fields))._replace(
        has_equation=1.0, friction_observable=1.0, omega_density=RIG.omega
    )
    densities = FixedDensities(*[getattr(RIG, name) for name in FixedDensities._fields])
    on_wagon = ActingOnWagon(wagon.vehicle.mass_kg, 0.0, RIG.deceleration, 0.0, heading=1.0, torque_error_density=0.0)
    now = Conditions(StepLength(PAPER_STEP_S, 0.0, 0.0), on_wagon, [rubs], densities)
    known = [[0.0] * wagon.layout.size for _ in range(wagon.layout.size)]
    q = np.zeros((wagon.layout.size, wagon.layout.size))
    q[:4, :4] = np.diag([1e1, 1e-5, 1e-3, 1e-1])
    assert np.array(literal_step(wagon, [SPEED_MPS] * wagon.layout.size, known, now).covariance) == pytest.approx(q)
    assert (RIG.omega_variance, RIG.speed_variance) == (1e-9, 1e-7)  # R


def test_the_adhesion_of_the_rig_preset_is_as_noisy_as_its_covariances_make_it() -> None:
    recording = drive("dry", "laboratory", Modifiers(), 0)
    rig = estimate(recording, Case("laboratory", "dry", "as_modelled", "rig").variant)
    counts = judged(rig) & (rig.truth.pressing_force_n[:, 0] == 0.0)  # braking, jitter of the frames' times adds to it
    errors = (rig.adhesion - rig.truth.adhesion)[counts]
    noise = noise_of_adhesion()
    assert errors.std() == pytest.approx(noise, rel=0.1)
    assert abs(errors.mean()) < 0.1 * noise
    assert np.abs(errors).max() == pytest.approx(noise * sqrt(2.0 * log(len(errors))), rel=0.2)
