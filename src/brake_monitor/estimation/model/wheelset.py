"""The equation of motion of one wheelset, with brake-positive signs, for filter and core.

    J omegȧ = mu_w F_z r_W - mu_b F_perp r_B + M_W                        (6), (7), (10)

While it rolls, omegȧ is next to nothing: mu_w = q mu_b - M_W / (F_z r_W), with the braking ratio
q = F_perp r_B / (F_z r_W).
"""

from typing import NamedTuple, Protocol

TREAD = 0.05  # of the wheel's radius; worn wheels are up to that much smaller than drawn ones


def is_on_tread(brake_radius_m: float, wheel_radius_m: float) -> bool:
    """Whether a brake is at the wheel's own radius: its blocks press on the tread, where no disc can be."""
    return abs(brake_radius_m - wheel_radius_m) < TREAD * wheel_radius_m


class Rotating(Protocol):
    """Whatever has the parameters of a wheelset."""

    @property
    def inertia_kgm2(self) -> float:
        """J."""

    @property
    def wheel_radius_m(self) -> float:
        """r_W."""

    @property
    def brake_radius_m(self) -> float:
        """r_B."""


class Wheelset(NamedTuple):
    """The parameters of one wheelset."""

    inertia_kgm2: float  # J_i
    wheel_radius_m: float  # r_W, as configured
    brake_radius_m: float  # r_B, as configured
    load_share: float  # s_i: F_z,i = m g s_i at rest; they sum to 1
    load_transfer_per_m: float  # t_i: F_z,i changes by - m h v̇ t_i; they sum to 0


def rail_radps2(wheelset: Rotating, wheel_load_n: float, turns: float) -> float:
    """What the rail adds to omegȧ per unit of mu_w; `turns`: 0 if it is locked or its torque unknown, else 1."""
    return wheelset.wheel_radius_m * wheel_load_n * (turns / wheelset.inertia_kgm2)


def brake_radps2(wheelset: Rotating, pressing_force_n: float, turns: float) -> float:
    """What the brake takes off omegȧ per unit of mu_b."""
    return wheelset.brake_radius_m * pressing_force_n * (turns / wheelset.inertia_kgm2)


def motor_radps2(wheelset: Rotating, wheel_torque_nm: float, turns: float) -> float:
    """What a motor adds to omegȧ."""
    return wheel_torque_nm * (turns / wheelset.inertia_kgm2)


def brake_radps(wheelset: Rotating, friction: float, impulse_ns: float) -> float:
    """What the brake takes off omega by an impulse ∫F_perp dt."""
    return wheelset.brake_radius_m / wheelset.inertia_kgm2 * friction * impulse_ns


def braking_ratio(wheelset: Rotating, pressing_force_n: float, wheel_load_n: float) -> float:
    """The braking ratio q: adhesion demand of the brake of a wheelset that rolls, mu_w per unit of mu_b."""
    return wheelset.brake_radius_m / wheelset.wheel_radius_m * pressing_force_n / wheel_load_n


def motor_demand(wheelset: Rotating, wheel_torque_nm: float, wheel_load_n: float) -> float:
    """The adhesion demand of a motor's torque on a wheelset that rolls, mu_w: negative while it drives."""
    return -wheel_torque_nm / (wheelset.wheel_radius_m * wheel_load_n)
