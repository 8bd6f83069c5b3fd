"""The wagon: longitudinal and rotational equations of motion with brake-positive signs.

The equations are the paper's (numbers in parentheses), put right in four places, each guarded by a test:

* **Factor 2.** Summed over the wheelsets (4) gives F_z,f + F_z,r = m g, so (1) with (2) yields v̇ = … + mu_w g.
  The printed (5), (12), (17), (18) have g/2, at odds with the printed (11); on a whole wagon g/2 doubles both
  estimates while every residual stays white.
* **Signs.** As printed, (1) and (6) suit axes with z down, where forward rolling is omega < 0. Here all forward
  speeds are positive and mu_w, mu_b are positive while braking.
* **Load transfer.** (12) puts (4) into (6) and drops 2 (h/a) mu_w, which is larger than the term it keeps. Here F_z,i
  are inputs that follow (4) by themselves (`loads_after_step`): in a train's restless d, or in the noise of mu_w, an
  EKF would take the shaking of its own wheel loads for news of mu_b, and minutes of steady braking would draw mu_b to
  nothing (`tests/estimation/test_long_braking.py`).
* **What transfers load.** Gravity and d act on the mass itself and pitch nothing; only what rail and air make of v̇
  belongs into (4). With all of v̇ in it, a wagon braked downhill at steady speed would have the loads of one at rest.

Beyond the paper, and N wheelsets instead of two:

* **mu_w,i.** A wheelset that rolls uses what its own brake asks for, one that slides gets what its own contact patch
  gives. The paper's single mu_w is the case where all mu_w,i are the same random walk.
* **d**, the unmodelled deceleration.
* **B**, by which the adhesion of sliding wheelsets decays with slip speed w, first as e^{-B w} (Polach, Wear 258 (2005)
  992-1000, has mu_0 [(1 - A) e^{-B w} + A]), and **C_k**, the shares of a changing brake torque that the rail takes up
  where slip is small, medium and large. As the WSP works, the rail gives more or less with slip: left to a random walk
  of mu_w, part of that is taken for the brake's, slide after slide.
* **E**, by which friction changes with the braking ratio q_i = F_perp,i r_B / (F_z,i r_W): pads rub less the harder
  they press, organic ones by some 5 to 10 % up to full force. Slide protection that vents and fills the brake shows how
  the torque changes with the force, mu_b + q_i dmu_b/dq_i; taken for mu_b itself, the difference goes into d.
* **L**, by which readings of v come late.
* **K**, the relative error of the torque that motors are said to have.

What E, B and C_k do belongs to a step, not to f(x, u): see `coupled_step`; what L does, to a reading (15).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Self

from brake_monitor.estimation.kalman.ekf import Matrix, Vector, zeros
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon
from brake_monitor.estimation.model.load_distribution import load_distribution
from brake_monitor.estimation.model.state_layout import StateLayout
from brake_monitor.estimation.model.wheelset import Wheelset, brake_radps2, motor_radps2, rail_radps2
from brake_monitor.settings.config import EstimatorSettings, Vehicle

GRAVITY_MPS2 = 9.81


class Inputs(NamedTuple):
    """The vectors u and u_lin of (14), and what else is known from outside."""

    mass_kg: float
    gradient: float  # rise over run, uphill positive
    wheels: Sequence[Acting]  # N


@dataclass(frozen=True)
class FrictionRelaxation:
    """The first-order variant (9): ṁu_b = (mu_b0 - mu_b) / (t_mu mu_b), a simplified Ostermeyer (2003).

    `time_s` is the time constant of small deviations from mu_b0, which by (9) is t_mu mu_b0; hence
    t_mu = time_s / mu_b0. Friction below mu_b0 rises faster than friction above it falls.
    """

    nominal: float  # mu_b0
    time_s: float

    @classmethod
    def from_settings(cls, settings: EstimatorSettings) -> Self | None:
        """The relaxation, if the settings choose it; None for the random walk (8)."""
        if settings.friction_model == "random-walk":
            return None
        return cls(settings.friction_nominal, settings.friction_time_s)

    def rate(self, friction: float) -> tuple[float, float]:
        """ṁu_b of (9) and its derivative by mu_b, in 1/s."""
        nominal_per_s = self.nominal / self.time_s
        return nominal_per_s * (self.nominal / friction - 1.0), -nominal_per_s * self.nominal / (friction * friction)


@dataclass(frozen=True)
class Wagon:
    """The parameters of (1)-(11)."""

    layout: StateLayout
    vehicle: Vehicle
    wheelsets: tuple[Wheelset, ...]
    relaxation: FrictionRelaxation | None = None  # (9); without it mu_b,i is a random walk (8)

    @classmethod
    def from_vehicle(
        cls, vehicle: Vehicle, relaxation: FrictionRelaxation | None = None, *, has_motors: bool = False
    ) -> Self:
        """Take the parameters from the configuration and spread the load over the wheelsets.

        `has_motors`: their torque is told, and its error is a state.
        """
        shares, transfers = load_distribution(vehicle)
        own = vehicle.wheelset_inertia_kgm2, vehicle.wheel_radius_m, vehicle.brake_radius_m
        return cls(
            layout=StateLayout(vehicle.wheelset_count, has_motors=has_motors),
            vehicle=vehicle,
            wheelsets=tuple(Wheelset(*row) for row in zip(*own, shares.tolist(), transfers.tolist(), strict=True)),
            relaxation=relaxation,
        )

    def inputs(self) -> Inputs:
        """Return inputs of a wagon that rolls freely on level track."""
        rolls = Acting(*[0.0] * len(Acting._fields))._replace(has_equation=1.0)
        wheels = [
            rolls._replace(wheel_radius_m=own.wheel_radius_m, brake_radius_m=own.brake_radius_m, wheel_load_n=load_n)
            for own, load_n in zip(self.wheelsets, self.wheel_load_n(0.0, self.vehicle.mass_kg), strict=True)
        ]
        return Inputs(self.vehicle.mass_kg, 0.0, wheels)

    def acceleration_mps2(self, x: Sequence[float], u: Inputs) -> float:
        """v̇ from (1), (2), (5): m v̇ = - Σ mu_w,i F_z,i - F_TR - k_d v² - m (g i + d)."""
        s = self.layout
        creep_n = sum([mu * own.wheel_load_n for mu, own in zip(x[s.adhesion], u.wheels, strict=True)])
        unmodelled_mps2 = GRAVITY_MPS2 * u.gradient + x[s.deceleration]
        return -(creep_n + self.vehicle.resistance_n(x[s.speed])) / u.mass_kg - unmodelled_mps2

    def pitching_mps2(self, x: Sequence[float], mass_kg: float, heading: float = 1.0) -> float:
        """The part of v̇ that shifts the wheel loads once they have settled: all but gravity and d.

        It depends on the wheel loads, and they on it (4): the equation is solved for it. Its sign is that of the axle
        positions: a wagon that reverses (`heading` -1) brakes by the same equations, but is loaded at its other end.
        """
        s = self.layout
        shares = zip(self.wheelsets, x[s.adhesion], strict=True)
        creep_mps2 = GRAVITY_MPS2 * sum([wheelset.load_share * mu for wheelset, mu in shares])
        resisted_mps2 = self.vehicle.resistance_n(x[s.speed]) / mass_kg
        return -heading * (creep_mps2 + resisted_mps2) / self._load_coupling(x, heading)

    def settled(self, x: Sequence[float], u: Inputs) -> Inputs:
        """The same inputs with the wheel loads as they have settled at this x."""
        loads_n = self.wheel_load_n(self.pitching_mps2(x, u.mass_kg), u.mass_kg)
        return u._replace(wheels=[own._replace(wheel_load_n=n) for own, n in zip(u.wheels, loads_n, strict=True)])

    def _load_coupling(self, x: Sequence[float], heading: float) -> float:
        """1 - h Σ t_i mu_w,i forwards: the load that braking transfers changes the braking where adhesions differ."""
        transfers = zip(self.wheelsets, x[self.layout.adhesion], strict=True)
        transferred_per_m = sum([wheelset.load_transfer_per_m * mu for wheelset, mu in transfers])
        return 1.0 - heading * self.vehicle.cog_height_m * transferred_per_m

    def wheel_load_n(self, pitching_mps2: float, mass_kg: float) -> Vector:
        """F_z,i of (4), N numbers: the leading wheelset is loaded while braking (`pitching_mps2` below 0 forwards)."""
        lifting_mps2m = self.vehicle.cog_height_m * pitching_mps2
        return [
            mass_kg * (GRAVITY_MPS2 * wheelset.load_share - lifting_mps2m * wheelset.load_transfer_per_m)
            for wheelset in self.wheelsets
        ]

    def worn(self, i: int, own: Acting) -> Wheelset:
        """Wheelset i with its radii of now: r_W as calibrated so far, and r_B, which on the tread wears with it."""
        return self.wheelsets[i]._replace(wheel_radius_m=own.wheel_radius_m, brake_radius_m=own.brake_radius_m)

    def loads_after_step(self, x: Sequence[float], now: ActingOnWagon, share: float) -> tuple[float, Vector]:
        """What pitches the wagon after a step, and the N wheel loads; both follow as slowly as suspensions let them.

        `share`: see `StepLength.settling_share`.
        """
        settled_mps2 = self.pitching_mps2(x, now.mass_kg, now.heading)
        pitching_mps2 = now.pitching_mps2 + (settled_mps2 - now.pitching_mps2) * share
        return pitching_mps2, self.wheel_load_n(pitching_mps2, now.mass_kg)

    def linearise(self, x: Sequence[float], u: Inputs) -> tuple[Vector, Matrix]:
        """f(x, u) of (12) and A = ∂f/∂x, analytic: (6), (7), (10) for omega, (5) for v, (9) for mu_b.

        (8), and (3) of wheelsets that roll, are zero rows.
        """
        s = self.layout
        f, a = [0.0] * s.size, zeros(s.size)
        f[s.speed], a[s.speed] = self.acceleration_mps2(x, u), self._speed_row(x, u)
        for i in range(s.wheelset_count):
            f[i], a[i] = self._wheel_equation(i, x, u.wheels[i])
        if self.relaxation is not None:
            for place, own in zip(range(s.friction.start, s.friction.stop), u.wheels, strict=True):
                rate, per_friction = self.relaxation.rate(x[place])
                f[place], a[place][place] = own.friction_observable * rate, own.friction_observable * per_friction
        return f, a

    def _speed_row(self, x: Sequence[float], u: Inputs) -> Vector:
        """∂v̇/∂x."""
        s = self.layout
        row = [0.0] * s.size
        row[s.speed] = -2.0 * self.vehicle.drag_n_per_mps2 * x[s.speed] / u.mass_kg
        row[s.adhesion] = [-own.wheel_load_n / u.mass_kg for own in u.wheels]
        row[s.deceleration] = -1.0
        return row

    def _wheel_equation(self, i: int, x: Sequence[float], own: Acting) -> tuple[float, Vector]:
        """omegȧ_i from (6), (7), (10), and ∂omegȧ_i/∂x; zero for a locked wheelset.

        J_i omegȧ_i = mu_w,i F_z,i r_W - mu_b,i F_perp,i r_B + (1 + K) M_W,i
        """
        s = self.layout
        wheelset = self.worn(i, own)
        friction, adhesion = s.friction.start + i, s.adhesion.start + i
        by_rail = rail_radps2(wheelset, own.wheel_load_n, own.has_equation)
        by_brake = brake_radps2(wheelset, own.pressing_force_n, own.has_equation)
        by_motor = motor_radps2(wheelset, own.wheel_torque_nm, own.has_equation)
        row = [0.0] * s.size
        row[adhesion], row[friction] = by_rail, -by_brake
        row[s.torque_error] = [by_motor for _ in x[s.torque_error]]
        return by_rail * x[adhesion] - by_brake * x[friction] + by_motor * (1.0 + sum(x[s.torque_error])), row
