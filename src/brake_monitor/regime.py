"""What the wagon is doing, as far as the filter must know: which states may move now, how fast, and which are held."""

from typing import NamedTuple

import numpy as np

from brake_monitor.tuning import Tuning
from brake_monitor.wagon import Array, StateLayout

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


def density(regime: Regime, tuning: Tuning, layout: StateLayout) -> Array:
    """Q, spectral density of the process noise, shape (n, n)."""
    s, n = layout, layout.wheelset_count
    q = np.zeros((s.size, s.size))
    if regime.slow:
        q[s.kinematic, s.kinematic] = SLOW_SPEED_DENSITY * np.eye(n + 1)
        return q
    own_wheel = [
        tuning.omega if turning and known else UNKNOWN_TORQUE_DENSITY
        for turning, known in zip(regime.turning, regime.torque_known, strict=True)
    ]
    q[s.omega, s.omega] = np.diag(own_wheel)
    q[s.speed, s.speed] = tuning.speed
    moving = np.outer(regime.observed, regime.observed)
    q[s.friction, s.friction] = moving * (tuning.friction + tuning.friction_own * np.eye(n))
    own_adhesion = [
        tuning.adhesion_sliding if quick or not known else tuning.adhesion_own
        for quick, known in zip(regime.quick, regime.torque_known, strict=True)
    ]
    q[s.adhesion, s.adhesion] = tuning.adhesion + np.diag(own_adhesion)
    q[s.deceleration, s.deceleration] = tuning.deceleration_braking if regime.braking else tuning.deceleration
    return q


def free_states(regime: Regime, layout: StateLayout) -> Array:
    """1 for states that an innovation may correct, 0 for held ones, shape (n,)."""
    free = np.ones(layout.size)
    if regime.slow:
        free[layout.speed + 1 :] = 0.0
    else:
        free[layout.friction] = regime.observed
    return free


class Terms(NamedTuple):
    """What a regime means to the filter, as arrays."""

    density: Array  # shape (n, n)
    free: Array  # shape (n,)
    rolls: Flags  # mu_w,i follows the brake torque
    unsettled: Flags
    turns: Flags


def terms(regime: Regime, tuning: Tuning, layout: StateLayout) -> Terms:
    """All of them."""
    rolls = tuple(turning and not quick for turning, quick in zip(regime.turning, regime.quick, strict=True))
    return Terms(density(regime, tuning, layout), free_states(regime, layout), rolls, regime.unsettled, regime.turning)
