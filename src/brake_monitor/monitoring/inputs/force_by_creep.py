"""What share of a brake shows in how its wheelset creeps against the others', whatever its sensor says.

What the vehicle's speed errs by is common to all of them. But how far a wheelset should creep is known only by what the
others do, and that error is part of it.
"""

from collections.abc import Iterable, Sequence
from math import hypot, sqrt
from statistics import median

from brake_monitor.estimation.core.regime_watch import PRESSES_N
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.estimation.rolling.radius_calibration import LEAST_SPEED_MPS
from brake_monitor.monitoring.contact_stiffness import SOFTEST, STIFFEST, USUALLY_STIFFEST
from brake_monitor.monitoring.creep_meter import AVERAGE_S, LEAST_CREEP, Creep
from brake_monitor.monitoring.inputs.nominal_brakes import NominalBrakes
from brake_monitor.monitoring.inputs.watched_force import INDEPENDENT, SURE_SIGMAS, WORKS, ShownShare
from brake_monitor.monitoring.running_mean import RunningMean

LATE_STD_S = 0.03  # the vehicle's speed comes late, as behind a filter: all wheelsets seem to creep more under a brake
LEARNED_FROM = 500  # steady observations: what the vehicle speed errs by lasts for seconds, and is in all of them


class ForceByCreep:
    """Judges by how far wheelsets have crept for each newton: as all pressed steadily, or else as the others do now."""

    def __init__(self, sensors: Sequence[Sequence[int]], nominal: NominalBrakes) -> None:
        """`sensors` as in `ForceWatch`."""
        self._sensors = sensors
        self._nominal = nominal
        self._learned = [RunningMean(LEARNED_FROM) for _ in sensors]  # creep per newton of each ...
        self._learned_late = RunningMean(LEARNED_FROM)  # ... and what a late speed may have had in it
        self._lately, self._late_lately = RunningMean(), RunningMean()  # the same, of those that press now

    def learn(self, wheelsets: Iterable[int], creep: Sequence[Creep], now: Estimate) -> None:
        """Note by how much these creep, while all brakes press steadily."""
        for i in wheelsets:
            self._learned[i].add(creep[i].value / now.wheelsets[i].pressing_force_n)
        self._learned_late.add(_late_std(now) / median(now.forces_n))

    def begin(self) -> None:
        """Other brakes press than before."""
        self._lately.begin()
        self._late_lately.begin()

    def see(self, creep: Sequence[Creep], now: Estimate) -> None:
        """Note how far those creep that press: what the vehicle's speed errs by for a moment is none of it."""
        pressing = [(own.value, n) for own, n in zip(creep, now.forces_n, strict=True) if n >= PRESSES_N]
        if pressing:
            self._lately.add(median([value / force_n for value, force_n in pressing]))
            self._late_lately.add(_late_std(now) / median([force_n for _, force_n in pressing]))

    def share(self, i: int, as_if_n: float, creep: Sequence[Creep], now: Estimate) -> ShownShare | None:
        """Of brake i, over what `as_if_n` would do; None where that cannot be told.

        A sensor is right or wrong for all of its brakes: it is their mean.
        """
        shares = [self._share(k, as_if_n, creep, now) for k in self._sensors[i]]
        told = [share for share in shares if share is not None]
        if len(told) < len(shares):
            return None
        value = sum(share.value for share in told) / len(told)
        return ShownShare(value, max(share.lasting_std for share in told), max(share.noise_std for share in told))

    def _share(self, i: int, as_if_n: float, creep: Sequence[Creep], now: Estimate) -> ShownShare | None:
        others = [k for k in range(len(creep)) if k not in self._sensors[i]]
        expected = self._expected(i, as_if_n, creep, now)
        if not others or expected is None:
            return None
        lag = median([creep[k].value for k in others]) - creep[i].value
        whole = median([now.forces_n[k] for k in others]) / as_if_n
        ends = [max(whole - lag / creeps, 0.0) for creeps in expected]
        own, per_creep = sum(ends) / 2.0, sum([1.0 / creeps for creeps in expected]) / 2.0
        reference_std = hypot(creep[i].reference_std, max(creep[k].reference_std for k in others)) * per_creep
        noise_std = sqrt(creep[i].noise_s + max(creep[k].noise_s for k in others) / len(others)) * per_creep
        std = hypot(reference_std, (ends[0] - ends[1]) / 2.0 / SURE_SIGMAS)
        if len(others) > 1:
            return ShownShare(own, std, noise_std)
        alone, alone_std = creep[i].value * per_creep, creep[i].common_lasting_std * per_creep
        share = median([own, WORKS, alone])  # it may be the other one that lies
        return ShownShare(share, hypot(std, alone_std), noise_std)

    def _expected(self, i: int, as_if_n: float, creep: Sequence[Creep], now: Estimate) -> tuple[float, float] | None:
        """How far its wheelset creeps under such a force, at the least and at the most; None: it would not show."""
        learned = [mean.value for mean in self._learned if mean.count]
        expected = as_if_n * (median(learned) if learned else self._lately.value)
        if expected < LEAST_CREEP:
            return None
        adhesion = self._nominal.retardation_mps2(i, as_if_n, now.mass_kg) * len(creep) / GRAVITY_MPS2
        count = max(mean.count for mean in self._learned) if learned else self._lately.count
        common_std = creep[i].common_std(AVERAGE_S * max(count / INDEPENDENT, 1.0))
        least = max(expected - SURE_SIGMAS * common_std, min(expected, adhesion / STIFFEST))
        if len(creep) - len(self._sensors[i]) > 1:  # else the other one's own creep is looked at as well
            late_std = as_if_n * (self._learned_late if learned else self._late_lately).value
            least = max(least - SURE_SIGMAS * late_std, min(least, adhesion / USUALLY_STIFFEST))
        return least, min(expected + SURE_SIGMAS * common_std, max(expected, adhesion / SOFTEST))


def _late_std(now: Estimate) -> float:
    """By how much all wheelsets may seem to creep for a speed that comes late."""
    retardation_mps2 = now.adhesion * GRAVITY_MPS2 + now.deceleration_mps2
    return LATE_STD_S * max(retardation_mps2, 0.0) / max(now.speed_mps, LEAST_SPEED_MPS)
