"""What the filter must know of what the wagon does: which states may move now, how fast, and which are held."""

from collections.abc import Sequence
from typing import NamedTuple

from brake_monitor.estimation.ekf import Matrix, Vector, zeros
from brake_monitor.estimation.model.wagon import StateLayout

SLOW_SPEED_DENSITY = 1.0  # (m/s)²/s and (rad/s)²/s, near standstill, where the measurements alone count
STOOD_FRICTION_STD = 0.05  # of pads that stand on their discs, or slide anew: friction rises by up to a quarter there
STOOD_FRICTION_DENSITY = STOOD_FRICTION_STD**2 / 1.5  # 1/s: contact patches grow and decay in 1.5 s (Ostermeyer)
SLOW_ADHESION_DENSITY = 0.01  # 1/s, there: within a second what was in use before the stop says nothing any more


class Regime(NamedTuple):
    """What the wagon does, in numbers; sequences have length N, flags are 0 or 1."""

    observed: Sequence[float]  # mu_b,i may move and be corrected
    stood: Sequence[float]  # mu_b,i moves unseen, or did
    rolls: Sequence[float]  # mu_w,i follows the brake torque
    unsettled: Sequence[float]  # the wheelset slid lately
    turns: Sequence[float]  # the wheel equation holds
    omega: Sequence[float]  # the spectral densities of the process noise, as in `Tuning`
    speed: float
    friction: float
    friction_own: float
    adhesion: float
    adhesion_own: Sequence[float]
    deceleration: float
    adhesion_decay: float
    uptake: float


def density(regime: Regime, layout: StateLayout) -> Matrix:
    """Q, spectral density of the process noise, shape (n, n)."""
    s, q = layout, zeros(layout.size)
    q[s.speed][s.speed] = regime.speed
    q[s.deceleration][s.deceleration] = regime.deceleration
    q[s.decay][s.decay] = regime.adhesion_decay
    for i in range(s.uptake.start, s.uptake.stop):
        q[i][i] = regime.uptake
    for i in range(s.wheelset_count):
        q[i][i] = regime.omega[i]
        for j in range(s.wheelset_count):
            moving = regime.observed[i] * regime.observed[j]
            anew = regime.stood[i] * regime.stood[j] * STOOD_FRICTION_DENSITY  # alike: they are pads of a kind
            friction = moving * (regime.friction + (i == j) * regime.friction_own) + anew
            q[s.friction.start + i][s.friction.start + j] = friction
            q[s.adhesion.start + i][s.adhesion.start + j] = regime.adhesion + (i == j) * regime.adhesion_own[i]
    return q


def free_states(layout: StateLayout, slow: bool, observed: Sequence[float]) -> Vector:
    """1 for states that an innovation may correct, 0 for held ones, n numbers; near standstill all but the speeds."""
    if slow:
        return [1.0] * (layout.speed + 1) + [0.0] * (layout.size - layout.speed - 1)
    free = [1.0] * layout.size
    free[layout.friction] = observed
    return free
