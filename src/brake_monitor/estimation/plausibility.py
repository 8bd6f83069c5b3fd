"""Whether a reading that arrived whole may be believed, judged before the filter sees it."""

from collections.abc import Mapping
from math import inf

from brake_monitor.samples import Quantity, Sample

# Nothing on rails exceeds these (SI, absolute); they keep a sensor's nonsense out of the arithmetic.
LARGEST: Mapping[Quantity, float] = {
    Quantity.SPEED: 200.0,
    Quantity.AXLE_SPEED: 1000.0,
    Quantity.PRESSING_FORCE: 1e6,
    Quantity.LOAD_FORCE: 5e6,
    Quantity.WHEEL_TORQUE: 1e6,
    Quantity.GRADIENT: 0.5,
}
FASTEST_FALL_NPS = 2e6  # 90 kN vented with a time constant of 0.05 s
FASTEST_RISE_NPS = 4e6  # a rig's hydraulics; air fills more slowly than it is vented
LEAST_FORCE_STEP_S = 0.01  # frames that a gateway bunches are not as close as their times
FROZEN_S = 1.0  # longer than a slow satellite receiver repeats its last fix
FROZEN_READINGS = 10
MOVED_SIGMAS = 10.0  # of the reading's noise, quantisation included: about three of its smallest steps


def is_possible(sample: Sample) -> bool:
    """Whether time and value are finite and of a size that occurs."""
    return abs(sample.time_s) < inf and abs(sample.value) <= LARGEST.get(sample.quantity, inf)


class SpikeGate:
    """Holds back a pressing force that changes faster than air can move, until the next one bears it out."""

    def __init__(self) -> None:
        self._time_s = -inf
        self._value = 0.0
        self._holds = False  # a reading back:
        self._held_s = 0.0
        self._held_n = 0.0

    def passes(self, time_s: float, pressing_force_n: float) -> bool:
        """Take a reading and say that it may be used by itself; or nothing is taken, and `pass_on` has to see it."""
        if self._holds or not self._can_follow(time_s, pressing_force_n):
            return False
        self._time_s, self._value = time_s, pressing_force_n
        return True

    def pass_on(self, time_s: float, pressing_force_n: float) -> list[tuple[float, float]]:
        """Take a reading; return the readings, times first, that may be used now: none, it alone, or both."""
        believed = [(time_s, pressing_force_n)]
        if not self._can_follow(time_s, pressing_force_n):
            held_back = (self._held_s, self._held_n)
            self._holds, self._held_s, self._held_n = not self._holds, time_s, pressing_force_n
            if self._holds:
                return []
            believed = [held_back, *believed]
        self._holds = False
        self._time_s, self._value = time_s, pressing_force_n
        return believed

    def _can_follow(self, time_s: float, pressing_force_n: float) -> bool:
        """Whether air can have moved from the last reading to this one."""
        passed_s = abs(time_s - self._time_s)
        step_s = passed_s if passed_s > LEAST_FORCE_STEP_S else LEAST_FORCE_STEP_S
        return -FASTEST_FALL_NPS * step_s <= pressing_force_n - self._value <= FASTEST_RISE_NPS * step_s


class FrozenReading:
    """Notices a speed that repeats itself to the last bit while another that must go along with it moves.

    Noise and quantisation of a live sensor see to it that this takes much longer than FROZEN_S by itself.
    """

    def __init__(self, noise_std: float) -> None:
        self._least_move = MOVED_SIGMAS * noise_std
        self._value = inf
        self._since_s = 0.0
        self._reference = inf  # until it was known
        self._repeated = 0
        self._is_frozen = False

    def see(self, time_s: float, value: float, reference: float, is_known: bool) -> bool:
        """Take a reading, and what it has to follow in the same unit if that is known; True while it is frozen."""
        is_new = value != self._value or time_s < self._since_s  # the clock was set back
        if is_new or (is_known and self._reference == inf):
            self._value, self._since_s, self._repeated, self._is_frozen = value, time_s, 0, False
            self._reference = reference if is_known else inf
            return False
        self._repeated += 1
        if is_known:
            self._is_frozen = (
                self._repeated >= FROZEN_READINGS
                and time_s - self._since_s >= FROZEN_S
                and abs(reference - self._reference) > self._least_move
            )
        return self._is_frozen
