"""How far each wheelset creeps under its brake, against how it rolled freely before: a torque meter without any sensor.

Within the linear part of the creep curve slip is proportional to the force between wheel and rail, for all wheelsets
alike. Radii, and whatever else is the same with and without brake, cancel against free rolling. How much is left of it
in the noise of the wheel speeds, their steps included, is told beside it. What motors make of it is not told apart from
what pads do.
"""

from collections.abc import Sequence
from math import exp, hypot, inf, sqrt
from statistics import fmean

from msgspec import Struct

from brake_monitor.estimation.brake_work import SLIDING_SLIP
from brake_monitor.estimation.core.regime_watch import ROLLING_AGAIN_S
from brake_monitor.estimation.estimate import LONGEST_STEP_S, Estimate, WheelsetEstimate
from brake_monitor.estimation.rolling.radius_calibration import LEAST_SPEED_MPS, TURNED_S
from brake_monitor.monitoring.passing_time import LastTime
from brake_monitor.monitoring.running_mean import RunningMean

MOTORS_LEFT_S = 3.0  # after a motor has acted, creep is the pads' alone
REFERENCE_S = 10.0  # of free rolling are remembered; the track behind has no say ...
ERRORS_S = 60.0  # ... but for how the vehicle's speed errs
ERRS_ALIKE_S = 5.0  # for about so long; what errs for less shows as scatter
LEAST_REFERENCE_S = 1.0  # how little that is worth, its deviation says
AVERAGE_S = 1.0
LEAST_CREEP = 3e-4  # to be expected, or of the others: less is lost in curves and noise


class Creep(Struct, frozen=True):
    """How far one wheelset creeps, and by how much its own speed errs, and that of the vehicle, for all alike."""

    value: float  # about a second's mean
    noise_s: float  # the square of its own deviation over a second: over T s, a mean's is noise / T
    reference_std: float  # of the free rolling that it is told against, the same until the brake is released
    common_noise_s: float  # the square of what the vehicle's speed errs by over a second, as `noise_s`
    common_lasting_std: float  # by so much it errs for ERRS_ALIKE_S and more

    def std(self, span_s: float) -> float:
        """Standard deviation of a mean over so long, against the other wheelsets'."""
        return hypot(sqrt(self.noise_s / span_s), self.reference_std)

    def common_std(self, span_s: float) -> float:
        """Likewise of what is common to all wheelsets."""
        lasting_std = self.common_lasting_std / sqrt(max(span_s / ERRS_ALIKE_S, 1.0))
        return hypot(sqrt(self.common_noise_s / span_s), lasting_std)


class CreepMeter:
    """Sees each estimate, in order of time; several may show it the same one, of whom the first is believed."""

    def __init__(self, free_force_n: float) -> None:
        """Below `free_force_n` a brake is taken to be released."""
        self._free_force_n = free_force_n
        self._seen: Estimate | None = None
        self._time_s = -inf
        self._driven = LastTime()  # a motor had a part in it
        self._held = LastTime()  # it did not roll freely, or was not known to
        self._rolled_s = -inf  # when it last rolled freely
        self._own_noise_s: list[float] = []  # of the logarithm of each wheelset's omega / v, as in `Creep`
        self._lately: list[float] = []  # of each omega / v, about a second's mean ...
        self._lately_s = 0.0  # ... over so long
        self._free_s = 0.0
        self._free: list[float] = []  # the same while it rolls freely
        self._free_noise_s: list[float] = []
        self._noise_s, self._lasting = RunningMean(ERRORS_S), RunningMean(ERRORS_S)  # squares, as in `Creep`
        self._off = 0.0  # by which all have left free rolling, lately

    def note(self, now: Estimate, known: Sequence[bool]) -> None:
        """Take an estimate, or the same one once more, and which pressing forces are known.

        Only where all of them are is it known that the wheelsets roll freely.
        """
        if now is self._seen:
            return
        self._seen = now
        step_s, self._time_s = now.time_s - self._time_s, now.time_s
        is_driven = now.a_motor_acts
        self._driven.see(now.time_s, is_driven)
        is_braked = max(now.forces_n) >= self._free_force_n
        slides = now.saturated or max([own.slip for own in now.wheelsets]) > SLIDING_SLIP  # that of a lost speed, too
        self._held.see(now.time_s, is_braked or is_driven or slides or not all(known))
        if now.time_s - self._rolled_s > TURNED_S:
            self._free_s = 0.0
        if now.speed_mps < LEAST_SPEED_MPS or not 0.0 < step_s <= LONGEST_STEP_S:
            self.forget_lately()
            return
        ratios = [wheelset.omega_radps / now.speed_mps for wheelset in now.wheelsets]
        self._own_noise_s = [_relative_noise_s(wheelset) for wheelset in now.wheelsets]
        self._lately_s += step_s
        share = max(1.0 - exp(-step_s / AVERAGE_S), step_s / self._lately_s)
        self._lately = nearer(self._lately or ratios, ratios, share)
        if now.time_s - self._held.time_s > ROLLING_AGAIN_S:
            self._rolled_s = now.time_s
            self._free_s = min(self._free_s + step_s, REFERENCE_S)
            share = step_s / self._free_s
            self._free = nearer(self._free or ratios, ratios, share)
            self._free_noise_s = nearer(self._free_noise_s or self._own_noise_s, self._own_noise_s, share)
            self._see_common(step_s)

    def forget_lately(self) -> None:
        """The vehicle's speed was another one than was thought, or none is told."""
        self._lately, self._lately_s = [], 0.0

    def _see_common(self, step_s: float) -> None:
        """See by how much the ratios of all, which roll freely, have left what they were."""
        off = fmean([lately / free for lately, free in zip(self._lately, self._free, strict=True)]) - 1.0
        self._off += (off - self._off) * step_s / ERRS_ALIKE_S
        self._noise_s.add(off * off, step_s)
        self._lasting.add(self._off * self._off, step_s)

    def creep(self, now: Estimate) -> tuple[Creep, ...] | None:
        """Each wheelset's as of `now`, the estimate taken last, about a second's mean.

        None when it cannot be told: too slow, or free rolling was not seen, or too little of now; or while a motor
        has a part in it.
        """
        if now.time_s - self._driven.time_s < MOTORS_LEFT_S:
            return None
        if self._free_s < LEAST_REFERENCE_S or self._lately_s < AVERAGE_S:
            return None
        return tuple([self._creep(i) for i in range(len(now.wheelsets))])

    def _creep(self, i: int) -> Creep:
        value = 1.0 - self._lately[i] / self._free[i]
        reference_std = sqrt(self._free_noise_s[i] / self._free_s)
        return Creep(value, self._own_noise_s[i], reference_std, self._noise_s.value, sqrt(self._lasting.value))


def _relative_noise_s(wheelset: WheelsetEstimate) -> float:
    """The noise of the logarithm of omega; 1 for a wheelset that stands."""
    turns_radps = max(wheelset.omega_radps, sqrt(wheelset.omega_noise))
    return wheelset.omega_noise / (turns_radps * turns_radps) if turns_radps else 0.0


def nearer(before: Sequence[float], target: Sequence[float], share: float) -> list[float]:
    """Means that go on to their target by this share of the way."""
    return [a + (target[i] - a) * share for i, a in enumerate(before)]
