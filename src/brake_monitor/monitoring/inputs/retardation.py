"""How much the wagon is retarded, by its speed and what motors do: in all, and beyond how it rolled freely before."""

from collections import deque
from collections.abc import Sequence
from math import inf
from operator import mul

from brake_monitor.estimation.estimate import LONGEST_STEP_S, Estimate
from brake_monitor.estimation.rolling.line_roughness import PULLED_MPS2
from brake_monitor.monitoring.passing_time import LastTime
from brake_monitor.monitoring.running_mean import RunningMean
from brake_monitor.settings.config import Vehicle

SPAN_S = 1.5  # of which the mean is taken
LEAST_COUNT = 8
FREE_AFTER_S = 2.0  # after the last contact the wagon rolls freely
FREE_S = 10.0  # of free rolling are remembered; the gradient further behind has no say
LEAST_FREE_S = 2.0
STEP_MPS2 = 0.1  # against the mean of free rolling: a pull has ended, or begun
EXPIRES_S = 60.0  # the gradient is another one by then
LEAST_SPEED_MPS = 3.0


class Retardation:
    """Sees each estimate, in order of time. Means over SPAN_S in m/s², None where they cannot be told.

    What motors take from the speed, as they tell, is theirs: the rest is the pads', but for what motors err by.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        self._vehicle = vehicle
        self._lately: deque[tuple[float, float, float]] = deque()  # of the last SPAN_S time, speed, and by motors
        self._rotating_kg = sum(vehicle.turning_kg)
        self._held = LastTime(inf)  # it did not roll freely
        self._free = RunningMean(FREE_S)  # retardation in free rolling ...
        self._rolled_s = -inf  # ... and when that ended
        self.total_mps2: float | None = None  # beyond what track, air and motors take
        self.by_motors_mps2 = 0.0
        self.by_brakes_mps2: float | None = None

    def see(self, now: Estimate, *, rolls_freely: bool) -> None:
        """Take an estimate, and whether no pad presses and no motor acts, for all that is known."""
        time_s, lately = now.time_s, self._lately
        gap_s = time_s - lately[-1][0] if lately else 0.0
        motors_n = [own.motor_force_n for own in now.wheelsets]
        if now.speed_mps < LEAST_SPEED_MPS or not 0.0 <= gap_s <= LONGEST_STEP_S or None in motors_n:
            lately.clear()
        lately.append((time_s, now.speed_mps, sum(filter(None, motors_n)) / (now.mass_kg + self._rotating_kg)))
        while time_s - lately[0][0] > SPAN_S:
            lately.popleft()
        times_s, speeds_mps, motors_mps2 = zip(*lately, strict=True)
        self.by_motors_mps2 = sum(motors_mps2) / len(motors_mps2)
        self._held.see(time_s, not rolls_freely)
        retarded_mps2 = mean_retardation_mps2(times_s, speeds_mps)
        resisted_mps2 = self._vehicle.resistance_n(now.speed_mps) / now.mass_kg
        self.total_mps2 = None if retarded_mps2 is None else retarded_mps2 - resisted_mps2 - self.by_motors_mps2
        if self.total_mps2 is not None and time_s - self._held.time_s > FREE_AFTER_S + SPAN_S:
            self._roll(time_s, self.total_mps2, gap_s)
        is_known = self._free.count >= LEAST_FREE_S and 0.0 <= time_s - self._rolled_s <= EXPIRES_S
        self.by_brakes_mps2 = self.total_mps2 - self._free.value if is_known and self.total_mps2 is not None else None

    def forget_lately(self) -> None:
        """What the speed was tells nothing of how it changes from now on."""
        self._lately.clear()

    @property
    def is_pulled(self) -> bool:
        """Whether the wagon gains speed by itself: a pull hides what its brakes take."""
        return self.total_mps2 is not None and self.total_mps2 < -PULLED_MPS2

    def _roll(self, time_s: float, free_mps2: float, step_s: float) -> None:
        if free_mps2 < -PULLED_MPS2:
            return
        if time_s - self._rolled_s > EXPIRES_S or abs(free_mps2 - self._free.value) > STEP_MPS2:
            self._free.begin()
        self._rolled_s = time_s
        self._free.add(free_mps2, step_s)


def mean_retardation_mps2(times_s: Sequence[float], speeds_mps: Sequence[float]) -> float | None:
    """By least squares; None with too little to tell."""
    count = len(times_s)
    if count < LEAST_COUNT:
        return None
    mean_s = sum(times_s) / count
    since_s = [time_s - mean_s for time_s in times_s]
    spread_s2: float = sum(map(mul, since_s, since_s))
    return -sum(map(mul, since_s, speeds_mps)) / spread_s2 if spread_s2 else None
