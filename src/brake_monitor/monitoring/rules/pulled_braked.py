"""How much speed a wagon has gained while its brakes press: the train pulls it, and they have not been released."""

from collections.abc import Sequence
from math import inf


class PulledBraked:
    """Sees every observation, in order of time."""

    def __init__(self, least_force_n: float) -> None:
        """A brake that presses with less, as one that keeps its discs free of snow, is taken to be released."""
        self._least_force_n = least_force_n
        self.least_speed_mps = inf  # since more than half of the brakes have pressed without interruption

    def see(self, speed_mps: float, forces_n: Sequence[float]) -> float:
        """Take an observation, without forces where they are not known; the speed gained, m/s.

        0 while no more than half of the brakes press, as far as is known.
        """
        if 2 * sum([force_n >= self._least_force_n for force_n in forces_n]) <= len(forces_n):
            self.least_speed_mps = inf
            return 0.0
        self.least_speed_mps = min(self.least_speed_mps, speed_mps)
        return speed_mps - self.least_speed_mps
