"""Hours of ordinary service from a seed: nothing is wrong, and nothing should be said.

Line running with gradients, curves, coasting, service brakings, speed held downhill, stops and standstill; in
between shunting at walking pace, to and fro. The rail is dry or wet and gives more than is ever asked for.
"""

import random
from collections.abc import Iterator

from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.line import ordinary_line
from brake_monitor.simulator.physics.coupler import GivenPull
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario

SERVICE = "service"  # its name beside those of scenarios and troubles
FASTEST_MPS = 30.0  # 108 km/h
HOLDING_DEMAND = 0.5
DRY = (0.30, 0.50)  # mu0
WET = (0.17, 0.25)
FRAME_LOSS = 0.001  # frames that never arrive


def ordinary_service(seed: int, duration_s: float) -> Scenario:
    """Service from a station on, of that length."""
    rng = random.Random(seed)
    legs = list(_legs(rng, duration_s))
    shunting = [number for number, leg in enumerate(leg for leg in legs if leg.act is Act.STAND) if leg.lasts_s < 15.0]
    backward = frozenset(number for number in shunting if rng.random() < 0.5)
    longest_m = FASTEST_MPS * duration_s
    return Scenario(
        name=SERVICE,
        summary="ordinary service: stops, gradients, curves, coasting, standstill, shunting; nothing is wrong",
        initial_speed_mps=0.0,
        duration_s=duration_s,
        demand=LegJourney(tuple(legs), longest_m, backward),
        rail_over_time=Profile(((0.0, 0.6),)),
        rail_over_position=Profile(tuple(_rail(rng, longest_m))),
        track=ordinary_line(rng, longest_m),
    )


def ordinary_disturbances(seed: int, wheelset_count: int, *, in_train: bool) -> Modifiers:
    """What every wagon in service has: mass and wheels not as configured, some frames lost."""
    rng = random.Random(f"disturbances {seed}")
    return Modifiers(
        train=GivenPull if in_train else None,
        mass_factor=rng.uniform(0.9, 1.1),
        wheel_radius_factor=tuple(rng.uniform(0.98, 1.005) for _ in range(wheelset_count)),
        slide_protection=rng.random() < 0.5,
        frame_loss=FRAME_LOSS,
    )


def _legs(rng: random.Random, duration_s: float) -> Iterator[Leg]:
    """Runs over the line, and now and then some shunting; more than can be driven in the time."""
    yield Leg(Act.STAND, lasts_s=rng.uniform(5.0, 60.0), demand=0.3)
    planned_s = 0.0
    while planned_s < duration_s:
        legs = list(_shunting(rng) if rng.random() < 0.15 else _line_run(rng))
        yield from legs
        planned_s += sum(min(leg.lasts_s, 30.0) for leg in legs)


def _line_run(rng: random.Random) -> Iterator[Leg]:
    """From a start to the next stop."""
    speed_mps = rng.uniform(10.0, FASTEST_MPS)
    yield Leg(Act.PULL, speed_mps, lasts_s=300.0, pull_mps2=rng.uniform(0.25, 0.55))
    for _ in range(rng.randint(1, 5)):
        match rng.choice(("hold", "hold", "coast", "slow")):
            case "hold":
                yield Leg(Act.HOLD, speed_mps, lasts_s=rng.uniform(30.0, 240.0), demand=HOLDING_DEMAND)
            case "coast":
                yield Leg(Act.COAST, lasts_s=rng.uniform(10.0, 60.0))
            case _:
                slower_mps = rng.uniform(0.4, 0.85) * speed_mps
                yield Leg(Act.BRAKE, slower_mps, lasts_s=120.0, demand=rng.uniform(0.2, 0.7))
                if rng.random() < 0.6:
                    yield Leg(Act.COAST, lasts_s=rng.uniform(3.0, 20.0))
                    yield Leg(Act.PULL, speed_mps, lasts_s=200.0, pull_mps2=rng.uniform(0.2, 0.5))
                else:
                    speed_mps = max(slower_mps, 5.0)
    demand = 1.0 if rng.random() < 0.15 else rng.uniform(0.3, 0.8)
    minutes = rng.random() < 0.3
    yield Leg(Act.STAND, lasts_s=rng.uniform(120.0, 400.0) if minutes else rng.uniform(20.0, 60.0), demand=demand)


def _shunting(rng: random.Random) -> Iterator[Leg]:
    """Short moves at up to 15 km/h."""
    for _ in range(rng.randint(2, 6)):
        speed_mps = rng.uniform(0.8, 4.0)
        yield Leg(Act.PULL, speed_mps, lasts_s=60.0, pull_mps2=rng.uniform(0.15, 0.4))
        yield Leg(Act.HOLD, speed_mps, lasts_s=rng.uniform(3.0, 40.0), demand=HOLDING_DEMAND)
        yield Leg(Act.STAND, lasts_s=rng.uniform(5.0, 14.0), demand=rng.uniform(0.2, 0.6))


def _rail(rng: random.Random, longest_m: float) -> Iterator[tuple[float, float]]:
    """Dry and wet stretches."""
    position_m = 0.0
    while position_m < longest_m:
        level = rng.uniform(*(WET if rng.random() < 0.3 else DRY))
        length_m = rng.uniform(500.0, 5000.0)
        yield position_m, level
        yield position_m + length_m, level
        position_m += length_m + 50.0
