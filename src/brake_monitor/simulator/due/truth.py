"""The truth of a run, as the rules for due alarms look at it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.simulator.due.alarm import DELAY_S, Due
from brake_monitor.simulator.simulate import EPOCH_S, TRUTH_STEP_S, Recording
from brake_monitor.simulator.trace import WHEELSET_COLUMNS

STEP_S = TRUTH_STEP_S
WALKING_MPS = 1.39  # 5 km/h
RUNNING_MPS = 3.0
SUPPLIED_BAR = 0.35  # the driver brakes
RELEASED_N = 1000.0  # a brake that presses with less is released
SLIDING_SLIP = 0.05
MOTOR_NM = 100.0  # a motor that brakes with less does nothing


@dataclass(frozen=True)
class Truth:
    """The truth every 10 ms; shapes (K,) and (N, K). Times count from the start."""

    recording: Recording
    time_s: Floats
    speed_mps: Floats
    supplied: Bools  # the driver brakes
    adhesion: Floats
    gradient: Floats
    radius_m: Floats  # shape (N, 1)
    wheels: dict[str, Floats]  # by WHEELSET_COLUMNS

    @classmethod
    def of(cls, recording: Recording) -> "Truth":
        """That of a finished run."""
        trace, every = recording.trace, round(STEP_S / recording.trace.step_s)
        speed_mps = trace.wagon("speed_mps")[::every]
        return cls(
            recording,
            np.asarray(np.arange(len(speed_mps)) * STEP_S, dtype=np.float64),
            speed_mps,
            trace.wagon("supply_pressure_bar")[::every] > SUPPLIED_BAR,
            trace.adhesion[::every],
            trace.wagon("gradient")[::every],
            np.array(recording.settings.vehicle.wheel_radius_m)[:, None],
            {name: np.ascontiguousarray(trace.wheelsets(name)[:, ::every]) for name in WHEELSET_COLUMNS},
        )

    def __getitem__(self, name: str) -> Floats:
        """One of WHEELSET_COLUMNS, shape (N, K)."""
        return self.wheels[name]

    @property
    def count(self) -> int:
        """N, the number of wheelsets."""
        return len(self.radius_m)

    @property
    def sliding(self) -> Bools:
        """Whether more is asked of each wheelset than the rail gives. Shape (N, K)."""
        sliding: Bools = (self["slip"] > SLIDING_SLIP) | (self["past_peak"] > 0.0) | (self["wsp"] > 0.0)
        return sliding & (np.abs(self.speed_mps) > WALKING_MPS)

    @property
    def braked_by_motors(self) -> Bools:
        """Whether its motor brakes each wheelset. Shape (N, K)."""
        braked: Bools = self["motor_torque_nm"] < -MOTOR_NM
        return braked

    def due(
        self, kind: str, wheelset: int | None, span: tuple[float, float], qualified_s: float | None, why: str
    ) -> Due:
        """`wheelset` from 0, times from the start; without `qualified_s`, or due after the drive's end, it may come."""
        by_s = None if qualified_s is None else qualified_s + DELAY_S[kind]
        if by_s is not None and by_s > self.time_s[-1]:
            by_s = None
        return Due(
            kind,
            None if wheelset is None else wheelset + 1,
            round(EPOCH_S + span[0], 3),
            None if by_s is None else round(EPOCH_S + by_s, 3),
            round(EPOCH_S + span[1], 3),
            why,
        )


def spans(flags: Bools, least_s: float = 0.0, gap_s: float = 0.0) -> Iterator[tuple[int, int]]:
    """First and last row of every run of true flags; shorter gaps are bridged, shorter runs left out."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], flags.astype(np.int8), [0]))))
    merged: list[list[int]] = []
    for start, end in edges.reshape(-1, 2).tolist():
        if merged and (start - merged[-1][1]) * STEP_S < gap_s:
            merged[-1][1] = end
        else:
            merged.append([start, end])
    for start, end in merged:
        if (end - start) * STEP_S >= least_s:
            yield start, end - 1
