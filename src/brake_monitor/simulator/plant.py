"""The wagon itself on its way through a scenario: what acts on it, its slide protection, its faults.

Forward speeds are positive, and so are forces and torques that brake.
"""

import math
import random
from dataclasses import dataclass

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.settings.config import Vehicle
from brake_monitor.simulator.brake_faults import BrakeFault, set_faults
from brake_monitor.simulator.journey import LegDriver, LegJourney
from brake_monitor.simulator.physics.compiled import side_by_side
from brake_monitor.simulator.physics.coupler import GivenPull, SpringToTrain
from brake_monitor.simulator.physics.motion import Circumstances, advance
from brake_monitor.simulator.physics.motors import MotorDrive, Motors
from brake_monitor.simulator.physics.pneumatics import BrakeGear, DelayedValve
from brake_monitor.simulator.physics.rail import Rail
from brake_monitor.simulator.physics.wsp import SAMPLE_S, WheelSlideProtection
from brake_monitor.simulator.scenarios import STANDING_S, Profile, Scenario, Track
from brake_monitor.simulator.sensor_faults import BusFault, SensorFault
from brake_monitor.simulator.trace import WAGON_COLUMNS, WHEELSET_COLUMNS, Trace
from brake_monitor.simulator.true_vehicle import new_wagon, new_wheelsets, true_radii

GRAVITY_MPS2 = 9.80665
STEP_S = 0.001
WSP_SENSOR_STD_MPS = 0.01
TRACK_PERIOD_S = 0.1  # the track is looked at as often


@dataclass(frozen=True, slots=True)
class Modifiers:
    """How this run's truth departs from what the configuration says."""

    gradient: float = 0.0  # rise over run, uphill positive; adds to the track's own
    train: type[GivenPull | SpringToTrain] | None = None  # what the one that it runs in does to it
    mass_factor: float = 1.0
    wheel_radius_factor: tuple[float, ...] = (1.0,)  # one for all wheelsets or one each
    slide_protection: bool = True  # goods wagons often have none: then a wheelset may lock and be dragged
    motors: Motors | None = None  # they drive the wagon, and brake before their pads do
    run_out: float = 0.0  # of all pole wheels: eccentricity over the radius on which their teeth are read
    frame_loss: float = 0.0  # fraction of frames that never arrive
    brake_faults: tuple[BrakeFault, ...] = ()
    sensor_faults: tuple[SensorFault, ...] = ()
    bus_faults: tuple[BusFault, ...] = ()


class Plant:
    """A wagon on its way through a scenario."""

    def __init__(
        self,
        scenario: Scenario,
        vehicle: Vehicle,
        gears: tuple[BrakeGear, ...],
        modifiers: Modifiers,
        *,
        seed: int,
        step_s: float = STEP_S,
        row_s: float | None = None,
    ) -> None:
        """`row_s`: how often the truth is noted, a multiple of the step; at each step where it is not given."""
        rng = random.Random(seed)
        self._rng = rng
        self._scenario = scenario
        self._vehicle = vehicle
        self._modifiers = modifiers
        self._step_s = step_s
        self._row_s = row_s or step_s
        self._mass_kg = vehicle.mass_kg * modifiers.mass_factor
        pull = GivenPull(rng)  # drawn in any case: what follows is the same with and without a train
        self._train: GivenPull | SpringToTrain | None = pull if modifiers.train is GivenPull else None
        if modifiers.train is SpringToTrain:
            self._train = SpringToTrain(scenario.initial_speed_mps)
        self._rail = Rail(scenario, rng)
        self._radius_m = true_radii(vehicle, modifiers.wheel_radius_factor)
        wagon = new_wagon(vehicle, self._mass_kg, scenario.initial_speed_mps, step_s)
        wheels = new_wheelsets(
            vehicle, gears, self._radius_m, mass_kg=self._mass_kg, speed_mps=scenario.initial_speed_mps, rng=rng
        )
        (self._wagon,), (self._compiled_wagon,) = side_by_side([wagon])
        self._wheels, self._compiled_wheels = side_by_side(wheels)
        self._motors = None
        if modifiers.motors is not None:
            self._motors = MotorDrive(modifiers.motors, vehicle, self._wheels, self._mass_kg)
        self._wsp = WheelSlideProtection(len(self._radius_m))
        self._valves = [DelayedValve() for _ in self._radius_m]
        demand = scenario.demand
        self._driver = LegDriver(demand) if isinstance(demand, LegJourney) else demand
        self._sanding = False
        self._resistance_n = vehicle.track_resistance_n
        self._lie(modifiers.gradient)
        self._track_known_until_s = 0.0

    def run(self) -> Trace:
        """Integrate until the scenario ends or, unless it goes on a journey, the wagon has stood for a while."""
        every = round(self._row_s / self._step_s)
        block = round(SAMPLE_S / self._step_s)
        if block % every:
            raise ValueError(f"row_s: expected a part of {SAMPLE_S} s and a multiple of {self._step_s} s")
        steps = round(self._scenario.duration_s / self._step_s)
        count = len(self._radius_m)
        rows = np.empty((steps // every + 1, len(WAGON_COLUMNS) + count * len(WHEELSET_COLUMNS)))
        stood_s = 0.0
        for k in range(0, steps + 1, block):
            todo = min(block, steps + 1 - k)
            self._advance(k * self._step_s, todo, every, rows[k // every :])
            stood_s = stood_s + SAMPLE_S if self._wagon.speed_mps == 0.0 else 0.0
            if stood_s > STANDING_S and isinstance(self._driver, Profile):
                return Trace(self._row_s, count, rows[: (k + todo - 1) // every + 1].copy())
        return Trace(self._row_s, count, rows)

    def _advance(self, time_s: float, steps: int, every: int, rows: Floats) -> None:
        """One sampling interval of the slide protection, or what is left of it at the end."""
        middle_s = time_s + 0.5 * (steps - 1) * self._step_s
        demand, pull_n = self._demand(middle_s)
        self._control(time_s)
        if self._motors is not None:
            self._motors.step(SAMPLE_S, demand, pull_n, self._wheels)
            pull_n = 0.0  # it is theirs
        self._rail.step(middle_s, SAMPLE_S, self._sanding)
        if self._modifiers.brake_faults:
            set_faults(self._modifiers.brake_faults, time_s, self._wheels)
        now = self._now(middle_s, steps, demand, pull_n)
        advance(now, self._compiled_wagon, self._compiled_wheels, rows, every)

    def _demand(self, time_s: float) -> tuple[float, float]:
        """How much the driver brakes, and how much the train pulls (N)."""
        if isinstance(self._driver, Profile):
            return self._driver.at(time_s), 0.0
        demand, pull_mps2 = self._driver.drive(time_s, self._wagon.speed_mps)
        return demand, pull_mps2 * self._mass_kg

    def _control(self, time_s: float) -> None:
        """Let the wheel-slide protection see the wheel speeds, and sand when it acts."""
        if not self._modifiers.slide_protection:
            return
        gauss, wheels = self._rng.gauss, self._wheels
        measured = [
            max(abs(wheel.omega_radps) * radius_m + gauss(0.0, WSP_SENSOR_STD_MPS), 0.0)
            for wheel, radius_m in zip(wheels, self._vehicle.wheel_radius_m, strict=True)
        ]
        acts = False
        for i, (wheel, valve) in enumerate(zip(wheels, self._wsp.step(measured), strict=True)):
            self._valves[i].command(time_s, valve)
            wheel.valve = self._valves[i].come_to(time_s)
            active = self._wsp.active(i)
            wheel.wsp = active
            acts = acts or active
        self._sanding = acts and time_s >= self._scenario.sanding_from_s

    def _now(self, time_s: float, steps: int, demand: float, pull_n: float) -> Circumstances:
        """What acts on the wagon."""
        if self._scenario.track is not None and time_s >= self._track_known_until_s:
            self._track_known_until_s = time_s + TRACK_PERIOD_S
            self._look_at(self._scenario.track)
        return Circumstances(
            steps=steps,
            demand=demand,
            load_n=self._weight_n / len(self._radius_m),
            resistance_n=self._resistance_n,
            hill_n=self._weight_n * self._gradient,
            coupler_n=self._coupler_n(time_s, demand) - pull_n,
            gradient=self._gradient,
            sanding=float(self._sanding),
            rail=self._rail.state,
        )

    def _look_at(self, track: Track) -> None:
        """Gradient and curve here, and how the wheels run on them."""
        position_m = self._wagon.position_m
        self._lie(self._modifiers.gradient + track.gradient.at(position_m))
        curvature_pm = track.curvature_pm.at(position_m)
        curve_n = track.curve_resistance(curvature_pm) * self._mass_kg * GRAVITY_MPS2
        self._resistance_n = self._vehicle.track_resistance_n + curve_n
        for i, (wheel, radius_m) in enumerate(zip(self._wheels, self._radius_m, strict=True)):
            wheel.radius_m = radius_m * track.rolling_radius_factor(curvature_pm, i)

    def _coupler_n(self, time_s: float, demand: float) -> float:
        if self._train is None:
            return 0.0
        return self._mass_kg * self._train.retardation_mps2(time_s, SAMPLE_S, demand, self._wagon.speed_mps)

    def _lie(self, gradient: float) -> None:
        """On a slope the weight presses a little less on the rail."""
        self._gradient = gradient
        self._weight_n = self._mass_kg * GRAVITY_MPS2 / math.hypot(1.0, gradient)
