"""What a step of the filter needs to know of the wagon and of its wheelsets; flags are 0 or 1."""

from typing import NamedTuple

from brake_monitor.estimation.kalman.straight_line import Named, straight_line


class Acting(NamedTuple):
    """Forces, flags and densities of one wheelset in a step of the filter; `WheelsetMoment` explains each field."""

    wheel_radius_m: float
    brake_radius_m: float
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
    """The same of the wagon as a whole; `WagonMoment` explains each field."""

    mass_kg: float
    gradient: float
    deceleration_density: float
    pitching_mps2: float
    heading: float
    torque_error_density: float


acting_on_wheelset = straight_line(tuple, Named(Acting))  # the numbers of an object with these names, in order
acting_on_wagon = straight_line(tuple, Named(ActingOnWagon))
