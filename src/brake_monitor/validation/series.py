"""One run of one estimator as arrays: what it said at each fused frame, and what was true then."""

from dataclasses import dataclass

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.estimation.core.readout import VALID
from brake_monitor.processing.whole_recording import Known
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.trace import Trace


@dataclass(frozen=True)
class Truth:
    """What the plant did, at the estimates' times; shapes (K,) for the wagon and (K, N) for the wheelsets."""

    speed_mps: Floats
    adhesion: Floats  # sum of the creep forces over the weight on the rail
    slip: Floats
    omega_radps: Floats
    friction: Floats
    pressing_force_n: Floats

    @classmethod
    def at(cls, times_s: Floats, trace: Trace) -> "Truth":
        """Read the trace at `times_s`, which count from its first row."""
        steps_s = np.arange(len(trace.values)) * trace.step_s

        def read(column: Floats) -> Floats:
            return np.interp(times_s, steps_s, column)

        def read_each(name: str) -> Floats:
            return np.stack([read(column) for column in trace.wheelsets(name)], axis=1)

        names = ("slip", "omega_radps", "friction", "pressing_force_n")
        return cls(read(trace.wagon("speed_mps")), read(trace.adhesion), *(read_each(name) for name in names))


@dataclass(frozen=True)
class Series:
    """Estimates of one run, shapes (K,) and (K, N); times count from the beginning of the run."""

    time_s: Floats
    adhesion: Floats
    adhesion_std: Floats
    slip: Floats
    friction: Floats
    friction_std: Floats
    pressing_force_n: Floats  # as measured
    valid: Bools
    truth: Truth

    @classmethod
    def of(cls, known: Known, trace: Trace) -> "Series":
        """Put what was known over a simulated recording beside its truth."""
        time_s = known.wagon("time_s") - EPOCH_S
        return cls(
            time_s=time_s,
            adhesion=known.wagon("adhesion"),
            adhesion_std=known.wagon("adhesion_std"),
            slip=known.each("slip"),
            friction=known.each("friction"),
            friction_std=known.each("friction_std"),
            pressing_force_n=known.each("pressing_force_n"),
            valid=known.wagon("trust") == VALID,
            truth=Truth.at(time_s, trace),
        )
