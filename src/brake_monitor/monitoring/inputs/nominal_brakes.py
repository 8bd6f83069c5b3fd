"""What the brakes would take from the wagon's speed if their pads had nominal friction."""

from collections.abc import Iterable

from brake_monitor.settings.config import EstimatorSettings, Vehicle


class NominalBrakes:
    """Those of one wagon, from 0."""

    def __init__(self, vehicle: Vehicle, estimator: EstimatorSettings) -> None:
        radii_m = zip(vehicle.brake_radius_m, vehicle.wheel_radius_m, strict=True)
        self._levers = [brake_m / wheel_m for brake_m, wheel_m in radii_m]
        self._friction = estimator.friction_nominal

    def retardation_mps2(self, i: int, force_n: float, mass_kg: float) -> float:
        """What such a pressing force of brake i takes from the speed."""
        return self._friction * force_n * self._levers[i] / mass_kg

    def all_mps2(self, forces_n: Iterable[float], mass_kg: float) -> float:
        """What such forces of all brakes do."""
        return sum([self.retardation_mps2(i, force_n, mass_kg) for i, force_n in enumerate(forces_n)])
