"""What the state of a wagon can be: bounds far beyond any wagon, within which the filter is kept."""

from math import inf

from brake_monitor.estimation.kalman.ekf import Matrix, Vector
from brake_monitor.estimation.model.state_layout import StateLayout

FRICTION_RANGE = (0.02, 1.0)
ADHESION_RANGE = (-0.8, 0.8)
FORCE_EFFECT_RANGE = (-0.6, 0.6)
DECAY_RANGE = (-0.5, 1.0)  # s/m
UPTAKE_RANGE = (-1.0, 1.5)
LAG_RANGE = (-0.12, 0.5)  # s; below 0 it is the pressing forces that come late
TORQUE_ERROR_RANGE = (-0.5, 0.5)
LARGEST_DECELERATION_MPS2 = 3.0  # of what the model leaves out: a train that stops, and pulls the wagon at its coupler
LARGEST = 1e100  # a number beyond this is not finite enough: a few of them must still add up to a finite one


def physical_range(s: StateLayout) -> tuple[Vector, Vector]:
    """The least and the greatest that each state can be."""
    lower, upper = [-inf] * s.size, [inf] * s.size
    lower[s.kinematic] = [0.0] * (s.speed + 1)
    for block, (least, greatest) in ((s.friction, FRICTION_RANGE), (s.adhesion, ADHESION_RANGE)):
        lower[block], upper[block] = [least] * s.wheelset_count, [greatest] * s.wheelset_count
    lower[s.deceleration], upper[s.deceleration] = -LARGEST_DECELERATION_MPS2, LARGEST_DECELERATION_MPS2
    lower[s.force_effect], upper[s.force_effect] = FORCE_EFFECT_RANGE
    lower[s.decay], upper[s.decay] = DECAY_RANGE
    for place in range(s.uptake.start, s.uptake.stop):
        lower[place], upper[place] = UPTAKE_RANGE
    lower[s.lag], upper[s.lag] = LAG_RANGE
    for place in range(s.torque_error.start, s.torque_error.stop):
        lower[place], upper[place] = TORQUE_ERROR_RANGE
    return lower, upper


def is_physical(x: Vector, covariance: Matrix, least: Vector, most: Vector) -> bool:
    """Whether a state is finite and within its bounds, and its variances are finite and not negative."""
    holds = covariance[0][0] >= 0.0
    for i, value in enumerate(x):
        holds = holds & (least[i] <= value) & (value <= min(most[i], LARGEST))
        holds = holds & (covariance[i][i] >= 0.0) & (covariance[i][i] <= LARGEST)
    return holds
