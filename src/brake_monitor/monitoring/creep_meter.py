"""How far each wheelset creeps under its brake, against how it rolled freely before: a torque meter without any sensor.

Within the linear part of the creep curve slip is proportional to the force between wheel and rail, for all wheelsets
alike. Radii, and whatever else is the same with and without brake, cancel against free rolling.
"""

from collections.abc import Sequence
from math import exp, inf

from brake_monitor.estimate import Estimate

FREE_AFTER_S = 3.0  # after the last contact every wheelset rolls freely
LEAST_SPEED_MPS = 5.0  # below it the speeds' own noise counts too much
REFERENCE_S = 10.0  # of free rolling are remembered; the track behind has no say
LEAST_REFERENCE_S = 3.0
AVERAGE_S = 1.0
LONGEST_GAP_S = 1.0


class CreepMeter:
    """Sees each estimate, in order of time."""

    def __init__(self, free_force_n: float) -> None:
        """Below `free_force_n` a brake is taken to be released."""
        self._free_force_n = free_force_n
        self._time_s = self._pressed_s = -inf
        self._free_s = 0.0
        self._free: list[float] = []  # omega / v of each wheelset, 1/m, while it rolls freely
        self._now_s = 0.0
        self._now: list[float] = []  # ... and lately

    def see(self, now: Estimate, known: Sequence[bool]) -> tuple[float, ...] | None:
        """Take an estimate and which pressing forces are known; each wheelset's creep, about a second's mean.

        None when it cannot be told: too slow, or free rolling was not seen, or too little of now.
        """
        step_s, self._time_s = now.time_s - self._time_s, now.time_s
        pressed = any(wheelset.pressing_force_n >= self._free_force_n for wheelset in now.wheelsets)
        if pressed or now.saturated or not all(known) or step_s < 0.0:  # at the latest as the clock was set back
            self._pressed_s = now.time_s
        if now.speed_mps < LEAST_SPEED_MPS or not 0.0 < step_s <= LONGEST_GAP_S:
            self._now_s, self._now = 0.0, []
            return None
        turns = [wheelset.omega_radps / now.speed_mps for wheelset in now.wheelsets]
        self._now_s += step_s
        self._now = _nearer(self._now or turns, turns, max(1.0 - exp(-step_s / AVERAGE_S), step_s / self._now_s))
        if now.time_s - self._pressed_s > FREE_AFTER_S:
            self._free_s = min(self._free_s + step_s, REFERENCE_S)
            self._free = _nearer(self._free or turns, turns, step_s / self._free_s)
        if self._free_s < LEAST_REFERENCE_S or self._now_s < AVERAGE_S:
            return None
        return tuple(1.0 - turn / free for turn, free in zip(self._now, self._free, strict=True))


def _nearer(before: list[float], target: list[float], share: float) -> list[float]:
    return [a + (b - a) * share for a, b in zip(before, target, strict=True)]
