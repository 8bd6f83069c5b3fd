"""Whether the state of the brake units, read from the memory or to be written there, is possible."""

from collections.abc import Iterator
from math import inf
from typing import Any

import msgspec

from brake_monitor.frame import LATEST_TIME_S
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.plural import plural
from brake_monitor.settings.bounds import COLDEST_C

DISC_RANGE_C = (COLDEST_C, 2000.0)


def why_impossible(brakes: Brakes) -> str | None:
    """Why no brake units can be like that; None when they can."""
    times_s = [brakes.time_s, *(unit.pads.gauged_time_s for unit in brakes.units)]
    if not all(time_s is None or is_time(time_s) for time_s in times_s):
        return "the wear is of a time that cannot be"
    if brakes.running is not None and len(brakes.running.wheelsets) != len(brakes.units):
        return f"the brake application that goes on is one of {plural(len(brakes.running.wheelsets), 'wheelset')}"
    for i, unit in enumerate(brakes.units, 1):
        if not all(0.0 <= number < inf for number in _numbers(msgspec.to_builtins(unit.pads))):
            return f"the wear of wheelset {i} has a negative or infinite number"
        if not DISC_RANGE_C[0] <= unit.disc_temperature_c <= DISC_RANGE_C[1]:
            return f"the disc of wheelset {i} has {unit.disc_temperature_c:g} °C"
    return None


def is_time(time_s: float) -> bool:
    """Whether any clock can have shown it."""
    return 0.0 <= time_s < LATEST_TIME_S


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, dict):
        for part in value.values():
            yield from _numbers(part)
    elif isinstance(value, int | float):
        yield value
