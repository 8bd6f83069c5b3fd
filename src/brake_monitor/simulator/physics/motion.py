"""The inner loop of the plant: brakes, load transfer, creep, and the motion of wagon and wheelsets, step by step.

The creep curve is stiff at low speed (time constants well below a millisecond), so speed and rotation are advanced
together by ROS2, a second-order, L-stable Rosenbrock scheme; its matrix is an arrow (each wheelset is coupled to the
speed alone). Everything here is plain numbers and records of them, so that it can be compiled.
"""

import math
from collections.abc import Sequence
from ctypes import Structure
from typing import NamedTuple

from brake_monitor.arrays import Floats
from brake_monitor.simulator.physics.compiled import compiled, record
from brake_monitor.simulator.physics.creep import law_for, utilisation
from brake_monitor.simulator.physics.pad import disc_temperature, following, steady_friction
from brake_monitor.simulator.physics.pneumatics import cylinder_after, supply_after
from brake_monitor.simulator.physics.rail import RailState, friction_level
from brake_monitor.simulator.trace import WAGON_COLUMNS, WHEELSET_COLUMNS

GAMMA = 1.0 - 1.0 / math.sqrt(2.0)  # of ROS2
PITCH_TIME_CONSTANT_S = 0.05  # the load moves between the wheelsets through the suspension
COUPLER_HEIGHT_M = 1.0  # of the draw hook above the rail (0.92 to 1.045 m, EN 15566)
STANDSTILL_MPS = 5e-3  # slower than a full brake takes off within a few steps
RESISTANCE_BLEND_MPS = 0.01  # running resistance changes sign smoothly through standstill

WAGON_WIDTH, WHEELSET_WIDTH = len(WAGON_COLUMNS), len(WHEELSET_COLUMNS)


@record
class Wagon(Structure):
    """The vehicle without its wheelsets: first what does not change during a run, then its motion."""

    step_s: float
    mass_kg: float
    coupler_pitch: float  # moment about the centre of mass by the coupler over that by as great a force at the rail
    drag_n_per_mps2: float
    speed_mps: float
    position_m: float
    pitching_mps2: float
    supply_bar: float


@record
class Wheelset(Structure):
    """One wheelset and its brake: what does not change, what others set, states, and what a step has worked out."""

    position_m: float
    moved_kg: float  # load that leaves it per acceleration by the rail
    passed: float  # wheelsets of this wagon that pass a place before this one
    radius_m: float
    brake_radius_m: float
    inertia_kgm2: float
    force_per_bar_n: float
    spring_n: float  # negative
    full_force_n: float
    quality: float  # friction of its pads over that of the nominal ones

    valve: float  # FILL, HOLD or DUMP
    wsp: float  # 1 while the slide protection acts
    motor_nm: float  # torque of its motor; braking forward motion positive
    blending: float  # share of the brake that its motor leaves to the pads, 1 without one
    inlet: float  # 1, or 0 where the cylinder is isolated
    least_bar: float  # below it the cylinder does not empty
    rigging: float  # share of the cylinder's force that reaches the pads
    stuck_n: float  # below it the pads do not come off
    friction_factor: float  # what a fault makes of their friction

    pressure_bar: float
    force_n: float
    friction: float
    temperature_c: float
    omega_radps: float
    locked: float  # 0 or 1
    load_n: float
    mu0: float

    creep_n: float
    slope: float  # of adhesion over slip velocity
    torque_nm: float
    rate: float  # right side of the stage's equation
    grip: float
    pivot: float
    solved: float
    first: float  # what the first stage has solved


Wheelsets = Sequence[Wheelset]


class Circumstances(NamedTuple):
    """What acts on the wagon, held for one sampling interval of the controller."""

    steps: int  # that it lasts
    demand: float  # 0 released, 1 full brake
    load_n: float  # of a wheelset at rest
    resistance_n: float  # track and curve, against the motion
    hill_n: float  # gradient, uphill positive
    coupler_n: float  # the train holds back, negative when it pulls
    gradient: float
    sanding: float
    rail: RailState


@compiled
def advance(now: Circumstances, wagon: Wagon, wheels: Wheelsets, rows: Floats, every: int) -> None:
    """Advance as long as that is so, and note the truth at the beginning of every `every`th step in `rows`."""
    for k in range(now.steps):
        prepare(now, wagon, wheels)
        acceleration = act(now, wagon, wheels)
        if k % every == 0:
            note(rows[k // every], acceleration, now, wagon, wheels)
        if is_at_rest(now, wagon, wheels):
            stand(wagon, wheels)
        else:
            move(acceleration, now, wagon, wheels)
    warm_up(now.steps * wagon.step_s, wagon, wheels)


@compiled
def prepare(now: Circumstances, wagon: Wagon, wheels: Wheelsets) -> None:
    """What changes little within a step: pressures, pressing forces, loads, rail."""
    wagon.supply_bar = supply_after(wagon.supply_bar, wagon.step_s, now.demand)
    for wheel in wheels:
        supply_bar = wagon.supply_bar * wheel.inlet * wheel.blending
        wheel.pressure_bar = cylinder_after(wheel.pressure_bar, wagon.step_s, wheel.valve, supply_bar, wheel.least_bar)
        force_n = max(wheel.force_per_bar_n * wheel.pressure_bar + wheel.spring_n, 0.0)
        wheel.force_n = max(force_n * wheel.rigging, min(wheel.stuck_n, wheel.force_n))
        wheel.load_n = now.load_n - wheel.moved_kg * wagon.pitching_mps2
        wheel.mu0 = friction_level(wagon.position_m + wheel.position_m, wheel.passed, now.rail)


@compiled
def resistance(speed: float, now: Circumstances, wagon: Wagon) -> float:
    """Track, curve, drag, gradient and coupler; braking positive."""
    running = now.resistance_n * math.tanh(speed / RESISTANCE_BLEND_MPS)
    return running + wagon.drag_n_per_mps2 * speed * abs(speed) + now.hill_n + now.coupler_n


@compiled
def act(now: Circumstances, wagon: Wagon, wheels: Wheelsets) -> float:
    """Creep forces and brake torques now; returns the acceleration.

    A locked wheelset is held by just what rail and motor ask for, until that is more than its brake can hold.
    """
    speed = wagon.speed_mps
    force_n = 0.0
    for wheel in wheels:
        slip_mps = speed - wheel.omega_radps * wheel.radius_m
        share, wheel.slope = utilisation(slip_mps, speed, wheel.load_n, wheel.mu0, law_for(wheel.mu0))
        wheel.creep_n = share * wheel.load_n
        limit_nm = wheel.friction * wheel.force_n * wheel.brake_radius_m
        turning_nm = wheel.creep_n * wheel.radius_m - wheel.motor_nm
        if wheel.locked != 0.0 and abs(turning_nm) > limit_nm:
            wheel.locked = 0.0
            wheel.omega_radps = math.copysign(1e-12, turning_nm)  # lets the brake know against what it works
        if wheel.locked != 0.0:
            wheel.torque_nm = min(max(turning_nm, -limit_nm), limit_nm)
            wheel.rate = 0.0
        else:
            wheel.torque_nm = math.copysign(limit_nm, wheel.omega_radps)
            wheel.rate = (turning_nm - wheel.torque_nm) / wheel.inertia_kgm2
        force_n += wheel.creep_n
    return -(force_n + resistance(speed, now, wagon)) / wagon.mass_kg


@compiled
def move(acceleration: float, now: Circumstances, wagon: Wagon, wheels: Wheelsets) -> None:
    """One ROS2 step of speed and rotations."""
    step_s, speed = wagon.step_s, wagon.speed_mps
    first_v = solve(acceleration, wagon, wheels)
    stage_v = speed + step_s * first_v
    total_n = resistance(stage_v, now, wagon)
    for wheel in wheels:
        wheel.first = wheel.solved
        slip_mps = stage_v - (wheel.omega_radps + step_s * wheel.first) * wheel.radius_m
        creep_n = utilisation(slip_mps, stage_v, wheel.load_n, wheel.mu0, law_for(wheel.mu0))[0] * wheel.load_n
        total_n += creep_n
        turning_nm = creep_n * wheel.radius_m - wheel.motor_nm
        rate = (1.0 - wheel.locked) * (turning_nm - wheel.torque_nm) / wheel.inertia_kgm2
        wheel.rate = rate - 2.0 * wheel.first
    second_v = solve(-total_n / wagon.mass_kg - 2.0 * first_v, wagon, wheels)
    wagon.speed_mps = speed + step_s * (1.5 * first_v + 0.5 * second_v)
    for wheel in wheels:
        turn(step_s * (1.5 * wheel.first + 0.5 * wheel.solved), wheel)
    wagon.position_m += step_s * 0.5 * (speed + wagon.speed_mps)
    # about the centre of mass: there gravity has no moment, and the coupler pulls not far below it
    central_n = now.hill_n + (1.0 - wagon.coupler_pitch) * now.coupler_n
    pitching = acceleration + central_n / wagon.mass_kg
    wagon.pitching_mps2 += (pitching - wagon.pitching_mps2) * step_s / PITCH_TIME_CONSTANT_S


@compiled
def solve(speed_rate: float, wagon: Wagon, wheels: Wheelsets) -> float:
    """(I - gamma h A) k = rates for the arrow matrix A of creep stiffness; wheelsets are eliminated first.

    Returns k of the speed; that of each wheelset is its `solved`.
    """
    gain = GAMMA * wagon.step_s
    diagonal = wagon.mass_kg
    right = wagon.mass_kg * speed_rate
    for wheel in wheels:
        stiffness = max(wheel.slope, 0.0) * wheel.load_n
        grip = gain * stiffness * wheel.radius_m * (1.0 - wheel.locked)
        pivot = wheel.inertia_kgm2 + grip * wheel.radius_m
        diagonal += gain * stiffness - grip * grip / pivot
        right += grip * wheel.inertia_kgm2 * wheel.rate / pivot
        wheel.grip = grip
        wheel.pivot = pivot
    k_v = right / diagonal
    for wheel in wheels:
        wheel.solved = (wheel.inertia_kgm2 * wheel.rate + wheel.grip * k_v) / wheel.pivot
    return k_v


@compiled
def turn(change: float, wheel: Wheelset) -> None:
    """Apply a change of rotation; a brake stops a wheelset but never turns it backwards."""
    if wheel.locked != 0.0:
        return
    before = wheel.omega_radps
    wheel.omega_radps = before + change
    if wheel.force_n > 0.0 and before * wheel.omega_radps < 0.0:
        wheel.omega_radps = 0.0
        wheel.locked = 1.0


@compiled
def is_at_rest(now: Circumstances, wagon: Wagon, wheels: Wheelsets) -> bool:
    """Standing, or about to, with brakes and resistance that can hold the wagon."""
    if abs(wagon.speed_mps) > STANDSTILL_MPS:
        return False
    holding_n, pushing_n = now.resistance_n, now.hill_n + now.coupler_n
    for wheel in wheels:
        brake_n = wheel.friction * wheel.force_n * wheel.brake_radius_m / wheel.radius_m
        holding_n += min(brake_n, wheel.mu0 * wheel.load_n)
        pushing_n += wheel.motor_nm / wheel.radius_m
    return abs(pushing_n) <= holding_n


@compiled
def stand(wagon: Wagon, wheels: Wheelsets) -> None:
    """Come to rest."""
    wagon.speed_mps = 0.0
    wagon.pitching_mps2 = 0.0
    for wheel in wheels:
        wheel.omega_radps = 0.0
        wheel.locked = 1.0


@compiled
def warm_up(interval_s: float, wagon: Wagon, wheels: Wheelsets) -> None:
    """What changes slowly: discs and the friction of their pads."""
    for wheel in wheels:
        sliding_mps = wheel.omega_radps * wheel.brake_radius_m
        power_w = wheel.friction * wheel.force_n * abs(sliding_mps)
        wheel.temperature_c = disc_temperature(wheel.temperature_c, interval_s, power_w, wagon.speed_mps)
        relative_force = wheel.force_n / wheel.full_force_n
        steady = steady_friction(sliding_mps, relative_force, wheel.temperature_c)
        target = wheel.quality * wheel.friction_factor * steady
        wheel.friction = following(wheel.friction, interval_s, target)


@compiled
def note(row: Floats, acceleration: float, now: Circumstances, wagon: Wagon, wheels: Wheelsets) -> None:
    """One row of WAGON_COLUMNS and N times WHEELSET_COLUMNS."""
    speed = wagon.speed_mps
    row[:WAGON_WIDTH] = (
        speed,
        wagon.position_m,
        acceleration,
        resistance(speed, now, wagon),
        now.coupler_n,
        wagon.supply_bar,
        now.sanding,
        now.gradient,
    )
    at = WAGON_WIDTH
    for wheel in wheels:
        slip_mps = speed - wheel.omega_radps * wheel.radius_m
        row[at : at + WHEELSET_WIDTH] = (
            wheel.omega_radps,
            slip_mps / speed if abs(speed) > RESISTANCE_BLEND_MPS else 0.0,
            wheel.creep_n / wheel.load_n,
            wheel.friction,
            wheel.force_n,
            wheel.pressure_bar,
            wheel.wsp,
            wheel.temperature_c,
            1.0 if wheel.slope < 0.0 else 0.0,
            wheel.creep_n,
            wheel.torque_nm,
            wheel.load_n,
            wheel.motor_nm if speed < 0.0 else 0.0 - wheel.motor_nm,
        )
        at += WHEELSET_WIDTH
