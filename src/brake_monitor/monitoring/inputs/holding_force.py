"""What could hold a wheelset: its pads, and a motor that brakes, which counts as the pads that could do the same."""

from collections import deque
from math import inf

from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.settings.bounds import LARGEST_FRICTION
from brake_monitor.settings.config import Vehicle

LEAST_ADHESION = 0.01  # the brake torque must overcome at least as much
CAUSE_S = 1.5  # a brake that pressed so long ago may have stopped it


class HoldingForce:
    """The force of one wheelset's pads and motor, and how large it has been lately."""

    def __init__(self, vehicle: Vehicle, i: int, contact_force_n: float) -> None:
        self._force_per_nm = 1.0 / (LARGEST_FRICTION * vehicle.brake_radius_m[i])
        self._rail_nm_per_kg = LEAST_ADHESION * GRAVITY_MPS2 / vehicle.wheelset_count * vehicle.wheel_radius_m[i]
        self._contact_force_n = contact_force_n
        self.rail_nm = 0.0  # torque by which a rail that gives hardly anything turns the wheelset ...
        self.least_n = 0.0  # ... and the least force that holds it against that
        self.bear(vehicle.mass_kg)
        self.pressing_force_n = 0.0
        self.motor_force_n = 0.0  # with which pads would brake at the least as the motor does
        self.driven_s = -inf  # when the motor last drove it
        self.told_s = -inf  # when either was last told
        self._lately: deque[tuple[float, float]] = deque()  # (time, what both press like) at the last observations

    def bear(self, mass_kg: float) -> None:
        """Note the mass of the wagon."""
        self.rail_nm = self._rail_nm_per_kg * mass_kg
        self.least_n = max(self.rail_nm * self._force_per_nm, self._contact_force_n)

    @property
    def suffices(self) -> bool:
        """Whether the wheelset may be held by it."""
        return self.pressing_force_n + self.motor_force_n >= self.least_n

    @property
    def largest_n(self) -> float:
        """The largest that may have stopped the wheelset just now."""
        return max([self.pressing_force_n + self.motor_force_n, *[force_n for _, force_n in self._lately]])

    def see_force(self, time_s: float, pressing_force_n: float) -> None:
        """Take a good reading."""
        self.told_s, self.pressing_force_n = time_s, pressing_force_n

    def see_torque(self, time_s: float, accelerating_nm: float) -> None:
        """Take a good reading."""
        self.told_s, self.motor_force_n = time_s, self._force_per_nm * max(-accelerating_nm, 0.0)
        if self._force_per_nm * accelerating_nm >= self.least_n:
            self.driven_s = time_s

    def remember(self, time_s: float) -> None:
        """Remember, at each observation, what both press like."""
        lately = self._lately
        lately.append((time_s, self.pressing_force_n + self.motor_force_n))
        while time_s - lately[0][0] > CAUSE_S or lately[0][0] > time_s:
            lately.popleft()
