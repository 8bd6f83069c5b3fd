"""How well an estimator does on a recording: by what it foretold of the readings, or by the truth."""

from math import log10
from typing import ClassVar

import numpy as np
from msgspec import Struct

from brake_monitor.compiled.kept_code import have_made
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.tuning import FITTED_DENSITIES, PRESETS, Tuning
from brake_monitor.processing.whole_recording import Known, take_all
from brake_monitor.samples import Channel
from brake_monitor.settings.config import EstimatorSettings, Vehicle
from brake_monitor.tuner.recording import Recording, Truth
from brake_monitor.validation.scores import (
    AIMED_ADHESION_RMSE,
    AIMED_COVERAGE,
    AIMED_FRICTION_RMSE,
    LEAST_FORCE_N,
    LEAST_SPEED_MPS,
    SETTLED_S,
    Additive,
    Sums,
)

# Speeds are foretold best by densities that are too sure of adhesion and friction: what the model leaves out hardly
# shows in the next reading, and more readings do not change that. So the preset stands as a prior: to leave it by a
# decade must gain so many nats per reading, and by two decades four times as many.
PRIOR_NATS = 0.02

ESTIMATES_EVERY_S = 0.05
COVERAGE_WEIGHT = 10.0  # a tenth of the truth outside of the intervals counts as much as an error of one aim


class Likelihood(Additive, frozen=True):
    """Logarithm of the probability density of all readings, each given those before it, and that of the tuning."""

    readings: int
    nats: float
    prior_nats: float = 0.0
    least_gain: ClassVar[float] = 1.0  # a smaller change of the cost means nothing

    @property
    def judged(self) -> int:
        """How many readings were judged: all."""
        return self.readings

    @property
    def cost(self) -> float:
        """Less likely costs more."""
        return -self.nats - self.prior_nats

    def told(self) -> dict[str, str]:
        """Means over all readings."""
        return {
            "log-likelihood of a reading": f"{self.nats / self.readings:z.3f}",
            "less what leaving the preset costs": f"{-self.cost / self.readings:z.3f}",
        }


class Accuracy(Additive, frozen=True):
    """Errors against the truth."""

    adhesion: Sums
    friction: Sums
    least_gain: ClassVar[float] = 0.005  # a smaller change of the cost means nothing

    @property
    def judged(self) -> int:
        """How many estimates were judged."""
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

    def have_compiled(self) -> None:
        """Let machine code be made of the estimator that is needed; until it is there Python scores."""
        estimator = Estimator(self.vehicle, self.settings, self.channels)
        if not estimator.waits:
            have_made(estimator)

    def _likelihood(self, recording: Recording, tuning: Tuning) -> Likelihood:
        estimator = Estimator(self.vehicle, self.settings, self.channels, tuning, foretells=True)
        take_all(estimator, recording.samples)
        decades = decades_between(tuning, PRESETS[self.settings.preset])
        foretold = estimator.core.foretold
        prior_nats = -PRIOR_NATS * foretold.readings * sum(distance**2 for distance in decades)
        return Likelihood(foretold.readings, foretold.nats, prior_nats)

    def _accuracy(self, recording: Recording, truth: Truth, tuning: Tuning) -> Accuracy:
        estimator = Estimator(self.vehicle, self.settings, self.channels, tuning)
        known = take_all(estimator, recording.samples, ESTIMATES_EVERY_S)
        time_s = known.wagon("time_s")
        from_s = max(float(recording.samples.time_s[0]) + SETTLED_S, truth.time_s[0])
        judged = (time_s >= from_s) & (time_s <= truth.time_s[-1]) & (known.wagon("speed_mps") > LEAST_SPEED_MPS)
        return _compared(known.where(judged), truth)


def decades_between(one: Tuning, other: Tuning) -> list[float]:
    """How far their densities lie apart; one that is switched off in either does not count."""
    pairs = ((getattr(one, name), getattr(other, name)) for name in FITTED_DENSITIES)
    return [log10(a / b) for a, b in pairs if a > 0.0 and b > 0.0]


def _compared(known: Known, truth: Truth) -> Accuracy:
    time_s = known.wagon("time_s")
    error = known.wagon("adhesion") - np.interp(time_s, truth.time_s, truth.adhesion)
    friction = Sums()
    for i, column in enumerate(truth.friction.T):
        friction_error = known.each("friction")[:, i] - np.interp(time_s, truth.time_s, column)
        pressed = known.each("pressing_force_n")[:, i] > LEAST_FORCE_N
        friction += Sums.of(friction_error[pressed], known.each("friction_std")[pressed, i])
    return Accuracy(Sums.of(error, known.wagon("adhesion_std")), friction)


def _lacking(coverage: float) -> float:
    low, high = AIMED_COVERAGE
    return max(low - coverage, coverage - high, 0.0)
