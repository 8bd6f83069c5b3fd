"""From the driver's demand to the pressing force: supply, wheel-slide valve with its delay, cylinder, spring."""

import math
from collections import deque
from dataclasses import dataclass, field
from enum import IntEnum

from brake_monitor.simulator.physics.compiled import compiled

FULL_PRESSURE_BAR = 3.8
SUPPLY_TIME_CONSTANT_S = 0.25  # distributor valve and brake pipe
FILL_TIME_CONSTANT_S = 0.35
DUMP_TIME_CONSTANT_S = 0.10
VALVE_DELAY_S = 0.06


class Valve(IntEnum):
    """What the wheel-slide valve of one wheelset does with the cylinder."""

    FILL = 0
    HOLD = 1
    DUMP = 2


FILL, HOLD, DUMP = (float(valve) for valve in Valve)  # as compiled code knows them


@dataclass(frozen=True, slots=True)
class BrakeGear:
    """Pressing force of a wheelset = force_per_bar * pressure + offset, the offset being the return spring's."""

    force_per_bar_n: float
    offset_n: float

    @property
    def full_force_n(self) -> float:
        """At full cylinder pressure, the sum over all pad faces."""
        return self.force_per_bar_n * FULL_PRESSURE_BAR + self.offset_n


@compiled
def supply_after(pressure_bar: float, step_s: float, demand: float) -> float:
    """Pressure that the distributor valve offers to all cylinders, following the demand (0 released to 1 full)."""
    target = FULL_PRESSURE_BAR * demand
    return pressure_bar + (target - pressure_bar) * -math.expm1(-step_s / SUPPLY_TIME_CONSTANT_S)


@compiled
def cylinder_after(pressure_bar: float, step_s: float, valve: float, supply_bar: float, least_bar: float) -> float:
    """Pressure of a wheelset's cylinders behind their wheel-slide valve (FILL, HOLD or DUMP).

    Below `least_bar` they do not empty, 0 where nothing is wrong; a held cylinder still empties backwards when
    the driver releases.
    """
    after = pressure_bar
    if valve == DUMP:
        after = pressure_bar * math.exp(-step_s / DUMP_TIME_CONSTANT_S)
    elif valve == FILL or pressure_bar > supply_bar:
        after = pressure_bar + (supply_bar - pressure_bar) * -math.expm1(-step_s / FILL_TIME_CONSTANT_S)
    return max(after, min(least_bar, pressure_bar))


@dataclass(slots=True)
class DelayedValve:
    """The wheel-slide valve of one wheelset; it moves some time after its command."""

    position: Valve = Valve.FILL
    _commands: deque[tuple[float, Valve]] = field(default_factory=deque)

    def command(self, time_s: float, valve: Valve) -> None:
        """Ask for a new position."""
        last = self._commands[-1][1] if self._commands else self.position
        if valve is not last:
            self._commands.append((time_s + VALVE_DELAY_S, valve))

    def come_to(self, time_s: float) -> Valve:
        """Position at `time_s`."""
        while self._commands and self._commands[0][0] <= time_s + 1e-9:
            self.position = self._commands.popleft()[1]
        return self.position
