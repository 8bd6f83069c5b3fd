"""Whether the vehicle speed of a recording errs for longer than from one reading to the next.

Filters, satellites and what a radar's beam falls on make readings err alike for a second or so. To the estimator each
is a measurement of its own, and it takes the error for the wagon's; with a `noise_std` that stands for their means it
does not. The wheels show the error while the wagon rolls steadily: their radii and a lag are the same all the time.
"""

from collections.abc import Iterator, Sequence
from math import sqrt

import numpy as np

from brake_monitor.arrays import Floats, indices
from brake_monitor.inspection.first_hour import LEAST_MPS, FirstHour, Readings, change_per_s
from brake_monitor.inspection.repeated import times_repeated
from brake_monitor.samples import Quantity

BLOCK_S = 2.0  # over which means are taken: estimates of the line and the pads go by some seconds
APART = 2  # blocks from one mean to the other: neighbours err alike
FULL = 0.8  # of a block's readings, so many at least
STEADY_MPS2, ALIKE_MPS2 = 0.15, 0.03  # in a block, and from one to the other: a lag changes the difference by less
LEAST_PAIRS = 10  # of blocks
STEPS = 0.5  # of the signal: less is how it rounds a speed that hardly changes
SPIKE = 4.0  # times the median size; a normal variate reaches that in 0.7 %
CLEARLY = 2.0  # times as noisy as configured


def times_noisier(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> float:
    """The factor on noise_std that would make it right for means over some seconds; 1 when nothing can be told."""
    speeds = first_hour.speeds_told_together_mps(wheel_radius_m)
    if speeds is None or times_repeated(first_hour, Quantity.SPEED) > 1:
        return 1.0
    (times_s, told_mps), *wheels = speeds
    wheels_mps = np.array([wheel.at(times_s) for wheel in wheels])
    rolling_mps = wheels_mps.mean(axis=0)
    mps2 = change_per_s(Readings(times_s, rolling_mps).at, times_s)
    steady = (np.minimum(told_mps, wheels_mps.min(axis=0)) > LEAST_MPS) & (np.abs(mps2) < STEADY_MPS2)
    blocks, block, count = np.unique((times_s - times_s[0]) // BLOCK_S, return_inverse=True, return_counts=True)
    per_block = float(np.median(count))
    whole = (np.bincount(indices(block), steady) == count) & (count > FULL * per_block)

    def changes(values: Floats) -> Floats:
        """How the mean changes from each block to the one that lies `APART` later."""
        means: Floats = np.bincount(indices(block), values) / count
        return means[APART:] - means[:-APART]

    pairs = whole[APART:] & whole[:-APART] & (blocks[APART:] - blocks[:-APART] == APART)
    pairs &= np.abs(changes(mps2)) < ALIKE_MPS2
    if np.count_nonzero(pairs) < LEAST_PAIRS:
        return 1.0
    radius_error = np.median(told_mps[steady] / rolling_mps[steady])
    mean_std = _std(changes(told_mps - radius_error * rolling_mps)[pairs])
    moved = np.abs(np.diff(told_mps))
    step_mps = float(moved[moved > 0.0].min(initial=np.inf))
    if not mean_std / sqrt(2.0) > STEPS * step_mps:
        return 1.0
    variance = 0.5 * mean_std**2 - _variance_of_mean([changes(own - rolling_mps)[pairs] for own in wheels_mps])
    times = sqrt(max(variance, 0.0) * per_block) / first_hour.noise_std(Quantity.SPEED)
    return times if times > CLEARLY else 1.0


def _std(values: Floats) -> float:
    """The root of the mean square of those that are no spikes."""
    size = np.abs(values)
    return float(np.sqrt(np.mean(np.square(values[size <= SPIKE * np.median(size)]))))


def _variance_of_mean(apart: Sequence[Floats]) -> float:
    """The variance of the wheels' mean, by how far their changes lie from its own; a single wheel does not tell."""
    n = len(apart)
    return float(np.mean(np.square(apart))) / (2.0 * (n - 1)) if n > 1 else 0.0


def remarks_on_wandering(first_hour: FirstHour, wheel_radius_m: Sequence[float]) -> Iterator[str]:
    """What to do about it."""
    times = times_noisier(first_hour, wheel_radius_m)
    if times > 1.0:
        yield (
            "speed errs for longer than from one reading to the next, as the wheels show while they roll, and each "
            f"reading counts as a measurement: multiply its noise_std by {times:.1f}"
        )
