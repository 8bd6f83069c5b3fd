"""Whether a wheel speed spikes now and then: readings that are off by more than noise, and back with the next one.

A wheelset that begins to slide, or finds hold, surprises too, and is believed at once; it does not come back within a
reading. Where readings were seen to do so lately, whatever surprises has to be borne out by the next reading.
"""

from math import exp, inf

LATELY_S = 10.0
SPIKES_NEEDED = 1.5  # lately; rails that are rough make one in a hundred seconds look like it
BACK = 0.5  # of what the reading was off by, within which the next one is back
NEXT_S = 0.15  # reading


class SpikeWatch:
    """Counts the spikes of one wheelset's speed."""

    def __init__(self) -> None:
        self.awaits = False  # the reading after one that surprised
        self._spikes = 0.0  # lately
        self._spiked_s = -inf
        self._reading_radps = 0.0  # the last reading that surprised
        self._off_radps = 0.0  # ... from what was foretold
        self._taken = False  # it was
        self._seen_s = -inf

    def note(self, time_s: float, reading_radps: float, residual: float, taken: bool) -> None:
        """Note a reading that surprised, and whether it was taken for true."""
        self._seen_s, self._reading_radps, self._off_radps = time_s, reading_radps, residual
        self._taken, self.awaits = taken, True

    def see_next(self, time_s: float, reading_radps: float, residual: float) -> bool:
        """See by its innovation whether the reading after one that surprised is back; whether that was taken for true.

        Then this one is off the other way, by once to twice as much: what was taken for a pull of the rail goes on.
        A wheelset that finds hold and rolls is not where its pull foretold it to be either, but does not come back.
        """
        self.awaits = False
        came_back = (self._reading_radps - reading_radps) / self._off_radps
        off = residual / self._off_radps
        goes_on = -2.0 - BACK < off < -1.0 + BACK if self._taken else -BACK < off < BACK
        is_spike = 0.0 < time_s - self._seen_s < NEXT_S and came_back > BACK and goes_on
        if is_spike:
            self._spikes = self._lately(time_s) + 1.0
            self._spiked_s = time_s
        return is_spike and self._taken

    def is_on(self, time_s: float) -> bool:
        """Whether readings that surprise are to be borne out."""
        return self._lately(time_s) >= SPIKES_NEEDED

    def _lately(self, time_s: float) -> float:
        passed_s = time_s - self._spiked_s
        return self._spikes * exp(-passed_s / LATELY_S) if 0.0 <= passed_s < inf else 0.0
