"""The vehicle as the mechanics knows it when a run begins: out of its settings, and of what departs from them."""

import random
from collections.abc import Sequence

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.settings.config import Vehicle
from brake_monitor.simulator.physics.motion import COUPLER_HEIGHT_M, Wagon, Wheelset
from brake_monitor.simulator.physics.pad import AMBIENT_C, steady_friction
from brake_monitor.simulator.physics.pneumatics import BrakeGear

PAD_QUALITY_SPREAD = 0.04


def true_radii(vehicle: Vehicle, factors: tuple[float, ...]) -> list[float]:
    """Those of the wheels; one factor for all wheelsets, or one each."""
    count = vehicle.wheelset_count
    if len(factors) not in (1, count):
        raise ValueError(f"wheel_radius_factor needs 1 or {count} values")
    factors = factors * count if len(factors) == 1 else factors
    return [radius_m * factor for radius_m, factor in zip(vehicle.wheel_radius_m, factors, strict=True)]


def new_wagon(vehicle: Vehicle, mass_kg: float, speed_mps: float, step_s: float) -> Wagon:
    """Running; what is not named is 0, as in `new_wheelsets`."""
    height_m = vehicle.cog_height_m
    return Wagon(
        step_s=step_s,
        mass_kg=mass_kg,
        coupler_pitch=1.0 - COUPLER_HEIGHT_M / height_m if height_m > 0.0 else 0.0,
        drag_n_per_mps2=vehicle.drag_n_per_mps2,
        speed_mps=speed_mps,
    )


def new_wheelsets(
    vehicle: Vehicle,
    gears: Sequence[BrakeGear],
    radius_m: Sequence[float],
    *,
    mass_kg: float,
    speed_mps: float,
    rng: random.Random,
) -> list[Wheelset]:
    """All rolling, with released brakes, each with pads of its own quality."""
    positions_m, moved_kg = vehicle.axle_positions_m, mass_kg * _moved(vehicle)
    wheels = []
    for i, gear in enumerate(gears):
        quality = 1.0 + rng.uniform(-PAD_QUALITY_SPREAD, PAD_QUALITY_SPREAD)
        omega_radps = speed_mps / radius_m[i]
        wheels.append(
            Wheelset(
                position_m=positions_m[i],
                moved_kg=moved_kg[i],
                passed=sum(other > positions_m[i] for other in positions_m),
                radius_m=radius_m[i],
                brake_radius_m=vehicle.brake_radius_m[i],
                inertia_kgm2=vehicle.wheelset_inertia_kgm2[i],
                force_per_bar_n=gear.force_per_bar_n,
                spring_n=gear.offset_n,
                full_force_n=gear.full_force_n,
                quality=quality,
                blending=1.0,
                inlet=1.0,
                rigging=1.0,
                friction_factor=1.0,
                friction=quality * steady_friction(omega_radps * vehicle.brake_radius_m[i], 0.0, AMBIENT_C),
                temperature_c=AMBIENT_C,
                omega_radps=omega_radps,
            )
        )
    return wheels


def _moved(vehicle: Vehicle) -> Floats:
    """Of a unit of mass, the load that leaves each wheelset per acceleration by the rail.

    Each frame that pitches (the body on its wheelsets; on bogies, the body on their pivots and each bogie on its
    wheelsets) is in balance on springs alike. All bogies are pulled alike.
    """
    positions_m, each = np.array(vehicle.axle_positions_m), vehicle.wheelsets_per_bogie
    if each == 1:
        return _springs(positions_m, vehicle.cog_height_m)
    bogies_m = [positions_m[first : first + each] for first in range(0, len(positions_m), each)]
    pivots = _springs(np.array([bogie_m.mean() for bogie_m in bogies_m]), vehicle.cog_height_m - vehicle.pivot_height_m)
    moment = vehicle.pivot_height_m / len(bogies_m)
    return np.concatenate(
        [
            pivot / each + _springs(bogie_m - bogie_m.mean(), moment)
            for pivot, bogie_m in zip(pivots, bogies_m, strict=True)
        ]
    )


def _springs(positions_m: Floats, moment: float) -> Floats:
    """What springs at these places, of which the sum is none, give way to a moment."""
    return positions_m * (moment / (positions_m @ positions_m)) if positions_m.any() else np.zeros(len(positions_m))
