"""Whether a speed scatters: a loose pole wheel, too wide a gap, a wire beside the motor's, an aerial that is covered.

Where all wheel speeds scatter their configuration, the times of their frames or the vehicle's speed are to blame, and
no sensor alone.
"""

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.passing_time import Steps

TOLD_S = 10.0  # of rolling: a slide, or what a curve or a bridge does, is over sooner
MOST_S = 20.0  # it is told for no longer than this after it has ended, however long it lasted
WATCHED_FROM_MPS = 3.0


class ScatterWatch:
    """Sees the wagon at each observation."""

    def __init__(self, wheelset_count: int) -> None:
        self._vehicle = _Scattering()
        self._wheels = [_Scattering() for _ in range(wheelset_count)]
        self._lasts = False  # what any has shown lately
        self._steps = Steps()
        self.wheels = frozenset[int]()  # whose speeds scatter
        self.speed_scatters = False  # the vehicle's

    def see(self, now: Estimate) -> None:
        """Go on by one observation."""
        step_s = self._steps.until(now.time_s)
        if not (self._lasts or now.speed_scatters or Doubt.SCATTERED in now.reasons):  # the usual case
            return
        if not step_s or now.speed_mps < WATCHED_FROM_MPS:
            return
        if not now.saturated:  # slides make wheel speeds scatter, and not the vehicle's
            scatters = [own.speed_scatters for own in now.wheelsets]
            alone = not (all(scatters) or now.speed_scatters)
            for wheel, own in zip(self._wheels, scatters, strict=True):
                wheel.go_on(step_s if own and alone else -step_s)
        self._vehicle.go_on(step_s if now.speed_scatters else -step_s)
        self._lasts = any(one.for_s > 0.0 for one in (self._vehicle, *self._wheels))
        self.wheels = frozenset([i for i, wheel in enumerate(self._wheels) if wheel.is_told])
        self.speed_scatters = self._vehicle.is_told


class _Scattering:
    """That of one speed."""

    def __init__(self) -> None:
        self.for_s = 0.0  # how long it has scattered, less how long it has not since
        self.is_told = False

    def go_on(self, by_s: float) -> None:
        """By so many seconds of scatter, below 0 of none."""
        self.for_s = min(max(self.for_s + by_s, 0.0), MOST_S)
        self.is_told = self.for_s >= TOLD_S or (self.is_told and self.for_s > 0.0)
