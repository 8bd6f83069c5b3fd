"""Lines as there are: gradients and curves along the way."""

import random
from collections.abc import Iterator
from math import ceil, sqrt

from brake_monitor.simulator.scenarios import Profile, Track

STEEPEST = 0.025
EASY_STD = 0.004
STEEP_LENGTH_M = (200.0, 1200.0)
EASY_LENGTH_M = (400.0, 4000.0)
VERTICAL_RADIUS_M = 2000.0  # where gradients meet; Bane NOR asks for 2900 m at 120 km/h on its existing lines
TRANSITION_M = 60.0  # between straight track and curves
TIGHTEST_RADIUS_M, WIDEST_RADIUS_M = 300.0, 3000.0
UNDULATION_M = 5.0
BEGUN_M = 20_000.0  # how far from a line's beginning a drive may start


def ordinary_line(rng: random.Random, longest_m: float) -> Track:
    """From a station on."""
    return Track(Profile(tuple(_gradients(rng, longest_m))), Profile(tuple(_curves(rng, longest_m))))


def somewhere_on_a_line(seed: int, longest_m: float) -> Track:
    """A stretch of an ordinary line that begins anywhere on it."""
    rng = random.Random(f"line {seed}")
    from_m = rng.uniform(0.0, BEGUN_M)
    line = ordinary_line(rng, from_m + longest_m)
    return Track(_moved(line.gradient, -from_m), _moved(line.curvature_pm, -from_m))


def undulating_line(seed: int, longest_m: float, first_std: float, density_pm: float) -> Track:
    """Straight track whose gradient is a random walk of the way, from ± `first_std` on by `density_pm` per metre."""
    rng = random.Random(f"undulating {seed}")
    gradients = [rng.gauss(0.0, first_std)]
    for _ in range(ceil(longest_m / UNDULATION_M)):
        gradients.append(gradients[-1] + rng.gauss(0.0, sqrt(density_pm * UNDULATION_M)))
    points = tuple((UNDULATION_M * k, gradient) for k, gradient in enumerate(gradients))
    return Track(Profile(points), Profile(((0.0, 0.0),)))


def _moved(profile: Profile, by_m: float) -> Profile:
    return Profile(tuple((position_m + by_m, value) for position_m, value in profile.points))


def _gradients(rng: random.Random, longest_m: float) -> Iterator[tuple[float, float]]:
    """Mostly easy, now and then steep for a short while; stations are level enough for a brake to hold anywhere."""
    position_m, gradient = 0.0, 0.0
    while position_m < longest_m:
        steep = rng.random() < 0.15
        length_m = rng.uniform(*(STEEP_LENGTH_M if steep else EASY_LENGTH_M))
        yield position_m, gradient
        before, gradient = gradient, rng.uniform(-STEEPEST, STEEPEST) if steep else rng.gauss(0.0, EASY_STD)
        position_m += VERTICAL_RADIUS_M * abs(gradient - before)
        yield position_m, gradient
        position_m += length_m


def _curves(rng: random.Random, longest_m: float) -> Iterator[tuple[float, float]]:
    """Straight track and curves in turn."""
    position_m = 0.0
    while position_m < longest_m:
        straight_m, curve_m = rng.uniform(200.0, 2000.0), rng.uniform(100.0, 600.0)
        curvature_pm = 1.0 / rng.uniform(TIGHTEST_RADIUS_M, WIDEST_RADIUS_M)
        yield position_m, 0.0
        yield position_m + straight_m, 0.0
        yield position_m + straight_m + TRANSITION_M, curvature_pm
        yield position_m + straight_m + TRANSITION_M + curve_m, curvature_pm
        position_m += straight_m + 2.0 * TRANSITION_M + curve_m
