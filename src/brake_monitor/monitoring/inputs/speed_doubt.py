"""Whether the vehicle's speed stands alone against those of its wheelsets, or has another scale than before."""

from collections.abc import Sequence
from math import inf

from brake_monitor.monitoring.inputs.speed_scale import SpeedScale
from brake_monitor.monitoring.inputs.turning import HARDEST_RETARDATION_MPS2, WATCHED_FROM_MPS
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.wagon_past import WAIT_S, WagonPast
from brake_monitor.monitoring.inputs.watched_wheelset import CUTS_OUT_BELOW_MPS, NOT_TURNED, Origin, WatchedWheelset

SOONER_S = 0.2  # the vehicle's speed is doubted this long before all its wheelsets are said to stand
ALL_STOPPED_MPS2 = 0.1  # no wheelset turns and yet the wagon hardly slows down: its speed is wrong
SPEED_JUMP_MPS = 1.5  # from one reading to a later one, beyond what any wagon loses or gains meanwhile
DIFFERS = 0.2
DIFFERS_MPS = 1.5  # wheel-speed sensors cut out as late
DOUBT_S = 0.5
AGREES = 0.05  # one that was not believed is believed again when it agrees as well with a wheelset ...
AGREES_S = 3.0  # ... for so long, at a speed where that says something


class SpeedDoubt:
    """Sees the wheelsets whose speeds are told, at each observation."""

    def __init__(self, speed: VehicleSpeed, past: WagonPast, wheelset_count: int) -> None:
        """`past` is noted before."""
        self._speed = speed
        self._past = past
        self._count = wheelset_count
        self._scale = SpeedScale()
        self._stands_alone = self._jumped = False
        self._before: tuple[float, float] | None = None  # the reading as of the last observation: time and speed
        self._doubt_since_s = self._agrees_since_s = inf

    @property
    def is_contradicted(self) -> bool:
        """Whether it is not to be believed."""
        return self._stands_alone or self._scale.is_off

    @property
    def is_doubted(self) -> bool:
        """Whether it is not, or may not be."""
        return self.is_contradicted or self._doubt_since_s < inf

    def see(self, time_s: float, told: Sequence[WatchedWheelset], *, is_free: bool) -> None:
        """Take the wheelsets, and whether neither brake nor motor has acted on any for a while."""
        speed_mps = self._speed.mps or 0.0
        if self._speed.mps is not None:
            before_s, before_mps = self._before or (self._speed.time_s, speed_mps)
            can_change_mps = SPEED_JUMP_MPS + HARDEST_RETARDATION_MPS2 * max(self._speed.time_s - before_s, 0.0)
            self._jumped |= abs(speed_mps - before_mps) > can_change_mps
            self._before = self._speed.time_s, speed_mps
        rolling_mps = [wheel.rolling_mps for wheel in told]
        if self._stands_alone:
            self._believe_again(time_s, speed_mps, rolling_mps)
        else:
            alone = self._seems_alone(time_s, speed_mps, told)
            self._doubt_since_s = min(self._doubt_since_s, time_s) if alone else inf
            self._stands_alone = time_s - self._doubt_since_s >= DOUBT_S
        if len(told) == self._count > 1 and self._speed.mps is not None:
            self._scale.see(time_s, self._speed.mps, rolling_mps, is_free=is_free)

    def _seems_alone(self, time_s: float, speed_mps: float, told: Sequence[WatchedWheelset]) -> bool:
        several = len(told) > 1
        left_all = several and _have_all_been_left(told, speed_mps)
        if not told or (any(_agree(wheel.rolling_mps, speed_mps) for wheel in told) and not left_all):
            self._jumped = False
            return False
        rolling_mps = sorted(wheel.rolling_mps for wheel in told)
        together = rolling_mps[-1] - rolling_mps[0] < DIFFERS * rolling_mps[-1] + DIFFERS_MPS
        is_odd = self._jumped or left_all or (several and all(wheel.turning.odd.is_on for wheel in told))
        return (together and is_odd) or self._cannot_all_stand(time_s, speed_mps, told)

    def _cannot_all_stand(self, time_s: float, speed_mps: float, told: Sequence[WatchedWheelset]) -> bool:
        """Whether no wheelset turns, and none can have been stopped."""
        if speed_mps <= WATCHED_FROM_MPS or any(wheel.stands_since_s == inf for wheel in told):
            return False
        origins = {wheel.origin for wheel in told}
        if origins == {Origin.STOOD}:
            return speed_mps > CUTS_OUT_BELOW_MPS
        slows = (self._past.retardation_mps2(time_s - WAIT_S, time_s) or 0.0) > ALL_STOPPED_MPS2
        pressed = all(wheel.holding.suffices for wheel in told)
        waited = time_s - max(wheel.stands_since_s for wheel in told) >= WAIT_S - SOONER_S
        return waited and origins <= NOT_TURNED and not (slows and pressed)

    def _believe_again(self, time_s: float, speed_mps: float, rolling_mps: Sequence[float]) -> None:
        agrees = any(abs(own - speed_mps) < AGREES * own for own in rolling_mps if own > WATCHED_FROM_MPS)
        self._agrees_since_s = min(self._agrees_since_s, time_s) if agrees else inf
        if time_s - self._agrees_since_s >= AGREES_S:
            self._stands_alone = self._jumped = False
            self._doubt_since_s = self._agrees_since_s = inf


def _have_all_been_left(wheels: Sequence[WatchedWheelset], speed_mps: float) -> bool:
    """Whether the vehicle's speed has left all of these wheelsets, though it agrees with them by half.

    One of them then turns as nothing can make it turn, and none as it rolled before.
    """
    is_odd = any(wheel.turning.odd.is_on for wheel in wheels)
    return is_odd and all(wheel.turning.was_left_by(speed_mps, wheel.rolling_mps) for wheel in wheels)


def _agree(rolling_mps: float, speed_mps: float) -> bool:
    """Whether the vehicle's speed may be as a wheelset says."""
    return abs(rolling_mps - speed_mps) < DIFFERS * max(rolling_mps, speed_mps) + DIFFERS_MPS
