"""One prediction of the filter: x and P of (13) over a time step, from inputs and forces known at both of its ends.

Plain arithmetic on numbers: `straight_line` compiles it for each wagon.
"""

from collections.abc import Sequence
from typing import NamedTuple

from brake_monitor.estimation import ekf
from brake_monitor.estimation.ekf import Matrix, Vector
from brake_monitor.estimation.model.regime import Regime, density
from brake_monitor.estimation.model.wagon import Inputs, Wagon
from brake_monitor.estimation.moment import Acting

SHARE_MEMORY_S = 0.01  # how long the share of a changing brake torque that the rail takes up stays the same
SHORTEST_STEP_S = 0.005
IMPULSE_DOUBT = 2.0  # variance, as a multiple of the estimated error's square


class BrakeForces(NamedTuple):
    """What the N pressing forces, and the torques of motors, did over a step beside their mean."""

    begin_n: Sequence[float]  # at the end of the last step: mu_w agrees with them
    end_n: Sequence[float]  # at the end of this one
    begin_nm: Sequence[float]  # likewise
    end_nm: Sequence[float]
    impulse_std_ns: Sequence[float]  # how far ∫F dt over the step may be off
    unseen_std_ns: Sequence[float]  # ... and by what slide protection may have done since the last sample


class FixedDensities(NamedTuple):
    """The spectral densities that are the same in every step, as in `Tuning`; the others are `RegimeDensities`."""

    speed: float
    friction: float
    friction_own: float
    adhesion: float
    deceleration_per_metre: float
    adhesion_decay: float
    uptake: float


class Conditions(NamedTuple):
    """What a step is taken under."""

    step_s: float
    share_memory: float  # see `share_memory`
    u: Inputs  # their means over the step
    regime: Regime
    forces: BrakeForces
    effect_shows: Sequence[float]  # 1 where E acts on mu_b,i, else 0
    uptake_weights: Sequence[Sequence[float]]  # of the C_k for each wheelset; 0 where it rolls
    slid_mps: Sequence[float]  # what the slip speeds of those that slide have changed by, as far as mu_w still falls


def conditions(
    step: Sequence[float], acting: Sequence[Acting], densities: FixedDensities, speed_mps: float
) -> Conditions:
    """Those of a step: its length, `share_memory`, mass, gradient and density of d by time, what acts on each wheelset.

    With the speed, d walks by the way as well.
    """
    step_s, memory, mass_kg, gradient, deceleration_density = step
    each = {name: [getattr(one, name) for one in acting] for name in Acting._fields}
    u = Inputs(
        each["pressing_force_n"],
        each["wheel_torque_nm"],
        mass_kg,
        gradient,
        each["turning"],
        each["observed"],
        each["wheel_load_n"],
    )
    regime = Regime(
        observed=each["observed"],
        stood=each["stood"],
        rolls=each["rolls"],
        unsettled=each["unsettled"],
        turns=each["turning"],
        omega=each["omega_density"],
        speed=densities.speed,
        friction=densities.friction,
        friction_own=densities.friction_own,
        adhesion=densities.adhesion,
        adhesion_own=each["adhesion_density"],
        adhesion_decay=densities.adhesion_decay * sum(each["slides"]) / len(acting),
        uptake=densities.uptake * sum(each["unsettled"]) / len(acting),
        deceleration=deceleration_density + densities.deceleration_per_metre * speed_mps,
    )
    forces = BrakeForces(*[each[name] for name in BrakeForces._fields])
    weights = list(zip(each["small_slip"], each["medium_slip"], each["large_slip"], strict=True))
    slid_mps = [slides * change for slides, change in zip(each["slides"], each["slip_change_mps"], strict=True)]
    return Conditions(step_s, memory, u, regime, forces, each["effect_shows"], weights, slid_mps)


class Predicted(NamedTuple):
    """The state after a step, and how it came to it."""

    x: Vector
    covariance: Matrix
    step: Matrix  # F - I
    noise: Matrix


class Asked(NamedTuple):
    """What a change of the braking ratio q_i, mu_w,i = q_i mu_b,i of a wheelset that rolls, does to both of them."""

    friction: float  # change of mu_b,i ...
    friction_per_effect: float  # ... by E
    adhesion: float  # change of mu_w,i ...
    per_friction: float  # ... by mu_b,i ...
    per_effect: float  # ... by E ...
    per_uptake: Sequence[float]  # ... and by the C_k


class Following(NamedTuple):
    """What the pressing force of one wheelset, and its motor, do to its mu_b and mu_w over a step."""

    middle: Asked  # until the middle of the step
    end: Asked
    share_variance: float  # of the change of mu_w,i, where the rail may take up any share of the torque
    omega_variance: float  # (rad/s)², by what the force's impulse may be off


def share_memory(step_s: float) -> float:
    """How much longer than a step the share that the rail takes up stays the same; bunched frames count as apart."""
    return SHARE_MEMORY_S / max(step_s, SHORTEST_STEP_S)


def literal_step(wagon: Wagon, x: Vector, covariance: Matrix, now: Conditions) -> Predicted:
    """A step with the covariances of (20), which belong to steps and not to time."""
    derivative, jacobian = wagon.linearise(x, now.u)
    step = ekf.scaled(jacobian, now.step_s)
    noise = ekf.scaled(density(now.regime, wagon.layout), now.step_s)
    moved = [value + rate * now.step_s for value, rate in zip(x, derivative, strict=True)]
    return Predicted(moved, ekf.predict(covariance, step, noise), step, noise)


def coupled_step(wagon: Wagon, x: Vector, covariance: Matrix, now: Conditions) -> Predicted:
    """A step in which mu_w,i of a wheelset that rolls follows its torques, and of one that slides its slip speed.

    Δmu_w,i = - B mu_w,i Δw_i, where Δw_i is known from the readings so far. As - B mu_w,i ẇ_i of the model itself
    it would be bilinear in noisy states: while all wheelsets creep steadily it would tell of mu_b what nothing tells.
    """
    s = wagon.layout
    uptake = range(s.uptake.start, s.uptake.stop)
    following = [_following(wagon, i, x, now) for i in range(s.wheelset_count)]
    meanwhile = list(x)
    for i, own in enumerate(following):
        meanwhile[s.friction.start + i] += own.middle.friction
        meanwhile[s.adhesion.start + i] += own.middle.adhesion
    derivative, jacobian = wagon.linearise(meanwhile, now.u)
    noise = ekf.process_noise(jacobian, density(now.regime, s), now.step_s)
    step = ekf.scaled(jacobian, now.step_s)
    moved = [value + rate * now.step_s for value, rate in zip(x, derivative, strict=True)]
    for i, own in enumerate(following):
        friction, adhesion = s.friction.start + i, s.adhesion.start + i
        for row in step[s.kinematic]:
            row[s.force_effect] += row[friction] * own.middle.friction_per_effect
            row[s.force_effect] += row[adhesion] * own.middle.per_effect
            row[friction] += row[adhesion] * own.middle.per_friction
            for place, change in zip(uptake, own.middle.per_uptake, strict=True):
                row[place] += row[adhesion] * change
        step[friction][s.force_effect] = own.end.friction_per_effect
        step[adhesion][friction] = own.end.per_friction
        step[adhesion][s.force_effect] = own.end.per_effect
        step[adhesion][s.uptake] = own.end.per_uptake
        step[adhesion][adhesion] = -x[s.decay] * now.slid_mps[i]
        step[adhesion][s.decay] = -x[adhesion] * now.slid_mps[i]
        moved[friction] += own.end.friction
        moved[adhesion] += own.end.adhesion + step[adhesion][adhesion] * x[adhesion]
        noise[adhesion][adhesion] += own.share_variance
        noise[i][i] += own.omega_variance
    return Predicted(moved, ekf.predict(covariance, step, noise), step, noise)


def _following(wagon: Wagon, i: int, x: Vector, now: Conditions) -> Following:
    """What the pressing force of wheelset i, and its motor, do to its mu_b and mu_w over a step.

    mu_w,i of a rolling wheelset follows its brake torque. Without this, a brake application looks like a random
    walk of mu_w to the filter, and so does a motor that hands over to the pads: it lags, and puts the difference
    into mu_b. For the same reason the mean force of a step has to meet the mu_w of its middle, not of its
    beginning. A sliding wheelset turns a change of brake torque into rotation instead. In between, on the rising
    flank of the creep curve, the rail takes up a share C of it, the less the nearer the peak, which is anywhere
    between 1 and 12 % of slip: C_k, at UPTAKE_SLIPS, are learned. Left to a random walk of mu_w, what the rail
    takes up would be taken for a weaker brake, slide after slide. How far C is off at the moment, and the force
    between its samples, would pull mu_b down as errors of a regressor do.

    Nor does mu_b stay the same as slide protection vents and fills the brake: E, for wheelsets that slid lately. As
    they roll, forces change slowly, and mu_b with them by its own walk: the timing of each would pass for E there.
    """
    regime, begin_n, end_n = now.regime, now.forces.begin_n[i], now.forces.end_n[i]
    ratio_per_n = wagon.asked_kg_per_n(i) / now.u.mass_kg
    s, friction = wagon.layout, x[wagon.layout.friction.start + i]
    weights = now.uptake_weights[i]
    taken = regime.rolls[i] + sum([weight * own for weight, own in zip(weights, x[s.uptake], strict=True)])
    effect, shown, ratio = x[s.force_effect], now.effect_shows[i], ratio_per_n * begin_n
    until_middle, until_end = [ratio_per_n * (force_n - begin_n) for force_n in (now.u.pressing_force_n[i], end_n)]
    per_nm, begin_nm = wagon.asked_per_torque(i, now.u.mass_kg), now.forces.begin_nm[i]
    torques_nm = (now.u.wheel_torque_nm[i], now.forces.end_nm[i])
    driven_middle, driven_end = [per_nm * (torque_nm - begin_nm) for torque_nm in torques_nm]

    def asked(change: float, driven: float) -> Asked:
        """Δmu_b = E Δq, and the share of Δ(q mu_b) and the motor's that the rail takes up; to first order in Δq."""
        per_taken = (friction + shown * ratio * effect) * change + driven
        return Asked(
            friction=shown * effect * change,
            friction_per_effect=shown * change,
            adhesion=taken * per_taken,
            per_friction=taken * change,
            per_effect=taken * shown * ratio * change,
            per_uptake=[weight * per_taken for weight in weights],
        )

    share_std = until_end * friction + driven_end
    omega_std = wagon.spin_per_impulse(i) * friction * now.forces.impulse_std_ns[i]
    unseen_std = wagon.spin_per_impulse(i) * friction * now.forces.unseen_std_ns[i]
    return Following(
        asked(until_middle, driven_middle),
        asked(until_end, driven_end),
        regime.unsettled[i] * (share_std * share_std) * now.share_memory,
        regime.turns[i] * (IMPULSE_DOUBT * (omega_std * omega_std) + regime.unsettled[i] * (unseen_std * unseen_std)),
    )
