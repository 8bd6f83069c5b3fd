"""Alarms and pads as JSON lines: one object for each, as it stands at the end of a recording."""

from collections.abc import Iterator

import msgspec

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.wear import pad_life
from brake_monitor.settings.wear_settings import WearSettings

AGREED = ("kind", "wheelset", "severity", "raised_time_s", "cleared_time_s", "message")


def alarm_line(alarm: Alarm) -> str:
    """The agreed keys first, then what else an alarm carries; times in seconds on the recording's own time base."""
    values = msgspec.to_builtins(alarm)
    first = {key: values.pop(key) for key in AGREED}
    return msgspec.json.encode(first | values).decode()


def wear_lines(brakes: Brakes, settings: WearSettings) -> Iterator[str]:
    """Use of pads and what is left, in the order of the wheelsets, which count from 1."""
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
