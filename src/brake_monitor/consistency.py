"""Whether readings and model go on fitting together: what no covariance can tell, since it believes both.

Each check knows what its quantity does while sensors and model are right, whatever the rail does, and raises a doubt
long before the estimate's own uncertainty would have grown.
"""

from collections.abc import Iterator
from enum import StrEnum
from math import copysign, inf, sqrt

from brake_monitor.ekf import Innovation
from brake_monitor.plausibility import MOVED_SIGMAS, FrozenReading

LEAST_BIAS_STD_MPS = 0.01  # a speed that is better than this contradicts a model that is not
LARGEST_SIGMAS = 7.0  # a single innovation counts for no more, so that a spike does no harm
DOUBT_S = 3.0  # how long a doubt outlasts its reason: as long as a start takes to settle
STILL_SLIP = 0.05  # a slip that changes by more makes every slide protection move the force
TIMING_DOUBT_S = 10.0  # the force's changes alone tell of its timing: it is in doubt until many were in step


class Doubt(StrEnum):
    """Why an estimate whose covariance is small is not to be believed."""

    BIASED = "speed contradicts forces"
    SCATTERED = "wheel speeds scatter"
    OUT_OF_STEP = "pressing force out of step"
    STILL = "pressing force still in a slide"
    UNEXPLAINED = "unexplained deceleration"


class Bias:
    """Running mean of normalised innovations; zero when model and sensors agree, whatever the noise."""

    WEIGHT = 0.1  # of the newest innovation: the mean is over about ten
    DOUBTFUL_SIGMAS = 1.1  # white noise alone stays below 0.95
    CONTRADICTORY_SIGMAS = 3.0  # a sensor that is noisier than configured stays far below: its signs change

    def __init__(self) -> None:
        self._mean = 0.0

    def see(self, seen: Innovation) -> None:
        """Take an innovation of the vehicle speed."""
        sigmas = seen.residual / max(sqrt(seen.variance), LEAST_BIAS_STD_MPS)
        self._mean += self.WEIGHT * (max(min(sigmas, LARGEST_SIGMAS), -LARGEST_SIGMAS) - self._mean)

    @property
    def is_doubtful(self) -> bool:
        """Whether something is not as the model has it."""
        return abs(self._mean) > self.DOUBTFUL_SIGMAS

    @property
    def is_contradictory(self) -> bool:
        """Whether model and readings exclude each other."""
        return abs(self._mean) > self.CONTRADICTORY_SIGMAS

    def restart(self) -> None:
        """Forget what was seen."""
        self._mean = 0.0


class Scatter:
    """Running mean of squared innovations: readings whose times are wrong scatter far beyond their noise."""

    WEIGHT = 0.02
    DOUBTFUL_NIS = 8.0  # slides reach 3, locked wheels that are let go 6

    def __init__(self) -> None:
        self._mean = 1.0

    def see(self, seen: Innovation) -> bool:
        """Take an innovation; True when the readings scatter too much."""
        self._mean += self.WEIGHT * (min(seen.nis, LARGEST_SIGMAS**2) - self._mean)
        return self._mean > self.DOUBTFUL_NIS


class ForceTiming:
    """How late a wheel follows its pressing force, from what the wheel does whenever the force has changed.

    A force that changes by ΔF speeds the wheel up by -r_b mu_b ΔF / J (6). If the wheel has done so earlier than the
    force was told, its innovation shortly after has the opposite sign, in proportion to the force's lag: regressed on
    each other, weighted by the innovation's own certainty, they give the part of the lag that the filter has not
    yet taken for adhesion.
    """

    MEMORY = 0.97  # per change of force
    LEAST_CHANGE_RADPS2 = 1.0  # a smaller one does not show
    CHANGES_NEEDED = 20
    DOUBTFUL_LAG_S = 0.009  # lasting lags of 0.1 s leave 0.01 to 0.03 s; none leaves -0.02 to +0.007 s

    def __init__(self) -> None:
        self._last_radps2: float | None = None
        self._product = self._square = 0.0
        self._changes = 0

    def see(self, brake_radps2: float, seen: Innovation) -> bool:
        """Take what the brake does to the wheel now, -r_b mu_b F / J, and the wheel's innovation; True when late."""
        change_radps2 = 0.0 if self._last_radps2 is None else brake_radps2 - self._last_radps2
        self._last_radps2 = brake_radps2
        if abs(change_radps2) < self.LEAST_CHANGE_RADPS2:
            return False
        residual = copysign(min(abs(seen.residual), LARGEST_SIGMAS * sqrt(seen.variance)), seen.residual)
        self._product = self.MEMORY * self._product + change_radps2 * residual / seen.variance
        self._square = self.MEMORY * self._square + change_radps2 * change_radps2 / seen.variance
        self._changes += 1
        return self._changes >= self.CHANGES_NEEDED and -self._product > self.DOUBTFUL_LAG_S * self._square


class Consistency:
    """The checks of one wagon and the doubts that they have raised."""

    def __init__(self, wheelset_count: int) -> None:
        self._bias = Bias()
        self._scatter = [Scatter() for _ in range(wheelset_count)]
        self._timing = [ForceTiming() for _ in range(wheelset_count)]
        self._still = [FrozenReading(STILL_SLIP / MOVED_SIGMAS) for _ in range(wheelset_count)]
        self._raised_s = dict.fromkeys(Doubt, -inf)

    def see_speed(self, time_s: float, seen: Innovation) -> bool:
        """Take an innovation of the vehicle speed; True when it contradicts the model, which starts anew then."""
        self._bias.see(seen)
        if self._bias.is_doubtful:
            self._raised_s[Doubt.BIASED] = time_s
        if not self._bias.is_contradictory:
            return False
        self._bias.restart()
        return True

    def see_wheel(self, time_s: float, wheelset: int, seen: Innovation, brake_radps2: float) -> None:
        """Take an innovation of a wheelset's speed and what its brake does to it, -r_b mu_b F / J."""
        if self._scatter[wheelset].see(seen):
            self._raised_s[Doubt.SCATTERED] = time_s
        if self._timing[wheelset].see(brake_radps2, seen):
            self._raised_s[Doubt.OUT_OF_STEP] = time_s

    def see_force(self, time_s: float, wheelset: int, pressing_force_n: float, slip: float) -> None:
        """Take a pressing force and the slip of its wheelset: who slides has a force that moves, down to its noise."""
        if self._still[wheelset].see(time_s, pressing_force_n, slip) and pressing_force_n > 0.0:
            self._raised_s[Doubt.STILL] = time_s

    def see_deceleration(self, time_s: float, deceleration_mps2: float, largest_mps2: float) -> None:
        """Take the unmodelled deceleration and the largest one that there is."""
        if abs(deceleration_mps2) > largest_mps2:
            self._raised_s[Doubt.UNEXPLAINED] = time_s

    def set_back(self, by_s: float) -> None:
        """Note that the clock was set back by so much."""
        for doubt in Doubt:
            self._raised_s[doubt] -= by_s

    def doubts(self, time_s: float) -> Iterator[Doubt]:
        """What is in doubt now."""
        for doubt, raised_s in self._raised_s.items():
            if time_s - raised_s < (TIMING_DOUBT_S if doubt is Doubt.OUT_OF_STEP else DOUBT_S):
                yield doubt
