"""Whether readings and model go on fitting together: what no covariance can tell, since it believes both.

Each check knows what its quantity does while sensors and model are right, whatever the rail does, and raises a doubt
long before the estimate's own uncertainty would have grown.
"""

from enum import StrEnum
from math import copysign, inf, nan, sqrt

from brake_monitor.estimation.still_force import StillForce

LEAST_BIAS_STD_MPS = 0.01  # a speed that is better than this contradicts a model that is not
LARGEST_SIGMAS = 7.0  # a single innovation counts for no more, so that a spike does no harm
LARGEST_NIS = LARGEST_SIGMAS**2
BIAS_WEIGHT = 0.1  # of the newest innovation: the mean is over about ten
BIASED_SIGMAS = 1.1  # white noise alone stays below 0.95
CONTRADICTORY_SIGMAS = 3.0  # a sensor that is noisier than configured stays far below: its signs change
SCATTER_WEIGHT = 0.02  # of the newest innovation
SCATTERED_NIS = 8.0  # slides reach 3, locked wheels that are let go 6
TIMING_SIGMAS = 4.0  # as above: the rail's own surprises are not the force's
TIMING_MEMORY = 0.97  # per change of force
LEAST_CHANGE_RADPS2 = 1.0  # a smaller one does not show
CHANGES_NEEDED = 20
LATE_S = 0.009  # lasting lags of 0.1 s leave 0.01 to 0.03 s; none leaves -0.02 to +0.007 s
LATE_IN_A_ROW = 6  # changes: a rail that slips away as slide protection begins to vent looks late for some
DOUBT_S = 3.0  # how long a doubt outlasts its reason: as long as a start takes to settle
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

    def __init__(self) -> None:
        self._mean_sigmas = 0.0

    def see(self, residual: float, variance: float) -> None:
        """Take an innovation of the vehicle speed."""
        sigmas = residual / max(sqrt(variance), LEAST_BIAS_STD_MPS)
        self._mean_sigmas += BIAS_WEIGHT * (max(min(sigmas, LARGEST_SIGMAS), -LARGEST_SIGMAS) - self._mean_sigmas)

    @property
    def is_doubtful(self) -> bool:
        """Whether something is not as the model has it."""
        return abs(self._mean_sigmas) > BIASED_SIGMAS

    @property
    def is_contradictory(self) -> bool:
        """Whether model and readings exclude each other."""
        return abs(self._mean_sigmas) > CONTRADICTORY_SIGMAS

    def restart(self) -> None:
        """Forget what was seen."""
        self._mean_sigmas = 0.0


class Scatter:
    """Running mean of squared innovations: readings whose times are wrong scatter far beyond their noise."""

    def __init__(self) -> None:
        self._mean_nis = 1.0

    def see(self, nis: float) -> bool:
        """Take an innovation, squared and normalised; True when the readings scatter too much."""
        self._mean_nis += SCATTER_WEIGHT * ((LARGEST_NIS if nis > LARGEST_NIS else nis) - self._mean_nis)
        return self._mean_nis > SCATTERED_NIS


class ForceTiming:
    """How late a wheel follows its pressing force, from what the wheel does whenever the force has changed.

    A force that changes by ΔF speeds the wheel up by -r_b mu_b ΔF / J (6). If the wheel has done so earlier than the
    force was told, its innovation shortly after has the opposite sign, in proportion to the force's lag: regressed on
    each other, weighted by the innovation's own certainty, they give the part of the lag that the filter has not
    yet taken for adhesion.
    """

    def __init__(self) -> None:
        self._last_radps2 = nan
        self._product = self._square = 0.0
        self._changes = self._late = 0

    def see(self, brake_radps2: float, residual: float, variance: float) -> bool:
        """Take what the brake does to the wheel now, -r_b mu_b F / J, and the wheel's innovation; True when late."""
        change_radps2 = brake_radps2 - self._last_radps2
        self._last_radps2 = brake_radps2
        if not abs(change_radps2) >= LEAST_CHANGE_RADPS2:  # nor is it at first, when it is NaN
            return False
        residual = copysign(min(abs(residual), TIMING_SIGMAS * sqrt(variance)), residual)
        self._product = TIMING_MEMORY * self._product + change_radps2 * residual / variance
        self._square = TIMING_MEMORY * self._square + change_radps2 * change_radps2 / variance
        self._changes += 1
        is_late = self._changes >= CHANGES_NEEDED and -self._product > LATE_S * self._square
        self._late = self._late + 1 if is_late else 0
        return self._late >= LATE_IN_A_ROW


class WheelChecks:
    """Those of one wheelset."""

    def __init__(self) -> None:
        self.scatter = Scatter()
        self.timing = ForceTiming()
        self.still = StillForce()


class Consistency:
    """The checks of one wagon, and when each last raised its doubt."""

    def __init__(self) -> None:
        self.bias = Bias()
        self.biased_s = self.scattered_s = self.out_of_step_s = self.still_s = self.unexplained_s = -inf

    def see_speed(self, time_s: float, residual: float, variance: float) -> bool:
        """Take an innovation of the vehicle speed; True when it contradicts the model, which starts anew then."""
        self.bias.see(residual, variance)
        if not self.bias.is_doubtful:
            return False
        self.biased_s = time_s
        if not self.bias.is_contradictory:
            return False
        self.bias.restart()
        return True

    def see_wheel(
        self, time_s: float, wheel: WheelChecks, residual: float, variance: float, brake_radps2: float
    ) -> None:
        """Take an innovation of a wheelset's speed and what its brake does to it, -r_b mu_b F / J."""
        if wheel.scatter.see(residual * residual / variance):
            self.scattered_s = time_s
        if wheel.timing.see(brake_radps2, residual, variance):
            self.out_of_step_s = time_s

    def see_force(
        self, time_s: float, wheel: WheelChecks, pressing_force_n: float, slip: float, speed_mps: float
    ) -> None:
        """Take a pressing force, and how fast its wheelset slides: who slides anew has a force that moves."""
        if wheel.still.see(time_s, pressing_force_n, slip, speed_mps):
            self.still_s = time_s

    def is_in_step_again(self, time_s: float) -> bool:
        """Whether a doubt in the forces' timing is over: what they taught meanwhile is still there."""
        return -inf < self.out_of_step_s <= time_s - TIMING_DOUBT_S

    def see_deceleration(self, time_s: float, deceleration_mps2: float, largest_mps2: float) -> None:
        """Take the unmodelled deceleration and the largest one that there is."""
        if abs(deceleration_mps2) > largest_mps2:
            self.unexplained_s = time_s

    def set_back(self, by_s: float) -> None:
        """Note that the clock was set back by so much."""
        self.biased_s -= by_s
        self.scattered_s -= by_s
        self.out_of_step_s -= by_s
        self.still_s -= by_s
        self.unexplained_s -= by_s

    def doubts(self, time_s: float) -> int:
        """What is in doubt now, in one number: see `in_words`."""
        return (
            (1 if time_s - self.biased_s < DOUBT_S else 0)
            + (2 if time_s - self.scattered_s < DOUBT_S else 0)
            + (4 if time_s - self.out_of_step_s < TIMING_DOUBT_S else 0)
            + (8 if time_s - self.still_s < DOUBT_S else 0)
            + (16 if time_s - self.unexplained_s < DOUBT_S else 0)
        )


def in_words(doubts: int) -> tuple[Doubt, ...]:
    """The doubts that `Consistency.doubts` counted: a bit for each, in order."""
    return tuple([doubt for k, doubt in enumerate(Doubt) if doubts >> k & 1])
