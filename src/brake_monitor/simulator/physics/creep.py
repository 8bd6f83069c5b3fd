"""Wheel-rail creep force after Polach (2005), with friction that falls with the slip velocity.

mu  = mu0 [(1 - A) exp(-B w) + A]                   w: slip velocity, m/s
eps = G pi a b c11 s / (4 Q mu)                     s: slip, Q: wheelset load, N
F/Q = (2 mu / pi) [k_A eps / (1 + (k_A eps)^2) + atan(k_S eps)]
"""

import math
from typing import NamedTuple

from brake_monitor.simulator.physics.compiled import compiled

SHEAR_MODULUS_PA = 84e9
CONTACT_SEMI_AXES_M = (6.5e-3, 6.0e-3)  # along and across the rail
KALKER_C11 = 4.1
CONTACT_STIFFNESS_N = SHEAR_MODULUS_PA * math.pi * CONTACT_SEMI_AXES_M[0] * CONTACT_SEMI_AXES_M[1] * KALKER_C11 / 4.0
SLIP_REFERENCE_FLOOR_MPS = 0.1  # slip is undefined at standstill; below this speed the creep law turns viscous


class CreepLaw(NamedTuple):
    """Polach's parameters for one state of the rail surface."""

    adhesion_reduction: float  # k_A, area of adhesion
    slip_reduction: float  # k_S, area of slip
    friction_ratio: float  # A, friction at infinite over friction at zero slip velocity
    friction_decay_spm: float  # B, s/m


DRY = CreepLaw(1.0, 0.40, 0.40, 0.60)
WET = CreepLaw(0.30, 0.10, 0.40, 0.20)
WET_BELOW_MU0 = 0.30
DRY_ABOVE_MU0 = 0.55


@compiled
def law_for(mu0: float) -> CreepLaw:
    """Creep law of a rail with friction level mu0: wet (or contaminated) below 0.30, dry from 0.55, mixed between."""
    if mu0 <= WET_BELOW_MU0:
        return WET
    dry = min((mu0 - WET_BELOW_MU0) / (DRY_ABOVE_MU0 - WET_BELOW_MU0), 1.0)
    return CreepLaw(
        WET.adhesion_reduction + dry * (DRY.adhesion_reduction - WET.adhesion_reduction),
        WET.slip_reduction + dry * (DRY.slip_reduction - WET.slip_reduction),
        WET.friction_ratio + dry * (DRY.friction_ratio - WET.friction_ratio),
        WET.friction_decay_spm + dry * (DRY.friction_decay_spm - WET.friction_decay_spm),
    )


@compiled
def utilisation(
    slip_speed_mps: float, speed_mps: float, load_n: float, mu0: float, law: CreepLaw
) -> tuple[float, float]:
    """F/Q of one wheelset and its derivative by the slip velocity (s/m), at constant speed.

    `slip_speed_mps` is v - omega r, positive while braking; the result has its sign. A negative derivative
    means that the wheelset is past the peak of its creep curve.
    """
    w = abs(slip_speed_mps)
    decay = mu0 * (1.0 - law.friction_ratio) * math.exp(-law.friction_decay_spm * w)
    mu = decay + mu0 * law.friction_ratio
    mu_slope = -law.friction_decay_spm * decay
    eps_per_mps = CONTACT_STIFFNESS_N / (max(abs(speed_mps), SLIP_REFERENCE_FLOOR_MPS) * load_n * mu)
    eps = eps_per_mps * w
    eps_slope = eps_per_mps - eps * mu_slope / mu
    sticking = law.adhesion_reduction * eps
    sliding = law.slip_reduction * eps
    sticking_square = 1.0 + sticking * sticking
    shape = sticking / sticking_square + math.atan(sliding)
    shape_slope = eps_slope * (
        law.adhesion_reduction * (2.0 - sticking_square) / (sticking_square * sticking_square)
        + law.slip_reduction / (1.0 + sliding * sliding)
    )
    value = 2.0 / math.pi * mu * shape
    slope = 2.0 / math.pi * (mu_slope * shape + mu * shape_slope)
    return (value if slip_speed_mps >= 0.0 else -value), slope
