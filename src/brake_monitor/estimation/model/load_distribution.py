"""How weight and braking moment are spread over the wheelsets: the coefficients of (4)."""

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.settings.config import Vehicle


def load_distribution(vehicle: Vehicle) -> tuple[Floats, Floats]:
    """Spread weight and braking moment over the wheelsets; shapes (N,), (N,).

    F_z,i = m (g s_i - h v̇ t_i) such that Σ F_z,i = m g and Σ F_z,i l_i = - m h v̇ (4). For positions symmetric about
    the centre of gravity s_i = 1/N and t_i = l_i / Σ l_j²; a rig (N = 1) has t = 0.

    With bogies, all taken to brake alike, the body's inertia force acts on them at the pivots. So only the part of h
    above the pivots pitches the body, which shifts load between bogies; the part below pitches each bogie, which shifts
    load from its trailing to its leading wheelset.
    """
    bogies_m = np.array(vehicle.axle_positions_m).reshape(-1, vehicle.wheelsets_per_bogie)
    count, wheelsets = bogies_m.shape
    centres_m = bogies_m.mean(axis=1)
    share, transfer = spread_over(centres_m)
    if wheelsets == 1:
        return share, transfer
    of_pivots = vehicle.pivot_height_m / vehicle.cog_height_m
    inside_m = bogies_m - centres_m[:, np.newaxis]
    inside = inside_m / (count * (inside_m**2).sum(axis=1, keepdims=True))
    by_body = (1.0 - of_pivots) * np.repeat(transfer, wheelsets) / wheelsets
    return np.repeat(share, wheelsets) / wheelsets, by_body + of_pivots * inside.ravel()


def spread_over(places_m: Floats) -> tuple[Floats, Floats]:
    """Spread a weight of 1 and a moment of 1 over equally stiff supports, linearly along the vehicle; (N,), (N,)."""
    n = len(places_m)
    mean = places_m.mean()
    deviation = places_m - mean
    spread = deviation @ deviation
    if spread == 0.0:
        return np.full(n, 1.0 / n), np.zeros(n)
    return 1.0 / n - mean * deviation / spread, deviation / spread
