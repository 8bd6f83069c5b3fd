"""Whether a reading that arrived whole may be believed, judged before the filter sees it."""

from collections.abc import Mapping
from math import exp, inf

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
FASTEST_EMPTYING_S = 0.02  # time constant; no valve vents a cylinder in less than 0.05 s
LEAST_FALL_N = 2000.0  # less is noise, or a coarse sensor's step
DEAD_S = 0.1  # so long another brake would have needed to follow
ALIVE_S = 0.5
LEAST_FORCE_STEP_S = 0.01  # frames that a gateway bunches are not as close as their times
FROZEN_S = 1.0  # longer than a slow satellite receiver repeats its last fix
FROZEN_READINGS = 10
MOVED_SIGMAS = 10.0  # of the reading's noise, quantisation included: about three of its smallest steps


def is_possible(sample: Sample) -> bool:
    """Whether time and value are finite and of a size that occurs."""
    return abs(sample.time_s) < inf and abs(sample.value) <= LARGEST.get(sample.quantity, inf)


class SpikeGate:
    """Holds back a pressing force that changes faster than air can move, until the next one bears it out.

    One that repeats itself to the last bit after such a fall, while another brake presses on, is a sensor that died.
    """

    def __init__(self) -> None:
        self.holds = False  # a reading back
        self.is_dead = False  # what is held back stays so until it changes
        self._time_s = -inf
        self._value = 0.0
        self._moved_s = -inf  # when its value last changed
        self._held_s = 0.0
        self._held_n = 0.0

    def passes(self, time_s: float, pressing_force_n: float, rolls: bool) -> bool:
        """Take a reading and say that it may be used by itself; or nothing is taken, and `pass_on` has to see it.

        `rolls`: the wheelset does, so that no slide protection vents its brake.
        """
        if self.holds or not self._can_follow(time_s, pressing_force_n, rolls):
            return False
        self._take(time_s, pressing_force_n)
        return True

    def pass_on(self, time_s: float, pressing_force_n: float, rolls: bool, is_alone: bool) -> list[tuple[float, float]]:
        """Take a reading; return the readings, times first, that may be used now: none, it alone, or both.

        `is_alone`: another brake presses on, by a sensor that is alive.
        """
        if self.holds and rolls and is_alone and pressing_force_n == self._held_n < self._value:
            self.is_dead |= time_s - self._held_s >= DEAD_S
            return []
        self.is_dead = False
        believed = [(time_s, pressing_force_n)]
        if not self._can_follow(time_s, pressing_force_n, rolls):
            held_back = (self._held_s, self._held_n)
            self.holds, self._held_s, self._held_n = not self.holds, time_s, pressing_force_n
            if self.holds:
                return []
            believed = [held_back, *believed]
        self.holds = False
        self._take(time_s, pressing_force_n)
        return believed

    def is_alive(self, time_s: float) -> bool:
        """Whether readings come that differ, if only by noise, and are believed."""
        return not self.holds and abs(time_s - self._moved_s) < ALIVE_S

    def _take(self, time_s: float, pressing_force_n: float) -> None:
        if pressing_force_n != self._value:
            self._moved_s = time_s
        self._time_s, self._value = time_s, pressing_force_n

    def _can_follow(self, time_s: float, pressing_force_n: float, rolls: bool) -> bool:
        """Whether air can have moved from the last reading to this one."""
        passed_s = abs(time_s - self._time_s)
        step_s = passed_s if passed_s > LEAST_FORCE_STEP_S else LEAST_FORCE_STEP_S
        moved_n = pressing_force_n - self._value
        if moved_n >= -LEAST_FALL_N or not rolls:
            return -FASTEST_FALL_NPS * step_s <= moved_n <= FASTEST_RISE_NPS * step_s
        return pressing_force_n >= self._value * exp(-step_s / FASTEST_EMPTYING_S)


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

    @property
    def since_s(self) -> float:
        """When the reading came that has repeated itself since then."""
        return self._since_s

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
