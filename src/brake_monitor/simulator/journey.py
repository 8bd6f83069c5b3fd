"""A train on its way, leg by leg: it is pulled, rolls, brakes, holds its speed downhill, stands, and reverses."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import inf

PULL_CHANGE_MPS3 = 0.15  # how fast the coupler force changes, by the wagon's mass
GREATEST_PULL_MPS2 = 0.6
SPEED_HOLDING_PER_S = 0.15  # pull per speed that is missing
TOO_FAST_MPS = 1.5  # while holding a speed: the brake comes on ...
SLOW_AGAIN_MPS = 1.0  # ... until the train is this much slower
DEMAND_CHANGE_PER_S = 1.0
STANDING_DEMAND = 0.3
RELEASE_BEFORE_START_S = 3.0
STANDING_MPS = 0.02


class Act(StrEnum):
    """What the driver does during a leg."""

    PULL = "pull"  # until `speed_mps` is reached
    HOLD = "hold"  # keep `speed_mps` for `lasts_s`, downhill by `demand` now and then
    COAST = "coast"  # for `lasts_s`
    BRAKE = "brake"  # by `demand` until `speed_mps` is reached
    STAND = "stand"  # stop with `demand`, and stand for `lasts_s`


@dataclass(frozen=True, slots=True)
class Leg:
    """One leg of a journey; only the values that its act needs count."""

    act: Act
    speed_mps: float = 0.0
    lasts_s: float = inf  # at most
    demand: float = 0.0
    pull_mps2: float = 0.0


@dataclass(frozen=True, slots=True)
class LegJourney:
    """All legs in order; after the last one the train coasts. Legs between two stands go forward or back."""

    legs: tuple[Leg, ...]
    longest_m: float  # how far it may lead
    backward: frozenset[int] = frozenset()  # numbers of the stands after which the train goes back until the next


class LegDriver:
    """Drives the train through the legs, from before the first; pull and brake change smoothly."""

    def __init__(self, journey: LegJourney) -> None:
        self._legs: Iterator[Leg] = iter(journey.legs)
        self._backward = journey.backward
        self._leg = next(self._legs, Leg(Act.COAST))
        self._since_s = 0.0
        self._stood_s = 0.0
        self._stands = 0
        self._direction = 1.0
        self._time_s = 0.0
        self._demand = self._pull_mps2 = 0.0
        self._is_holding_back = False

    def drive(self, time_s: float, speed_mps: float) -> tuple[float, float]:
        """Brake demand (0 to 1) now, and by how much the train pulls the wagon, m/s² of its mass; every 10 ms."""
        step_s, self._time_s = time_s - self._time_s, time_s
        forward_mps = speed_mps * self._direction
        while self._is_over(time_s, forward_mps, step_s):
            if self._leg.act is Act.STAND:
                self._stands += 1
                self._direction = -1.0 if self._stands in self._backward else 1.0
            self._leg, self._since_s, self._stood_s = next(self._legs, Leg(Act.COAST)), time_s, 0.0
            self._is_holding_back = False
        demand, pull_mps2 = self._wanted(forward_mps)
        self._demand = _towards(self._demand, demand, DEMAND_CHANGE_PER_S * step_s)
        self._pull_mps2 = _towards(self._pull_mps2, pull_mps2 * self._direction, PULL_CHANGE_MPS3 * step_s)
        return self._demand, self._pull_mps2

    def _is_over(self, time_s: float, speed_mps: float, step_s: float) -> bool:
        leg = self._leg
        if leg.act is Act.STAND:
            self._stood_s += step_s if abs(speed_mps) < STANDING_MPS else 0.0
            return self._stood_s >= leg.lasts_s
        reached = (leg.act is Act.PULL and speed_mps >= leg.speed_mps) or (
            leg.act is Act.BRAKE and speed_mps <= leg.speed_mps
        )
        return reached or time_s - self._since_s >= leg.lasts_s

    def _wanted(self, speed_mps: float) -> tuple[float, float]:
        """Demand, and pull in the direction of travel."""
        leg = self._leg
        match leg.act:
            case Act.PULL:
                return 0.0, leg.pull_mps2
            case Act.HOLD:
                return self._hold(leg.speed_mps - speed_mps)
            case Act.COAST:
                return 0.0, 0.0
            case Act.BRAKE:
                return leg.demand, 0.0
        if self._stood_s > leg.lasts_s - RELEASE_BEFORE_START_S:
            return 0.0, 0.0
        return (STANDING_DEMAND if self._stood_s > 0.0 else leg.demand), 0.0

    def _hold(self, missing_mps: float) -> tuple[float, float]:
        if missing_mps < -TOO_FAST_MPS:
            self._is_holding_back = True
        elif missing_mps > SLOW_AGAIN_MPS:
            self._is_holding_back = False
        if self._is_holding_back:
            return self._leg.demand, 0.0
        return 0.0, min(max(SPEED_HOLDING_PER_S * missing_mps, 0.0), GREATEST_PULL_MPS2)


def _towards(value: float, target: float, most: float) -> float:
    return value + min(max(target - value, -most), most)
