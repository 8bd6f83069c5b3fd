"""The inner loop of the plant: brakes, load transfer, creep, and the motion of wagon and wheelsets, step by step.

The creep curve is stiff at low speed (time constants well below a millisecond), so speed and rotation are advanced
together by ROS2, a second-order, L-stable Rosenbrock scheme; its matrix is an arrow (each wheelset is coupled to the
speed alone). Everything here is plain numbers and vectors, so that it can be compiled.
"""

import math
from typing import NamedTuple

from brake_monitor.arrays import Floats
from brake_monitor.simulator.physics.compiled import Vector, compiled
from brake_monitor.simulator.physics.creep import law_for, utilisation
from brake_monitor.simulator.physics.pad import disc_temperature, following, steady_friction
from brake_monitor.simulator.physics.pneumatics import cylinder_after, supply_after
from brake_monitor.simulator.physics.rail import RailState, friction_level

GAMMA = 1.0 - 1.0 / math.sqrt(2.0)  # of ROS2
PITCH_TIME_CONSTANT_S = 0.05  # the load moves between the wheelsets through the suspension
COUPLER_HEIGHT_M = 1.0  # of the draw hook above the rail (0.92 to 1.045 m, EN 15566)
STANDSTILL_MPS = 5e-3  # slower than a full brake takes off within a few steps
RESISTANCE_BLEND_MPS = 0.01  # running resistance changes sign smoothly through standstill

SPEED, POSITION, PITCHING, SUPPLY = range(4)  # places in the vector of the wagon's motion; SI units and bar


class Body(NamedTuple):
    """What does not change during a run."""

    step_s: float
    mass_kg: float
    coupler_pitch: float  # moment about the centre of mass by the coupler over that by as great a force at the rail
    drag_n_per_mps2: float


class Circumstances(NamedTuple):
    """What acts on the wagon, held for one sampling interval of the controller."""

    demand: float  # 0 released, 1 full brake
    load_n: float  # of a wheelset at rest
    resistance_n: float  # track and curve, against the motion
    hill_n: float  # gradient, uphill positive
    coupler_n: float  # the train holds back, negative when it pulls
    gradient: float
    sanding: float
    rail: RailState


class Wheelsets(NamedTuple):
    """One entry per wheelset; the second half are states."""

    position_m: Vector
    moved_kg: Vector  # load that leaves it per acceleration by the rail
    passed: Vector  # wheelsets of this wagon that pass a place before this one
    radius_m: Vector
    brake_radius_m: Vector
    inertia_kgm2: Vector
    force_per_bar_n: Vector
    spring_n: Vector  # negative
    full_force_n: Vector
    quality: Vector  # friction of its pads over that of the nominal ones
    inlet: Vector  # 1, or 0 where the cylinder is isolated
    blending: Vector  # share of the brake that its motor leaves to the pads, 1 without one
    motor_nm: Vector  # torque of its motor; braking forward motion positive
    least_bar: Vector  # below it the cylinder does not empty
    rigging: Vector  # share of the cylinder's force that reaches the pads
    stuck_n: Vector  # below it the pads do not come off
    valve: Vector  # FILL, HOLD or DUMP
    wsp: Vector  # 1 while the slide protection acts
    pressure_bar: Vector
    force_n: Vector
    friction: Vector
    temperature_c: Vector
    omega: Vector
    locked: Vector  # 0 or 1
    load_n: Vector
    mu0: Vector


class Scratch(NamedTuple):
    """Room for one entry per wheelset between the stages of a step."""

    creep_n: Vector
    slope: Vector
    torque_nm: Vector
    rate: Vector
    first: Vector
    second: Vector
    grip: Vector
    pivot: Vector


class Wagon(NamedTuple):
    """The whole vehicle."""

    body: Body
    motion: Vector  # by SPEED, POSITION, PITCHING, SUPPLY
    wheels: Wheelsets
    scratch: Scratch


@compiled
def advance(steps: int, every: int, now: Circumstances, wagon: Wagon, rows: Floats) -> None:
    """Advance by `steps`, and note the truth at the beginning of every `every`th of them in `rows`."""
    for k in range(steps):
        prepare(now, wagon)
        acceleration = act(now, wagon)
        if k % every == 0:
            note(rows[k // every], acceleration, now, wagon)
        if is_at_rest(now, wagon):
            stand(wagon)
        else:
            move(acceleration, now, wagon)
    warm_up(steps * wagon.body.step_s, wagon)


@compiled
def prepare(now: Circumstances, wagon: Wagon) -> None:
    """What changes little within a step: pressures, pressing forces, loads, rail."""
    wheels, motion, step_s = wagon.wheels, wagon.motion, wagon.body.step_s
    motion[SUPPLY] = supply_after(motion[SUPPLY], step_s, now.demand)
    for i in range(len(wheels.omega)):
        supply_bar = motion[SUPPLY] * wheels.inlet[i] * wheels.blending[i]
        wheels.pressure_bar[i] = cylinder_after(
            wheels.pressure_bar[i], step_s, wheels.valve[i], supply_bar, wheels.least_bar[i]
        )
        force_n = max(wheels.force_per_bar_n[i] * wheels.pressure_bar[i] + wheels.spring_n[i], 0.0)
        wheels.force_n[i] = max(force_n * wheels.rigging[i], min(wheels.stuck_n[i], wheels.force_n[i]))
        wheels.load_n[i] = now.load_n - wheels.moved_kg[i] * motion[PITCHING]
        place_m = motion[POSITION] + wheels.position_m[i]
        wheels.mu0[i] = friction_level(place_m, wheels.passed[i], now.rail)


@compiled
def resistance(speed: float, now: Circumstances, body: Body) -> float:
    """Track, curve, drag, gradient and coupler; braking positive."""
    running = now.resistance_n * math.tanh(speed / RESISTANCE_BLEND_MPS)
    return running + body.drag_n_per_mps2 * speed * abs(speed) + now.hill_n + now.coupler_n


@compiled
def act(now: Circumstances, wagon: Wagon) -> float:
    """Creep forces and brake torques now; returns the acceleration.

    A locked wheelset is held by just what rail and motor ask for, until that is more than its brake can hold.
    """
    wheels, scratch, speed = wagon.wheels, wagon.scratch, wagon.motion[SPEED]
    force_n = 0.0
    for i in range(len(wheels.omega)):
        radius_m, load_n, mu0 = wheels.radius_m[i], wheels.load_n[i], wheels.mu0[i]
        share, slope = utilisation(speed - wheels.omega[i] * radius_m, speed, load_n, mu0, law_for(mu0))
        creep_n = share * load_n
        limit_nm = wheels.friction[i] * wheels.force_n[i] * wheels.brake_radius_m[i]
        turning_nm = creep_n * radius_m - wheels.motor_nm[i]
        if wheels.locked[i] != 0.0 and abs(turning_nm) > limit_nm:
            wheels.locked[i] = 0.0
            wheels.omega[i] = math.copysign(1e-12, turning_nm)  # lets the brake know against what it works
        if wheels.locked[i] != 0.0:
            torque_nm = min(max(turning_nm, -limit_nm), limit_nm)
            scratch.rate[i] = 0.0
        else:
            torque_nm = math.copysign(limit_nm, wheels.omega[i])
            scratch.rate[i] = (turning_nm - torque_nm) / wheels.inertia_kgm2[i]
        scratch.creep_n[i] = creep_n
        scratch.slope[i] = slope
        scratch.torque_nm[i] = torque_nm
        force_n += creep_n
    return -(force_n + resistance(speed, now, wagon.body)) / wagon.body.mass_kg


@compiled
def move(acceleration: float, now: Circumstances, wagon: Wagon) -> None:
    """One ROS2 step of speed and rotations."""
    body, motion, wheels, scratch = wagon
    step_s = body.step_s
    speed = motion[SPEED]
    first_v = solve(acceleration, scratch.first, wagon)
    stage_v = speed + step_s * first_v
    total_n = resistance(stage_v, now, body)
    for i in range(len(wheels.omega)):
        radius_m, load_n, mu0 = wheels.radius_m[i], wheels.load_n[i], wheels.mu0[i]
        slip_mps = stage_v - (wheels.omega[i] + step_s * scratch.first[i]) * radius_m
        creep_n = utilisation(slip_mps, stage_v, load_n, mu0, law_for(mu0))[0] * load_n
        total_n += creep_n
        free = 1.0 - wheels.locked[i]
        turning_nm = creep_n * radius_m - wheels.motor_nm[i]
        rate = free * (turning_nm - scratch.torque_nm[i]) / wheels.inertia_kgm2[i]
        scratch.rate[i] = rate - 2.0 * scratch.first[i]
    second_v = solve(-total_n / body.mass_kg - 2.0 * first_v, scratch.second, wagon)
    motion[SPEED] = speed + step_s * (1.5 * first_v + 0.5 * second_v)
    for i in range(len(wheels.omega)):
        turn(i, step_s * (1.5 * scratch.first[i] + 0.5 * scratch.second[i]), wheels)
    motion[POSITION] += step_s * 0.5 * (speed + motion[SPEED])
    # about the centre of mass: there gravity has no moment, and the coupler pulls not far below it
    central_n = now.hill_n + (1.0 - body.coupler_pitch) * now.coupler_n
    pitching = acceleration + central_n / body.mass_kg
    motion[PITCHING] += (pitching - motion[PITCHING]) * step_s / PITCH_TIME_CONSTANT_S


@compiled
def solve(speed_rate: float, into: Vector, wagon: Wagon) -> float:
    """(I - gamma h A) k = rates for the arrow matrix A of creep stiffness; wheelsets are eliminated first.

    Returns k of the speed, and writes those of the wheelsets.
    """
    body, wheels, scratch = wagon.body, wagon.wheels, wagon.scratch
    gain = GAMMA * body.step_s
    diagonal = body.mass_kg
    right = body.mass_kg * speed_rate
    for i in range(len(wheels.omega)):
        stiffness = max(scratch.slope[i], 0.0) * wheels.load_n[i]
        grip = gain * stiffness * wheels.radius_m[i] * (1.0 - wheels.locked[i])
        pivot = wheels.inertia_kgm2[i] + grip * wheels.radius_m[i]
        diagonal += gain * stiffness - grip * grip / pivot
        right += grip * wheels.inertia_kgm2[i] * scratch.rate[i] / pivot
        scratch.grip[i] = grip
        scratch.pivot[i] = pivot
    k_v = right / diagonal
    for i in range(len(wheels.omega)):
        into[i] = (wheels.inertia_kgm2[i] * scratch.rate[i] + scratch.grip[i] * k_v) / scratch.pivot[i]
    return k_v


@compiled
def turn(i: int, change: float, wheels: Wheelsets) -> None:
    """Apply a change of rotation; a brake stops a wheelset but never turns it backwards."""
    if wheels.locked[i] != 0.0:
        return
    before = wheels.omega[i]
    wheels.omega[i] = before + change
    if wheels.force_n[i] > 0.0 and before * wheels.omega[i] < 0.0:
        wheels.omega[i] = 0.0
        wheels.locked[i] = 1.0


@compiled
def is_at_rest(now: Circumstances, wagon: Wagon) -> bool:
    """Standing, or about to, with brakes and resistance that can hold the wagon."""
    wheels = wagon.wheels
    if abs(wagon.motion[SPEED]) > STANDSTILL_MPS:
        return False
    holding_n, pushing_n = now.resistance_n, now.hill_n + now.coupler_n
    for i in range(len(wheels.omega)):
        brake_n = wheels.friction[i] * wheels.force_n[i] * wheels.brake_radius_m[i] / wheels.radius_m[i]
        holding_n += min(brake_n, wheels.mu0[i] * wheels.load_n[i])
        pushing_n += wheels.motor_nm[i] / wheels.radius_m[i]
    return abs(pushing_n) <= holding_n


@compiled
def stand(wagon: Wagon) -> None:
    """Come to rest."""
    wheels, motion = wagon.wheels, wagon.motion
    motion[SPEED] = 0.0
    motion[PITCHING] = 0.0
    for i in range(len(wheels.omega)):
        wheels.omega[i] = 0.0
        wheels.locked[i] = 1.0


@compiled
def warm_up(interval_s: float, wagon: Wagon) -> None:
    """What changes slowly: discs and the friction of their pads."""
    wheels, motion = wagon.wheels, wagon.motion
    for i in range(len(wheels.omega)):
        sliding_mps = wheels.omega[i] * wheels.brake_radius_m[i]
        power_w = wheels.friction[i] * wheels.force_n[i] * abs(sliding_mps)
        wheels.temperature_c[i] = disc_temperature(wheels.temperature_c[i], interval_s, power_w, motion[SPEED])
        relative_force = wheels.force_n[i] / wheels.full_force_n[i]
        target = wheels.quality[i] * steady_friction(sliding_mps, relative_force, wheels.temperature_c[i])
        wheels.friction[i] = following(wheels.friction[i], interval_s, target)


@compiled
def note(row: Floats, acceleration: float, now: Circumstances, wagon: Wagon) -> None:
    """One row of WAGON_COLUMNS and N times WHEELSET_COLUMNS."""
    body, motion, wheels, scratch = wagon
    speed = motion[SPEED]
    row[0] = speed
    row[1] = motion[POSITION]
    row[2] = acceleration
    row[3] = resistance(speed, now, body)
    row[4] = now.coupler_n
    row[5] = motion[SUPPLY]
    row[6] = now.sanding
    row[7] = now.gradient
    at = 8
    for i in range(len(wheels.omega)):
        slip_mps = speed - wheels.omega[i] * wheels.radius_m[i]
        row[at] = wheels.omega[i]
        row[at + 1] = slip_mps / speed if abs(speed) > RESISTANCE_BLEND_MPS else 0.0
        row[at + 2] = scratch.creep_n[i] / wheels.load_n[i]
        row[at + 3] = wheels.friction[i]
        row[at + 4] = wheels.force_n[i]
        row[at + 5] = wheels.pressure_bar[i]
        row[at + 6] = wheels.wsp[i]
        row[at + 7] = wheels.temperature_c[i]
        row[at + 8] = 1.0 if scratch.slope[i] < 0.0 else 0.0
        row[at + 9] = scratch.creep_n[i]
        row[at + 10] = scratch.torque_nm[i]
        row[at + 11] = wheels.load_n[i]
        row[at + 12] = wheels.motor_nm[i] if speed < 0.0 else 0.0 - wheels.motor_nm[i]
        at += 13
