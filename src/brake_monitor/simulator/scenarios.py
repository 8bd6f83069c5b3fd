"""What happens on the track: demand, adhesion and sanding over time or position, as frozen descriptions."""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

from brake_monitor.simulator.journey import LegJourney

RAMP_S = 0.2  # in which a demand moves from one value to the next


@dataclass(frozen=True, slots=True)
class Profile:
    """A value over time (s) or position (m): constant outside its points, without kinks between them."""

    points: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if not self.points or any(b[0] <= a[0] for a, b in pairwise(self.points)):
            raise ValueError("a profile needs points in ascending order")

    def at(self, x: float) -> float:
        """Value at `x`, cosine-shaped between two points."""
        following = bisect_right(self.points, (x, math.inf))
        if following == 0:
            return self.points[0][1]
        if following == len(self.points):
            return self.points[-1][1]
        (start, before), (end, after) = self.points[following - 1], self.points[following]
        if before == after:
            return before
        return before + (after - before) * 0.5 * (1.0 - math.cos(math.pi * (x - start) / (end - start)))


def steps(*changes: tuple[float, float]) -> Profile:
    """A demand that moves to each (time, value) within RAMP_S, starting from released."""
    points = [(0.0, 0.0)]
    for time_s, value in changes:
        points += [(time_s, points[-1][1]), (time_s + RAMP_S, value)]
    return Profile(tuple(points))


DRY = Profile(((0.0, 0.45),))  # mu0


@dataclass(frozen=True, slots=True)
class Track:
    """Gradients and curves over the position."""

    gradient: Profile  # rise over run, uphill positive
    curvature_pm: Profile  # 1/m, unsigned

    @staticmethod
    def curve_resistance(curvature_pm: float) -> float:
        """Extra resistance over weight; Röckl's 0.65 m / (R - 55 m)."""
        return 0.65 * curvature_pm / (1.0 - 55.0 * curvature_pm) if curvature_pm > 0.0 else 0.0

    @staticmethod
    def rolling_radius_factor(curvature_pm: float, wheelset: int) -> float:
        """Rolling radius in a curve over that on straight track: leading and trailing wheelsets stand apart in it.

        0.4 per mille at 500 m: a flange-ward shift of some millimetres on a tread of conicity 1:40.
        """
        return 1.0 + (0.2 if wheelset % 2 == 0 else -0.12) * curvature_pm


@dataclass(frozen=True, slots=True)
class Scenario:
    """One run: the wagon coasts, brakes as demanded and stands, on a rail that is as slippery as described."""

    name: str
    summary: str
    initial_speed_mps: float
    duration_s: float  # at most; the run ends earlier, `STANDING_S` after the stop
    demand: Profile | LegJourney  # over time: 0 released, 1 full brake; or a journey, whose driver brakes and is pulled
    rail_over_time: Profile  # Polach's mu0 over time
    rail_over_position: Profile = Profile(((0.0, 0.55),))  # mu0 over the position on the track; the lower one counts
    sanding_from_s: float = math.inf  # from then on sand is dropped whenever the wheel-slide protection acts
    track: Track | None = None  # straight and level where there is none

    @property
    def longest_m(self) -> float:
        """How far the wagon may come."""
        if isinstance(self.demand, LegJourney):
            return self.demand.longest_m
        return self.initial_speed_mps * self.duration_s


STANDING_S = 5.0

SCENARIOS = {
    scenario.name: scenario
    for scenario in (
        Scenario(
            name="wsp",
            summary="120 km/h, three short brakings, then a stop on adhesion 0.02-0.05 with almost continuous WSP",
            initial_speed_mps=120.0 / 3.6,
            duration_s=180.0,
            demand=steps((18.0, 0.3), (20.5, 0.0), (24.0, 0.4), (26.5, 0.0), (30.0, 0.3), (33.0, 0.0), (42.0, 1.0)),
            rail_over_time=Profile(((36.0, 0.25), (41.0, 0.05), (60.0, 0.035), (104.0, 0.045), (112.0, 0.25))),
        ),
        Scenario(
            name="sanding",
            summary="200 km/h, adhesion falls from 0.1 to 0.05, sanding raises it again",
            initial_speed_mps=200.0 / 3.6,
            duration_s=180.0,
            demand=steps((5.0, 1.0)),
            rail_over_time=Profile(((5.0, 0.11), (14.0, 0.06), (30.0, 0.06), (70.0, 0.13))),
            sanding_from_s=14.0,
        ),
        Scenario(
            name="dry",
            summary="120 km/h, service brakings and a full stop on a dry rail, no slide",
            initial_speed_mps=120.0 / 3.6,
            duration_s=180.0,
            demand=steps((6.0, 0.4), (14.0, 0.0), (20.0, 0.65), (28.0, 0.0), (36.0, 1.0)),
            rail_over_time=DRY,
        ),
        Scenario(
            name="leaf",
            summary="full brake from 120 km/h over 400 m of leaves below 0.03, good rail before and after",
            initial_speed_mps=120.0 / 3.6,
            duration_s=180.0,
            demand=steps((7.0, 1.0)),
            rail_over_time=Profile(((0.0, 0.35),)),
            rail_over_position=Profile(((380.0, 0.35), (420.0, 0.028), (600.0, 0.018), (800.0, 0.026), (840.0, 0.35))),
        ),
    )
}
