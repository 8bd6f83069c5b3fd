"""The truth of a run: every quantity over time."""

from dataclasses import dataclass

import numpy as np

from brake_monitor.arrays import Floats

WAGON_COLUMNS = (
    "speed_mps",
    "position_m",
    "acceleration_mps2",
    "resistance_n",  # track, curve, drag, gradient and coupler: all that brakes besides the wheels
    "coupler_force_n",  # the train holds back, negative when it pulls
    "supply_pressure_bar",
    "sanding",
    "gradient",
)
WHEELSET_COLUMNS = (
    "omega_radps",
    "slip",
    "adhesion",  # F_x / F_z
    "friction",
    "pressing_force_n",
    "pressure_bar",
    "wsp",
    "disc_temperature_c",
    "past_peak",
    "creep_force_n",
    "brake_torque_nm",
    "load_n",
    "motor_torque_nm",  # accelerating positive, whichever way the wagon goes
)


@dataclass(frozen=True, slots=True)
class Trace:
    """Truth every `step_s`; `values` has shape (rows, columns)."""

    step_s: float
    wheelset_count: int
    values: Floats

    @property
    def duration_s(self) -> float:
        """Time of the last row; the first is at 0."""
        return (len(self.values) - 1) * self.step_s

    @property
    def adhesion(self) -> Floats:
        """The wagon's over all rows: the creep forces of all wheelsets over their loads."""
        creep_n, load_n = (np.sum(self.wheelsets(name), axis=0) for name in ("creep_force_n", "load_n"))
        adhesion: Floats = creep_n / load_n
        return adhesion

    def wagon(self, name: str) -> Floats:
        """One of WAGON_COLUMNS over all rows."""
        return self.values[:, WAGON_COLUMNS.index(name)]

    def wheelset(self, index: int, name: str) -> Floats:
        """One of WHEELSET_COLUMNS of wheelset `index` (from 0) over all rows."""
        return self.values[:, len(WAGON_COLUMNS) + index * len(WHEELSET_COLUMNS) + WHEELSET_COLUMNS.index(name)]

    def wheelsets(self, name: str) -> Floats:
        """One of WHEELSET_COLUMNS of all wheelsets over all rows, shape (N, rows)."""
        return self.values[:, len(WAGON_COLUMNS) + WHEELSET_COLUMNS.index(name) :: len(WHEELSET_COLUMNS)].T
