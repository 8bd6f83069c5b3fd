"""What an earlier run has learned, taken over as this one begins, and what the next one is to take over."""

from math import inf, sqrt

from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.estimation.learned import Learned
from brake_monitor.estimation.model.friction_pause import pause_variance
from brake_monitor.estimation.rolling.radius_calibration import MEMORY_S, TURNED_S

FAST_MPS = 30.0  # of a train that went on while the program did not run


class EarlierRun:
    """Knows what an earlier run has learned, and sets it in the core."""

    def __init__(self, core: Core) -> None:
        """Nothing is known of one."""
        self._core = core
        self._learned: Learned | None = None
        self._configured_m = tuple([wheel.radius.configured_m for wheel in core.wheels])

    def take(self, learned: Learned) -> None:
        """Take over what no pause changes: radii, mass, how lines undulate; InputError where it is impossible."""
        core, now = self._core, self._core.now
        learned = learned.for_wheels(self._configured_m)
        learned.check(self._configured_m)
        self._learned = learned
        for wheel, radius_m in zip(core.wheels, learned.wheel_radius_m, strict=True):
            wheel.radius.radius_m = radius_m
        if learned.deceleration_per_metre is not None:
            now.line.density = learned.deceleration_per_metre
        if learned.mass_kg is not None and core.load_n and not now.weighed:
            now.mass_kg, now.weighed = learned.mass_kg, 1

    def recall(self, clock_s: float) -> None:
        """Take over friction and d, widened by what may have changed since; `clock_s`: of the first sample."""
        learned, brakes, tuning = self._learned, self._core.filter, self._core.filter.tuning
        if learned is None:
            return
        pause_s = clock_s - learned.time_s
        if pause_s < 0.0:  # a clock that was set back says nothing of how long it was
            pause_s = inf
        brakes.recall_friction(learned.friction, max(learned.friction_std) ** 2, pause_variance(pause_s))
        density = tuning.deceleration + tuning.deceleration_per_metre * FAST_MPS
        drift = density * pause_s if density else 0.0
        std_mps2 = min(sqrt(learned.deceleration_std_mps2**2 + drift), tuning.deceleration_std)
        brakes.forget(brakes.layout.deceleration, learned.deceleration_mps2 if std_mps2 else 0.0, std_mps2)
        if learned.wheel_rolled_s is not None and pause_s < TURNED_S:
            for wheel, rolled_s in zip(self._core.wheels, learned.wheel_rolled_s, strict=True):
                wheel.radius.rolled_s = min(rolled_s, MEMORY_S)

    def handed_on(self, now: Estimate) -> Learned:
        """What the next run is to take over of this one, by what is known now."""
        core = self._core
        return Learned(
            time_s=now.clock_s,
            wheel_radius_m=tuple([wheel.radius.radius_m for wheel in core.wheels]),
            friction=tuple([wheelset.friction for wheelset in now.wheelsets]),
            friction_std=tuple([wheelset.friction_std for wheelset in now.wheelsets]),
            deceleration_mps2=now.deceleration_mps2,
            deceleration_std_mps2=now.deceleration_std_mps2,
            mass_kg=now.mass_kg if core.now.weighed else None,
            wheel_rolled_s=tuple([wheel.radius.rolled_s for wheel in core.wheels]),
            configured_radius_m=self._configured_m,
            deceleration_per_metre=core.now.line.density,
        )
