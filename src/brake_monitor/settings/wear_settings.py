"""The [wear] table of the configuration: pads and discs of one wheelset."""

from typing import Annotated

from msgspec import Meta, Struct

from brake_monitor.settings.bounds import Ambient, NonNegative, Positive, Thermal

Count = Annotated[int, Meta(ge=1)]


class WearSettings(Struct, frozen=True, forbid_unknown_fields=True):
    """What pads and discs are made of; the same for all wheelsets."""

    pads_per_wheelset: Count = 4
    pad_area_cm2: Positive = 400.0
    new_pad_thickness_mm: Positive = 35.0
    new_pad_thickness_std_mm: Positive = 0.5
    pad_limit_mm: NonNegative = 5.0
    gauge_std_mm: Positive = 0.2  # one sigma of a measured thickness
    specific_wear_cm3_per_mj: Positive = 0.2
    specific_wear_std_cm3_per_mj: Positive = 0.1  # how far a fleet's pads lie from it before any measurement
    least_specific_wear_cm3_per_mj: Positive = 0.05  # no pad wears less ...
    greatest_specific_wear_cm3_per_mj: Positive = 1.0  # ... or more
    archard_mm3_per_nm: Positive = 7e-5  # k of V = k F s; the specific wear times a friction of 0.35
    discs_per_wheelset: Count = 2
    disc_mass_kg: Thermal = 100.0
    disc_heat_capacity_jpkgk: Thermal = 500.0
    disc_cooling_wpk: Thermal = 30.0  # H at standstill, per disc
    disc_cooling_per_speed_wpk: NonNegative = 3.0  # ... and what each m/s adds
    ambient_c: Ambient = 15.0
