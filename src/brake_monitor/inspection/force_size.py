"""Whether the forces of a recording are of the size that its vehicle needs: what brakes it, and what it weighs."""

from collections.abc import Iterator, Sequence

from brake_monitor.digits import significant
from brake_monitor.estimation.core.core import LARGEST_LOAD_RATIO
from brake_monitor.estimation.model.wagon import GRAVITY_MPS2
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.friction_size import remarks_on_friction
from brake_monitor.inspection.traffic import Found, Traffic
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings

SLOWED_MPS = 10.0  # a recording in which speed changes by this much usually has a braking in it, and its end
BRAKED_MPS2 = 0.3  # which neither the train's resistance takes from the speed, nor a gradient of 25 per mille
IDLE = 0.1  # of what another brake presses with at most
HARDEST_MPS2 = 2.0  # no friction brake on rails is made for this much
WEAK = 2.5  # times as much as by friction_nominal; cast iron rubs as much more at the end of a stop


def remarks_on_load(traffic: Traffic, settings: Settings) -> Iterator[str]:
    """A load that the estimator does not use, since the vehicle cannot weigh that."""
    loaded_kg, mass_kg = _loaded_kg(traffic, settings), settings.vehicle.mass_kg
    if loaded_kg is not None and not mass_kg / LARGEST_LOAD_RATIO <= loaded_kg <= mass_kg * LARGEST_LOAD_RATIO:
        yield (
            f"load_force adds up to {significant(loaded_kg, 3)} kg, and is not used: beside vehicle.mass_kg, "
            f"{mass_kg:g}, it is out of all proportion; look at its unit, scale and offset"
        )


def remarks_on_forces(traffic: Traffic, settings: Settings) -> Iterator[str]:
    """A brake presses and releases, and does what it is seen to do: no more than it was made for, and no less."""
    forces = [traffic.found[Quantity.PRESSING_FORCE, place] for place in range(settings.vehicle.wheelset_count)]
    loaded_kg, mass_kg = _loaded_kg(traffic, settings), settings.vehicle.mass_kg
    masses_kg = (mass_kg,) if loaded_kg is None else (mass_kg, loaded_kg)
    contact_n = settings.estimator.contact_force_n
    told = [*_on_released(traffic.found[Quantity.SPEED, 0], forces, contact_n), *_on_idle(forces, contact_n)]
    told += _on_strong(forces, settings, max(masses_kg))
    told = told or list(_on_weak(traffic.first_hour, forces, settings, min(masses_kg)))
    yield from told or remarks_on_friction(traffic.first_hour, settings, _weighed_kg(traffic, settings))


def _weighed_kg(traffic: Traffic, settings: Settings) -> tuple[float, ...]:
    """The mass, or the least and the greatest that load signals tell, as far as the estimator uses them."""
    mass_kg = settings.vehicle.mass_kg
    told_kg = _told_kg(traffic, settings) or ()
    used_kg = [one for one in told_kg if mass_kg / LARGEST_LOAD_RATIO <= one <= mass_kg * LARGEST_LOAD_RATIO]
    return tuple(used_kg) or (mass_kg,)


def _loaded_kg(traffic: Traffic, settings: Settings) -> float | None:
    """The greatest mass that the load signals tell together; None when not all of them do."""
    told_kg = _told_kg(traffic, settings)
    return None if told_kg is None else told_kg[1]


def _told_kg(traffic: Traffic, settings: Settings) -> tuple[float, float] | None:
    """The least and the greatest."""
    loads = [traffic.found[Quantity.LOAD_FORCE, place] for place in range(len(settings.signals.load_force))]
    if not loads or not all(load.is_kept for load in loads):
        return None
    least_n, greatest_n = sum(load.kept_least for load in loads), sum(load.kept_greatest for load in loads)
    return least_n / GRAVITY_MPS2, greatest_n / GRAVITY_MPS2


def _on_released(speed: Found, forces: Sequence[Found], contact_n: float) -> Iterator[str]:
    """Where the vehicle slows down and goes on, brakes have pressed, and come off."""
    if not speed.is_kept or speed.kept_greatest - speed.kept_least < SLOWED_MPS:
        return
    most_n = max(0.0, *(force.kept_greatest for force in forces))
    meanwhile = f"while speed goes from {speed.kept_least:.3g} to {speed.kept_greatest:.3g} m/s"
    if most_n < contact_n and any(force.size > 0.0 for force in forces):  # if none: `_on_weak`
        yield (
            f"no pressing_force goes beyond {significant(most_n, 3)} N {meanwhile}, and below "
            f"estimator.contact_force_n, {contact_n:g} N, no pad presses: if it braked, look at unit and scale"
        )
    for place, force in enumerate(forces, 1):
        if force.is_kept and force.kept_least >= contact_n:
            yield (
                f"pressing_force {place} never falls below {significant(force.kept_least, 3)} N {meanwhile}: if its "
                "brake was ever released, look at its offset"
            )


def _on_idle(forces: Sequence[Found], contact_n: float) -> Iterator[str]:
    """A brake that never presses beside another: a wrong sign and a `min` turn all that its sensor says into 0."""
    most_n = {place: max(force.kept_greatest, 0.0) for place, force in enumerate(forces, 1) if force.is_kept}
    hardest_n = max(most_n.values(), default=0.0)
    if hardest_n < contact_n:
        return
    for place, own_n in most_n.items():
        if own_n < min(contact_n, IDLE * hardest_n):
            yield (
                f"pressing_force {place} never goes beyond {significant(own_n, 3)} N while another goes up to "
                f"{significant(hardest_n, 3)} N: if its brake is not cut out, look at its scale and the sign of it, "
                "and at its offset, min and max"
            )


def _on_strong(forces: Sequence[Found], settings: Settings, mass_kg: float) -> Iterator[str]:
    greatest_n = [max(force.kept_greatest, 0.0) for force in forces]
    by_brakes_mps2 = _retarding_n(greatest_n, settings) / mass_kg
    if by_brakes_mps2 > HARDEST_MPS2:
        yield (
            f"pressing forces of up to {significant(max(greatest_n), 3)} N would brake {mass_kg:.0f} kg by "
            f"{significant(by_brakes_mps2, 2)} m/s²: look at their unit and scale, and at vehicle.mass_kg"
        )


def _on_weak(first_hour: FirstHour, forces: Sequence[Found], settings: Settings, mass_kg: float) -> Iterator[str]:
    """Brakes that could not slow the vehicle down like that with what they are said to press.

    Where a train or motors brake it as well, that is in doubt only of brakes that never press.
    """
    others_brake = settings.estimator.preset == "train" or bool(settings.signals.wheel_torque)
    if others_brake and any(force.size > 0.0 for force in forces):
        return
    slowed_mps2, begin_s = first_hour.hardest_slowing()
    told_n = [first_hour.greatest_force_n(i, begin_s) for i in range(len(forces))]
    pressing_n = [force_n for force_n in told_n if force_n is not None]
    if len(pressing_n) < len(forces):
        return
    by_brakes_mps2 = _retarding_n(pressing_n, settings) / mass_kg
    if slowed_mps2 - BRAKED_MPS2 > WEAK * by_brakes_mps2:
        yield (
            f"the vehicle slows down by up to {significant(slowed_mps2, 2)} m/s², and the pressing forces meanwhile, "
            f"up to {significant(max(pressing_n), 3)} N, would do {significant(by_brakes_mps2, 2)} m/s²: unless others "
            'did that, as a train does (preset = "train"), look at unit, scale (of all pads together) and the sign of '
            "it, and at offset, min, max and vehicle.mass_kg"
        )


def _retarding_n(forces_n: Sequence[float], settings: Settings) -> float:
    """What brakes that press like that do at the rail, with nominal friction."""
    vehicle, friction = settings.vehicle, settings.estimator.friction_nominal
    of_each = zip(forces_n, vehicle.brake_radius_m, vehicle.wheel_radius_m, strict=True)
    return friction * sum(force_n * brake_m / wheel_m for force_n, brake_m, wheel_m in of_each)
