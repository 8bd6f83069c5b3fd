"""One simulated run: scenario and vehicle in, frames and truth out. The same seed gives the same bytes."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from brake_monitor.errors import InputError
from brake_monitor.frame import Frame
from brake_monitor.settings.config import Settings, SignalMapping
from brake_monitor.simulator.can_encoder import encode, signal_unit
from brake_monitor.simulator.physics.pad import NOMINAL_FRICTION
from brake_monitor.simulator.physics.pneumatics import FULL_PRESSURE_BAR, BrakeGear
from brake_monitor.simulator.plant import GRAVITY_MPS2, Modifiers, Plant
from brake_monitor.simulator.scenarios import SCENARIOS, Scenario
from brake_monitor.simulator.sensors import Sensors
from brake_monitor.simulator.trace import Trace

EPOCH_S = 1_700_000_000.0  # time stamp of a run's beginning
TRUTH_STEP_S = 0.01
NO_MODIFIERS = Modifiers()

DEFAULT_UTILISATION = 0.11  # adhesion that a full brake asks for, where the mapping does not tell the brake gear
SPRING_BAR = 0.25
LEAST_BY_AIR = 0.1  # of such a brake: what presses less at full air pressure is hydraulic, with a hundred bar and more

TRUTH_WAGON_COLUMNS = (
    "time_s",
    "speed_mps",
    "adhesion",
    "saturated",
    "gradient",
    "coupler_force_n",
    "position_m",
    "sanding",
)
TRUTH_WHEELSET_COLUMNS = {  # by their names in the trace
    "omega_radps": "omega_{}_radps",
    "slip": "slip_{}",
    "adhesion": "adhesion_{}",
    "friction": "friction_{}",
    "pressing_force_n": "pressing_force_{}_n",
    "wsp": "wsp_{}",
    "disc_temperature_c": "disc_temperature_{}_c",
    "motor_torque_nm": "motor_torque_{}_nm",
}


@dataclass(frozen=True)
class Recording:
    """A finished run."""

    settings: Settings
    seed: int
    modifiers: Modifiers
    gears: tuple[BrakeGear, ...]
    trace: Trace = field(repr=False)

    @property
    def duration_s(self) -> float:
        """From the first to the last step."""
        return self.trace.duration_s

    @cached_property
    def frames(self) -> list[Frame]:
        """What the bus carried, in order of time."""
        mass_kg = self.settings.vehicle.mass_kg * self.modifiers.mass_factor
        sensors = Sensors(self.trace, self.gears, mass_kg, self.modifiers.run_out)
        frames = encode(
            self.settings,
            sensors,
            duration_s=self.duration_s,
            start_s=EPOCH_S,
            seed=self.seed,
            loss=self.modifiers.frame_loss,
            faults=self.modifiers.sensor_faults,
        )
        for fault in self.modifiers.bus_faults:
            frames = fault.spoil(frames, EPOCH_S)
        return frames

    def truth_header(self) -> list[str]:
        """Column names of the truth; wheelsets count from 1."""
        numbers = range(1, self.trace.wheelset_count + 1)
        return [*TRUTH_WAGON_COLUMNS, *(name.format(i) for i in numbers for name in TRUTH_WHEELSET_COLUMNS.values())]

    def truth(self) -> Iterator[list[float]]:
        """One row per 10 ms on the frames' time base; flags are 0 or 1."""
        trace, every = self.trace, round(TRUTH_STEP_S / self.trace.step_s)
        saturated = np.max([*trace.wheelsets("past_peak"), *trace.wheelsets("wsp")], axis=0)
        columns = [trace.wagon("speed_mps"), trace.adhesion, saturated]
        columns += [trace.wagon(name) for name in ("gradient", "coupler_force_n", "position_m", "sanding")]
        columns += [trace.wheelset(i, name) for i in range(trace.wheelset_count) for name in TRUTH_WHEELSET_COLUMNS]
        rows = zip(*(column[::every].tolist() for column in columns), strict=True)
        for k, (speed, adhesion, flag, *rest) in enumerate(rows):
            time_s = round(EPOCH_S + k * TRUTH_STEP_S, 6)
            yield [time_s, speed, adhesion, int(flag), *rest]


def run(
    scenario: str | Scenario,
    settings: Settings,
    seed: int = 0,
    modifiers: Modifiers = NO_MODIFIERS,
    *,
    row_s: float | None = None,
) -> Recording:
    """Simulate `scenario` (one of SCENARIOS by name, or your own) with the vehicle of `settings`.

    `row_s`: how often the truth is noted; at each step where it is not given.

    Raises InputError for an unknown scenario or a DBC that cannot be read.
    """
    if isinstance(scenario, str):
        if scenario not in SCENARIOS:
            raise InputError(f"unknown scenario {scenario!r}: expected one of {', '.join(SCENARIOS)}")
        scenario = SCENARIOS[scenario]
    gears = brake_gears(settings)
    trace = Plant(scenario, settings.vehicle, gears, modifiers, seed=seed, row_s=row_s).run()
    return Recording(settings, seed, modifiers, gears, trace)


def brake_gears(settings: Settings) -> tuple[BrakeGear, ...]:
    """The brake gear of each wheelset: from the mapping where that goes from air to newton, else a plausible one."""
    return tuple(_brake_gear(settings, i, mapping) for i, mapping in enumerate(settings.signals.pressing_force))


def _brake_gear(settings: Settings, wheelset: int, mapping: SignalMapping) -> BrakeGear:
    newton = 1000.0 if mapping.unit == "kN" else 1.0
    vehicle = settings.vehicle
    load_n = vehicle.mass_kg * GRAVITY_MPS2 / vehicle.wheelset_count
    lever = vehicle.wheel_radius_m[wheelset] / (NOMINAL_FRICTION * vehicle.brake_radius_m[wheelset])
    full_n = DEFAULT_UTILISATION * load_n * lever
    if signal_unit(settings, mapping) == "bar":
        gear = BrakeGear(mapping.scale * newton, mapping.offset * newton)
        if gear.full_force_n > LEAST_BY_AIR * full_n:
            return gear
    if mapping.max is not None:
        full_n = min(full_n, mapping.max * newton)
    per_bar_n = full_n / (FULL_PRESSURE_BAR - SPRING_BAR)
    return BrakeGear(per_bar_n, -SPRING_BAR * per_bar_n)
