"""How far each wheelset creeps under its brake, against how it rolled freely before: a torque meter without any sensor.

Within the linear part of the creep curve slip is proportional to the force between wheel and rail, for all wheelsets
alike. Radii, and whatever else is the same with and without brake, cancel against free rolling. How much is left of it
in the noise of the wheel speeds, their steps included, is told beside it.
"""

from collections.abc import Sequence
from math import exp, hypot, inf, sqrt

from msgspec import Struct

from brake_monitor.estimation.estimate import Estimate, WheelsetEstimate

FREE_AFTER_S = 3.0  # after the last contact every wheelset rolls freely
LEAST_SPEED_MPS = 5.0  # below it the speeds' own noise counts too much
REFERENCE_S = 10.0  # of free rolling are remembered; the track behind has no say
LEAST_REFERENCE_S = 3.0
AVERAGE_S = 1.0
LONGEST_GAP_S = 1.0


class Creep(Struct, frozen=True):
    """Of one wheelset. Its errors are those of its own speed; what the vehicle's errs by is common to all."""

    value: float  # about a second's mean
    noise_s: float  # the square of its own deviation over a second: over T s, a mean's is noise / T
    reference_std: float  # of the free rolling that it is told against, the same until the brake is released

    def std(self, span_s: float) -> float:
        """Standard deviation of a mean over so long."""
        return hypot(sqrt(self.noise_s / span_s), self.reference_std)


class CreepMeter:
    """Sees each estimate, in order of time."""

    def __init__(self, free_force_n: float) -> None:
        """Below `free_force_n` a brake is taken to be released."""
        self._free_force_n = free_force_n
        self._time_s = self._pressed_s = -inf
        self._free_s = 0.0
        self._free: list[float] = []  # omega / v of each wheelset, 1/m, while it rolls freely
        self._free_noise_s: list[float] = []  # of its logarithm
        self._now_s = 0.0
        self._now: list[float] = []  # ... and lately

    def note(self, now: Estimate, known: Sequence[bool]) -> None:
        """Take an estimate and which pressing forces are known: what `creep` is told from, should anyone ask."""
        time_s, speed_mps, wheelsets = now.time_s, now.speed_mps, now.wheelsets
        step_s, self._time_s = time_s - self._time_s, time_s
        pressed = max([wheelset.pressing_force_n for wheelset in wheelsets]) >= self._free_force_n
        if pressed or now.saturated or not all(known) or step_s < 0.0:  # at the latest as the clock was set back
            self._pressed_s = time_s
        if speed_mps < LEAST_SPEED_MPS or not 0.0 < step_s <= LONGEST_GAP_S:
            self._now_s, self._now = 0.0, []
            return
        turns = [wheelset.omega_radps / speed_mps for wheelset in wheelsets]
        self._now_s += step_s
        self._now = _nearer(self._now or turns, turns, max(1.0 - exp(-step_s / AVERAGE_S), step_s / self._now_s))
        if time_s - self._pressed_s > FREE_AFTER_S:
            self._free_s = min(self._free_s + step_s, REFERENCE_S)
            share = step_s / self._free_s
            self._free = _nearer(self._free or turns, turns, share)
            noise_s = [_relative_noise_s(wheelset) for wheelset in wheelsets]
            self._free_noise_s = _nearer(self._free_noise_s or noise_s, noise_s, share)

    def creep(self, now: Estimate) -> tuple[Creep, ...] | None:
        """Each wheelset's as of `now`, the estimate taken last, about a second's mean.

        None when it cannot be told: too slow, or free rolling was not seen, or too little of now.
        """
        if self._free_s < LEAST_REFERENCE_S or self._now_s < AVERAGE_S:
            return None
        return tuple([self._creep(i, wheelset) for i, wheelset in enumerate(now.wheelsets)])

    def _creep(self, i: int, wheelset: WheelsetEstimate) -> Creep:
        value = 1.0 - self._now[i] / self._free[i]
        return Creep(value, _relative_noise_s(wheelset), sqrt(self._free_noise_s[i] / self._free_s))


def _relative_noise_s(wheelset: WheelsetEstimate) -> float:
    """Of the logarithm of omega; 1 for a wheelset that stands."""
    turns_radps = max(wheelset.omega_radps, sqrt(wheelset.omega_noise))
    return wheelset.omega_noise / (turns_radps * turns_radps) if turns_radps else 0.0


def _nearer(before: list[float], target: list[float], share: float) -> list[float]:
    return [a + (target[i] - a) * share for i, a in enumerate(before)]
