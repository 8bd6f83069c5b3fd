"""The rail's friction level under each wheelset: profile, random roughness along the track, sand, conditioning."""

import math
import random

from brake_monitor.simulator.scenarios import Scenario

ROUGHNESS_WAVELENGTHS_M = (7.0, 19.0, 47.0, 110.0, 260.0)
ROUGHNESS = 0.04  # relative amplitude of each wave
CONDITIONING = 0.05  # each wheelset leaves a slippery rail better by this fraction for the next one
SLIPPERY_BELOW = 0.30
SAND_LIFT = 0.05  # mu0 gained on a slippery rail once the sand lies under the wheels
SAND_DELAY_S = 1.0
SAND_RISE_S = 0.8
SAND_DECAY_S = 3.0
LEAST_MU0 = 0.005


class Rail:
    """mu0 at a place and time; remembers how much sand lies under the wagon."""

    def __init__(self, scenario: Scenario, rng: random.Random) -> None:
        self._scenario = scenario
        self._waves = [
            (2.0 * math.pi / length_m, rng.uniform(0.0, 2.0 * math.pi)) for length_m in ROUGHNESS_WAVELENGTHS_M
        ]
        self._sanding_s = 0.0
        self._sand = 0.0

    def step_sand(self, step_s: float, sanding: bool) -> None:
        """Advance the amount of sand under the wheels (0 to 1)."""
        self._sanding_s = self._sanding_s + step_s if sanding else 0.0
        arrives = self._sanding_s > SAND_DELAY_S
        self._sand += ((1.0 if arrives else 0.0) - self._sand) * step_s / (SAND_RISE_S if arrives else SAND_DECAY_S)

    def friction_level(self, time_s: float, place_m: float, wheelsets_before: int) -> float:
        """mu0 under the wheelset at `place_m` on the track, after `wheelsets_before` have passed there."""
        level = min(self._scenario.rail_over_time.at(time_s), self._scenario.rail_over_place.at(place_m))
        level *= 1.0 + ROUGHNESS * sum(math.sin(rate * place_m + phase) for rate, phase in self._waves)
        slippery = max(1.0 - level / SLIPPERY_BELOW, 0.0)
        level *= 1.0 + CONDITIONING * wheelsets_before * slippery
        return max(level + SAND_LIFT * self._sand * slippery, LEAST_MU0)
