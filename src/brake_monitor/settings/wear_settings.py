"""The [wear] table of the configuration: pads and discs of one wheelset."""

from typing import Annotated, ClassVar

from msgspec import Meta, Struct

from brake_monitor.settings.bounds import Ambient, Thermal

Count = Annotated[int, Meta(ge=1, le=1000)]
Area = Annotated[float, Meta(ge=1e-3, le=1e6)]
Thickness = Annotated[float, Meta(gt=0.0, le=1000.0)]
Limit = Annotated[float, Meta(ge=0.0, le=1000.0)]
Wear = Annotated[float, Meta(gt=0.0, le=1000.0)]  # cm³/MJ
Cooling = Annotated[float, Meta(ge=0.0, le=1e6)]  # W/K for each m/s
Archard = Annotated[float, Meta(gt=0.0, le=1.0)]  # mm³/(N m), which is 1000 cm³/MJ at a friction of one


class WearSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """What pads and discs are made of; the same for all wheelsets."""

    rising: ClassVar[tuple[str, ...]] = (  # none may be greater than the next
        "least_specific_wear_cm3_per_mj",
        "specific_wear_cm3_per_mj",
        "greatest_specific_wear_cm3_per_mj",
    )

    pads_per_wheelset: Count = 4
    pad_area_cm2: Area = 400.0
    new_pad_thickness_mm: Thickness = 35.0
    new_pad_thickness_std_mm: Thickness = 0.5
    pad_limit_mm: Limit = 5.0
    gauge_std_mm: Thickness = 0.2  # one sigma of a measured thickness
    specific_wear_cm3_per_mj: Wear = 0.2
    specific_wear_std_cm3_per_mj: Wear = 0.1  # how far a fleet's pads lie from it before any measurement
    least_specific_wear_cm3_per_mj: Wear = 0.05  # no pad wears less ...
    greatest_specific_wear_cm3_per_mj: Wear = 1.0  # ... or more
    archard_mm3_per_nm: Archard = 7e-5  # k of V = k F s; the specific wear times a friction of 0.35
    discs_per_wheelset: Count = 2
    disc_mass_kg: Thermal = 100.0
    disc_heat_capacity_jpkgk: Thermal = 500.0
    disc_cooling_wpk: Thermal = 30.0  # H at standstill, per disc
    disc_cooling_per_speed_wpk: Cooling = 3.0  # ... and what each m/s adds
    ambient_c: Ambient = 15.0
