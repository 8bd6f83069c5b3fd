"""The core as machine code, for thousands of samples at once: desk tools play recordings with it where numba is there.

The methods of `Core`, of `Belief` and of what they consist of are compiled as they stand, and the filter's equations
are the straight lines that run in Python as well. Only how these are called stands twice: `FilterArrays` hands them
arrays where `BrakeFilter` hands them lists. Importing this module loads numba, which a gateway's daemon does not.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from typing import Any, NamedTuple, Self

import numpy as np
from numba import types

from brake_monitor.compiled.held_tuple import HeldTuple
from brake_monitor.compiled.machine_code import FlatFunction, compiled
from brake_monitor.compiled.numba_classes import Mirror, as_tuple, record_type, teach
from brake_monitor.estimation import estimate
from brake_monitor.estimation.core import readout
from brake_monitor.estimation.core.core import ELSE, Core
from brake_monitor.estimation.core.correction import FUSED, TAKEN
from brake_monitor.estimation.core.readout import read_out, width
from brake_monitor.estimation.doubts import still_force
from brake_monitor.estimation.filter.belief import Belief
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.estimation.filter.filter_lines import flat_sources
from brake_monitor.estimation.kalman import ekf, foretold
from brake_monitor.estimation.kalman.ekf import Innovation, Measured
from brake_monitor.estimation.model import acting, brake_step, friction_pause, wheelset
from brake_monitor.estimation.model.acting import Acting, ActingOnWagon, acting_on_wagon, acting_on_wheelset
from brake_monitor.estimation.model.brake_step import StepLength, step_length
from brake_monitor.estimation.moment import WagonMoment, WheelsetMoment


@dataclass
class FilterArrays(Belief):
    """A BrakeFilter in arrays: what its straight lines read and write, with x and P as parts of it.

    It is compiled as a tuple: `FilterTuple`.
    """

    speed_place: int  # of v in x
    adhesion_place: int  # of the first mu_w,i
    adhesion_std: float  # beforehand
    x: Any  # (n,)
    covariance: Any  # (n, n)
    direction: Any  # (n,)
    saved: Any  # (k, n + n * n)
    free: Any  # (n,) 1 for states that an innovation may correct
    least: Any  # (n,)
    most: Any  # (n,)
    friction_place: int  # of the first mu_b,i
    lag_place: int  # of L
    given: Any  # arguments of both lines: x, P, the step, what acts on wagon and wheelsets, and fixed densities
    carried: Any  # results of `step`: x and P
    corrected: Any  # (n, n) P after a reading
    loads: Any  # results of `follow`
    step: FlatFunction  # the prediction
    follow: FlatFunction  # the wheel loads after it

    @classmethod
    def of(cls, brakes: BrakeFilter) -> Self:
        """Arrays for the numbers of this filter."""
        size, count = brakes.layout.size, brakes.layout.wheelset_count
        both = size + size * size
        told = len(StepLength._fields) + len(ActingOnWagon._fields) + count * len(Acting._fields)
        given = np.concatenate((np.zeros(both + told), brakes.equations.densities))
        step, follow = map(FlatFunction, flat_sources(brakes.equations))
        return cls(
            speed_place=brakes.speed_place,
            adhesion_place=brakes.adhesion_place,
            adhesion_std=brakes.adhesion_std,
            x=given[:size],
            covariance=given[size:both].reshape(size, size),
            direction=np.zeros(size),
            saved=np.array(brakes.saved),
            free=np.zeros(size),
            least=np.array(brakes.least),
            most=np.array(brakes.most),
            friction_place=brakes.layout.friction.start,
            lag_place=brakes.layout.lag,
            given=given,
            carried=np.zeros(both),
            corrected=np.zeros((size, size)),
            loads=np.zeros(count + 1),
            step=step,
            follow=follow,
        )

    def predict(self, now: WagonMoment, wheels: Sequence[WheelsetMoment], step_s: float) -> None:
        """As BrakeFilter does."""
        place = self.give(len(self.carried), step_length(step_s))
        place = self.give(place, acting_on_wagon(now))
        for i in range(len(wheels)):
            place = self.give(place, acting_on_wheelset(wheels[i]))
        if now.near_standstill:
            self.admit_unseen(step_s)
        else:
            self.step(self.given, self.carried)
            self.give(0, self.carried)
        self.follow(self.given, self.loads)
        now.pitching_mps2 = self.loads[0]
        for i in range(len(wheels)):
            wheels[i].next_wheel_load_n = self.loads[1 + i]

    def give(self, place: int, numbers: Sequence[float]) -> int:
        """Write down arguments from this place on, in the order in which BrakeFilter has them; the place after them."""
        for k in range(len(numbers)):
            self.given[place + k] = numbers[k]
        return place + len(numbers)

    def fuse(
        self, now: WagonMoment, wheels: Sequence[WheelsetMoment], index: int, residual: float, variance: float
    ) -> bool:
        """As BrakeFilter does."""
        for k in range(len(self.x)):
            self.free[k] = 1.0 if k <= self.speed_place or not now.near_standstill else 0.0
        for i in range(len(wheels)):
            self.free[self.friction_place + i] *= wheels[i].friction_observable
        x, covariance, updated = self.carried, self.covariance, self.corrected
        measured = Measured(index, self.lag_place, now.speed_per_lag_mps2 if index == self.speed_place else 0.0)
        ekf.correct((self.x, covariance), measured, Innovation(residual, variance), self.free, (x, updated))
        for i in range(len(self.x)):
            self.x[i] = min(max(x[i], self.least[i]), self.most[i])
            for j in range(len(self.x)):
                covariance[i][j] = updated[i][j]
        return self.is_sound()


FilterTuple = as_tuple(FilterArrays, "FilterTuple", __name__)
CoreTuple = as_tuple(Core, "CoreTuple", __name__)
OBJECTS = ("now", "wheels", "readings", "channels", "tuning", "foretold")  # of a core: records ...
LASTING = ("channels", "tuning")  # ... and those that a run does not change


class SampleColumns(NamedTuple):
    """Samples of mapped signals, one array with an entry per sample each; and rows for what is known in between."""

    channel: Any  # int64
    time_s: Any  # float64
    value: Any  # float64
    is_good: Any  # bool
    row: Any  # int64, where in `rows` to write what is known after the sample, if it moved time on; -1: nowhere
    rows: Any  # (M, `width`)


class Played(NamedTuple):
    """How far a run over samples came."""

    place: int  # of the first sample that is still to be dealt with
    outcome: int  # what became of it; TAKEN where the run came to its end
    fused: int  # place of the last one that was fused, -1 for none


def play(core: Core, samples: SampleColumns, place: int, end: int, readout: Any) -> Played:
    """Take samples up to one that is not ordinary; `readout` is for what is known at the end."""
    fused = -1
    for k in range(place, end):
        channel = samples.channel[k]
        told = core.channels[channel]
        if samples.is_good[k] and (told.tells != ELSE or told.lost):
            outcome = core.take(channel, samples.time_s[k], samples.value[k])
            if outcome == FUSED:
                fused = k
            if outcome > FUSED:
                return Played(k, outcome, fused)
        if samples.row[k] >= 0 and core.now.time_s == samples.time_s[k]:
            read_out(core, samples.rows[samples.row[k]])
    read_out(core, readout)
    return Played(end, TAKEN, fused)


teach(
    (CoreTuple, Innovation, Measured, FilterTuple),
    (estimate, readout, still_force, ekf, foretold, acting, brake_step, friction_pause, wheelset),
)


class CompiledCore:
    """A core's numbers in arrays, beside the core itself: copied from it before they are used, and back."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._brakes: BrakeFilter = core.filter
        self._filter = FilterTuple.of(core.filter)
        self._load_n = np.array(core.load_n)
        numbers = {field.name: getattr(core, field.name) for field in fields(core)}
        numbers |= {"load_n": self._load_n, "filter": self._filter}
        self._mirrors: dict[str, Mirror] = {}
        for name in OBJECTS:
            found = numbers[name]
            objects = found if isinstance(found, Sequence) else [found]
            records = np.zeros(len(objects), record_type(objects[0]))
            numbers[name] = records if isinstance(found, Sequence) else records[0]
            self._mirrors[name] = Mirror(objects, records)
        self._numbers = HeldTuple(CoreTuple(**numbers))
        self._readout = np.zeros(width(core.wheelset_count))
        self._play = _machine_code(self._numbers.kind)

    def load(self) -> None:
        """Take over the numbers of the core."""
        for mirror in self._mirrors.values():
            mirror.load()
        self._load_n[:] = self._core.load_n
        self._filter.x[:], self._filter.covariance[:] = self._brakes.x, self._brakes.covariance
        self._filter.saved[:] = self._brakes.saved

    def store(self) -> None:
        """Give the core its numbers back."""
        self._core.load_n[:] = self._load_n.tolist()
        for name, mirror in self._mirrors.items():
            if name not in LASTING:
                mirror.store()
        self._brakes.x, self._brakes.covariance = self._filter.x.tolist(), self._filter.covariance.tolist()
        self._brakes.saved = self._filter.saved.tolist()

    @property
    def readout(self) -> list[float]:
        """As `read_out` has them, at the end of the last run that came to its end."""
        readout: list[float] = self._readout.tolist()
        return readout

    def play(self, samples: SampleColumns, place: int, end: int) -> Played:
        """See `play`."""
        return Played(*self._play(self._numbers, samples, place, end, self._readout))


@cache
def _machine_code(core: Any) -> Callable[..., tuple[int, ...]]:
    """`play` for a core of this type, called without looking at types: that takes longer than most of its runs."""
    column = types.Array(types.float64, 1, "C")
    places, table = types.Array(types.int64, 1, "C"), types.Array(types.float64, 2, "C")
    columns = (places, column, column, types.Array(types.bool_, 1, "C"), places, table)
    signature = (core, types.NamedTuple(columns, SampleColumns), types.int64, types.int64, column)
    dispatcher = compiled(play)
    dispatcher.compile(signature)
    entry_point: Callable[..., tuple[int, ...]] = dispatcher.overloads[signature].entry_point
    return entry_point
