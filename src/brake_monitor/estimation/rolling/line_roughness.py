"""How much the gradient of a line changes with the way, from what it does between stretches of free rolling.

Under the brake a gradient that changes cannot be told from friction: how far it may have changed has to be known. It
shows beside the brake applications. Where nothing but the line acts on the wagon, d is the line's; its change since it
was so before, squared, by the way in between, is the density of its walk. Flat lines have less than the tuning says:
what is learned only adds to that.
"""

from math import inf

LEAST_WAY_M = 300.0  # between two looks: over less, noise of the sensors changes d as much as a line
LONGEST_WAY_M = 5000.0
PULLED_MPS2 = 0.1  # downhill by 10 per mille; what gains as much speed may be pulled, and does not roll freely then
LARGEST_VARIANCE = 4e-4  # (m/s²)², of d: it has to be known
LARGEST_DENSITY = 2e-5  # (m/s²)²/m: 14 per mille in a kilometre
LARGEST_LOOK = 5e-5  # (m/s²)²/m that one look counts for
PRIOR_M = 3000.0  # of way, for which the tuning's density counts, or one from before a restart
MEMORY_M = 30e3  # of way: one line differs from the next


class LineRoughness:
    """Learns the density of d by the way."""

    def __init__(self, expected: float) -> None:
        """`expected`: (m/s²)²/m, as in `Tuning`; 0 where d is not the line's."""
        self._expected = expected
        self.density = expected  # (m/s²)²/m, as learned so far
        self._seen_m = PRIOR_M  # of way over which it is the mean
        self._looked_m = -inf  # where d was looked at last; -inf: nowhere yet
        self._looked_mps2 = 0.0  # d there, ...
        self._looked_variance = 0.0  # ... and how well it was known

    def see_rolling(self, place_m: float, deceleration_mps2: float, variance: float) -> None:
        """Take d of a wagon that neither brakes nor drives, after `place_m` of way, and its variance."""
        if deceleration_mps2 < -PULLED_MPS2 or variance > LARGEST_VARIANCE or self._expected == 0.0:
            return
        way_m = place_m - self._looked_m
        if way_m < LEAST_WAY_M:
            return
        if way_m <= LONGEST_WAY_M:
            change_mps2 = deceleration_mps2 - self._looked_mps2
            by_line = (change_mps2 * change_mps2 - variance - self._looked_variance) / way_m
            self._seen_m = min(self._seen_m + way_m, MEMORY_M)
            density = self.density + (min(by_line, LARGEST_LOOK) - self.density) * (way_m / self._seen_m)
            self.density = min(max(density, 0.0), LARGEST_DENSITY)
        self._looked_m, self._looked_mps2, self._looked_variance = place_m, deceleration_mps2, variance

    def forget_look(self) -> None:
        """Begin anew: since it was looked at last, d has changed by something else than the line, or unseen."""
        self._looked_m = -inf

    @property
    def more(self) -> float:
        """By how much d's density by the way exceeds the expected one, (m/s²)²/m."""
        return max(self.density - self._expected, 0.0) if self._expected > 0.0 else 0.0
