"""How well an estimator does on a recording: by what it foretold of the readings, or by the truth."""

from collections.abc import Sequence
from math import exp, inf, isfinite, log, log1p, log10, pi
from typing import ClassVar

import numpy as np
from msgspec import Struct

from brake_monitor.estimation.core import Core
from brake_monitor.estimation.ekf import Innovation
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.tuning import DENSITIES, PRESETS, Tuning
from brake_monitor.samples import Channel
from brake_monitor.settings.config import EstimatorSettings, Vehicle
from brake_monitor.tuner.recording import Recording, Truth
from brake_monitor.validation.scores import LEAST_FORCE_N, LEAST_SPEED_MPS, SETTLED_S, Additive, Sums

STRANGE_SHARE = 0.01  # readings that the model does not explain: outliers, jumps of the adhesion
STRANGE_STD_MPS = 1.0  # how far from the prediction such a reading lies (of a wheel: at its circumference)

# Speeds are foretold best by densities that are too sure of adhesion and friction: what the model leaves out hardly
# shows in the next reading, and more readings do not change that. So the preset stands as a prior: to leave it by a
# decade must gain so many nats per reading, and by two decades four times as many.
PRIOR_NATS = 0.02

ESTIMATES_EVERY_S = 0.05
AIMED_ADHESION_RMSE = 0.002  # errors are weighed in units of what is aimed at
AIMED_FRICTION_RMSE = 0.010
AIMED_COVERAGE = (0.90, 0.99)  # of the 95 % intervals
COVERAGE_WEIGHT = 10.0  # a tenth of the truth outside of the intervals counts as much as an error of one aim


class Likelihood(Additive, frozen=True):
    """Logarithm of the probability density of all readings, each given those before it, and that of the tuning."""

    readings: int = 0
    nats: float = 0.0
    prior_nats: float = 0.0
    least_gain: ClassVar[float] = 1.0  # a smaller change of the cost means nothing

    @property
    def judged(self) -> int:
        """All readings are."""
        return self.readings

    @property
    def cost(self) -> float:
        """Less likely costs more."""
        return -self.nats - self.prior_nats

    def told(self) -> dict[str, str]:
        """Means over all readings."""
        return {
            "log-likelihood of a reading": f"{self.nats / self.readings:.3f}",
            "less what leaving the preset costs": f"{-self.cost / self.readings:.3f}",
        }


class Accuracy(Additive, frozen=True):
    """Errors against the truth."""

    adhesion: Sums = Sums()
    friction: Sums = Sums()
    least_gain: ClassVar[float] = 0.005  # a smaller change of the cost means nothing

    @property
    def judged(self) -> int:
        """Estimates of the adhesion."""
        return self.adhesion.count

    @property
    def cost(self) -> float:
        """The errors in units of their aims, and what coverage lacks."""
        aims = ((self.adhesion, AIMED_ADHESION_RMSE), (self.friction, AIMED_FRICTION_RMSE))
        return sum(sums.rmse / aim + COVERAGE_WEIGHT * _lacking(sums.coverage) for sums, aim in aims if sums.count)

    def told(self) -> dict[str, str]:
        """Error and coverage of what could be judged."""
        known = (("adhesion", self.adhesion), ("friction", self.friction))
        return {
            f"{name} {figure}": text
            for name, sums in known
            if sums.count
            for figure, text in (("RMSE", f"{sums.rmse:.4f}"), ("inside 95 % interval", f"{sums.coverage:.0%}"))
        }


Score = Likelihood | Accuracy


class ForetellingCore(Core):
    """The steps of an estimator, adding up how probable each reading was before it was seen.

    A reading is either one of the model's, N(0, S) about the prediction, or with the probability STRANGE_SHARE a
    strange one, N(0, STRANGE_STD²). Both are fixed before the reading is seen, so neither the gate nor the widening
    after a surprise can improve the sum: every reading counts, and a rejected one costs what a strange one costs.
    """

    foretold: "Foretold"

    def fuse(self, index: int, value: float, variance: float) -> int:
        """Note a reading, and correct the estimate by it."""
        seen = self.filter.innovation(index, value, variance)
        self.foretold.see(index, seen, was_foretold=isfinite(self.readings[index].fused_s))
        return super().fuse(index, value, variance)


class Foretold:
    """The sum over all readings."""

    def __init__(self, wheel_radius_m: Sequence[float]) -> None:
        wheels = ((STRANGE_STD_MPS / radius_m) ** 2 for radius_m in wheel_radius_m)
        self._strange_variance = (*wheels, STRANGE_STD_MPS**2)  # per measured state
        self.readings = 0
        self.nats = 0.0

    def see(self, index: int, seen: Innovation, *, was_foretold: bool) -> None:
        """Add a reading; the first after a start was not foretold."""
        strange_variance = self._strange_variance[index]
        self.readings += 1
        if was_foretold:
            usual = log1p(-STRANGE_SHARE) + _log_normal(seen.residual, seen.variance)
            strange = log(STRANGE_SHARE) + _log_normal(seen.residual, strange_variance)
            self.nats += _log_sum(usual, strange)
        else:
            self.nats += log(STRANGE_SHARE) + _log_normal(0.0, strange_variance)


class ForetellingEstimator(Estimator):
    """The estimator, adding up how probable each reading was before it was seen."""

    core_type = ForetellingCore

    def __init__(
        self, vehicle: Vehicle, settings: EstimatorSettings, channels: tuple[Channel, ...], tuning: Tuning
    ) -> None:
        super().__init__(vehicle, settings, channels, tuning)
        self.foretold = Foretold(vehicle.wheel_radius_m)
        assert isinstance(self.core, ForetellingCore)
        self.core.foretold = self.foretold


class Judge(Struct, frozen=True):
    """Runs the estimator of a vehicle over recordings with one tuning or another."""

    vehicle: Vehicle
    settings: EstimatorSettings
    channels: tuple[Channel, ...]

    def score(self, recording: Recording, tuning: Tuning) -> Score:
        """Accuracy where the truth is known, likelihood where it is not."""
        if recording.truth is None:
            return self._likelihood(recording, tuning)
        return self._accuracy(recording, recording.truth, tuning)

    def _likelihood(self, recording: Recording, tuning: Tuning) -> Likelihood:
        estimator = ForetellingEstimator(self.vehicle, self.settings, self.channels, tuning)
        for sample in recording.samples:
            estimator.take(sample)
        decades = decades_between(tuning, PRESETS[self.settings.preset])
        foretold = estimator.foretold
        prior_nats = -PRIOR_NATS * foretold.readings * sum(distance**2 for distance in decades)
        return Likelihood(foretold.readings, foretold.nats, prior_nats)

    def _accuracy(self, recording: Recording, truth: Truth, tuning: Tuning) -> Accuracy:
        estimator = Estimator(self.vehicle, self.settings, self.channels, tuning)
        from_s = max(recording.samples[0].time_s + SETTLED_S, truth.time_s[0])
        to_s = truth.time_s[-1]
        estimates: list[Estimate] = []
        for sample in recording.samples:
            if not estimator.take(sample) or not from_s <= estimator.time_s <= to_s:
                continue
            if estimator.speed_mps > LEAST_SPEED_MPS:
                estimates.append(estimator.estimate())
                from_s = estimator.time_s + ESTIMATES_EVERY_S
        return _compared(estimates, truth) if estimates else Accuracy()


def decades_between(one: Tuning, other: Tuning) -> list[float]:
    """How far their densities lie apart; one that is switched off in either does not count."""
    pairs = ((getattr(one, name), getattr(other, name)) for name in DENSITIES)
    return [log10(a / b) for a, b in pairs if a > 0.0 and b > 0.0]


def _compared(estimates: list[Estimate], truth: Truth) -> Accuracy:
    time_s = np.array([e.time_s for e in estimates])
    error = np.array([e.adhesion for e in estimates]) - np.interp(time_s, truth.time_s, truth.adhesion)
    friction = Sums()
    for i, column in enumerate(truth.friction.T):
        wheelset = [e.wheelsets[i] for e in estimates]
        pressed = np.array([w.pressing_force_n > LEAST_FORCE_N for w in wheelset])
        friction_error = np.array([w.friction for w in wheelset]) - np.interp(time_s, truth.time_s, column)
        friction += Sums.of(friction_error[pressed], np.array([w.friction_std for w in wheelset])[pressed])
    return Accuracy(Sums.of(error, np.array([e.adhesion_std for e in estimates])), friction)


def _lacking(coverage: float) -> float:
    low, high = AIMED_COVERAGE
    return max(low - coverage, coverage - high, 0.0)


def _log_normal(residual: float, variance: float) -> float:
    return -0.5 * (residual * residual / variance + log(2.0 * pi * variance))


def _log_sum(one: float, other: float) -> float:
    """log(e^one + e^other)."""
    low, high = min(one, other), max(one, other)
    return high + log1p(exp(low - high)) if low > -inf else high
