"""Whether readings and model go on fitting together: what no covariance can tell, since it believes both.

Each check knows what its quantity does while sensors and model are right, whatever the rail does, and raises a doubt
long before the estimate's own uncertainty would have grown.
"""

from enum import StrEnum
from math import inf, sqrt

from brake_monitor.estimation.doubts.force_timing import ForceTiming
from brake_monitor.estimation.doubts.still_force import StillForce

LEAST_BIAS_STD_MPS = 0.01  # a speed that is better than this contradicts a model that is not
LARGEST_SIGMAS = 7.0  # a single innovation counts for no more, so that a spike does no harm
LARGEST_NIS = LARGEST_SIGMAS**2
BIAS_WEIGHT = 0.1  # of the newest innovation: the mean is over about ten
BIASED_SIGMAS = 1.1  # white noise alone stays below 0.95
CONTRADICTORY_SIGMAS = 3.0  # a sensor that is noisier than configured stays far below: its signs change
SCATTER_WEIGHT = 0.02  # of the newest innovation
SCATTERED_NIS = 8.0  # slides reach 3, locked wheels that are let go 6
DOUBT_S = 3.0  # how long a doubt outlasts its reason: as long as a start takes to settle
TAUGHT_S = 3.0  # so long wheel speeds must scatter to spoil all that slides teach of friction
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


class WheelChecks:
    """The checks of one wheelset."""

    def __init__(self) -> None:
        self.scatter = Scatter()
        self.timing = ForceTiming()
        self.still = StillForce()


class Consistency:
    """The checks of one wagon, and when each last raised its doubt."""

    def __init__(self) -> None:
        self.bias = Bias()
        self.biased_s = self.scattered_s = self.out_of_step_s = self.still_s = self.unexplained_s = -inf
        self.scattered_from_s = -inf

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

    def see_wheel(self, time_s: float, wheel: WheelChecks, nis: float, omega_radps: float, slides: float) -> None:
        """Take a wheelset's speed, its innovation, squared and normalised, and whether it slides (1 or 0)."""
        if wheel.scatter.see(nis):
            if not time_s - self.scattered_s < DOUBT_S:
                self.scattered_from_s = time_s
            self.scattered_s = time_s
        if wheel.timing.see(time_s, omega_radps, slides):
            self.out_of_step_s = time_s

    def see_force(
        self, time_s: float, wheel: WheelChecks, pressing_force_n: float, slip: float, speed_mps: float
    ) -> None:
        """Take a pressing force, and how fast its wheelset slides: who slides anew has a force that moves."""
        if wheel.still.see(time_s, pressing_force_n, slip, speed_mps):
            self.still_s = time_s

    def is_biased(self, time_s: float) -> bool:
        """Whether the vehicle's speed contradicts the forces, or did lately."""
        return time_s - self.biased_s < DOUBT_S

    def is_out_of_step(self, time_s: float) -> bool:
        """Whether the forces' timing is in doubt."""
        return time_s - self.out_of_step_s < TIMING_DOUBT_S

    def end_doubts(self, time_s: float) -> float:
        """As a doubt in wheel speeds or forces ends: how much of what they taught meanwhile is wrong, up to 1; 0 else.

        It is in the estimate yet. Wheel speeds that scatter for a moment teach little.
        """
        wrong = 0.0
        if -inf < self.out_of_step_s <= time_s - TIMING_DOUBT_S:
            self.out_of_step_s, wrong = -inf, 1.0
        if -inf < self.still_s <= time_s - DOUBT_S:
            self.still_s, wrong = -inf, 1.0
        if -inf < self.scattered_s <= time_s - DOUBT_S:
            scattered_for_s, self.scattered_s = self.scattered_s - self.scattered_from_s, -inf
            wrong = max(wrong, min(scattered_for_s / TAUGHT_S, 1.0))
        return wrong

    def see_deceleration(self, time_s: float, deceleration_mps2: float, largest_mps2: float) -> None:
        """Take the unmodelled deceleration and the largest one that there is."""
        if abs(deceleration_mps2) > largest_mps2:
            self.unexplained_s = time_s

    def set_back(self, by_s: float) -> None:
        """Note that the clock was set back by so much."""
        self.biased_s -= by_s
        self.scattered_s -= by_s
        self.scattered_from_s -= by_s
        self.out_of_step_s -= by_s
        self.still_s -= by_s
        self.unexplained_s -= by_s

    def doubts(self, time_s: float) -> int:
        """What is in doubt now, in one number: see `in_words`."""
        return (
            (1 if self.is_biased(time_s) else 0)
            + (2 if time_s - self.scattered_s < DOUBT_S else 0)
            + (4 if self.is_out_of_step(time_s) else 0)
            + (8 if time_s - self.still_s < DOUBT_S else 0)
            + (16 if time_s - self.unexplained_s < DOUBT_S else 0)
        )


def in_words(doubts: int) -> tuple[Doubt, ...]:
    """The doubts that `Consistency.doubts` counted: a bit for each, in order."""
    return tuple([doubt for k, doubt in enumerate(Doubt) if doubts >> k & 1])
