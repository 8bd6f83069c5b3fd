"""Means of observations that err alike for a while: how well they are known, by the means of blocks of them."""

from collections.abc import Sequence
from itertools import pairwise
from math import hypot, sqrt
from statistics import fmean, pstdev, pvariance

BLOCK = 10  # observations whose mean is one independent value
LEAST_CORRELATION = 0.2  # of one block with the next; so few blocks may hide as much


def moved(early: Sequence[float], late: Sequence[float]) -> float:
    """By how much the mean has moved, less one deviation of that."""
    (early_mean, early_std), (late_mean, late_std) = mean_and_std(early), mean_and_std(late)
    return abs(early_mean - late_mean) - hypot(early_std, late_std)


def mean_and_std(values: Sequence[float]) -> tuple[float, float]:
    """Mean of a series, and its deviation by the scatter of its blocks."""
    blocks = block_means(values)
    return fmean(values), pstdev(blocks) / sqrt(max(len(blocks) - 1, 1))


def std_between(blocks: Sequence[float], others: float) -> float:
    """Of the difference between their mean and that of so many other blocks, which err alike, maybe for seconds."""
    mean, variance = fmean(blocks), pvariance(blocks)
    products = sum((early - mean) * (late - mean) for early, late in pairwise(blocks))
    correlation = max(products / (len(blocks) * variance) if variance else 0.0, LEAST_CORRELATION)
    worth = (1.0 - correlation) / (1.0 + correlation)  # of one block, as a value by itself
    return sqrt(variance * sum(1.0 / max(worth * count, 1.0) for count in (len(blocks), others)))


def block_means(values: Sequence[float]) -> list[float]:
    """Of all whole blocks, or of the one that is begun."""
    return [fmean(values[k : k + BLOCK]) for k in range(0, len(values) - BLOCK + 1, BLOCK)] or [fmean(values)]
