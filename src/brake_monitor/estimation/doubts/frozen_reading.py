"""Whether a speed stands still while another that must go along with it moves."""

from math import inf, log

FROZEN_S = 1.0  # longer than a slow satellite receiver repeats its last fix
FROZEN_READINGS = 10
MOVED_SIGMAS = 10.0  # of the reading's noise, quantisation included: about three of its smallest steps
HABIT_ABOVE_MPS = 2.0  # below about 1 km/h radars hold their last value
HABIT_READINGS = 100.0  # so many, about, tell how often a sensor repeats itself
LEAST_HABIT = 0.02  # a share of them that is known no better
BY_CHANCE = log(1e-6)  # of a run of repeats, by that share: what is less probable is no chance
SHOWN_SIGMAS = 3.0  # as MOVED_SIGMAS, of a sensor that repeats itself against its habit


class FrozenReading:
    """Notices a speed that repeats itself to the last bit while another that must go along with it moves.

    Noise and quantisation of a live sensor hardly let it repeat itself for FROZEN_S, and one that has hardly repeated
    itself so far not even a few times. Once frozen a reading stays so until it changes, even as the other speed passes
    by its value.
    """

    def __init__(self, noise_std: float) -> None:
        self._habit = 1.0  # the share of its readings that repeat the one before, ...
        self._habit_readings = 1.0  # ... of so many
        self.repeats = False  # the last reading says what the one before said, ...
        self.turns = False  # ... or moves against the way that the speed moved before, as noise does
        self._noise_std = noise_std
        self._value = inf
        self._moved = 0.0  # the last change of its value
        self.since_s = 0.0  # since when the reading has repeated itself
        self._reference = inf  # the other speed when the value began to repeat itself; inf: not known then
        self._repeated = 0
        self._is_frozen = False

    def see(self, time_s: float, value: float, reference: float, is_known: bool, has_habit: bool = False) -> bool:
        """Take a reading, and in its unit the reference that it has to follow; True while the reading is frozen.

        `has_habit`: how often it repeats itself tells how it does while it lives.
        """
        self.repeats, self.turns = value == self._value, False
        if has_habit and not self.repeats and not self._is_frozen:
            self._learn_habit()
        if not self.repeats and self._value < inf:
            moved = value - self._value
            self.turns, self._moved = moved * self._moved < 0.0, moved
        is_new = not self.repeats or time_s < self.since_s  # the clock was set back
        if is_new or (is_known and self._reference == inf):
            self._value, self.since_s, self._repeated, self._is_frozen = value, time_s, 0, False
            self._reference = reference if is_known else inf
            return False
        self._repeated += 1
        if is_known and not self._is_frozen:
            passed = abs(reference - self._reference)
            is_long = self._repeated >= FROZEN_READINGS and time_s - self.since_s >= FROZEN_S
            is_odd = has_habit and self._repeated * log(max(self._habit, LEAST_HABIT)) < BY_CHANCE
            self._is_frozen = (is_long and passed > MOVED_SIGMAS * self._noise_std) or (
                is_odd and passed > SHOWN_SIGMAS * self._noise_std
            )
        return self._is_frozen

    def _learn_habit(self) -> None:
        """Take a reading that does not repeat the one before, and the run of repeats that it ends."""
        readings = self._repeated + 1.0
        self._habit_readings = min(self._habit_readings + readings, HABIT_READINGS)
        weight = min(readings / self._habit_readings, 1.0)
        self._habit += weight * (self._repeated / readings - self._habit)
