"""Whether readings and model go on fitting together: covariances cannot tell, since they presuppose it.

Each check follows a quantity whose behaviour is known while sensors and model are right, whatever the rail does. It
raises a doubt long before the estimate's own deviation would have grown.
"""

from enum import StrEnum
from math import inf, sqrt

from brake_monitor.estimation.doubts.dead_force import DeadForce
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
GROSS_NIS = 25.0  # what no pull, no line and no coarse steps of a vehicle speed make for long
DOUBT_S = 3.0  # how long a doubt outlasts its reason: as long as a start takes to settle
TAUGHT_S = 3.0  # wheel speeds that scatter for so long have spoilt all that slides teach of friction
TIMING_DOUBT_S = 10.0  # only changes of the force show its timing: many must have been in step to end the doubt

# Each `Doubt` as a number, in their order.
BIASED, SCATTERED, OUT_OF_STEP, STILL, UNEXPLAINED, REPEATED, DEAD, SEIZES = range(8)
LASTS_S = (DOUBT_S, DOUBT_S, TIMING_DOUBT_S, DOUBT_S, DOUBT_S, DOUBT_S, DOUBT_S, DOUBT_S)


class Doubt(StrEnum):
    """Why an estimate whose covariance is small is not to be believed."""

    BIASED = "speed contradicts forces"
    SCATTERED = "wheel speeds scatter"
    OUT_OF_STEP = "pressing force out of step"
    STILL = "pressing force still in a slide"
    UNEXPLAINED = "unexplained deceleration"
    REPEATED = "all speeds stand still"
    DEAD = "pressing force repeats itself"
    SEIZES = "a wheelset seizes"


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
    def doubtful_sigmas(self) -> float:
        """By how much it does; below 0 where the wagon slows down more than the model says."""
        return self._mean_sigmas if self.is_doubtful else 0.0

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
        return self.is_large

    @property
    def is_large(self) -> bool:
        """Whether they scatter too much now."""
        return self._mean_nis > SCATTERED_NIS

    @property
    def is_gross(self) -> bool:
        """Whether they scatter so much that their sensor is to blame, and not the model."""
        return self._mean_nis > GROSS_NIS


class WheelChecks:
    """The checks of one wheelset."""

    def __init__(self) -> None:
        self.scatter = Scatter()
        self.timing = ForceTiming()
        self.still = StillForce()
        self.dead = DeadForce()


class Consistency:
    """The checks of one wagon, and when each last raised its doubt."""

    def __init__(self) -> None:
        self.bias = Bias()
        self.scatter = Scatter()  # of the vehicle's speed
        self.speeds = StillSpeeds()
        self.raised_s = [-inf] * len(Doubt)  # when each doubt was last raised; -inf: never, or that has been dealt with
        self.scattered_from_s = -inf

    def is_on(self, doubt: int, time_s: float) -> bool:
        """Whether there is such a doubt."""
        return time_s - self.raised_s[doubt] < LASTS_S[doubt]

    def is_over(self, doubt: int, time_s: float) -> bool:
        """Whether there was such a doubt, and it has not been dealt with since."""
        return -inf < self.raised_s[doubt] <= time_s - LASTS_S[doubt]

    def see_speed(self, time_s: float, residual: float, variance: float) -> bool:
        """Take an innovation of the vehicle speed; True when it contradicts the model, which starts anew then."""
        self.bias.see(residual, variance)
        self.scatter.see(residual * residual / variance)
        if not self.bias.is_doubtful:
            return False
        self.raised_s[BIASED] = time_s
        if not self.bias.is_contradictory:
            return False
        self.bias.restart()
        return True

    def see_outlying_speed(self) -> None:
        """Take a reading of the vehicle's speed that was no news of it."""
        self.scatter.see(LARGEST_NIS)

    def see_wheel(self, time_s: float, wheel: WheelChecks, nis: float, omega_radps: float, slides: float) -> None:
        """Take a wheelset's speed, its normalised innovation squared, and whether the wheelset slides (1 or 0)."""
        if wheel.scatter.see(nis):
            if not self.is_on(SCATTERED, time_s):
                self.scattered_from_s = time_s
            self.raised_s[SCATTERED] = time_s
        if wheel.timing.see(time_s, omega_radps, slides):
            self.raised_s[OUT_OF_STEP] = time_s

    def see_force(
        self, time_s: float, wheel: WheelChecks, pressing_force_n: float, slip: float, speed_mps: float
    ) -> None:
        """Take a pressing force with slip and speed: a wheelset slides anew only if its force has moved.

        Slip that goes to and fro with a vehicle speed that scatters is none.
        """
        if self.scatter.is_gross:
            return
        if wheel.still.see(time_s, pressing_force_n, slip, speed_mps):
            self.raised_s[STILL] = time_s

    def taught_wrongly(self, time_s: float) -> float:
        """Which share, 0 to 1, of what wheel speeds and forces have taught is wrong, of doubts in them that are over.

        That is still part of the estimate. Wheel speeds that scattered for a moment have taught little.
        """
        for doubt in (OUT_OF_STEP, STILL, REPEATED, DEAD, SEIZES):
            if self.is_over(doubt, time_s):
                return 1.0
        scattered_for_s = self.raised_s[SCATTERED] - self.scattered_from_s
        return min(scattered_for_s / TAUGHT_S, 1.0) if self.is_over(SCATTERED, time_s) else 0.0

    def deal_with_doubts(self, time_s: float) -> None:
        """Note that what was taught wrongly until now has been allowed for."""
        for doubt in (SCATTERED, OUT_OF_STEP, STILL, REPEATED, DEAD, SEIZES):
            if self.is_over(doubt, time_s):
                self.raised_s[doubt] = -inf

    def see_deceleration(self, time_s: float, deceleration_mps2: float, largest_mps2: float) -> None:
        """Take the unmodelled deceleration, or a part of it, and the largest that is explained."""
        if abs(deceleration_mps2) > largest_mps2:
            self.raised_s[UNEXPLAINED] = time_s

    def set_back(self, by_s: float) -> None:
        """Note that the clock was set back by so much."""
        self.scattered_from_s -= by_s
        for doubt in range(len(self.raised_s)):
            self.raised_s[doubt] -= by_s

    def doubts(self, time_s: float) -> int:
        """What is in doubt now, a bit for each `Doubt` in order: see `in_words`."""
        bits = 0
        for doubt in range(len(self.raised_s)):
            if self.is_on(doubt, time_s):
                bits += 1 << doubt
        return bits


def in_words(doubts: int) -> tuple[Doubt, ...]:
    """The doubts whose bits are set in a number by `Consistency.doubts`."""
    return tuple([doubt for k, doubt in enumerate(Doubt) if doubts >> k & 1])
