"""Wear as JSON lines: one object per wheelset, as its pads stand at the end of a recording."""

from collections.abc import Iterator

import msgspec

from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.wear import pad_life
from brake_monitor.settings.wear_settings import WearSettings

MEGA = 1e6


def lines(brakes: Brakes, settings: WearSettings) -> Iterator[str]:
    """Use and what is left, in the order of the wheelsets, which count from 1."""
    for wheelset, unit in enumerate(brakes.units, 1):
        life, use = pad_life(unit.pads, settings), unit.pads.since_fitted
        yield msgspec.json.encode(
            {
                "wheelset": wheelset,
                "pad_energy_j": use.energy_j,
                "stops": use.stops,
                "sliding_distance_m": use.sliding_distance_m,
                "distance_m": use.distance_m,
                "thickness_mm": life.by_energy.value_mm,
                "thickness_low_mm": life.by_energy.low_mm,
                "thickness_high_mm": life.by_energy.high_mm,
                "archard_thickness_mm": life.by_archard.value_mm,
                "remaining_mm": life.remaining_mm,
                "remaining_stops": life.remaining_stops,
                "remaining_km": life.remaining_km,
                "disc_temperature_c": unit.disc_temperature_c,
            }
        ).decode()


def told(brakes: Brakes, settings: WearSettings) -> Iterator[str]:
    """The same for a person, one line per wheelset."""
    for wheelset, unit in enumerate(brakes.units, 1):
        thickness, use = pad_life(unit.pads, settings).by_energy, unit.pads.since_fitted
        yield (
            f"wheelset {wheelset}: {use.energy_j / MEGA:.2f} MJ of braking, {use.stops:.0f} applications ended, "
            f"slid {use.sliding_distance_m:.0f} m; pads {thickness.value_mm:.3f} mm "
            f"({thickness.low_mm:.1f} to {thickness.high_mm:.1f} mm), discs {unit.disc_temperature_c:.0f} °C"
        )
