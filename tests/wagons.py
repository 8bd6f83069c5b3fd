"""A wagon of any number of wheelsets, each of which differs from the others, for tests of the equations."""

from collections.abc import Sequence

import numpy as np

from brake_monitor.estimation.model.wagon import FrictionRelaxation, Inputs, Wagon
from brake_monitor.settings.config import Vehicle

AXLES = {1: (0.0,), 2: (4.5, -4.5), 4: (9.4, 7.6, -7.6, -9.4), 6: (8.0, 6.2, 4.4, -4.4, -6.2, -8.0)}


def derivative(wagon: Wagon, x: Sequence[float], u: Inputs) -> np.ndarray:
    """f(x, u) of (12)."""
    return np.array(wagon.linearise(x, u)[0])


def jacobian(wagon: Wagon, x: Sequence[float], u: Inputs) -> np.ndarray:
    """A = ∂f/∂x."""
    return np.array(wagon.linearise(x, u)[1])


def told(u: Inputs, **vectors: Sequence[float]) -> Inputs:
    """The same inputs with other numbers for the wheelsets, N of each name."""
    wheels = [own._replace(**{name: vector[i] for name, vector in vectors.items()}) for i, own in enumerate(u.wheels)]
    return u._replace(wheels=wheels)


def of_each(u: Inputs, name: str) -> np.ndarray:
    """What the inputs say of each wheelset."""
    return np.array([getattr(own, name) for own in u.wheels])


def make_wagon(n: int, relaxation: FrictionRelaxation | None = None, *, has_motors: bool = False) -> Wagon:
    return Wagon.from_vehicle(
        Vehicle(
            id="test",
            mass_kg=18_000.0 * n,
            axle_positions_m=AXLES[n],
            cog_height_m=1.6,
            wheelset_inertia_kgm2=tuple(118.0 + i for i in range(n)),
            wheel_radius_m=tuple(0.445 + 0.002 * i for i in range(n)),
            brake_radius_m=(0.247,) * n,
            track_resistance_n=1800.0,
            drag_n_per_mps2=2.6,
        ),
        relaxation,
        has_motors=has_motors,
    )
