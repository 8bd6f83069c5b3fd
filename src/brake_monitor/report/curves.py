"""The estimates of a recording as columns of numbers, as many rows as a page can draw."""

from array import array
from collections.abc import Callable
from math import nan
from typing import Any

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.dashboard.recent import WAGON_COLUMNS, WHEELSET_COLUMNS
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.samples import Quantity

COMMON_COLUMNS = ("time_s", "distance_m", "latitude_deg", "longitude_deg", *WAGON_COLUMNS)
MOST_ROWS = 80_000  # two hours at 10 Hz; of more, each stretch keeps its least and greatest values


class Curves:
    """Estimates as columns. What an estimate says of itself is invalid, or held because its input is, is a gap."""

    def __init__(self, wheelset_count: int) -> None:
        self.wheelset_count = wheelset_count
        self._width = len(COMMON_COLUMNS) + wheelset_count * len(WHEELSET_COLUMNS)
        self._values = array("d")

    def take(self, estimate: Estimate, is_told: Callable[[Quantity, int], bool]) -> None:
        """Append a row; `is_told`: whether the input of this quantity and wheelset (from 0) tells what is."""
        e, valid = estimate, estimate.status is not Status.INVALID
        available = e.adhesion if e.saturated else nan
        wagon = (e.speed_mps, e.adhesion, e.adhesion_std, available) if valid else (nan,) * len(WAGON_COLUMNS)
        place = (nan if x is None else x for x in (e.latitude_deg, e.longitude_deg))
        self._values.extend((e.time_s, e.distance_m, *place, *wagon))
        speed_told = is_told(Quantity.SPEED, 0)
        for i, own in enumerate(e.wheelsets):
            known = own.friction_status is not Status.INVALID
            turning_told = is_told(Quantity.AXLE_SPEED, i)
            self._values.extend(
                (
                    own.slip if speed_told and turning_told else nan,
                    own.omega_radps if turning_told else nan,
                    own.pressing_force_n if is_told(Quantity.PRESSING_FORCE, i) else nan,
                    own.friction if known else nan,
                    own.friction_std if known else nan,
                    float(own.friction_status is Status.HELD),
                    own.adhesion if known else nan,
                    float(own.wsp_active),
                )
            )

    def table(self) -> Floats:
        """All rows, shape (rows, columns)."""
        return np.frombuffer(self._values, dtype=np.float64).reshape(-1, self._width)

    def columns(self, table: Floats) -> dict[str, Any]:
        """The columns of a table by name; those of wheelset i under "wheelsets", i."""
        common, own = len(COMMON_COLUMNS), len(WHEELSET_COLUMNS)
        return {
            **{name: table[:, k] for k, name in enumerate(COMMON_COLUMNS)},
            "wheelsets": {
                i + 1: {name: table[:, common + i * own + k] for k, name in enumerate(WHEELSET_COLUMNS)}
                for i in range(self.wheelset_count)
            },
        }


def to_draw(table: Floats, most_rows: int = MOST_ROWS) -> Floats:
    """At most so many rows in the order of their times: of every stretch one of the least, one of the greatest values.

    Nothing is smoothed: every peak stays as high as it was, at most a stretch away from where it was.
    """
    if (np.diff(table[:, 0]) < 0.0).any():  # a clock was set back
        table = table[np.argsort(table[:, 0], kind="stable")]
    if len(table) <= most_rows:
        return table
    stretches = most_rows // 2
    starts = np.arange(stretches) * len(table) // stretches
    with np.errstate(invalid="ignore"):
        least, greatest = np.fmin.reduceat(table, starts), np.fmax.reduceat(table, starts)
    least[:, 0] = table[starts, 0]  # time goes on
    greatest[:, 0] = table[starts + len(table) // most_rows, 0]
    return np.stack((least, greatest), axis=1).reshape(-1, table.shape[1])
