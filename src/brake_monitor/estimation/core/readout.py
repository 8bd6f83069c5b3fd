"""What is known at an instant, as a row of numbers read off the core; a `Statement` puts it into words.

Runs in Python and compiled, as the core does: a compiled run writes rows without copying all numbers back.
"""

from collections.abc import MutableSequence
from math import inf, nan, sqrt
from typing import NamedTuple

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.core.core_numbers import CoreNumbers
from brake_monitor.estimation.model.friction_pause import pause_variance
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.model.wheelset import motor_demand

SETTLING_S = 3.0  # from a start or restart to `valid`
OWN_TORQUE_STD = 0.03  # by how much, relative, one motor errs beside what all do
PROVEN_SIGMAS = 3.0  # of L: less certain, it would shift the speed by as much as creep is, a few per mille

# How far an estimate is to be trusted; of several that hold, the first after VALID.
VALID, LOST, UNOBSERVABLE, SETTLING, UNCERTAIN, DOUBTED = range(6)


class WagonReadout(NamedTuple):
    """Of the wagon, as in `Estimate`; flags are 0 or 1."""

    time_s: float  # of the last fused sample
    speed_mps: float
    distance_m: float
    adhesion: float
    adhesion_std: float
    saturated: float
    deceleration_mps2: float
    deceleration_std_mps2: float
    mass_kg: float
    trust: float  # VALID, ...
    doubts: float  # a number as `Consistency.doubts` gives it
    nis: float
    speed_scatters: float


class WheelsetReadout(NamedTuple):
    """Of one wheelset, as in `WheelsetEstimate`."""

    omega_radps: float
    omega_noise: float
    slip: float
    friction: float
    friction_std: float
    line_friction_std: float
    friction_trust: float  # VALID, ...
    adhesion: float
    adhesion_std: float
    pressing_force_n: float
    renewed_slides: float
    speed_scatters: float
    wsp_active: float
    pad_energy_j: float
    force_travel_nm: float
    sliding_distance_m: float
    wsp_actions: float
    is_protected: float
    motor_force_n: float  # NaN: not told
    relative_load: float


OF_WAGON, OF_WHEELSET = len(WagonReadout._fields), len(WheelsetReadout._fields)


def width(wheelset_count: int) -> int:
    """How many numbers there are: those of the wagon, then those of each wheelset."""
    return OF_WAGON + wheelset_count * OF_WHEELSET


def read_out(core: CoreNumbers, row: MutableSequence[float]) -> None:
    """Write down what is known now; `row` has room for `width` numbers."""
    doubts = 0 if core.tuning.literal else core.now.consistency.doubts(core.now.time_s)  # (20) knows nothing anyway
    settles = core.now.time_s - core.now.started_s < SETTLING_S
    slides, lost = core.now.wsp_active, False
    for i in range(core.wheelset_count):
        place, wheelset = OF_WAGON + i * OF_WHEELSET, of_wheelset(core, i, settles, doubts)
        for k in range(OF_WHEELSET):
            row[place + k] = wheelset[k]
        slides = slides or core.slip(i) > SLIDING_SLIP
        lost = lost or wheelset.friction_trust == LOST
    wagon = of_wagon(core, slides, lost, settles, doubts)
    for k in range(OF_WAGON):
        row[k] = wagon[k]


def of_wagon(core: CoreNumbers, slides: bool, lost: bool, settles: bool, doubts: int) -> WagonReadout:
    """What is known of the wagon; `slides`: any wheelset does, or its protection acts; `lost`: an input is."""
    now, x, n, covariance = core.now, core.filter.x, core.wheelset_count, core.filter.covariance
    first, d = core.adhesion_place, core.deceleration_place
    adhesion = variance = 0.0
    for i in range(n):
        share = load_share(core, i)
        adhesion += share * x[first + i]
        for j in range(n):
            variance += share * load_share(core, j) * covariance[first + i][first + j]
    adhesion_std = sqrt(timed_variance(core, variance))
    trust = trust_in(lost, now.near_standstill, settles, adhesion_std > core.tuning.converged_adhesion_std, doubts != 0)
    return WagonReadout(
        now.time_s,
        x[n] + unproven_mps(core),
        now.distance_m,
        adhesion,
        adhesion_std,
        1.0 if slides and not now.near_standstill and not now.speed_lost else 0.0,
        x[d],
        sqrt(max(covariance[d][d], 0.0)),
        now.mass_kg,
        float(trust),
        float(doubts),
        now.nis,
        1.0 if now.consistency.scatter.is_gross else 0.0,
    )


def of_wheelset(core: CoreNumbers, i: int, settles: bool, doubts: int) -> WheelsetReadout:
    """What is known of wheelset i. `settles`: the estimate has only begun; `doubts`: see `Consistency.doubts`."""
    now, wheel, friction, adhesion = core.now, core.wheels[i], core.friction_place + i, core.adhesion_place + i
    x, covariance, applied = core.filter.x, core.filter.covariance, now.application
    friction_std = sqrt(max(covariance[friction][friction], 0.0) + unseen_friction_variance(core, i))
    unseen_std = unseen_adhesion_std(core, i)
    lost = now.speed_lost or wheel.axle_speed_lost or wheel.force_lost
    trust = trust_in(
        lost, wheel.friction_observable == 0.0, settles, friction_std > core.tuning.converged_friction_std, doubts != 0
    )
    return WheelsetReadout(
        x[i],
        wheel.omega_variance * core.readings[i].spacing_s,
        core.slip(i),
        x[friction],
        friction_std,
        min(applied.line_friction_std, sqrt(applied.line_friction_share) * friction_std),
        float(trust),
        x[adhesion],
        sqrt(timed_variance(core, covariance[adhesion][adhesion]) + unseen_std * unseen_std),
        wheel.force.value,
        float(wheel.checks.still.renewals),
        1.0 if wheel.checks.scatter.is_large else 0.0,
        1.0 if wheel.wsp_active else 0.0,
        wheel.work.pad_energy_j,
        wheel.work.force_travel_nm,
        wheel.work.sliding_distance_m,
        float(wheel.work.wsp_actions),
        1.0 if wheel.protection.is_acting else 0.0,
        -wheel.torque.value / wheel.radius.radius_m if wheel.motor_torque_known else nan,
        load_share(core, i) * core.wheelset_count,
    )


def trust_in(lost: bool, hidden: bool, settles: bool, uncertain: bool, doubted: bool) -> int:
    """The first of what speaks against an estimate, else VALID."""
    if lost:
        return LOST
    if hidden:
        return UNOBSERVABLE
    if settles:
        return SETTLING
    if uncertain:
        return UNCERTAIN
    return DOUBTED if doubted else VALID


def unproven_mps(core: CoreNumbers) -> float:
    """What to add to v while L is not proven: the speed is then published as it is read, L late."""
    lag = core.lag_place
    lag_s, variance = core.filter.x[lag], core.filter.covariance[lag][lag]
    is_proven = lag_s > 0.0 and lag_s * lag_s > PROVEN_SIGMAS * PROVEN_SIGMAS * variance
    return 0.0 if is_proven else core.now.speed_per_lag_mps2 * lag_s


def timed_variance(core: CoreNumbers, variance: float) -> float:
    """The variance of an adhesion, with what it has changed since the moment that late pressing forces tell of."""
    missed = core.now.missed_deceleration_mps2 / GRAVITY_MPS2
    return max(variance, 0.0) + missed * missed


def unseen_adhesion_std(core: CoreNumbers, i: int) -> float:
    """The deviation of mu_w,i by what the motor of wheelset i errs beside K."""
    wheel = core.wheels[i]
    asked = motor_demand(wheel, wheel.end_torque_nm, wheel.next_wheel_load_n) if core.has_torque_signal else 0.0
    return OWN_TORQUE_STD * abs(asked)


def load_share(core: CoreNumbers, i: int) -> float:
    """F_z,i / (m g) now."""
    return core.wheels[i].next_wheel_load_n / (core.now.mass_kg * GRAVITY_MPS2)


def unseen_friction_variance(core: CoreNumbers, i: int) -> float:
    """The variance of what friction of wheelset i may do unseen: at another force, and since its pad left the disc."""
    now, wheel = core.now, core.wheels[i]
    std = wheel.departure.relative_std * core.filter.x[core.friction_place + i]
    variance = std * std
    if not wheel.contact.pressed and now.pressed_s > -inf:
        variance += pause_variance(now.time_s - now.pressed_s)
    return variance
