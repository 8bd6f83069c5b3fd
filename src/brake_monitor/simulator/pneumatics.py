"""From the driver's demand to the pressing force: supply, wheel-slide valve with its delay, cylinder, spring."""

import math
from collections import deque
from dataclasses import dataclass, field
from enum import IntEnum

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


@dataclass(frozen=True, slots=True)
class BrakeGear:
    """Pressing force of a wheelset = force_per_bar * pressure + offset, the offset being the return spring's."""

    force_per_bar_n: float
    offset_n: float

    def pressing_force_n(self, pressure_bar: float) -> float:
        """Sum over all pad faces; never negative."""
        return max(self.force_per_bar_n * pressure_bar + self.offset_n, 0.0)

    @property
    def full_force_n(self) -> float:
        """Pressing force at full cylinder pressure."""
        return self.pressing_force_n(FULL_PRESSURE_BAR)


@dataclass(slots=True)
class Supply:
    """Pressure that the distributor valve offers to all cylinders."""

    pressure_bar: float = 0.0

    def step(self, step_s: float, demand: float) -> None:
        """Follow the driver's demand (0 released to 1 full)."""
        target = FULL_PRESSURE_BAR * demand
        self.pressure_bar += (target - self.pressure_bar) * -math.expm1(-step_s / SUPPLY_TIME_CONSTANT_S)


@dataclass(slots=True)
class Cylinder:
    """One wheelset's brake cylinders behind their wheel-slide valve."""

    pressure_bar: float = 0.0
    _valve: Valve = Valve.FILL
    _commands: deque[tuple[float, Valve]] = field(default_factory=deque)

    def command(self, time_s: float, valve: Valve) -> None:
        """Ask the valve for a new position; it moves after its delay."""
        last = self._commands[-1][1] if self._commands else self._valve
        if valve is not last:
            self._commands.append((time_s + VALVE_DELAY_S, valve))

    def step(self, time_s: float, step_s: float, supply_bar: float) -> None:
        """Advance the pressure from `time_s` by `step_s`."""
        while self._commands and self._commands[0][0] <= time_s + 1e-9:
            self._valve = self._commands.popleft()[1]
        if self._valve is Valve.FILL:
            self.pressure_bar += (supply_bar - self.pressure_bar) * -math.expm1(-step_s / FILL_TIME_CONSTANT_S)
        elif self._valve is Valve.DUMP:
            self.pressure_bar *= math.exp(-step_s / DUMP_TIME_CONSTANT_S)
        elif self.pressure_bar > supply_bar:  # a held cylinder still empties backwards when the driver releases
            self.pressure_bar += (supply_bar - self.pressure_bar) * -math.expm1(-step_s / FILL_TIME_CONSTANT_S)
