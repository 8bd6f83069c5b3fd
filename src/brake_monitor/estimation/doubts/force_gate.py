"""Whether a pressing force may be believed at once, by how fast air moves and by what other brakes do."""

from math import exp, inf

FASTEST_FALL_NPS = 2e6  # 90 kN vented with a time constant of 0.05 s
FASTEST_RISE_NPS = 4e6  # a rig's hydraulics; air fills more slowly than it is vented
FASTEST_EMPTYING_S = 0.02  # time constant; no valve vents a cylinder in less than 0.05 s
LEAST_FALL_N = 2000.0  # less is noise, or a coarse sensor's step
SPRINGS_N = 10e3  # below it return springs take the force on to 0 as fast as the air that leaves took it before
DEAD_S = 0.1  # by then another brake would have followed a true fall
ALIVE_S = 0.5  # a sensor whose value has changed within it is alive
TREMBLES_STEPS = 2.0  # a sensor whose value has changed within so many of its readings tells each as it is measured
SPIKE_S = 0.15  # no brake is applied and vented again as quickly
LEAST_FORCE_STEP_S = 0.01  # frames that a gateway bunches are not as close as their times


class ForceGate:
    """Holds back a pressing force that has changed faster than air can move, until the next reading bears it out.

    A sensor is dead if it repeats the new value to the last bit after such a fall, while another brake presses on, or
    its own wheelset uses the rail as before. So it is after such a rise far beyond what the brake pressed with lately:
    a wire touches another.
    """

    def __init__(self) -> None:
        self.holds = False  # it holds a reading back
        self.is_dead = False  # the sensor is: its reading is held back until it changes
        self._time_s = -inf
        self._value = 0.0
        self._before_s = -inf  # the reading believed before
        self._before_n = 0.0
        self._moved_s = -inf  # when its value last changed
        self._fell_s = -inf  # when it last fell by more than noise ...
        self._fell_nps = 0.0  # ... and how fast
        self._rose_s = -inf  # when it last was as low as before it rose by more than noise ...
        self._rose_from_n = 0.0  # ... and how low that was
        self._held_s = 0.0
        self._held_n = 0.0
        self.bears_out = False  # the last reading believed bore out the one held back before it
        self.fell_alive = False  # the one held back came from a sensor that had just trembled: it is told as measured

    def passes(self, time_s: float, pressing_force_n: float, rolls: bool) -> bool:
        """Take an ordinary reading; False if it is none: nothing is taken then, and `pass_on` has to decide.

        `rolls`: the wheelset does, so that no slide protection vents its brake.
        """
        if self.holds or not self._can_follow(time_s, pressing_force_n, rolls):
            return False
        self._take(time_s, pressing_force_n)
        return True

    def pass_on(self, time_s: float, pressing_force_n: float, rolls: bool, unlikely: bool) -> list[tuple[float, float]]:
        """Take a reading; return the readings (time, force) to use now: none, this one, or the one held back and this.

        `unlikely`: it falls, or has fallen and stays, while another brake presses on, or rises far beyond what it
        pressed with lately.
        """
        is_still = self.holds and unlikely and pressing_force_n == self._held_n
        if is_still and (rolls or self.is_dead or self._held_n > self._value):
            self.is_dead |= time_s - self._held_s >= DEAD_S
            return []
        self.is_dead = False
        believed = [(time_s, pressing_force_n)]
        if not self._can_follow(time_s, pressing_force_n, rolls):
            held_back = (self._held_s, self._held_n)
            self.holds, self._held_s, self._held_n = not self.holds, time_s, pressing_force_n
            if self.holds:
                self.fell_alive = self._time_s - self._moved_s <= TREMBLES_STEPS * self._step_s(time_s)
                return []
            believed = [held_back, *believed]
        self.holds = False
        self._take(time_s, pressing_force_n)
        self.bears_out = len(believed) > 1
        return believed

    def is_alive(self, time_s: float) -> bool:
        """Whether readings are believed and have differed lately, if only by noise."""
        return not self.holds and abs(time_s - self._moved_s) < ALIVE_S

    def has_jumped(self) -> bool:
        """Whether the last reading believed is further from the one before than air moves: one of them is wrong."""
        step_s = max(abs(self._time_s - self._before_s), LEAST_FORCE_STEP_S)
        return abs(self._value - self._before_n) > FASTEST_FALL_NPS * step_s

    def _take(self, time_s: float, pressing_force_n: float) -> None:
        self._before_s, self._before_n = self._time_s, self._value
        if pressing_force_n != self._value:
            self._moved_s = time_s
        if pressing_force_n > self._value + LEAST_FALL_N and abs(time_s - self._rose_s) > SPIKE_S:
            self._rose_s, self._rose_from_n = self._time_s, self._value
        if pressing_force_n < self._value - LEAST_FALL_N:
            self._fell_s, self._fell_nps = time_s, (self._value - pressing_force_n) / self._step_s(time_s)
        self._time_s, self._value = time_s, pressing_force_n
        self.bears_out = False

    def _can_follow(self, time_s: float, pressing_force_n: float, rolls: bool) -> bool:
        """Whether air can have moved from the last reading to this one."""
        step_s = self._step_s(time_s)
        moved_n = pressing_force_n - self._value
        if moved_n >= -LEAST_FALL_N or not rolls:
            return -FASTEST_FALL_NPS * step_s <= moved_n <= FASTEST_RISE_NPS * step_s
        if pressing_force_n >= self._value * exp(-step_s / FASTEST_EMPTYING_S):
            return True
        if abs(time_s - self._rose_s) <= SPIKE_S and pressing_force_n >= self._rose_from_n - LEAST_FALL_N:
            return True  # what was told between was no force
        is_vented = self._value < SPRINGS_N and abs(time_s - self._fell_s) < ALIVE_S
        return is_vented and -moved_n <= self._fell_nps * step_s

    def _step_s(self, time_s: float) -> float:
        passed_s = abs(time_s - self._time_s)
        return passed_s if passed_s > LEAST_FORCE_STEP_S else LEAST_FORCE_STEP_S
