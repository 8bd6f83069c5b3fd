"""Whether a wheel speed spikes now and then: readings that are off by more than noise, and back with the next one.

A wheelset that begins to slide, or finds hold, surprises too, but its speed does not come back within a reading: it is
believed at once. Only where readings have come back lately, a surprise has to be borne out by the next reading.
"""

from math import exp, inf

LATELY_S = 10.0
SPIKES_NEEDED = 1.5  # lately; rails that are rough make one in a hundred seconds look like it
BACK = 0.5  # of what the reading was off by, within which the next one is back
NEXT_S = 0.15  # within which the next reading must come to be compared


class SpikeWatch:
    """Counts the spikes of one wheelset's speed."""

    def __init__(self) -> None:
        self.awaits = False  # the reading after one that surprised
        self._spikes = 0.0  # lately
        self._spiked_s = -inf
        self._reading_radps = 0.0  # the last reading that surprised
        self._off_radps = 0.0  # ... and its residual
        self._taken = False  # ... and whether it was taken for true
        self._seen_s = -inf  # ... and its time

    def note(self, time_s: float, reading_radps: float, residual: float, taken: bool) -> None:
        """Note a reading that surprised, and whether it was taken for true."""
        self._seen_s, self._reading_radps, self._off_radps = time_s, reading_radps, residual
        self._taken, self.awaits = taken, True

    def see_next(self, time_s: float, reading_radps: float, residual: float) -> bool:
        """Take the reading after one that surprised; True if that one was a spike, and was taken for true.

        After a spike the reading comes back to where it was. Its residual is about 0 if the spike was held back. If the
        spike was taken for true, so was a pull of the rail that goes on in the prediction: the residual is once to
        twice the spike's, the other way. A wheelset that finds hold and rolls leaves its prediction too, but its
        reading does not come back.
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
        return self._spikes * exp(-passed_s / LATELY_S) if passed_s >= 0.0 else 0.0
