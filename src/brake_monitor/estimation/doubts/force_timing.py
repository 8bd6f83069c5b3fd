"""Whether readings of a pressing force and of its wheelset's speed are of the same moment, from what they do in slides.

A wheelset that slides obeys its brake at once (6): J dω/dt = r mu_w N - r_b mu_b F, and slide protection moves F all
the time. So dω/dt repeats F upside down, and how much later one is told than the other is where their correlation is
strongest. Whatever friction the filter believes in does not matter, nor does the rail, which changes more slowly: both
are compared with their own mean of the last tenth of a second.
"""

from math import inf, sqrt

EARLIEST, LATEST = 6, 6  # readings by which a force may be told before its effect on the wheel speed, and after
LAGS = EARLIEST + LATEST + 1
LEAST_SPACING_S, LARGEST_SPACING_S = 0.018, 0.15  # between readings that are compared
MEAN_S = 0.1
MEMORY = 0.995  # of the sums over readings, per reading: they are over ...
READINGS_REMEMBERED = 200.0  # ... so many at most
READINGS_NEEDED = 40
LEAST_CORRELATION = 0.75  # in step or not it is 0.8 to 0.99, ...
SHAKEN_CORRELATION, BETTER = 0.5, 0.25  # ... less if more shakes a wheelset: by so much above what was believed
FEW_READINGS, CORRELATION_OF_FEW = 15, 0.9
MORE_UNEXPLAINED = 1.25  # of the acceleration, if they were in step: a brake that is only put on fits with any lag
SHORT_S, MUCH_MORE_UNEXPLAINED = 0.04, 2.5  # a rail that gives more with slip makes a force look up to 0.03 s late
TURNED = 0.5  # of the force's typical departure from its mean, beyond which it has turned ...
TURNS_NEEDED = 4  # with slides begun: on a rail that fades meanwhile, one vent fits a lag of -0.06 s best
IN_A_ROW = 10  # readings that say the same: a rail that changes at once misleads for some
PLAIN_READINGS, PLAIN_CORRELATION, PLAINLY_UNEXPLAINED, PLAIN_IN_A_ROW = 10, 0.95, 14.0, 5  # where there is no doubt
LATE_S, EARLY_S = 0.012, 0.02  # a rail that gives way with slip makes a force come up to 0.016 s early, none 0.008 late


class ForceTiming:
    """Correlates one wheelset's pressing force with its angular acceleration."""

    def __init__(self) -> None:
        self.lag_s = 0.0  # by which the force is told later than the wheel speed
        self.readings = 0  # compared so far
        self._turns = 0  # of the force meanwhile, and slides that they were in
        self._rises = 0.0  # 1 after it has turned up, -1 after it has turned down
        self.correlation = 0.0  # where it is strongest
        self._is_apart = False  # force and speed are out of step, as far as was last known, ...
        self._believed = EARLIEST  # ... by this lag, in readings from the earliest
        self._otherwise = 0  # readings in a row that contradict `_is_apart`
        self._plainly = 0  # readings in a row that show plainly that force and speed are apart
        self._seen_s = -inf
        self._last_radps = 0.0
        self._impulse_ns = 0.0  # ∫F dt since the last wheel speed
        self._is_followed = False  # `press` has told of it
        self._in_a_row = 0  # wheel speeds between which it has
        self._slid_in_a_row = 0  # ... the last of them in one slide
        self._spacing_s = 0.0  # mean
        self._spin_mean = self._force_mean = 0.0
        self._spins = [0.0] * LAGS  # the last ones, less their means
        self._slides = [0.0] * LAGS  # 1 for those in a slide
        self._forces = [0.0] * LAGS
        self._products = [0.0] * LAGS  # sums over readings, by lag
        self._squares = [0.0] * LAGS  # of the forces; a slide is short, and its end is not like its beginning
        self._spin_square = 0.0
        self._fits = [0.0] * LAGS  # correlations, ...
        self._best = EARLIEST  # ... and where they are strongest

    def press(self, impulse_ns: float) -> None:
        """Take ∫F dt of a step in which the wheelset slides, or did lately."""
        self._impulse_ns += impulse_ns
        self._is_followed = True

    def see(self, time_s: float, omega_radps: float, slides: float) -> bool:
        """Take a wheel speed, and whether its wheelset slides (1 or 0); True while it does and is out of step.

        What its force does before a slide and after it counts as well: a quick slide protection lets it last for less
        than a lag.
        """
        passed_s = time_s - self._seen_s
        if not self._is_followed or not 0.0 < passed_s <= LARGEST_SPACING_S:
            self._in_a_row = self._slid_in_a_row = 0
        elif passed_s < LEAST_SPACING_S:
            return False
        else:
            self._compare((omega_radps - self._last_radps) / passed_s, self._impulse_ns / passed_s, passed_s, slides)
        self._seen_s = time_s if self._is_followed else -inf
        self._last_radps = omega_radps
        self._impulse_ns = 0.0
        self._is_followed = False
        return self._slid_in_a_row > 1 and self._is_apart

    @property
    def is_known(self) -> bool:
        """Whether slides have shown by how much the force comes late."""
        return self._is_clearly_better_than(EARLIEST)

    def _is_clearly_better_than(self, lag: int) -> bool:
        """Whether the best correlation is high enough by itself, or stands out against that at another lag."""
        if self._turns < TURNS_NEEDED:
            return False
        if self.readings < READINGS_NEEDED:
            return self.readings >= FEW_READINGS and self.correlation >= CORRELATION_OF_FEW
        is_peak = 0 < self._best < LAGS - 1  # else the search's end
        least = max(SHAKEN_CORRELATION, min(LEAST_CORRELATION, self._fits[lag] + BETTER))
        return self.correlation >= (least if is_peak else LEAST_CORRELATION)

    def _compare(self, spin_radps2: float, force_n: float, passed_s: float, slides: float) -> None:
        self._slid_in_a_row = self._slid_in_a_row + 1 if slides != 0.0 else 0
        obeys = self._slid_in_a_row > 1  # it did over all of the time between the readings
        if self._in_a_row == 0:
            self._force_mean, self._spacing_s = force_n, passed_s
        if self._slid_in_a_row == 2:
            self._spin_mean = spin_radps2
        share = passed_s / (MEAN_S + passed_s)
        self._spin_mean += share * (spin_radps2 - self._spin_mean)
        self._force_mean += share * (force_n - self._force_mean)
        self._spacing_s += share * (passed_s - self._spacing_s)
        newest = self._in_a_row % LAGS
        self._slides[newest] = 1.0 if obeys else 0.0
        self._spins[newest] = spin_radps2 - self._spin_mean
        self._forces[newest] = force_n - self._force_mean
        self._in_a_row += 1
        if self._in_a_row >= LAGS and self._slides[(newest + 1 + EARLIEST) % LAGS] != 0.0:
            self._correlate(newest + 1)

    def _correlate(self, oldest: int) -> None:
        spin, best = self._spins[(oldest + EARLIEST) % LAGS], 0
        self._spin_square = MEMORY * self._spin_square + spin * spin
        for lag in range(LAGS):
            force = self._forces[(oldest + lag) % LAGS]
            self._products[lag] = MEMORY * self._products[lag] - spin * force
            self._squares[lag] = MEMORY * self._squares[lag] + force * force
            power = self._squares[lag] * self._spin_square
            self._fits[lag] = self._products[lag] / sqrt(power) if power > 0.0 else 0.0
            if self._fits[lag] > self._fits[best]:
                best = lag
        self.readings += 1
        self._count_turns(oldest)
        self._best = best
        self.correlation = self._fits[best]
        self.lag_s = (best - EARLIEST + self._beside(best)) * self._spacing_s
        unexplained, in_step = 1.0 - self.correlation**2, 1.0 - self._fits[EARLIEST] ** 2
        more = MORE_UNEXPLAINED if abs(self.lag_s) > SHORT_S else MUCH_MORE_UNEXPLAINED
        is_apart = not -EARLY_S <= self.lag_s <= LATE_S and in_step > more * unexplained
        is_plain = self.readings >= PLAIN_READINGS and self.correlation >= PLAIN_CORRELATION
        is_plain = is_plain and is_apart and in_step > PLAINLY_UNEXPLAINED * unexplained
        self._plainly = self._plainly + 1 if is_plain else 0
        is_otherwise = is_apart != self._is_apart and self._is_clearly_better_than(self._believed)
        self._otherwise = self._otherwise + 1 if is_otherwise else 0
        if self._otherwise >= IN_A_ROW or self._plainly >= PLAIN_IN_A_ROW:
            self._is_apart, self._believed = is_apart, best if is_apart else EARLIEST

    def _count_turns(self, oldest: int) -> None:
        """Count as a slide begins, and as the force, less its mean, turns up or down."""
        force_n = self._forces[(oldest + EARLIEST) % LAGS]
        if self._slides[(oldest + EARLIEST - 1) % LAGS] == 0.0:
            self._turns += 1
        typical_n = sqrt(self._squares[EARLIEST] / min(self.readings, READINGS_REMEMBERED))
        if abs(force_n) > TURNED * typical_n and force_n * self._rises <= 0.0:
            self._rises = 1.0 if force_n > 0.0 else -1.0
            self._turns += 1

    def _beside(self, best: int) -> float:
        """How far the peak of correlation is from the lag `best`, in lags, by the parabola through three of them."""
        if best in (0, LAGS - 1):
            return 0.0
        before, after = self._fits[best - 1], self._fits[best + 1]
        bend = 2.0 * self._fits[best] - before - after
        return 0.5 * (after - before) / bend if bend > 0.0 else 0.0
