"""Whether readings and model go on fitting together: covariances cannot tell, since they presuppose it.

Each check follows a quantity whose behaviour is known while sensors and model are right, whatever the rail does. It
raises a doubt long before the estimate's own deviation would have grown.
"""

from enum import StrEnum
from math import inf, sqrt

from brake_monitor.estimation.doubts.force_timing import ForceTiming
from brake_monitor.estimation.doubts.still_force import StillForce
from brake_monitor.estimation.doubts.still_speeds import StillSpeeds

LEAST_BIAS_STD_MPS = 0.01  # the model is no better: a more precise speed would contradict it for no reason
LARGEST_SIGMAS = 7.0  # a single innovation counts for no more, so that a spike does no harm
LARGEST_NIS = LARGEST_SIGMAS**2
BIAS_WEIGHT = 0.1  # of the newest innovation: the mean is over about ten
BIASED_SIGMAS = 1.1  # white noise alone stays below 0.95
CONTRADICTORY_SIGMAS = 3.0  # a sensor that is noisier than configured stays far below: its signs change
SCATTER_WEIGHT = 0.02  # of the newest innovation
SCATTERED_NIS = 8.0  # slides reach 3, locked wheels that are let go 6
DOUBT_S = 3.0  # how long a doubt outlasts its reason: as long as a start takes to settle
TAUGHT_S = 3.0  # wheel speeds that scatter for so long have spoilt all that slides teach of friction
TIMING_DOUBT_S = 10.0  # only changes of the force show its timing: many must have been in step to end the doubt


class Doubt(StrEnum):
    """Why an estimate whose covariance is small is not to be believed."""

    BIASED = "speed contradicts forces"
    SCATTERED = "wheel speeds scatter"
    OUT_OF_STEP = "pressing force out of step"
    STILL = "pressing force still in a slide"
    UNEXPLAINED = "unexplained deceleration"
    REPEATED = "all speeds stand still"


class Bias:
    """Running mean of normalised innovations of v: about 0 while model and sensors agree, whatever the noise."""

    def __init__(self) -> None:
        self._mean_sigmas = 0.0

    def see(self, residual: float, variance: float) -> None:
        """Take an innovation of the vehicle speed."""
        sigmas = residual / max(sqrt(variance), LEAST_BIAS_STD_MPS)
        self._mean_sigmas += BIAS_WEIGHT * (max(min(sigmas, LARGEST_SIGMAS), -LARGEST_SIGMAS) - self._mean_sigmas)

    @property
    def is_doubtful(self) -> bool:
        """Whether the vehicle's speed deviates from the model."""
        return abs(self._mean_sigmas) > BIASED_SIGMAS

    @property
    def is_contradictory(self) -> bool:
        """Whether it deviates so far that model and readings exclude each other."""
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
        self.speeds = StillSpeeds()
        self.biased_s = self.scattered_s = self.out_of_step_s = -inf
        self.still_s = self.unexplained_s = self.repeated_s = -inf
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
        """Take a wheelset's speed, its normalised innovation squared, and whether the wheelset slides (1 or 0)."""
        if wheel.scatter.see(nis):
            if not time_s - self.scattered_s < DOUBT_S:
                self.scattered_from_s = time_s
            self.scattered_s = time_s
        if wheel.timing.see(time_s, omega_radps, slides):
            self.out_of_step_s = time_s

    def see_force(
        self, time_s: float, wheel: WheelChecks, pressing_force_n: float, slip: float, speed_mps: float
    ) -> None:
        """Take a pressing force with slip and speed: a wheelset slides anew only if its force has moved."""
        if wheel.still.see(time_s, pressing_force_n, slip, speed_mps):
            self.still_s = time_s

    def is_biased(self, time_s: float) -> bool:
        """Whether the vehicle's speed contradicts the forces, or did lately."""
        return time_s - self.biased_s < DOUBT_S

    def is_out_of_step(self, time_s: float) -> bool:
        """Whether the forces' timing is in doubt."""
        return time_s - self.out_of_step_s < TIMING_DOUBT_S

    def end_doubts(self, time_s: float) -> float:
        """End doubts in wheel speeds and forces that are over; the share, 0 to 1, of what these taught that is wrong.

        That is still part of the estimate. Wheel speeds that scattered for a moment have taught little.
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
        """Take the unmodelled deceleration, or a part of it, and the largest that is explained."""
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
        self.repeated_s -= by_s

    def doubts(self, time_s: float) -> int:
        """What is in doubt now, a bit for each `Doubt` in order: see `in_words`."""
        return (
            (1 if self.is_biased(time_s) else 0)
            + (2 if time_s - self.scattered_s < DOUBT_S else 0)
            + (4 if self.is_out_of_step(time_s) else 0)
            + (8 if time_s - self.still_s < DOUBT_S else 0)
            + (16 if time_s - self.unexplained_s < DOUBT_S else 0)
            + (32 if time_s - self.repeated_s < DOUBT_S else 0)
        )


def in_words(doubts: int) -> tuple[Doubt, ...]:
    """The doubts whose bits are set in a number by `Consistency.doubts`."""
    return tuple([doubt for k, doubt in enumerate(Doubt) if doubts >> k & 1])
