"""The vehicle's speed as it is read, one reading after the other or many of them together."""

from math import inf
from typing import TypeVar

from brake_monitor.arrays import Floats

HARDEST_RETARDATION_MPS2 = 2.0  # no wagon retards as much; a wheelset that begins to slide slows down far quicker
SPEED_JUMP_MPS = 1.5  # between two readings, beyond what any wagon loses or gains meanwhile

# Of one reading, or of many in an array.
Number = TypeVar("Number", float, Floats)


def most_without_jump_mps(step_s: Number) -> Number:
    """By how much the vehicle's speed can change from one reading to the next."""
    return SPEED_JUMP_MPS + HARDEST_RETARDATION_MPS2 * step_s


class VehicleSpeed:
    """The vehicle's speed as it is read."""

    def __init__(self) -> None:
        self.mps: float | None = None
        self.time_s = -inf
        self.jumped = False

    def see(self, time_s: float, value: float) -> None:
        """Take a good reading."""
        speed_mps = abs(value)
        if self.mps is not None:
            self.jumped |= abs(speed_mps - self.mps) > most_without_jump_mps(max(time_s - self.time_s, 0.0))
        self.time_s, self.mps = time_s, speed_mps

    def go_on(self, time_s: float, speed_mps: float, *, jumped: bool) -> None:
        """Take several readings together: the last of them, and whether there is a jump among them."""
        self.jumped |= jumped
        self.time_s, self.mps = time_s, speed_mps
