"""How much the line's gradient changes by the way, from how the wagon runs while nothing brakes it.

Under the brake a change of gradient looks like one of friction. How likely that is depends on the line: d walks by the
way with a density of some (5 ‰ g)² in 700 m where it is hilly, and by nothing where it is level. Over two stretches of
L metres one after the other the mean of such a walk changes with a variance of 2/3 of the density times L.
"""

STRETCH_S = 5.0  # long against the speed's noise
PRIOR_M = 500.0  # of the way that what is configured is worth
MEMORY_M = 10_000.0
PER_STRETCH = 1.5
SPEEDS_IN_CHANGE = 6.0  # variances of v: of v_2 - 2 v_1 + v_0
LARGEST = 2e-5  # (m/s²)²/m, of d; more is no gradient


class Hilliness:
    """Compares what slows the wagon down, beside what is known, from stretch to stretch."""

    def __init__(self, configured: float) -> None:
        self.density = configured  # (m/s²)²/m, of d; 0 stays 0: d is held to walk otherwise
        self._way_m = PRIOR_M  # that this is known from
        self._runs = False  # a stretch does, ...
        self._begun_mps = 0.0
        self._passed_s = self._run_m = 0.0
        self._known_mps = 0.0  # ... in which known gradients have taken so much
        self._may_compare = False  # with the stretch just before
        self._before_mps2 = 0.0

    def interrupt(self) -> None:
        """What comes now says nothing of the line."""
        self._runs = self._may_compare = False

    def see_coasting(self, speed_mps: float, variance: float, known_mps2: float, step_s: float) -> None:
        """Take v and its variance after a step in which nothing braked nor drove, and what known gradients took."""
        if not self._runs:
            self._begin(speed_mps)
            return
        self._passed_s += step_s
        self._run_m += speed_mps * step_s
        self._known_mps += known_mps2 * step_s
        if self._passed_s >= STRETCH_S:
            self._end(speed_mps, variance)
            self._begin(speed_mps)

    def _begin(self, speed_mps: float) -> None:
        self._runs, self._begun_mps = True, speed_mps
        self._passed_s = self._run_m = self._known_mps = 0.0

    def _end(self, speed_mps: float, variance: float) -> None:
        slowed_mps2 = (self._begun_mps - speed_mps - self._known_mps) / self._passed_s
        if self._may_compare:
            change_mps2 = slowed_mps2 - self._before_mps2
            noise = SPEEDS_IN_CHANGE * variance / (self._passed_s * self._passed_s)
            walked = PER_STRETCH * max(change_mps2 * change_mps2 - noise, 0.0)
            self._way_m = min(self._way_m + self._run_m, MEMORY_M)
            self.density = min(self.density + (walked - self.density * self._run_m) / self._way_m, LARGEST)
        self._may_compare, self._before_mps2 = True, slowed_mps2
