"""What the wagon is doing, as far as the filter must know: which states may move now, how fast, and which are held."""

from collections.abc import Sequence
from typing import NamedTuple

from brake_monitor.ekf import Matrix, Vector, zeros
from brake_monitor.tuning import Tuning
from brake_monitor.wagon import StateLayout

UNKNOWN_TORQUE_DENSITY = 40.0  # (rad/s)²/s, for a wheelset whose equation cannot be used
SLOW_SPEED_DENSITY = 1.0  # (m/s)²/s and (rad/s)²/s, near standstill, where the measurements alone count

Flags = tuple[bool, ...]  # one per wheelset


class Regime(NamedTuple):
    """Conditions that hold over one step of the filter."""

    slow: bool  # near standstill: parameters are held, speeds are as measured
    braking: bool  # a pad presses
    observed: Flags  # mu_b,i shows itself (17): pressed, turning, measured
    unsettled: Flags  # the wheelset slid lately: which share of a changing torque the rail takes up is in doubt
    quick: Flags  # the wheelset slides, or its WSP acts: its adhesion may change at once
    turning: Flags  # not locked: the wheel equation holds
    torque_known: Flags  # the pressing force is measured


class Terms(NamedTuple):
    """What a regime means to the filter beside standstill, in numbers; sequences have length N, flags are 0 or 1."""

    observed: Sequence[float]  # mu_b,i may move and be corrected
    rolls: Sequence[float]  # mu_w,i follows the brake torque
    unsettled: Sequence[float]
    turns: Sequence[float]
    omega: Sequence[float]  # the spectral densities of the process noise, as in `Tuning`
    speed: float
    friction: float
    friction_own: float
    adhesion: float
    adhesion_own: Sequence[float]
    deceleration: float


def terms(regime: Regime, tuning: Tuning) -> Terms:
    """All of them."""
    wheels = tuple(zip(regime.turning, regime.quick, regime.torque_known, strict=True))
    return Terms(
        observed=_numbers(regime.observed),
        rolls=_numbers([turning and not quick for turning, quick, _ in wheels]),
        unsettled=_numbers(regime.unsettled),
        turns=_numbers(regime.turning),
        omega=[tuning.omega if turning and known else UNKNOWN_TORQUE_DENSITY for turning, _, known in wheels],
        speed=tuning.speed,
        friction=tuning.friction,
        friction_own=tuning.friction_own,
        adhesion=tuning.adhesion,
        adhesion_own=[
            tuning.adhesion_sliding if quick or not known else tuning.adhesion_own for _, quick, known in wheels
        ],
        deceleration=tuning.deceleration_braking if regime.braking else tuning.deceleration,
    )


def density(terms: Terms, layout: StateLayout) -> Matrix:
    """Q, spectral density of the process noise, shape (n, n)."""
    s, q = layout, zeros(layout.size)
    q[s.speed][s.speed] = terms.speed
    q[s.deceleration][s.deceleration] = terms.deceleration
    for i in range(s.wheelset_count):
        q[i][i] = terms.omega[i]
        for j in range(s.wheelset_count):
            moving = terms.observed[i] * terms.observed[j]
            q[s.friction.start + i][s.friction.start + j] = moving * (terms.friction + (i == j) * terms.friction_own)
            q[s.adhesion.start + i][s.adhesion.start + j] = terms.adhesion + (i == j) * terms.adhesion_own[i]
    return q


def free_states(observed: Sequence[float], layout: StateLayout) -> Vector:
    """1 for states that an innovation may correct, 0 for held ones, n numbers."""
    free = [1.0] * layout.size
    free[layout.friction] = observed
    return free


def _numbers(flags: Sequence[bool]) -> Vector:
    """Flags to multiply by."""
    return [float(flag) for flag in flags]
