"""Estimators to compare with: the presets, the paper's equations as printed, and ours with one part taken out."""

from collections.abc import Iterable, Mapping, Sequence

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.kalman.ekf import Matrix, Vector
from brake_monitor.estimation.model.tuning import Tuning
from brake_monitor.estimation.model.wagon import Inputs, Wagon
from brake_monitor.samples import Channel
from brake_monitor.settings.config import FrictionModel, Preset
from brake_monitor.simulator.simulate import Recording
from brake_monitor.validation.informed import WITHOUT_D, InformedEstimator


class PrintedWagon(Wagon):
    """The model with row 3 of the printed (12): adhesion retards the wagon by g/2 instead of g."""

    def linearise(self, x: Sequence[float], u: Inputs) -> tuple[Vector, Matrix]:
        """f(x, u) and its Jacobian; half of the creep forces are missing in the speed equation."""
        f, a = super().linearise(x, u)
        s = self.layout
        creep_n = sum([mu * own.wheel_load_n for mu, own in zip(x[s.adhesion], u.wheels, strict=True)])
        f[s.speed] += 0.5 * creep_n / u.mass_kg
        a[s.speed][s.adhesion] = [0.5 * rate for rate in a[s.speed][s.adhesion]]
        return f, a


class NeverContradictingCore(Core):
    """The steps of an estimator that believes whatever friction it finds."""

    def see_speed(self, residual: float, total_variance: float) -> bool:
        """Never: the friction that the printed model finds is more than any pad has, and that is to be seen."""
        return False


class PrintedEstimator(Estimator):
    """The estimator on the printed model."""

    wagon_type = PrintedWagon
    core_type = NeverContradictingCore


class NeverHoldingCore(Core):
    """The steps of an estimator that goes on correcting the friction while the pad is off the disc."""

    def enter_regime(self) -> None:
        """The usual regime, but friction counts as observable on every wheelset that turns."""
        super().enter_regime()
        for wheel in self.wheels:
            wheel.friction_observable = 1.0 if wheel.turns and not self.now.near_standstill else 0.0
        self.now.any_friction_observable = any(wheel.friction_observable for wheel in self.wheels)


class NeverHoldingEstimator(Estimator):
    """The estimator that goes on correcting the friction while the pad is off the disc."""

    core_type = NeverHoldingCore


class Variant(Struct, frozen=True):
    """One estimator of the comparison."""

    label: str
    preset: Preset = "wagon"
    tuning: Tuning | None = None  # instead of the preset's
    friction_model: FrictionModel = "random-walk"
    estimator: type[Estimator] = Estimator
    knows_truth: bool = False  # see `informed`


VARIANTS: Mapping[str, Variant] = {
    "wagon": Variant("preset wagon"),
    "train": Variant("preset train", preset="train"),
    "without_d": Variant("wagon without d", tuning=WITHOUT_D),
    "without_hold": Variant("wagon without holding the friction", estimator=NeverHoldingEstimator),
    "first_order": Variant("wagon with the friction of (9)", friction_model="first-order"),
    "printed": Variant("g/2 as printed in (5) and (12), without d", tuning=WITHOUT_D, estimator=PrintedEstimator),
    "rig": Variant("preset rig: (19), (20) to the letter", preset="rig"),
    "informed": Variant("limit: told everything but adhesion", knows_truth=True),
}


def variant_estimator(recording: Recording, name: str, channels: Iterable[Channel]) -> Estimator:
    """The estimator of a variant (a key of VARIANTS) for the recording's vehicle."""
    variant, vehicle = VARIANTS[name], recording.settings.vehicle
    settings = replace(recording.settings.estimator, preset=variant.preset, friction_model=variant.friction_model)
    if variant.knows_truth:
        return InformedEstimator(vehicle, settings, channels, recording.trace)
    return variant.estimator(vehicle, settings, channels, variant.tuning)
