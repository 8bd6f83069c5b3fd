"""Whether a vehicle can be as it is configured: each wheelset bears weight, and inertia fits mass."""

from itertools import combinations
from statistics import fmean

from brake_monitor.settings.bounds import MOST_WHEELSETS
from brake_monitor.settings.config import Vehicle
from brake_monitor.settings.config_text import ConfigText
from brake_monitor.settings.key_space import fault_of

PER_WHEELSET = ("wheelset_inertia_kgm2", "wheel_radius_m", "brake_radius_m")

# Beyond what any vehicle or rig has, so that one of the two was meant in another unit.
_LEAST_MASS = 0.2  # of J/r^2 of all wheelsets
_LEAST_TURNING_MASS = 1e-4  # J/r^2 of a wheelset, of its share of the mass


def a_number_or_list(count: int) -> str:
    """What each key of PER_WHEELSET may be, in words."""
    return f"a number or a list of {count} (one per wheelset)"


def check_vehicle(text: ConfigText, vehicle: Vehicle) -> None:
    """InputError when no vehicle can be like that."""
    if fault := fault_of(vehicle.id):
        text.refuse(("vehicle", "id"), fault)
    count = vehicle.wheelset_count
    if count == 0:
        text.refuse(("vehicle", "axle_positions_m"), "expected one number per wheelset, got an empty list")
    if count > MOST_WHEELSETS:  # of more a watcher believes nothing
        text.refuse(("vehicle", "axle_positions_m"), f"expected {MOST_WHEELSETS} wheelsets at the most, got {count}")
    for name in PER_WHEELSET:
        given = len(getattr(vehicle, name))
        if given != count:
            text.refuse(("vehicle", name), f"expected {a_number_or_list(count)}, got {given}")
    if vehicle.full_pressing_force_n and (given := len(vehicle.full_pressing_force_n)) != count:
        text.refuse(("vehicle", "full_pressing_force_n"), f"expected a list of {count} (one per wheelset), got {given}")
    places = zip(vehicle.axle_positions_m, vehicle.wheel_radius_m, strict=True)
    for (one_m, one_radius_m), (other_m, other_radius_m) in combinations(places, 2):
        if abs(one_m - other_m) < (radius_m := max(one_radius_m, other_radius_m)):
            sentence = f"expected wheelsets that stand farther apart than {radius_m:g} m, the radius of their wheels"
            text.refuse(("vehicle", "axle_positions_m"), sentence)
    _check_bogies(text, vehicle)
    _check_weight(text, vehicle)
    _check_turning_mass(text, vehicle)


def _check_bogies(text: ConfigText, vehicle: Vehicle) -> None:
    """Two or more of them, one behind the other, with a known height of their pivots; or none."""
    count, each = vehicle.wheelset_count, vehicle.wheelsets_per_bogie
    if each == 1:
        if vehicle.pivot_height_m:
            text.refuse(("vehicle", "pivot_height_m"), "expected wheelsets_per_bogie = 2 or more beside it")
        return
    if count % each or count == each:
        text.refuse(("vehicle", "wheelsets_per_bogie"), f"expected {count} wheelsets to make two or more such bogies")
    if not 0.0 < vehicle.pivot_height_m <= vehicle.cog_height_m:
        text.refuse(
            ("vehicle", "pivot_height_m"),
            f"bogies need the height of their pivots above the rail, at most cog_height_m, got "
            f"{vehicle.pivot_height_m:g}",
        )
    in_order = sorted(vehicle.axle_positions_m)
    if list(vehicle.axle_positions_m) not in (in_order, in_order[::-1]):
        text.refuse(("vehicle", "axle_positions_m"), "with bogies, expected places in order along the vehicle")


def _check_weight(text: ConfigText, vehicle: Vehicle) -> None:
    """Equally stiff wheelsets or bogies share the weight linearly along the vehicle; each must carry some of it."""
    each = vehicle.wheelsets_per_bogie
    centres_m = [
        fmean(vehicle.axle_positions_m[first : first + each]) for first in range(0, vehicle.wheelset_count, each)
    ]
    mean_m = fmean(centres_m)
    apart_m = [centre_m - mean_m for centre_m in centres_m]
    spread_m2 = sum(apart**2 for apart in apart_m)
    for place, apart in enumerate(apart_m):
        if spread_m2 > 0.0 and mean_m * apart / spread_m2 > (1.0 - 1e-6) / len(centres_m):
            text.refuse(
                ("vehicle", "axle_positions_m", place * each),
                "no weight rests on this wheelset: expected places from the centre of gravity, forward positive",
            )


def _check_turning_mass(text: ConfigText, vehicle: Vehicle) -> None:
    """J/r^2 of all wheelsets is some hundredths of the mass, with geared motors or flywheels some tenths."""
    turning_kg = vehicle.turning_kg
    if vehicle.mass_kg < _LEAST_MASS * sum(turning_kg):
        text.refuse(
            ("vehicle", "mass_kg"),
            f"expected a mass that fits the wheelsets, whose inertia alone stands for {sum(turning_kg):.0f} kg "
            f"(wheelset_inertia_kgm2 / wheel_radius_m^2), got {vehicle.mass_kg:g}",
        )
    share_kg = vehicle.mass_kg / vehicle.wheelset_count
    for place, (each_kg, inertia) in enumerate(zip(turning_kg, vehicle.wheelset_inertia_kgm2, strict=True)):
        if each_kg < _LEAST_TURNING_MASS * share_kg:
            text.refuse(
                ("vehicle", "wheelset_inertia_kgm2", place),
                f"expected more: {inertia:g} kg m2 at this wheel radius stand for {each_kg:.2g} kg of {share_kg:g}",
            )
