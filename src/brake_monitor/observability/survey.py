"""The vehicle, its sensors, and the operating points at which they are looked at."""

from dataclasses import dataclass
from itertools import product
from math import ceil

import numpy as np

from brake_monitor.decoding.dbc import load_buses
from brake_monitor.decoding.signal_field import cycle_time_s, signal_field
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.estimation.model.wheelset import braking_ratio
from brake_monitor.observability.analysis import (
    Observability,
    OperatingPoint,
    Prior,
    Sensors,
    Variant,
    analyse,
    variants,
    worst,
)
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings

CYCLE_S = 0.05  # of a message whose DBC does not say
FULL_ADHESION = 0.10  # what a full application asks of the rail
FORCE_STEP_N = 10_000.0
SPEEDS_KMH = (5.0, 80.0, 160.0)
ADHESIONS = (0.02, 0.10, 0.30)


@dataclass(frozen=True)
class Survey:
    """The vehicle, its sensors and the grid of operating points."""

    vehicle_id: str
    wagon: Wagon
    variants: tuple[Variant, ...]
    sensors: Sensors
    prior: Prior
    window_s: float
    contact_force_n: float
    full_force_n: float

    @classmethod
    def of(cls, settings: Settings, window_s: float) -> "Survey":
        """Take what the configuration and its DBC files say; InputError when the window is shorter than a cycle."""
        sensors = _sensors(settings)
        if window_s < sensors.period_s.max():
            raise InputError(
                f"--window {window_s:g}: expected at least {sensors.period_s.max():g}, the time between two samples "
                "of the slowest speed signal"
            )
        wagon = Wagon.from_vehicle(settings.vehicle)
        return cls(
            vehicle_id=settings.vehicle.id,
            wagon=wagon,
            variants=variants(settings.vehicle.wheelset_count),
            sensors=sensors,
            prior=Prior(friction_std=settings.estimator.friction_nominal_std),
            window_s=window_s,
            contact_force_n=settings.estimator.contact_force_n,
            full_force_n=_full_force_n(wagon, settings.estimator.friction_nominal),
        )

    def at(self, variant: Variant, force_n: float, speed_kmh: float, adhesion: float) -> Observability:
        """What one variant tells at one operating point."""
        point = OperatingPoint(force_n, speed_kmh / 3.6, adhesion)
        return analyse(self.wagon, variant, point, self.sensors.map_std(self.window_s), self.prior)

    def over_grid(self, variant: Variant, force_n: float) -> Observability:
        """The worst over all speeds and adhesions."""
        return worst(self.at(variant, force_n, *point) for point in product(SPEEDS_KMH, ADHESIONS))

    @property
    def table_forces_n(self) -> list[float]:
        """No force, where friction stops being held, a light and a full application."""
        return sorted({0.0, self.contact_force_n, self.full_force_n / 4.0, self.full_force_n})


def _sensors(settings: Settings) -> Sensors:
    """Noise and cycle time of the wheel speeds and the vehicle speed."""
    databases = load_buses(settings)
    decoder = SignalDecoder(settings, databases)
    by_measurand = {channel.measurand: channel for channel in decoder.channels}
    channels = [by_measurand[Quantity.AXLE_SPEED, i] for i in range(settings.vehicle.wheelset_count)]
    channels.append(by_measurand[Quantity.SPEED, 0])
    messages = [databases[c.bus].message(c.message) for c in channels]
    fields = [signal_field(message, c.signal) for message, c in zip(messages, channels, strict=True)]
    periods_s = [cycle_time_s(*pair) or CYCLE_S for pair in zip(messages, fields, strict=True)]
    return Sensors(np.array([c.noise_std for c in channels]), np.array(periods_s))


def _full_force_n(wagon: Wagon, friction: float) -> float:
    """The pressing force that asks FULL_ADHESION of the most loaded wheelset, rounded up."""
    loads_n = wagon.wheel_load_n(0.0, wagon.vehicle.mass_kg)
    asked = [friction * braking_ratio(own, 1.0, load_n) for own, load_n in zip(wagon.wheelsets, loads_n, strict=True)]
    force_n = max(FULL_ADHESION / per_n for per_n in asked)
    return ceil(force_n / FORCE_STEP_N) * FORCE_STEP_N
