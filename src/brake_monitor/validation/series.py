"""One run of one estimator as arrays: what it said at each fused frame, and what was true then."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.trace import Trace

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Truth:
    """What the plant did, at the estimates' times; shapes (K,) for the wagon and (K, N) for the wheelsets."""

    speed_mps: Array
    adhesion: Array  # sum of the creep forces over the weight on the rail
    slip: Array
    omega_radps: Array
    friction: Array
    pressing_force_n: Array

    @classmethod
    def at(cls, times_s: Array, trace: Trace) -> "Truth":
        """Read the trace at `times_s`, which count from its first row."""
        wheelsets = range(trace.wheelset_count)
        steps_s = np.arange(len(trace.values)) * trace.step_s

        def read(column: Array) -> Array:
            return np.interp(times_s, steps_s, column)

        def read_each(name: str) -> Array:
            return np.stack([read(trace.wheelset(i, name)) for i in wheelsets], axis=1)

        creep_n = np.sum([trace.wheelset(i, "creep_force_n") for i in wheelsets], axis=0)
        load_n = np.sum([trace.wheelset(i, "load_n") for i in wheelsets], axis=0)
        names = ("slip", "omega_radps", "friction", "pressing_force_n")
        return cls(read(trace.wagon("speed_mps")), read(creep_n / load_n), *(read_each(name) for name in names))


@dataclass(frozen=True)
class Series:
    """Estimates of one run, shapes (K,) and (K, N); times count from the beginning of the run."""

    time_s: Array
    adhesion: Array
    adhesion_std: Array
    slip: Array
    friction: Array
    friction_std: Array
    pressing_force_n: Array  # as measured
    valid: Flags
    truth: Truth

    @classmethod
    def from_estimates(cls, estimates: list[Estimate], trace: Trace) -> "Series":
        """Put the estimates of a simulated recording beside its truth."""

        def each(name: str) -> Array:
            return np.array([[getattr(wheelset, name) for wheelset in e.wheelsets] for e in estimates])

        time_s = np.array([e.time_s for e in estimates]) - EPOCH_S
        return cls(
            time_s=time_s,
            adhesion=np.array([e.adhesion for e in estimates]),
            adhesion_std=np.array([e.adhesion_std for e in estimates]),
            slip=each("slip"),
            friction=each("friction"),
            friction_std=each("friction_std"),
            pressing_force_n=each("pressing_force_n"),
            valid=np.array([e.status is Status.VALID for e in estimates]),
            truth=Truth.at(time_s, trace),
        )
