"""The wagon: longitudinal and rotational equations of motion with brake-positive signs.

The equations are the paper's (numbers in parentheses), put right in three places, each guarded by a test:

* **Factor 2.** Summed over the wheelsets (4) gives F_z,f + F_z,r = m g, so (1) with (2) yields v̇ = … + mu_w g.
  The printed (5), (12), (17), (18) have g/2, at odds with the printed (11); on a whole wagon g/2 doubles both
  estimates while every residual stays white.
* **Signs.** As printed, (1) and (6) suit axes with z down, where forward rolling is omega < 0. Here all forward
  speeds are positive and mu_w, mu_b are positive while braking.
* **Load transfer.** F_z keeps its dependence on v̇ exactly; (12) drops 2 (h/a) mu_w, which is larger than the
  term it keeps.

Beyond the paper: N wheelsets instead of two; each wheelset has its own utilised adhesion mu_w,i, because a wheelset
that rolls uses what its own brake asks for and one that slides gets what its own contact patch gives (the
paper's single mu_w is the case where all mu_w,i are the same random walk); and the unmodelled deceleration d.
"""

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from brake_monitor.config import Vehicle

Array = NDArray[np.float64]

GRAVITY_MPS2 = 9.81


@dataclass(frozen=True)
class StateLayout:
    """Where each state lives in x = [omega_1..N, v, mu_b,1..N, mu_w,1..N, d], the order of (13) with d appended."""

    wheelset_count: int
    size: int = field(init=False, compare=False)
    omega: slice = field(init=False, compare=False)  # wheelset angular speeds, rad/s
    speed: int = field(init=False, compare=False)  # vehicle speed v, m/s
    friction: slice = field(init=False, compare=False)  # pad-disc friction mu_b,i
    adhesion: slice = field(init=False, compare=False)  # utilised wheel-rail adhesion mu_w,i = F_x,i / F_z,i
    deceleration: int = field(init=False, compare=False)  # unmodelled longitudinal deceleration d, m/s²
    kinematic: slice = field(init=False, compare=False)  # omega and v together: what is measured (15)

    def __post_init__(self) -> None:
        n = self.wheelset_count
        for name, place in {
            "omega": slice(0, n),
            "speed": n,
            "friction": slice(n + 1, 2 * n + 1),
            "adhesion": slice(2 * n + 1, 3 * n + 1),
            "deceleration": 3 * n + 1,
            "kinematic": slice(0, n + 1),
            "size": 3 * n + 2,
        }.items():
            object.__setattr__(self, name, place)


@dataclass
class Inputs:
    """The vectors u and u_lin of (14), and what else is known from outside; all arrays have length N."""

    pressing_force_n: Array  # F_perp,i, summed over all pad faces of the wheelset
    wheel_torque_nm: Array  # M_W,i, accelerating positive
    mass_kg: float
    gradient: float  # rise over run, uphill positive
    turning: NDArray[np.bool_]  # False for a locked wheelset: a static contact has no wheel equation
    rubbing: NDArray[np.bool_]  # True where mu_b,i may move: it shows itself only while the pad presses


@dataclass(frozen=True)
class FrictionRelaxation:
    """The first-order variant (9): ṁu_b = (mu_b0 - mu_b) / (t_mu mu_b), a simplified Ostermeyer (2003).

    `time_s` is the time constant of small deviations from mu_b0, which by (9) is t_mu mu_b0; hence
    t_mu = time_s / mu_b0. Friction below mu_b0 rises faster than friction above it falls.
    """

    nominal: float  # mu_b0
    time_s: float

    def rate(self, friction: Array) -> tuple[Array, Array]:
        """ṁu_b of (9) and its derivative by mu_b, in 1/s, each of the shape of `friction`."""
        nominal_per_s = self.nominal / self.time_s
        return nominal_per_s * (self.nominal / friction - 1.0), -nominal_per_s * self.nominal / friction**2


@dataclass(frozen=True)
class Wagon:
    """The parameters of (1)-(11). Arrays have length N."""

    layout: StateLayout
    mass_kg: float
    cog_height_m: float
    wheelset_inertia_kgm2: Array
    wheel_radius_m: Array
    brake_radius_m: Array
    track_resistance_n: float
    drag_n_per_mps2: float
    static_load_share: Array  # s_i: F_z,i = m g s_i at rest; sums to 1
    load_transfer_per_m: Array  # t_i [1/m]: F_z,i changes by - m h v̇ t_i; sums to 0
    relaxation: FrictionRelaxation | None = None  # (9); without it mu_b,i is a random walk (8)
    _wheels: NDArray[np.int64] = field(init=False, compare=False)  # 0..N-1

    def __post_init__(self) -> None:
        object.__setattr__(self, "_wheels", np.arange(self.layout.wheelset_count))

    @classmethod
    def from_vehicle(cls, vehicle: Vehicle, relaxation: FrictionRelaxation | None = None) -> Self:
        """Take the parameters from the configuration and spread the load over the wheelsets."""
        share, transfer = load_distribution(np.array(vehicle.axle_positions_m))
        return cls(
            layout=StateLayout(vehicle.wheelset_count),
            mass_kg=vehicle.mass_kg,
            cog_height_m=vehicle.cog_height_m,
            wheelset_inertia_kgm2=np.array(vehicle.wheelset_inertia_kgm2),
            wheel_radius_m=np.array(vehicle.wheel_radius_m),
            brake_radius_m=np.array(vehicle.brake_radius_m),
            track_resistance_n=vehicle.track_resistance_n,
            drag_n_per_mps2=vehicle.drag_n_per_mps2,
            static_load_share=share,
            load_transfer_per_m=transfer,
            relaxation=relaxation,
        )

    def inputs(self) -> Inputs:
        """Return inputs of a wagon that rolls freely on level track."""
        n = self.layout.wheelset_count
        turning, rubbing = np.ones(n, dtype=np.bool_), np.zeros(n, dtype=np.bool_)
        return Inputs(np.zeros(n), np.zeros(n), self.mass_kg, 0.0, turning, rubbing)

    def acceleration_mps2(self, x: Array, u: Inputs) -> float:
        """v̇ from (1), (2), (4), (5): m v̇ = - Σ mu_w,i F_z,i - F_TR - k_d v² - m d, solved for v̇."""
        s = self.layout
        adhesion = x[s.adhesion]
        resistance_n = self.track_resistance_n + self.drag_n_per_mps2 * float(x[s.speed]) ** 2
        unmodelled_mps2 = GRAVITY_MPS2 * u.gradient + float(x[s.deceleration])
        creep_mps2 = GRAVITY_MPS2 * float(self.static_load_share @ adhesion)
        return -(creep_mps2 + resistance_n / u.mass_kg + unmodelled_mps2) / self._load_coupling(adhesion)

    def _load_coupling(self, adhesion: Array) -> float:
        """1 - h Σ t_i mu_w,i: braking loads the wheelsets unevenly, which feeds back if their adhesions differ."""
        return 1.0 - self.cog_height_m * float(self.load_transfer_per_m @ adhesion)

    def wheel_load_n(self, acceleration_mps2: float, mass_kg: float) -> Array:
        """F_z,i of (4), shape (N,): the leading wheelset is loaded while braking (v̇ < 0)."""
        transfer_mps2 = (self.cog_height_m * acceleration_mps2) * self.load_transfer_per_m
        return mass_kg * (GRAVITY_MPS2 * self.static_load_share - transfer_mps2)

    def derivative(self, x: Array, u: Inputs) -> Array:
        """f(x, u) of (12), shape (3N+2,); see `linearise`."""
        return self.linearise(x, u)[0]

    def jacobian(self, x: Array, u: Inputs) -> Array:
        """A = ∂f/∂x, shape (3N+2, 3N+2); see `linearise`."""
        return self.linearise(x, u)[1]

    def linearise(self, x: Array, u: Inputs) -> tuple[Array, Array]:
        """f(x, u) of (12) and A = ∂f/∂x, analytic: (6), (7), (10) for omega, (5) for v, (9) for mu_b.

        (3) and (8) are zero rows.
        """
        s = self.layout
        adhesion = x[s.adhesion]
        acceleration = self.acceleration_mps2(x, u)
        load_n = self.wheel_load_n(acceleration, u.mass_kg)
        per_inertia = u.turning / self.wheelset_inertia_kgm2  # a locked wheelset has no equation
        creep_rate = per_inertia * self.wheel_radius_m * load_n  # ∂omegȧ_i/∂mu_w,i
        brake_rate = per_inertia * self.brake_radius_m * u.pressing_force_n  # -∂omegȧ_i/∂mu_b,i

        f = np.zeros(s.size)
        f[s.omega] = creep_rate * adhesion - brake_rate * x[s.friction] + per_inertia * u.wheel_torque_nm
        f[s.speed] = acceleration

        a = np.zeros((s.size, s.size))
        inert_kg = u.mass_kg * self._load_coupling(adhesion)
        speed_row = a[s.speed]
        speed_row[s.speed] = -2.0 * self.drag_n_per_mps2 * float(x[s.speed]) / inert_kg
        speed_row[s.adhesion] = load_n * (-1.0 / inert_kg)
        speed_row[s.deceleration] = -u.mass_kg / inert_kg
        # every state that moves v̇ also moves the wheel loads: ∂F_z,i/∂x = - m h t_i ∂v̇/∂x
        load_rate_n = (-u.mass_kg * self.cog_height_m) * self.load_transfer_per_m
        omega_rows = a[s.omega]
        omega_rows += (per_inertia * self.wheel_radius_m * adhesion * load_rate_n)[:, None] * speed_row
        wheels = self._wheels
        omega_rows[wheels, s.adhesion.start + wheels] += creep_rate
        omega_rows[wheels, s.friction.start + wheels] -= brake_rate
        if self.relaxation is not None:
            rate, rate_per_friction = self.relaxation.rate(x[s.friction])
            f[s.friction] = u.rubbing * rate
            places = s.friction.start + wheels
            a[places, places] = u.rubbing * rate_per_friction
        return f, a


def load_distribution(axle_positions_m: Array) -> tuple[Array, Array]:
    """Spread weight and braking moment over equally stiff wheelsets; shapes (N,), (N,).

    F_z,i = m (g s_i - h v̇ t_i) with s, t linear in l_i such that Σ F_z,i = m g and Σ F_z,i l_i = - m h v̇ (4).
    For positions symmetric about the centre of gravity s_i = 1/N and t_i = l_i / Σ l_j²; a rig (N = 1) has t = 0.
    """
    n = len(axle_positions_m)
    mean = axle_positions_m.mean()
    deviation = axle_positions_m - mean
    spread = deviation @ deviation
    if spread == 0.0:
        return np.full(n, 1.0 / n), np.zeros(n)
    return 1.0 / n - mean * deviation / spread, deviation / spread
