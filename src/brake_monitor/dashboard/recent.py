"""The last minutes of one wagon as columns of numbers, in a ring that never grows. Pure: no clock, no network.

An estimate that says of itself that it is invalid is a gap in them.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brake_monitor.estimation.estimate import Status
from brake_monitor.publishing.payloads import AdhesionMessage, FrictionMessage
from brake_monitor.publishing.published import ESTIMATES_KEPT

CAPACITY = ESTIMATES_KEPT  # rows: as much as a daemon can be asked for
WAGON_COLUMNS = ("speed_mps", "adhesion", "adhesion_std", "adhesion_available")  # the last: while saturated
WHEELSET_COLUMNS = (
    "slip",
    "omega_radps",
    "pressing_force_n",
    "friction",
    "friction_std",
    "held",
    "adhesion",
    "wsp_active",
)
DECIMALS = 5
LOOK_BACK = 20  # rows among which that of a part of an estimate is looked for
PATIENCE = 3  # rows; what is missing of an older one was lost on the way
JUMP_S = 2.0
WAGON = 0  # beside wheelsets, which count from 1

Columns = dict[str, list[float]]
Rows = NDArray[np.float32]  # one row per estimate


class Recent:
    """Rows in the order of capture. A row's number counts from the first that was ever taken."""

    def __init__(self) -> None:
        self.count = 0  # rows taken so far
        self.epoch = 0  # changes whenever rows that were there have changed
        self._time_s = np.full(CAPACITY, np.nan)
        self._wagon = _empty(len(WAGON_COLUMNS))
        self._wheelsets: dict[int, Rows] = {}
        self._awaited: dict[int, set[int]] = {}  # of the newest rows, by number: the parts that have not come yet

    @property
    def wheelsets(self) -> list[int]:
        """The numbers of the wheelsets that were heard of."""
        return sorted(self._wheelsets)

    def take(self, message: AdhesionMessage) -> None:
        """Note the wagon's part of an estimate; the parts of an estimate come in any order."""
        number = self._row_of(message.time_s)
        if number is not None:
            _put(self._wagon, number, _wagon_row(message))
            self._awaited.get(number, set()).discard(WAGON)

    def take_wheelset(self, message: FrictionMessage) -> None:
        """Note a wheelset's part of an estimate."""
        if message.wheelset not in self._wheelsets:
            self._wheelsets[message.wheelset] = _empty(len(WHEELSET_COLUMNS))
            self.epoch += 1
        number = self._row_of(message.time_s)
        if number is not None:
            _put(self._wheelsets[message.wheelset], number, _wheelset_row(message))
            self._awaited.get(number, set()).discard(message.wheelset)

    def _row_of(self, time_s: float) -> int | None:
        """Number of the row of an estimate, which may be new; None for one that comes too late.

        Time that jumps back begins all anew: a recording is played again, or a clock was set.
        """
        newest_s = self._time_s[(self.count - 1) % CAPACITY] if self.count else -np.inf
        if newest_s - time_s > JUMP_S:
            self.clear()
        elif time_s <= newest_s:
            latest = range(self.count - 1, max(self.count - LOOK_BACK, 0) - 1, -1)
            return next((number for number in latest if self._time_s[number % CAPACITY] == time_s), None)
        row = self.count % CAPACITY
        self._time_s[row] = time_s
        for part in (self._wagon, *self._wheelsets.values()):
            part[row] = np.nan
        self._awaited[self.count] = {WAGON, *self._wheelsets}
        self._awaited.pop(self.count - PATIENCE, None)
        self.count += 1
        return self.count - 1

    def precede(self, wagon: Sequence[AdhesionMessage], wheelsets: Sequence[FrictionMessage]) -> None:
        """Put older rows before those that are there, as far as there is room."""
        kept = self._rows(self.count - min(self.count, CAPACITY), self.count)
        first_s = self._time_s[kept[0]] if len(kept) else np.inf
        older = {m.time_s: m for m in wagon if m.time_s < first_s}
        room = CAPACITY - len(kept)
        times_s = sorted(older)[-room:] if room else []
        if not times_s:
            return
        place = {time_s: k for k, time_s in enumerate(times_s)}
        before, now = len(times_s), len(times_s) + len(kept)
        for message in wheelsets:
            self._wheelsets.setdefault(message.wheelset, _empty(len(WHEELSET_COLUMNS)))
        parts = [self._wagon, *self._wheelsets.values()]
        for part in parts:
            part[before:now] = part[kept]
            part[:before] = np.nan
        self._time_s[before:now] = self._time_s[kept]
        self._time_s[:before] = times_s
        for time_s in times_s:
            _put(self._wagon, place[time_s], _wagon_row(older[time_s]))
        for message in wheelsets:
            if message.time_s in place:
                _put(self._wheelsets[message.wheelset], place[message.time_s], _wheelset_row(message))
        self._awaited = {before + number - (self.count - len(kept)): parts for number, parts in self._awaited.items()}
        self.count = now
        self.epoch += 1

    def clear(self) -> None:
        """Forget all rows."""
        self.count = 0
        self.epoch += 1
        self._awaited.clear()

    def ready(self) -> int:
        """How many rows may be shown: those before the first whose parts have not all come yet."""
        return min((number for number, parts in self._awaited.items() if parts), default=self.count)

    def columns(self, first: int, end: int) -> dict[str, Any]:
        """The rows numbered from `first`, or the oldest kept, to before `end`, by column; NaN: not known."""
        rows = self._rows(max(first, self.count - CAPACITY, 0), end)
        return {
            "time_s": np.round(self._time_s[rows], 3).tolist(),
            **_columns(self._wagon[rows], WAGON_COLUMNS),
            "wheelsets": {i: _columns(self._wheelsets[i][rows], WHEELSET_COLUMNS) for i in self.wheelsets},
        }

    def _rows(self, first: int, end: int) -> NDArray[np.intp]:
        return np.arange(first, max(end, first), dtype=np.intp) % CAPACITY


def _empty(columns: int) -> Rows:
    return np.full((CAPACITY, columns), np.nan, dtype=np.float32)


def _put(part: Rows, number: int, values: list[float | None]) -> None:
    with np.errstate(over="ignore"):  # what is beyond all measure becomes infinite, and is then not shown
        part[number % CAPACITY] = values


def _wagon_row(m: AdhesionMessage) -> list[float | None]:
    if m.status is Status.INVALID:
        return [None] * len(WAGON_COLUMNS)
    return [m.speed_mps, m.adhesion, m.adhesion_std, m.adhesion if m.saturated else None]


def _wheelset_row(m: FrictionMessage) -> list[float | None]:
    return [
        m.slip,
        m.omega_radps,
        m.pressing_force_n,
        None if m.status is Status.INVALID else m.friction,
        None if m.status is Status.INVALID else m.friction_std,
        float(m.status is Status.HELD),
        m.adhesion,
        None if m.wsp_active is None else float(m.wsp_active),
    ]


def _columns(part: Rows, names: Sequence[str]) -> Columns:
    rounded = np.round(part.astype(np.float64), DECIMALS)
    rounded[~np.isfinite(rounded)] = np.nan
    return {name: rounded[:, k].tolist() for k, name in enumerate(names)}
