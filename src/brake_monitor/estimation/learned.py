"""What the estimator has learned of a vehicle and goes on with after a restart."""

from collections.abc import Sequence
from math import isfinite

from msgspec import Struct
from msgspec.structs import replace

from brake_monitor.errors import InputError
from brake_monitor.estimation.filter.physical import FRICTION_RANGE, LARGEST_DECELERATION_MPS2
from brake_monitor.estimation.rolling.line_roughness import LARGEST_DENSITY
from brake_monitor.estimation.rolling.radius_calibration import PRIOR_S, radius_range

LARGEST_MASS_KG = 1e6  # far beyond any wagon


class Learned(Struct, frozen=True):
    """Slow parameters at one instant; tuples have one entry per wheelset."""

    time_s: float
    wheel_radius_m: tuple[float, ...]
    friction: tuple[float, ...]
    friction_std: tuple[float, ...]
    deceleration_mps2: float  # d, what the model does not know
    deceleration_std_mps2: float
    mass_kg: float | None = None  # by its load; None where none is told
    wheel_rolled_s: tuple[float, ...] | None = None  # over which the radii are means; None in older memories
    configured_radius_m: tuple[float, ...] | None = None  # as they were learned; None in older memories
    calibration: int | None = None  # `Settings.calibration` as friction was learned; None in older memories
    deceleration_per_metre: float | None = None  # (m/s²)²/m, of the line; None in older memories

    def for_wheels(self, configured_radius_m: tuple[float, ...]) -> "Learned":
        """The same for these configured radii: a wheel that was configured otherwise begins with its new radius.

        Where a sensor tells a speed, not a rotation, its readings have another meaning now, too.
        """
        then_m, count = self.configured_radius_m, len(configured_radius_m)
        if then_m in (None, configured_radius_m) or not len(then_m) == len(self.wheel_radius_m) == count:
            return self
        rolled_s = self.wheel_rolled_s or (PRIOR_S,) * count
        if len(rolled_s) != count:
            return self  # as `check` will tell
        found = [
            (radius_m, own_s) if then == now else (now, PRIOR_S)
            for radius_m, own_s, then, now in zip(
                self.wheel_radius_m, rolled_s, then_m, configured_radius_m, strict=True
            )
        ]
        radii_m, kept_s = zip(*found, strict=True)
        return replace(self, wheel_radius_m=radii_m, wheel_rolled_s=kept_s, configured_radius_m=configured_radius_m)

    def with_friction(self, friction: float, std: float) -> "Learned":
        """The same with this friction for all pads, and without mass: it is weighed anew."""
        count = len(self.friction)
        return replace(self, friction=(friction,) * count, friction_std=(std,) * count, mass_kg=None)

    def check(self, configured_radius_m: Sequence[float]) -> None:
        """Raise InputError where no wagon with these configured radii can be like this."""
        count = len(configured_radius_m)
        if not len(self.wheel_radius_m) == len(self.friction) == len(self.friction_std) == count:
            raise InputError(f"what was learned is not of {count} wheelsets")
        for radius_m, configured_m in zip(self.wheel_radius_m, configured_radius_m, strict=True):
            low, high = radius_range(configured_m)
            if not low <= radius_m <= high:
                raise InputError(f"a learned wheel radius of {radius_m:.4f} m does not go with {configured_m:g} m")
        rolled_s = (1.0,) * count if self.wheel_rolled_s is None else self.wheel_rolled_s
        if len(rolled_s) != count or not all(own_s > 0.0 for own_s in rolled_s):
            raise InputError("the time over which wheel radii were learned makes no sense")
        low, high = FRICTION_RANGE
        if not all(low <= friction <= high for friction in self.friction):
            raise InputError("a learned friction is beyond what pads have")
        if not all(0.0 < std < high for std in self.friction_std):
            raise InputError("the uncertainty of a learned friction makes no sense")
        if not (
            isfinite(self.time_s)
            and abs(self.deceleration_mps2) <= LARGEST_DECELERATION_MPS2
            and 0.0 <= self.deceleration_std_mps2 <= LARGEST_DECELERATION_MPS2
        ):
            raise InputError("a learned deceleration makes no sense")
        if not 0.0 <= (self.deceleration_per_metre or 0.0) <= LARGEST_DENSITY:
            raise InputError("how much lines undulate, as learned, makes no sense")
        if self.mass_kg is not None and not 0.0 < self.mass_kg <= LARGEST_MASS_KG:
            raise InputError("a learned mass makes no sense")
