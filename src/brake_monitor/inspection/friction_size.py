"""Whether friction comes out as pads have it: a mass, force or radius that is wrong by a factor shows in it."""

from collections.abc import Iterator
from statistics import median

import numpy as np
from msgspec import Struct

from brake_monitor.arrays import Bools, Floats
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings

FACTOR = 1.5  # pads of a fleet differ by a third at most, three sigma of `friction_nominal_std`
LEAST_APPLICATIONS = 3  # of which the median counts: the line may change, or a train push, as one of them begins
GRID_S = 0.1
BEFORE_S, FILLING_S = 3.0, 2.0  # released before an application; until brakes press as they were told to
LEAST_S, LONGEST_S = 2.0, 10.0  # of what is looked at behind that: later the line may be another
LEAST_MPS = 5.0  # slower than this sensors may say 0, and pads rub more
LEAST_MPS2 = 0.25  # that brakes take from the speed, as told or as seen: few gradients come and go with as much
SLIDE = 0.05  # of slip, with what a wheel may be worn by
UNLIKE = 0.2  # of the deceleration, between the vehicle's speed and the wheels': one of them fails


class _Drive(Struct, frozen=True):
    """What speeds and forces tell, every GRID_S."""

    speed_mps: Floats
    wheels_mps: Floats  # their mean
    retarding_n: Floats  # at the rail, with a friction of one
    released: Bools
    rolls: Bools


def remarks_on_friction(first_hour: FirstHour, settings: Settings, masses_kg: tuple[float, ...]) -> Iterator[str]:
    """Friction by the balance of forces, over the brake applications in which nothing slides.

    `masses_kg`: the wagon's, or the least and the greatest that it was told to have. Nothing where others brake it as
    well, nor of blocks, whose friction depends on speed.
    """
    estimator = settings.estimator
    if estimator.preset == "train" or settings.signals.wheel_torque or estimator.tuning.friction is not None:
        return
    drive = _drive(first_hour, settings)
    if drive is None:
        return
    nominal, turning_kg = estimator.friction_nominal, sum(settings.vehicle.turning_kg)
    found = [list(_frictions(drive, mass_kg + turning_kg, nominal)) for mass_kg in masses_kg]
    if min(map(len, found)) < LEAST_APPLICATIONS:
        return
    frictions = sorted(map(median, found))
    if frictions[0] > FACTOR * nominal or frictions[-1] < nominal / FACTOR:
        nearest = frictions[0] if frictions[0] > nominal else frictions[-1]
        yield (
            f"over {len(found[0])} brake applications friction comes out at about {nearest:.2f}, and "
            f"estimator.friction_nominal is {nominal:g}: unless others brake or push the vehicle, look at mass, "
            "brake_radius_m, wheel_radius_m, and at the scale of pressing_force (of all pads together) and load_force"
        )


def _drive(first_hour: FirstHour, settings: Settings) -> _Drive | None:
    """None when a signal is missing, or too little is told."""
    vehicle = settings.vehicle
    speeds = first_hour.speeds_mps(vehicle.wheel_radius_m)
    told = [first_hour.readings(Quantity.PRESSING_FORCE, i) for i in range(vehicle.wheelset_count)]
    forces = [one for one in told if one is not None]
    if speeds is None or len(forces) < len(told):
        return None
    every = (*speeds, *forces)
    begin_s, end_s = max(float(one.times_s[0]) for one in every), min(float(one.times_s[-1]) for one in every)
    if end_s - begin_s < BEFORE_S + FILLING_S + LEAST_S:
        return None
    times_s = np.arange(begin_s, end_s, GRID_S)
    speed_mps, *each_mps = (one.at(times_s) for one in speeds)
    wheels_mps = np.array(each_mps)
    forces_n = np.array([one.at(times_s).clip(min=0.0) for one in forces])
    ratios = np.array(vehicle.brake_radius_m) / np.array(vehicle.wheel_radius_m)
    return _Drive(
        speed_mps,
        wheels_mps.mean(axis=0),
        ratios @ forces_n,
        forces_n.max(axis=0) < settings.estimator.contact_force_n,
        (speed_mps > LEAST_MPS) & (wheels_mps.min(axis=0) > (1.0 - SLIDE) * speed_mps),
    )


def _frictions(drive: _Drive, mass_kg: float, nominal: float) -> Iterator[float]:
    """By each application: how much more the wagon slows down than just before, over what the brakes press."""
    before, filling, least, longest = (round(span_s / GRID_S) for span_s in (BEFORE_S, FILLING_S, LEAST_S, LONGEST_S))
    usable = drive.rolls & ~drive.released
    for begin in np.flatnonzero(drive.released[:-1] & ~drive.released[1:]) + 1:
        rolled = slice(begin - before, begin)
        if begin < before or not (drive.released[rolled] & drive.rolls[rolled]).all():
            continue
        pressed = usable[begin : begin + filling + longest]
        end = begin + (len(pressed) if pressed.all() else int(pressed.argmin()))
        braked = slice(begin + filling, end)
        if end - braked.start < least:
            continue
        slowed_mps2, by_wheels_mps2 = [
            _slowing_mps2(told_mps[braked]) - _slowing_mps2(told_mps[rolled])
            for told_mps in (drive.speed_mps, drive.wheels_mps)
        ]
        asked_mps2 = -_slowing_mps2(np.cumsum(drive.retarding_n[braked]) * GRID_S / mass_kg)  # weighted alike
        differs = abs(slowed_mps2 - by_wheels_mps2) > UNLIKE * abs(by_wheels_mps2)
        if max(slowed_mps2, nominal * asked_mps2) > LEAST_MPS2 and not differs:
            yield slowed_mps2 / asked_mps2


def _slowing_mps2(speed_mps: Floats) -> float:
    """By a straight line through successive speeds."""
    slope, _ = np.polyfit(np.arange(len(speed_mps)) * GRID_S, speed_mps, 1)
    return -float(slope)
