"""The rail's friction level under each wheelset: profile, random roughness along the track, sand, conditioning."""

import math
import random
from typing import NamedTuple

import numpy as np

from brake_monitor.simulator.physics.compiled import Vector, compiled, vector
from brake_monitor.simulator.scenarios import Scenario

GRID_M = 0.5  # the track is sampled once, and interpolated in between
BEFORE_START_M = 50.0  # the trailing wheelsets begin there
ROUGHNESS_WAVELENGTHS_M = (7.0, 19.0, 47.0, 110.0, 260.0)
ROUGHNESS = 0.04  # relative amplitude of each wave
CONDITIONING = 0.05  # each wheelset leaves a slippery rail better by this fraction for the next one
SLIPPERY_BELOW = 0.30
SAND_LIFT = 0.05  # mu0 gained on a slippery rail once the sand lies under the wheels
SAND_DELAY_S = 1.0
SAND_RISE_S = 0.8
SAND_DECAY_S = 3.0
LEAST_MU0 = 0.005


class RailState(NamedTuple):
    """The rail now, as compiled code sees it."""

    level_of_time: float  # mu0
    sand: float  # under the wheels, 0 to 1
    level_of_position: Vector  # mu0 on the grid
    roughness: Vector  # relative, on the grid


class Rail:
    """mu0 at a position and time; remembers how much sand lies under the wagon."""

    def __init__(self, scenario: Scenario, rng: random.Random) -> None:
        longest_m = scenario.longest_m + 2.0 * BEFORE_START_M
        positions_m = np.arange(-BEFORE_START_M, longest_m, GRID_M)
        waves = [
            np.sin(2.0 * math.pi * positions_m / length_m + rng.uniform(0.0, 2.0 * math.pi))
            for length_m in ROUGHNESS_WAVELENGTHS_M
        ]
        self._roughness = vector((1.0 + ROUGHNESS * np.sum(waves, axis=0)).tolist())
        self._level_of_position = vector(map(scenario.rail_over_position.at, positions_m.tolist()))
        self._level_over_time = scenario.rail_over_time
        self._level_of_time = self._level_over_time.at(0.0)
        self._sanding_s = 0.0
        self._sand = 0.0

    @property
    def state(self) -> RailState:
        """The rail at the last step."""
        return RailState(self._level_of_time, self._sand, self._level_of_position, self._roughness)

    def step(self, time_s: float, step_s: float, sanding: bool) -> None:
        """Come to `time_s`: the level of that time, and the amount of sand."""
        self._level_of_time = self._level_over_time.at(time_s)
        self._sanding_s = self._sanding_s + step_s if sanding else 0.0
        arrives = self._sanding_s > SAND_DELAY_S
        self._sand += ((1.0 if arrives else 0.0) - self._sand) * step_s / (SAND_RISE_S if arrives else SAND_DECAY_S)


@compiled
def friction_level(position_m: float, wheelsets_before: float, rail: RailState) -> float:
    """mu0 under the wheelset at `position_m` on the track, after `wheelsets_before` have passed there."""
    cell = max((position_m + BEFORE_START_M) / GRID_M, 0.0)
    index = min(int(cell), len(rail.roughness) - 2)
    share = cell - index
    of_position = rail.level_of_position[index]
    of_position += share * (rail.level_of_position[index + 1] - of_position)
    rough = rail.roughness[index]
    rough += share * (rail.roughness[index + 1] - rough)
    level = min(rail.level_of_time, of_position) * rough
    if level >= SLIPPERY_BELOW:
        return level
    slippery = 1.0 - level / SLIPPERY_BELOW
    level *= 1.0 + CONDITIONING * wheelsets_before * slippery
    return max(level + SAND_LIFT * rail.sand * slippery, LEAST_MU0)
