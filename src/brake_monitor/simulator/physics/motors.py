"""Motors that drive wheelsets, and brake them before their pads do.

Of what the driver asks of a driven wheelset its motor does as much as it can: by its torque, by its power at high
speed, and less and less as the wheelset comes to stand. Its pads do the rest. Slide protection takes the torque away
and gives it back as it does with the air of the pads, which meanwhile do no more for it.
"""

import math
from dataclasses import dataclass

from brake_monitor.settings.config import Vehicle
from brake_monitor.simulator.physics.motion import Wheelsets
from brake_monitor.simulator.physics.pad import NOMINAL_FRICTION
from brake_monitor.simulator.physics.pneumatics import DUMP, HOLD

FULL_SHARE = 0.8  # of what sound pads do in a full brake
POWER_W_PER_KG = 15.0  # of the mass on the wheelset
TORQUE_TIME_CONSTANT_S = 0.2
DUMP_TIME_CONSTANT_S = 0.04
LEAST_RADPS = 1.0  # power limits no torque below


@dataclass(frozen=True, slots=True)
class Motors:
    """Which wheelsets have one, and where pads take over from them."""

    wheelsets: frozenset[int]  # from 0
    fade_mps: float  # below it the dynamic brake does less and less, and at half of it nothing


class MotorDrive:
    """The motors of one run; torques that brake forward motion are positive, as pulls that drive forward are."""

    def __init__(self, motors: Motors, vehicle: Vehicle, wheels: Wheelsets, mass_kg: float) -> None:
        self._driven, self._fade_mps = sorted(motors.wheelsets), motors.fade_mps
        self._power_w = POWER_W_PER_KG * mass_kg / vehicle.wheelset_count
        self._brake_nm = [  # of the pads in a full brake
            NOMINAL_FRICTION * wheel.full_force_n * wheel.brake_radius_m for wheel in wheels
        ]

    def step(self, step_s: float, demand: float, pull_n: float, wheels: Wheelsets) -> None:
        """Let them act for an interval; `pull_n` is what the driver asks of all of them together."""
        for i in self._driven:
            wheel, full_nm = wheels[i], self._brake_nm[i]
            turns_radps = abs(wheel.omega_radps)
            most_nm = min(FULL_SHARE * full_nm, self._power_w / max(turns_radps, LEAST_RADPS))
            braking_nm = min(demand * full_nm, most_nm * self._left(turns_radps * wheel.radius_m))
            wheel.blending = 1.0 - braking_nm / (demand * full_nm) if demand > 0.0 else 1.0
            driving_nm = pull_n * wheel.radius_m / len(self._driven)
            target_nm = math.copysign(braking_nm, wheel.omega_radps) - min(max(driving_nm, -most_nm), most_nm)
            wheel.motor_nm = _follow(wheel.motor_nm, target_nm, step_s, wheel.valve)

    def _left(self, speed_mps: float) -> float:
        """Share of the dynamic brake that is left as it fades."""
        return min(max(2.0 * speed_mps / self._fade_mps - 1.0, 0.0), 1.0)


def _follow(torque_nm: float, target_nm: float, step_s: float, valve: float) -> float:
    """What becomes of a torque while slide protection does this with its wheelset."""
    if valve == HOLD:
        return torque_nm
    if valve == DUMP:
        return torque_nm * math.exp(-step_s / DUMP_TIME_CONSTANT_S)
    return torque_nm + (target_nm - torque_nm) * -math.expm1(-step_s / TORQUE_TIME_CONSTANT_S)
