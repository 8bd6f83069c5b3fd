"""What the filter must know of what the wagon does: which states may move now, how fast, and which are held."""

from collections.abc import Sequence
from typing import NamedTuple

from brake_monitor.estimation.doubts.force_departure import CONTACT_S
from brake_monitor.estimation.kalman.ekf import Matrix, Vector, zeros
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.state_layout import StateLayout

SLOW_SPEED_DENSITY = 1.0  # (m/s)²/s and (rad/s)²/s, near standstill, where the measurements alone count
STUCK_FRICTION_STD = 0.05  # of pads that do not slide, or have begun to: friction rises by up to a quarter there
STUCK_FRICTION_DENSITY = STUCK_FRICTION_STD**2 / CONTACT_S  # 1/s
SLOW_ADHESION_DENSITY = 0.01  # 1/s, near standstill: the adhesion before the stop says nothing after a second
SLOW_ADHESION_S = 1.0  # how long its error then has to do with those of other states


class FixedDensities(NamedTuple):
    """The spectral densities that are the same in every step, as in `Tuning`; the core sets the others."""

    speed: float
    friction: float
    friction_own: float
    adhesion: float
    deceleration_per_metre: float
    adhesion_decay: float
    uptake: float


def density(
    layout: StateLayout, fixed: FixedDensities, on_wagon: ActingOnWagon, acting: Sequence[Acting], speed_mps: float
) -> Matrix:
    """Q, spectral density of the process noise, shape (n, n). d walks with time, and with distance at this speed."""
    s, q = layout, zeros(layout.size)
    q[s.speed][s.speed] = fixed.speed
    q[s.deceleration][s.deceleration] = on_wagon.deceleration_density + fixed.deceleration_per_metre * speed_mps
    q[s.decay][s.decay] = fixed.adhesion_decay * sum([own.slides for own in acting]) / len(acting)
    for place in range(s.torque_error.start, s.torque_error.stop):
        q[place][place] = on_wagon.torque_error_density
    uptake = fixed.uptake * sum([own.unsettled for own in acting]) / len(acting)
    for place in range(s.uptake.start, s.uptake.stop):
        q[place][place] = uptake
    for i, own in enumerate(acting):
        q[i][i] = own.omega_density
        for j, other in enumerate(acting):
            anew = own.stuck_lately * other.stuck_lately * STUCK_FRICTION_DENSITY  # all alike: they are pads of a kind
            friction = (
                own.friction_observable * other.friction_observable * (fixed.friction + (i == j) * fixed.friction_own)
                + anew
            )
            q[s.friction.start + i][s.friction.start + j] = friction
            q[s.adhesion.start + i][s.adhesion.start + j] = fixed.adhesion + (i == j) * own.adhesion_density
    return q


def free_states(layout: StateLayout, near_standstill: bool, friction_observable: Sequence[float]) -> Vector:
    """1 for states that an innovation may correct, 0 for held ones, n numbers; near standstill all but the speeds."""
    if near_standstill:
        return [1.0] * (layout.speed + 1) + [0.0] * (layout.size - layout.speed - 1)
    free = [1.0] * layout.size
    free[layout.friction] = friction_observable
    return free
