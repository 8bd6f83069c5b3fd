"""Whether a speed stands still while another that must go along with it moves."""

from math import inf

FROZEN_S = 1.0  # longer than a slow satellite receiver repeats its last fix
FROZEN_READINGS = 10
MOVED_SIGMAS = 10.0  # of the reading's noise, quantisation included: about three of its smallest steps


class FrozenReading:
    """Notices a speed that repeats itself to the last bit while another that must go along with it moves.

    Noise and quantisation of a live sensor hardly let it repeat itself for FROZEN_S. Once frozen a reading stays so
    until it changes, even as the other speed passes by its value.
    """

    def __init__(self, noise_std: float) -> None:
        self.repeats = False  # the last reading says what the one before said, ...
        self.turns = False  # ... or moves against the way that the speed moved before, as noise does
        self._least_move = MOVED_SIGMAS * noise_std
        self._value = inf
        self._moved = 0.0  # the last change of its value
        self.since_s = 0.0  # since when the reading has repeated itself
        self._reference = inf  # the other speed when the value began to repeat itself; inf: not known then
        self._repeated = 0
        self._is_frozen = False

    def see(self, time_s: float, value: float, reference: float, is_known: bool) -> bool:
        """Take a reading, and in its unit the reference that it has to follow; True while the reading is frozen."""
        self.repeats, self.turns = value == self._value, False
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
            self._is_frozen = (
                self._repeated >= FROZEN_READINGS
                and time_s - self.since_s >= FROZEN_S
                and abs(reference - self._reference) > self._least_move
            )
        return self._is_frozen
