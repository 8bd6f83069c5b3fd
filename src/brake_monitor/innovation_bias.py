"""Whether what is measured goes on contradicting what is predicted, in the same direction."""

from math import copysign, sqrt

from brake_monitor.ekf import Innovation

WEIGHT = 0.1  # of the newest innovation: the mean is over about ten
LARGEST_SIGMAS = 7.0  # a single one counts for no more, so that a spike does no harm
BIASED_SIGMAS = 3.0  # a sensor that is noisier than configured stays far below: its innovations change sign


class InnovationBias:
    """Running mean of normalised innovations; zero when model and sensors agree, whatever the noise."""

    def __init__(self) -> None:
        self._mean = 0.0

    def see(self, seen: Innovation) -> bool:
        """Take an innovation; True when model and readings contradict each other, upon which it starts anew."""
        sigmas = min(sqrt(seen.nis), LARGEST_SIGMAS)
        self._mean += WEIGHT * (copysign(sigmas, seen.residual) - self._mean)
        if abs(self._mean) < BIASED_SIGMAS:
            return False
        self._mean = 0.0
        return True
