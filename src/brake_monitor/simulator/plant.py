"""The wagon itself: longitudinal motion, wheelset rotation, brakes and WSP, integrated in fixed steps.

Forward speeds are positive, and so are forces and torques that brake. The creep curve is stiff at low speed
(time constants well below a millisecond), so speed and rotation are advanced together by ROS2, a second-order,
L-stable Rosenbrock scheme; its matrix is an arrow (each wheelset is coupled to the speed alone).
"""

import math
import random
from dataclasses import dataclass

import numpy as np

from brake_monitor.config import Vehicle
from brake_monitor.simulator.creep import CreepLaw, law_for, utilisation
from brake_monitor.simulator.pad import Pad
from brake_monitor.simulator.pneumatics import BrakeGear, Cylinder, Supply
from brake_monitor.simulator.rail import Rail
from brake_monitor.simulator.scenarios import STANDING_S, Scenario
from brake_monitor.simulator.trace import WAGON_COLUMNS, WHEELSET_COLUMNS, Trace
from brake_monitor.simulator.wsp import SAMPLE_S, WheelSlideProtection

GRAVITY_MPS2 = 9.80665
STEP_S = 0.001
GAMMA = 1.0 - 1.0 / math.sqrt(2.0)  # of ROS2
PITCH_TIME_CONSTANT_S = 0.05  # the load moves between the wheelsets through the suspension
WSP_SENSOR_STD_MPS = 0.01
PAD_QUALITY_SPREAD = 0.04
STANDSTILL_MPS = 5e-3  # slower than a full brake takes off within a few steps
RESISTANCE_BLEND_MPS = 0.01  # running resistance changes sign smoothly through standstill
COUPLER_MPS2 = 20e3 / 36e3  # mean retardation by the rest of the train: 20 kN on a wagon of 36 t ...
COUPLER_SWING_MPS2 = 10e3 / 36e3  # ... swinging by 10 kN within seconds
COUPLER_RISE_S = 1.0
COUPLER_PERIODS_S = (2.3, 4.1, 7.9)


@dataclass(frozen=True, slots=True)
class Modifiers:
    """How this run's truth departs from what the configuration says."""

    gradient: float = 0.0  # rise over run, uphill positive
    coupler: bool = False  # the rest of the train brakes better and holds this wagon back
    mass_factor: float = 1.0
    wheel_radius_factor: tuple[float, ...] = (1.0,)  # one for all wheelsets or one each
    slide_protection: bool = True  # goods wagons often have none: then a wheelset may lock and be dragged
    frame_loss: float = 0.0  # fraction of frames that never arrive


class _Wheelset:
    """One wheelset with its brake; `omega` and `locked` belong to the integrator."""

    __slots__ = (
        "brake_radius_m",
        "cylinder",
        "gear",
        "inertia_kgm2",
        "law",
        "load_n",
        "locked",
        "mu0",
        "nominal_radius_m",
        "omega",
        "pad",
        "position_m",
        "pressing_force_n",
        "radius_m",
    )

    def __init__(self, vehicle: Vehicle, index: int, radius_factor: float, gear: BrakeGear, pad_quality: float) -> None:
        self.position_m = vehicle.axle_positions_m[index]
        self.inertia_kgm2 = vehicle.wheelset_inertia_kgm2[index]
        self.nominal_radius_m = vehicle.wheel_radius_m[index]
        self.radius_m = self.nominal_radius_m * radius_factor
        self.brake_radius_m = vehicle.brake_radius_m[index]
        self.gear = gear
        self.pad = Pad(gear.full_force_n, pad_quality)
        self.cylinder = Cylinder()
        self.omega = 0.0
        self.locked = False
        self.load_n = 0.0
        self.mu0 = 0.0
        self.law: CreepLaw = law_for(0.0)
        self.pressing_force_n = 0.0

    def brake_torque(self, creep_force_n: float) -> float:
        """Torque against the rotation; a locked wheelset is held by just what the rail asks for."""
        limit = self.pad.friction * self.pressing_force_n * self.brake_radius_m
        if not self.locked:
            return math.copysign(limit, self.omega)
        turning = creep_force_n * self.radius_m
        return min(max(turning, -limit), limit)


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
    ) -> None:
        count = vehicle.wheelset_count
        factors = modifiers.wheel_radius_factor
        if len(factors) == 1:
            factors = factors * count
        if len(factors) != count:
            raise ValueError(f"wheel_radius_factor needs 1 or {count} values")
        rng = random.Random(seed)
        self._rng = rng
        self._scenario = scenario
        self._vehicle = vehicle
        self._step_s = step_s
        self._mass_kg = vehicle.mass_kg * modifiers.mass_factor
        self._slope_cosine = 1.0 / math.hypot(1.0, modifiers.gradient)
        self._gradient_force_n = self._mass_kg * GRAVITY_MPS2 * modifiers.gradient * self._slope_cosine
        self._lever_sum_m2 = sum(place * place for place in vehicle.axle_positions_m)
        self._coupled = modifiers.coupler
        self._coupler_share = 0.0
        self._coupler_phases = [rng.uniform(0.0, 2.0 * math.pi) for _ in COUPLER_PERIODS_S]
        self._rail = Rail(scenario, rng)
        self._supply = Supply()
        self._wsp = WheelSlideProtection(count, enabled=modifiers.slide_protection)
        self._wheelsets = [
            _Wheelset(
                vehicle,
                index,
                factors[index],
                gears[index],
                1.0 + rng.uniform(-PAD_QUALITY_SPREAD, PAD_QUALITY_SPREAD),
            )
            for index in range(count)
        ]
        self._order = sorted(range(count), key=lambda i: -vehicle.axle_positions_m[i])
        self._speed = scenario.initial_speed_mps
        for wheelset in self._wheelsets:
            wheelset.omega = self._speed / wheelset.radius_m
            wheelset.pad.settle(wheelset.omega * wheelset.brake_radius_m)
        self._position_m = 0.0
        self._acceleration = 0.0  # as the suspension feels it
        self._sanding = False
        self._coupler_force_n = 0.0

    def run(self) -> Trace:
        """Integrate until the scenario ends or the wagon has stood for a while."""
        steps = round(self._scenario.duration_s / self._step_s)
        standing_steps = round(STANDING_S / self._step_s)
        control_every = round(SAMPLE_S / self._step_s)
        count = len(self._wheelsets)
        values = np.empty((steps + 1, len(WAGON_COLUMNS) + count * len(WHEELSET_COLUMNS)))
        stood = 0
        for k in range(steps + 1):
            time_s = k * self._step_s
            self._prepare(time_s)
            if k % control_every == 0:
                self._control(time_s)
                self._warm_up()
            values[k] = self._advance()
            stood = stood + 1 if self._speed == 0.0 else 0
            if stood > standing_steps:
                return Trace(self._step_s, count, values[: k + 1].copy())
        return Trace(self._step_s, count, values)

    def _control(self, time_s: float) -> None:
        """Let the wheel-slide protection see the wheel speeds, and sand when it acts."""
        gauss = self._rng.gauss
        measured = [max(w.omega * w.nominal_radius_m + gauss(0.0, WSP_SENSOR_STD_MPS), 0.0) for w in self._wheelsets]
        for wheelset, valve in zip(self._wheelsets, self._wsp.step(measured), strict=True):
            wheelset.cylinder.command(time_s, valve)
        acts = any(self._wsp.active(i) for i in range(len(self._wheelsets)))
        self._sanding = acts and time_s >= self._scenario.sanding_from_s

    def _warm_up(self) -> None:
        """What changes slowly, once per sampling interval of the controller: pads, discs and the rail's state."""
        for w in self._wheelsets:
            w.pad.step(SAMPLE_S, w.pressing_force_n, w.omega * w.brake_radius_m, self._speed)
            w.law = law_for(w.mu0)

    def _prepare(self, time_s: float) -> None:
        """What changes little within a step: pressures, loads, rail, coupler."""
        step_s = self._step_s
        demand = self._scenario.demand.at(time_s)
        self._supply.step(step_s, demand)
        self._rail.step(time_s, step_s, self._sanding)
        per_wheelset_n = self._mass_kg * GRAVITY_MPS2 * self._slope_cosine / len(self._wheelsets)
        transfer = 0.0
        if self._lever_sum_m2 > 0.0:
            transfer = self._vehicle.cog_height_m * self._mass_kg * self._acceleration / self._lever_sum_m2
        for passed, index in enumerate(self._order):
            w = self._wheelsets[index]
            w.cylinder.step(time_s, step_s, self._supply.pressure_bar)
            w.pressing_force_n = w.gear.pressing_force_n(w.cylinder.pressure_bar)
            w.load_n = per_wheelset_n - transfer * w.position_m
            w.mu0 = self._rail.friction_level(self._position_m + w.position_m, passed)
        if self._coupled:
            self._update_coupler(time_s, demand)

    def _update_coupler(self, time_s: float, demand: float) -> None:
        """The train pulls back while it brakes, and lets go as it stands."""
        self._coupler_share += ((1.0 if demand > 0.0 else 0.0) - self._coupler_share) * self._step_s / COUPLER_RISE_S
        swing = sum(
            math.sin(2.0 * math.pi * time_s / period_s + phase)
            for period_s, phase in zip(COUPLER_PERIODS_S, self._coupler_phases, strict=True)
        ) / len(COUPLER_PERIODS_S)
        pull = self._mass_kg * (COUPLER_MPS2 + COUPLER_SWING_MPS2 * swing)
        self._coupler_force_n = self._coupler_share * pull * min(max(self._speed, 0.0), 1.0)

    def _resistance(self, speed: float) -> float:
        """Track, drag, gradient and coupler; braking positive."""
        vehicle = self._vehicle
        running = vehicle.track_resistance_n * math.tanh(speed / RESISTANCE_BLEND_MPS)
        drag = vehicle.drag_n_per_mps2 * speed * abs(speed)
        return running + drag + self._gradient_force_n + self._coupler_force_n

    def _advance(self) -> list[float]:
        """One ROS2 step of speed and rotations; returns the truth at its beginning."""
        speed, step_s, wheelsets = self._speed, self._step_s, self._wheelsets
        forces, slopes, torques, rates = [], [], [], []
        for w in wheelsets:
            share, slope = utilisation(speed - w.omega * w.radius_m, speed, w.load_n, w.mu0, w.law)
            force = share * w.load_n
            if w.locked and abs(force * w.radius_m) > w.pad.friction * w.pressing_force_n * w.brake_radius_m:
                w.locked = False
                w.omega = math.copysign(1e-12, force)  # lets the brake know against what it works
            torque = w.brake_torque(force)
            forces.append(force)
            slopes.append(slope)
            torques.append(torque)
            rates.append(0.0 if w.locked else (force * w.radius_m - torque) / w.inertia_kgm2)
        acceleration = -(sum(forces) + self._resistance(speed)) / self._mass_kg
        truth = self._truth(acceleration, forces, slopes, torques)
        if self._at_rest(speed, acceleration):
            self._stand()
            return truth

        stiffness = [0.0 if w.locked else max(s, 0.0) * w.load_n for w, s in zip(wheelsets, slopes, strict=True)]
        sliding = sum(max(s, 0.0) * w.load_n for w, s in zip(wheelsets, slopes, strict=True) if w.locked)
        first_v, first = self._solve(stiffness, sliding, acceleration, rates)
        stage_v = speed + step_s * first_v
        stage_rates, total = [], self._resistance(stage_v)
        for w, k1, torque in zip(wheelsets, first, torques, strict=True):
            slip_speed = stage_v - (w.omega + step_s * k1) * w.radius_m
            force = utilisation(slip_speed, stage_v, w.load_n, w.mu0, w.law)[0] * w.load_n
            total += force
            rate = 0.0 if w.locked else (force * w.radius_m - torque) / w.inertia_kgm2
            stage_rates.append(rate - 2.0 * k1)
        second_v, second = self._solve(stiffness, sliding, -total / self._mass_kg - 2.0 * first_v, stage_rates)
        self._speed = speed + step_s * (1.5 * first_v + 0.5 * second_v)
        for w, k1, k2 in zip(wheelsets, first, second, strict=True):
            self._turn(w, step_s * (1.5 * k1 + 0.5 * k2))
        self._position_m += step_s * 0.5 * (speed + self._speed)
        self._acceleration += (acceleration - self._acceleration) * step_s / PITCH_TIME_CONSTANT_S
        return truth

    def _solve(
        self, stiffness: list[float], sliding: float, speed_rate: float, rates: list[float]
    ) -> tuple[float, list[float]]:
        """(I - gamma h A) k = rates for the arrow matrix A of creep stiffness; wheelsets are eliminated first."""
        gain = GAMMA * self._step_s
        diagonal = self._mass_kg + gain * sliding
        right = self._mass_kg * speed_rate
        pivots = []
        for w, c, rate in zip(self._wheelsets, stiffness, rates, strict=True):
            grip = gain * c * w.radius_m
            pivot = w.inertia_kgm2 + grip * w.radius_m
            pivots.append((grip, pivot))
            diagonal += gain * c - grip * grip / pivot
            right += grip * w.inertia_kgm2 * rate / pivot
        k_v = right / diagonal
        return k_v, [
            (w.inertia_kgm2 * rate + grip * k_v) / pivot
            for w, rate, (grip, pivot) in zip(self._wheelsets, rates, pivots, strict=True)
        ]

    @staticmethod
    def _turn(wheelset: _Wheelset, change: float) -> None:
        """Apply a change of rotation; a brake stops a wheelset but never turns it backwards."""
        before = wheelset.omega
        if wheelset.locked:
            return
        wheelset.omega = before + change
        if wheelset.pressing_force_n > 0.0 and before * wheelset.omega < 0.0:
            wheelset.omega = 0.0
            wheelset.locked = True

    def _at_rest(self, speed: float, acceleration: float) -> bool:
        """Standing, or about to, with brakes and resistance that can hold the wagon."""
        if abs(speed) > STANDSTILL_MPS:
            return False
        holding = self._vehicle.track_resistance_n + sum(
            min(w.pad.friction * w.pressing_force_n * w.brake_radius_m / w.radius_m, w.mu0 * w.load_n)
            for w in self._wheelsets
        )
        return abs(self._gradient_force_n) <= holding

    def _stand(self) -> None:
        self._speed = 0.0
        self._acceleration = 0.0
        for w in self._wheelsets:
            w.omega = 0.0
            w.locked = True

    def _truth(
        self, acceleration: float, forces: list[float], slopes: list[float], torques: list[float]
    ) -> list[float]:
        """One row of WAGON_COLUMNS and N times WHEELSET_COLUMNS."""
        speed = self._speed
        row = [
            speed,
            self._position_m,
            acceleration,
            self._resistance(speed),
            self._coupler_force_n,
            self._supply.pressure_bar,
            float(self._sanding),
        ]
        for i, w in enumerate(self._wheelsets):
            slip = (speed - w.omega * w.radius_m) / speed if abs(speed) > RESISTANCE_BLEND_MPS else 0.0
            row += (
                w.omega,
                slip,
                forces[i] / w.load_n,
                w.pad.friction,
                w.pressing_force_n,
                w.cylinder.pressure_bar,
                float(self._wsp.active(i)),
                w.pad.temperature_c,
                float(slopes[i] < 0.0),
                forces[i],
                torques[i],
                w.load_n,
                w.mu0,
            )
        return row
