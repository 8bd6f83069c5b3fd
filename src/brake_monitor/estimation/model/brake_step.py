"""One prediction of the filter: x and P of (13) over a time step, from inputs and forces known at both of its ends.

Plain arithmetic on numbers: `straight_line` compiles it for each wagon.
"""

from collections.abc import Mapping, Sequence
from math import exp
from typing import NamedTuple

from brake_monitor.estimation.kalman import ekf
from brake_monitor.estimation.kalman.ekf import Matrix, Vector
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.regime import FixedDensities, density
from brake_monitor.estimation.model.wagon import Inputs, Wagon
from brake_monitor.estimation.model.wheelset import brake_radps, braking_ratio, motor_demand

PITCH_S = 0.3  # bodies pitch with one or two hertz
SHARE_MEMORY_S = 0.01  # for so long the error of c_i, see `_response`, stays the same
SHORTEST_STEP_S = 0.005  # shorter steps count as this: frames that a gateway bunches are not as close as their times
IMPULSE_DOUBT = 2.0  # variance, as a multiple of the estimated error's square


class StepLength(NamedTuple):
    """How long a step is, and what follows from that alone."""

    step_s: float
    share_memory_steps: float  # for how many steps of this length the error of c_i, see `_response`, stays the same
    settling_share: float  # which part of the way to their settled values the wheel loads go


class Conditions(NamedTuple):
    """The inputs and noise densities of one step."""

    length: StepLength
    on_wagon: ActingOnWagon
    wheels: Sequence[Acting]
    densities: FixedDensities

    @property
    def u(self) -> Inputs:
        """The inputs, means over the step."""
        return Inputs(self.on_wagon.mass_kg, self.on_wagon.gradient, self.wheels)


class Predicted(NamedTuple):
    """x and P after a step, and the matrices that led to them, which a smoother needs."""

    x: Vector
    covariance: Matrix
    step: Matrix  # F - I
    noise: Matrix  # Q_d


class Response(NamedTuple):
    """By how much mu_b,i and mu_w,i of a wheelset change as its braking ratio q_i does, and the derivatives of that."""

    friction: float  # change of mu_b,i ...
    friction_per_effect: float  # ... and its derivative by E
    adhesion: float  # change of mu_w,i ...
    adhesion_per: Mapping[int, float]  # ... and its derivatives, by the places of E, mu_b,i, the C_k and K in x


class WheelsetResponse(NamedTuple):
    """What pressing force and motor of one wheelset do to its mu_b,i and mu_w,i over a step, and how sure that is."""

    middle: Response  # from the step's beginning to its middle ...
    end: Response  # ... and to its end
    share_variance: float  # of the change of mu_w,i, where c_i may be anything
    omega_variance: float  # (rad/s)², of omega_i, as the impulse ∫F dt of the step is not known exactly


def step_length(step_s: float) -> StepLength:
    """A step of this length."""
    return StepLength(step_s, SHARE_MEMORY_S / max(step_s, SHORTEST_STEP_S), 1.0 - exp(-step_s / PITCH_S))


def literal_step(wagon: Wagon, x: Vector, covariance: Matrix, now: Conditions) -> Predicted:
    """A step with the covariances of (20), which belong to steps and not to time."""
    derivative, jacobian = wagon.linearise(x, now.u)
    q = density(wagon.layout, now.densities, now.on_wagon, now.wheels, x[wagon.layout.speed])
    step, noise = ekf.scaled(jacobian, now.length.step_s), ekf.scaled(q, now.length.step_s)
    moved = [value + rate * now.length.step_s for value, rate in zip(x, derivative, strict=True)]
    return Predicted(moved, ekf.predict(covariance, step, noise), step, noise)


def coupled_step(wagon: Wagon, x: Vector, covariance: Matrix, now: Conditions) -> Predicted:
    """A step in which mu_w,i of a wheelset that rolls follows its torques, and of one that slides its slip speed.

        Δmu_w,i = - B mu_w,i e^{-B w_i} Δw_i    of a wheelset that slides, beside what `_response` says

    Δw_i, the change of slip speed, is taken from the estimates so far. With ẇ_i of the model instead, the term would
    be a product of noisy states: while all wheelsets creep steadily, the filter would take its noise for news of mu_b.
    That e^{-B w_i} falls with B is left out of the derivative: it makes no difference.
    """
    s = wagon.layout
    following = [_response(wagon, i, x, now) for i in range(s.wheelset_count)]
    meanwhile = list(x)
    for i, own in enumerate(following):
        meanwhile[s.friction.start + i] += own.middle.friction
        meanwhile[s.adhesion.start + i] += own.middle.adhesion
    derivative, jacobian = wagon.linearise(meanwhile, now.u)
    q = density(s, now.densities, now.on_wagon, now.wheels, x[s.speed])
    noise = ekf.process_noise(jacobian, q, now.length.step_s)
    step = ekf.scaled(jacobian, now.length.step_s)
    moved = [value + rate * now.length.step_s for value, rate in zip(x, derivative, strict=True)]
    for i, (own, acting) in enumerate(zip(following, now.wheels, strict=True)):
        friction, adhesion = s.friction.start + i, s.adhesion.start + i
        for row in step[s.kinematic]:
            row[s.force_effect] += row[friction] * own.middle.friction_per_effect
            for place, per in own.middle.adhesion_per.items():
                row[place] += row[adhesion] * per
        step[friction][s.force_effect] = own.end.friction_per_effect
        for place, per in own.end.adhesion_per.items():
            step[adhesion][place] = per
        slid_mps = acting.slides * acting.slip_change_mps
        step[adhesion][adhesion] = -x[s.decay] * slid_mps
        step[adhesion][s.decay] = -x[adhesion] * slid_mps
        moved[friction] += own.end.friction
        moved[adhesion] += own.end.adhesion + step[adhesion][adhesion] * x[adhesion]
        noise[adhesion][adhesion] += own.share_variance
        noise[i][i] += own.omega_variance
    return Predicted(moved, ekf.predict(covariance, step, noise), step, noise)


def _response(wagon: Wagon, i: int, x: Vector, now: Conditions) -> WheelsetResponse:
    """What pressing force and motor of wheelset i do to its mu_b,i and mu_w,i over a step.

        q_i     = F_perp,i r_B / (F_z,i r_W)
        Δmu_b,i = E Δq_i                                     of a wheelset that slid lately, else 0
        Δmu_w,i = c_i Δ(q_i mu_b,i - (1 + K) M_W,i / (F_z,i r_W))  with c_i = 1 as it rolls, else Σ_k w_k C_k

    mu_w,i of a rolling wheelset follows its brake torque. Without this, a brake application looks like a random
    walk of mu_w to the filter, and so does a motor that hands over to the pads: it lags, and puts the difference
    into mu_b. For the same reason the mean force of a step has to meet the mu_w of its middle, not of its
    beginning. A sliding wheelset turns a change of brake torque into rotation instead. In between, on the rising
    flank of the creep curve, the rail takes up a share c_i of it, the less the nearer the peak, which is anywhere
    between 1 and 12 % of slip: C_k, at UPTAKE_SLIPS, are learned. Left to a random walk of mu_w, what the rail
    takes up would be taken for a weaker brake, slide after slide. The errors of c_i and of the force between its
    samples are errors of a regressor: without variances of their own they would pull mu_b down.

    q_i is formed with the wheel loads of now, since the brake asks for a force: mu_w,i of a wheelset that braking loads
    more is smaller. With the loads at rest the difference would come and go with the torque, as if mu_b were smaller.

    By E, mu_b changes as slide protection vents and fills the brake, but only that of wheelsets that slid lately. While
    they roll, forces change slowly and the walk of mu_b follows: the timing of either would pass for E there.
    """
    own, s = now.wheels[i], wagon.layout
    wheelset = wagon.worn(i, own)
    friction, effect, shown = x[s.friction.start + i], x[s.force_effect], own.force_effect_observable
    weights = own.small_slip, own.medium_slip, own.large_slip  # w_k
    taken = own.rolls + sum([weight * share for weight, share in zip(weights, x[s.uptake], strict=True)])  # c_i
    q = braking_ratio(wheelset, own.begin_force_n, own.begin_load_n)
    driven = motor_demand(wheelset, own.begin_torque_nm, own.begin_load_n)
    forces_n, torques_nm = (own.pressing_force_n, own.end_force_n), (own.wheel_torque_nm, own.end_torque_nm)
    dq_middle, dq_end = [braking_ratio(wheelset, force_n, own.wheel_load_n) - q for force_n in forces_n]
    asked_then = [motor_demand(wheelset, torque_nm, own.wheel_load_n) for torque_nm in torques_nm]
    driven_middle, driven_end = [then - driven for then in asked_then]
    torque_share = 1.0 + sum(x[s.torque_error])  # of what is told

    def asked(dq: float, driven: float) -> Response:
        """Both changes, to first order in Δq_i, and their derivatives; `driven`: what the motor asks for more."""
        per_taken = (friction + shown * q * effect) * dq + driven * torque_share
        per = {s.force_effect: taken * shown * q * dq, s.friction.start + i: taken * dq}
        per |= {s.uptake.start + k: weight * per_taken for k, weight in enumerate(weights)}
        per |= dict.fromkeys(range(s.torque_error.start, s.torque_error.stop), taken * driven)
        return Response(shown * effect * dq, shown * dq, taken * per_taken, per)

    share_std = dq_end * friction + driven_end * torque_share
    omega_std = brake_radps(wheelset, friction, own.impulse_std_ns)
    unseen_std = brake_radps(wheelset, friction, own.unseen_std_ns)
    return WheelsetResponse(
        asked(dq_middle, driven_middle),
        asked(dq_end, driven_end),
        own.unsettled * (share_std * share_std) * now.length.share_memory_steps,
        own.has_equation * (IMPULSE_DOUBT * (omega_std * omega_std) + own.unsettled * (unseen_std * unseen_std)),
    )
