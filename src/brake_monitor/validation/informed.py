"""The limit: the same filter on the same speeds, told by the plant everything but the adhesion.

It knows the friction of every brake unit, the true pressing forces and all that retards the wagon besides the rail, so
what error is left comes from the speed sensors and from adhesion that changes as it likes. No estimator that
has to find out the rest can be expected to do better.
"""

from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.samples import Channel, Quantity, Sample
from brake_monitor.settings.config import EstimatorSettings, Vehicle
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.trace import Trace

WITHOUT_D = replace(  # the states of (13)
    WAGON,
    deceleration=0.0,
    deceleration_braking=0.0,
    deceleration_sliding=0.0,
    deceleration_per_metre=0.0,
    deceleration_std=0.0,
)
INFORMED = replace(WITHOUT_D, friction=0.0, friction_own=0.0, friction_own_std=0.0, force_effect_std=0.0)


class InformedEstimator(Estimator):
    """The estimator that looks up in the trace what it cannot measure."""

    def __init__(
        self, vehicle: Vehicle, settings: EstimatorSettings, channels: Iterable[Channel], trace: Trace
    ) -> None:
        super().__init__(vehicle, settings, channels, INFORMED)
        known_n = np.array([vehicle.resistance_n(speed_mps) for speed_mps in trace.wagon("speed_mps").tolist()])
        self._step_s = trace.step_s
        self._friction = trace.wheelsets("friction")
        self._true_force_n = trace.wheelsets("pressing_force_n")
        self._unmodelled_mps2 = (trace.wagon("resistance_n") - known_n) / vehicle.mass_kg

    def take(self, sample: Sample) -> bool:
        """Take one sample, with the truth at its time."""
        row = min(max(round((sample.time_s - EPOCH_S) / self._step_s), 0), len(self._unmodelled_mps2) - 1)
        for i, friction in enumerate(self._friction):
            self.filter.forget(self.filter.layout.friction.start + i, float(friction[row]), 0.0)
        if self.speed_mps > 0.0:
            self.filter.forget(self.filter.layout.deceleration, float(self._unmodelled_mps2[row]), 0.0)
        if sample.quantity is Quantity.PRESSING_FORCE:
            sample = sample._replace(value=float(self._true_force_n[sample.wheelset][row]))
        return super().take(sample)
