"""What acts on the wagon and on its wheelsets in a step of the filter; flags are 0 or 1."""

from typing import NamedTuple


class Acting(NamedTuple):
    """What acts on a wheelset in a step of the filter: see `WheelsetMoment` for each."""

    pressing_force_n: float
    wheel_torque_nm: float
    wheel_load_n: float
    begin_load_n: float
    begin_force_n: float
    end_force_n: float
    begin_torque_nm: float
    end_torque_nm: float
    impulse_std_ns: float
    unseen_std_ns: float
    has_equation: float
    rolls: float
    slides: float
    unsettled: float
    force_effect_observable: float
    friction_observable: float
    stuck_lately: float
    omega_density: float
    adhesion_density: float
    small_slip: float
    medium_slip: float
    large_slip: float
    slip_change_mps: float


class ActingOnWagon(NamedTuple):
    """What acts on the wagon as a whole in a step of the filter: see `WagonMoment` for each."""

    mass_kg: float
    gradient: float
    deceleration_density: float
    pitching_mps2: float
