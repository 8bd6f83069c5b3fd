"""Alarms and pads as JSON lines: one object for each, as it stands at the end of a recording."""

from collections.abc import Iterator

import msgspec

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.publishing.payloads import WearMessage
from brake_monitor.settings.wear_settings import WearSettings

AGREED = ("kind", "wheelset", "severity", "raised_time_s", "cleared_time_s", "message")
OF_PADS = (
    *("wheelset", "pad_energy_j", "stops", "sliding_distance_m", "distance_m"),
    *("thickness_mm", "thickness_low_mm", "thickness_high_mm", "archard_thickness_mm"),
    *("remaining_mm", "remaining_stops", "remaining_km", "disc_temperature_c"),
)


def alarm_line(alarm: Alarm) -> str:
    """The agreed keys first, then what else an alarm carries; times in seconds on the recording's own time base."""
    values = msgspec.to_builtins(alarm)
    first = {key: values.pop(key) for key in AGREED}
    return msgspec.json.encode(first | values).decode()


def wear_lines(brakes: Brakes, settings: WearSettings) -> Iterator[str]:
    """What would be published of the pads of each wheelset, without what only counts there."""
    for wheelset in range(1, len(brakes.units) + 1):
        message = WearMessage.of(brakes, wheelset, settings, sequence=1, publish_time_s=0.0)
        yield msgspec.json.encode({key: getattr(message, key) for key in OF_PADS}).decode()
