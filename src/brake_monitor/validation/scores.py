"""How good the estimates of a run were: pure functions of arrays, and sums that add up over many runs."""

from collections.abc import Iterable
from typing import Self

import numpy as np
from msgspec import Struct

from brake_monitor.arrays import Bools, Floats
from brake_monitor.validation.series import Series

SETTLED_S = 3.0  # judged from then on ...
LEAST_SPEED_MPS = 2.0  # ... while the wagon is faster
LEAST_FORCE_N = 5000.0  # friction is judged where the pad presses with more
LARGE_ERROR = 0.02  # the paper's own bound of the adhesion error
AIMED_ADHESION_RMSE, AIMED_FRICTION_RMSE = 0.002, 0.010  # where all is as modelled
AIMED_COVERAGE = (0.90, 0.99)  # of the 95 % intervals
COVERING_SIGMAS = 1.959964  # half width of a 95 % interval of a normal distribution
DISHONEST_SIGMAS = 3.0
SMALLEST_STD = 1e-12  # an estimator that is told the truth says 0


def longest_s(times_s: Floats, flags: Bools) -> float:
    """Longest unbroken time with the flag set: from its first sample to the first one without it (or the last)."""
    longest, since = 0.0, None
    for time_s, flag in zip(times_s.tolist(), flags.tolist(), strict=True):
        if since is not None:
            longest = max(longest, time_s - since)
        if not flag:
            since = None
        elif since is None:
            since = time_s
    return longest


def judged(series: Series) -> Bools:
    """Samples that count, shape (K,)."""
    return (series.time_s >= SETTLED_S) & (series.truth.speed_mps > LEAST_SPEED_MPS)


def pressed(series: Series) -> Bools:
    """Samples whose friction counts, shape (K, N)."""
    return judged(series)[:, None] & (series.truth.pressing_force_n > LEAST_FORCE_N)


def _off(estimated: Floats, true: Floats) -> Floats:
    """Errors; infinite where the estimate is no number: that would be beyond no limit."""
    off: Floats = np.where(np.isnan(estimated), np.inf, estimated - true)
    return off


class Additive(Struct, frozen=True):
    """Figures of several runs that add up, field by field."""

    def __add__(self, other: Self) -> Self:
        return type(self)(*(getattr(self, name) + getattr(other, name) for name in self.__struct_fields__))


class Sums(Additive, frozen=True):
    """Squared errors of one quantity, as they are and over the published variance, added up."""

    count: int = 0
    square: float = 0.0
    normalised_square: float = 0.0
    covered: int = 0  # truth inside the published 95 % interval

    @classmethod
    def of(cls, error: Floats, std: Floats) -> Self:
        """Sum over arrays of one shape."""
        normalised = error / np.maximum(std, SMALLEST_STD)
        return cls(
            count=error.size,
            square=float(np.sum(error**2)),
            normalised_square=float(np.sum(normalised**2)),
            covered=int(np.sum(np.abs(normalised) <= COVERING_SIGMAS)),
        )

    @property
    def rmse(self) -> float:
        """Root mean square error; NaN when nothing was judged."""
        return float(np.sqrt(self.square / self.count)) if self.count else np.nan

    @property
    def coverage(self) -> float:
        """Share of the 95 % intervals that hold the truth."""
        return self.covered / self.count if self.count else np.nan

    @property
    def nees(self) -> float:
        """Mean normalised (estimation) error squared: 1 when the published deviations are those of the errors."""
        return self.normalised_square / self.count if self.count else np.nan


class Score(Struct, frozen=True):
    """The errors of one run, or of several runs of one case put together."""

    runs: int
    adhesion: Sums
    friction: Sums
    worst: float  # greatest |error| of adhesion
    longest_large_s: float  # longest time that |error| of adhesion stays above LARGE_ERROR
    longest_dishonest_s: float  # longest time `valid` while wrong by more than DISHONEST_SIGMAS
    worst_run_rmse: float  # of adhesion
    valid: int  # judged samples with status `valid`

    @classmethod
    def of(cls, series: Series) -> Self:
        """Judge one run."""
        truth = series.truth
        counts, friction_counts = judged(series), pressed(series)
        error = _off(series.adhesion, truth.adhesion)
        friction_error = _off(series.friction, truth.friction)
        adhesion = Sums.of(error[counts], series.adhesion_std[counts])
        honest = np.abs(error) <= DISHONEST_SIGMAS * series.adhesion_std
        dishonest = counts & series.valid & ~honest  # with a deviation that is no number, too
        return cls(
            runs=1,
            adhesion=adhesion,
            friction=Sums.of(friction_error[friction_counts], series.friction_std[friction_counts]),
            worst=float(np.max(np.abs(error[counts]), initial=0.0)),
            longest_large_s=longest_s(series.time_s, counts & (np.abs(error) > LARGE_ERROR)),
            longest_dishonest_s=longest_s(series.time_s, dishonest),
            worst_run_rmse=adhesion.rmse,
            valid=int(np.sum(series.valid & counts)),
        )

    @classmethod
    def together(cls, scores: Iterable[Self]) -> Self:
        """Pool runs: every judged sample counts alike, extremes are those of the worst run."""
        runs = list(scores)
        return cls(
            runs=sum(run.runs for run in runs),
            adhesion=sum((run.adhesion for run in runs), Sums()),
            friction=sum((run.friction for run in runs), Sums()),
            worst=max(run.worst for run in runs),
            longest_large_s=max(run.longest_large_s for run in runs),
            longest_dishonest_s=max(run.longest_dishonest_s for run in runs),
            worst_run_rmse=max(run.worst_run_rmse for run in runs),
            valid=sum(run.valid for run in runs),
        )

    @property
    def valid_share(self) -> float:
        """Share of the judged samples that are published as `valid`."""
        return self.valid / self.adhesion.count if self.adhesion.count else np.nan
