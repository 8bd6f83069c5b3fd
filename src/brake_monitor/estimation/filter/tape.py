"""The predictions and corrections of the filter, in order, for a smoother that goes back over them."""

from collections.abc import Sequence
from math import exp, inf
from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.estimation.doubts.consistency import BIASED, DOUBT_S
from brake_monitor.estimation.filter.brake_filter import BrakeFilter
from brake_monitor.estimation.filter.filter_lines import measured_of
from brake_monitor.estimation.kalman.ekf import Matrix, Measured, Vector, zeros
from brake_monitor.estimation.model.regime import SLOW_ADHESION_S
from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.estimation.moment import WagonMoment, WheelsetMoment

PULL_STD_MPS2 = 5.0  # of d as a stop is over: what pulls the wagon away has nothing to do with what braked it
HINDSIGHT_S = 2.0  # so long before it is in doubt d may have begun to move: a doubt is some ten readings of v late, ...
FOLLOWED_S = 1.0  # ... and so long after that it has followed

Elements = dict[tuple[int, int], float]  # of a matrix, by row and column


class Step(NamedTuple):
    """x moved to F x + w with w ~ N(0, noise); a prediction, or what was admitted or forgotten in between."""

    change: Floats  # F - I, shape (n, n)
    noise: Floats  # shape (n, n)
    time_s: float = -inf  # the filter's after it, ...
    unmodelled_mps2: float = 0.0  # ... and d


class Reading(NamedTuple):
    """A scalar measurement, and what the filter made of it."""

    measured: Measured
    residual: float  # against the state as predicted
    variance: float  # R, of the measurement alone
    correction: Floats  # by what the state was moved, shape (n,)


class Tape:
    """Records what the filter does; a smoother cuts off what it has gone over."""

    def __init__(self) -> None:
        self.events: list[Step | Reading] = []

    def step(self, step: Step) -> None:
        """Note a step; one that is not finite says nothing, the filter's reset follows it."""
        if np.isfinite(step.change).all() and np.isfinite(step.noise).all():
            self.events.append(step)

    def move_earlier(self, place: int, unmodelled_mps2: float, since_s: float, until_s: float) -> None:
        """Note that d, at `place`, moved between these times from what it was to `unmodelled_mps2`, unknown how."""
        steps: list[Step] = []
        for event in reversed(self.events):
            if isinstance(event, Reading) or event.time_s > until_s:
                continue
            if event.time_s < since_s:
                for step in steps:
                    step.noise[place, place] += (unmodelled_mps2 - event.unmodelled_mps2) ** 2 / len(steps)
                return
            steps.append(event)

    def reading(self, measured: Measured, residual: float, variance: float, correction: Vector) -> None:
        """Note a measurement that was fused; one that is not finite says nothing, the filter's reset follows it."""
        if np.isfinite([residual, *correction]).all():
            self.events.append(Reading(measured, residual, variance, np.array(correction)))

    def cut(self, count: int) -> None:
        """Drop the oldest `count` events."""
        del self.events[:count]


class TapedFilter(BrakeFilter):
    """A filter that notes on a tape whatever it does."""

    is_taped = True
    time_s = -inf
    doubted_s = -inf  # when the speed last contradicted the forces, ...
    doubted_from_s = inf  # ... and since when, until the tape tells of it

    def __init__(self, wagon: Wagon, tuning: Tuning, friction: float, friction_std: float) -> None:
        self.tape = Tape()
        super().__init__(wagon, tuning, friction, friction_std)

    def note_step(self, change: Matrix, noise: Matrix) -> None:
        """Note a step."""
        self.tape.step(Step(np.array(change), np.array(noise), self.time_s, self.x[self.layout.deceleration]))

    def predict(self, now: WagonMoment, wheels: Sequence[WheelsetMoment], step_s: float) -> None:
        """As `BrakeFilter` does; once the speed contradicts the forces, note that d has moved before."""
        self.time_s = now.time_s
        super().predict(now, wheels, step_s)
        doubted_s = now.consistency.raised_s[BIASED]
        if abs(doubted_s - self.doubted_s) >= DOUBT_S:
            self.doubted_from_s = doubted_s
        self.doubted_s = doubted_s
        if self.time_s - self.doubted_from_s >= FOLLOWED_S:
            place = self.layout.deceleration
            self.tape.move_earlier(place, self.x[place], self.doubted_from_s - HINDSIGHT_S, self.doubted_from_s)
            self.doubted_from_s = inf

    def forget(self, place: int, value: float, std: float) -> None:
        """As `BrakeFilter` does, and note it."""
        super().forget(place, value, std)
        self._note({(place, place): -1.0}, {(place, place): std**2})

    def forget_all(self, places: slice, value: float, std: float) -> None:
        """As `BrakeFilter` does, and note it."""
        diagonal = [(place, place) for place in range(self.layout.size)[places]]
        for place, _ in diagonal:
            super().forget(place, value, std)
        self._note(dict.fromkeys(diagonal, -1.0), dict.fromkeys(diagonal, std**2))

    def scale(self, place: int, factor: float, about: float) -> None:
        """As `BrakeFilter` does, and note it."""
        super().scale(place, factor, about)
        self._note({(place, place): factor - 1.0}, {})

    def widen(self, place: int, variance: float) -> None:
        """As `BrakeFilter` does, and note it."""
        super().widen(place, variance)
        self._note({}, {(place, place): variance})

    def admit_jump(self, place: int, variance: float, shown_by: int, per_jump: float, lost_mps: float) -> None:
        """As `BrakeFilter` does, and note it."""
        super().admit_jump(place, variance, shown_by, per_jump, lost_mps)
        moved = {place: 1.0, shown_by: per_jump, self.speed_place: -lost_mps}
        self._note({}, {(i, j): variance * by * also_by for i, by in moved.items() for j, also_by in moved.items()})

    def admit_along(self, variance: float) -> None:
        """As `BrakeFilter` does, and note it."""
        super().admit_along(variance)
        noise = [[variance * one * other for other in self.direction] for one in self.direction]
        self.note_step(zeros(self.layout.size), noise)

    def learn(self, place: int, value: float, variance: float) -> None:
        """As `BrakeFilter` does, and note it."""
        predicted = list(self.x)
        super().learn(place, value, variance)
        moved = [after - before for after, before in zip(self.x, predicted, strict=True)]
        self.tape.reading(Measured(place, place, 0.0), value - predicted[place], variance, moved)

    def _admit(self, noise: Matrix) -> None:
        super()._admit(noise)
        self.note_step(zeros(self.layout.size), noise)

    def admit_unseen(self, step_s: float) -> None:
        """As `BrakeFilter` does, and note it; what d was before a stop tells nothing of what it is after that."""
        places = range(self.layout.size)
        walking = [*places[self.layout.kinematic], *places[self.layout.adhesion]]
        moved = {(place, place): self.unseen_variance(place, step_s) for place in walking}
        super().admit_unseen(step_s)
        if self.tuning.deceleration_std:
            place = self.layout.deceleration
            moved[place, place] = max(PULL_STD_MPS2**2 - self.covariance[place][place], 0.0)
            super().widen(place, moved[place, place])
        lost = exp(-step_s / SLOW_ADHESION_S) - 1.0
        self._note({(place, place): lost for place in places[self.layout.adhesion]}, moved)

    def fuse(
        self, now: WagonMoment, wheels: Sequence[WheelsetMoment], index: int, residual: float, variance: float
    ) -> bool:
        """As `BrakeFilter` does, and note it."""
        predicted, covariance = self.x, self.covariance
        is_sound = super().fuse(now, wheels, index, residual, variance)
        moved = [after - before for after, before in zip(self.x, predicted, strict=True)]
        measured = measured_of(self.layout, index, now.speed_per_lag_mps2)
        foretold = [measured.of(row) for row in covariance]
        self.tape.reading(measured, residual, variance - measured.of(foretold), moved)
        return is_sound

    def _note(self, change: Elements, noise: Elements) -> None:
        """Note a step of which all elements but these are 0."""
        matrices = zeros(self.layout.size), zeros(self.layout.size)
        for matrix, elements in zip(matrices, (change, noise), strict=True):
            for (row, column), value in elements.items():
                matrix[row][column] = value
        self.note_step(*matrices)
