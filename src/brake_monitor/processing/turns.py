"""When a pipeline has something to do: to let the rules look, to give out an estimate. Time is the frames'."""

from math import floor, inf, isnan, nan

from brake_monitor.frame import MOST_LATE_S
from brake_monitor.monitoring.observation import OBSERVATION_PERIOD_S

BLIND_S = 0.5  # an estimate without any reading for longer says so


class Turns:
    """How far time has gone, and in which turns something was last given out.

    A turn is the number of a period since the first mapped frame: of the rules' looks, or of estimates given out.
    """

    def __init__(self, rate_hz: float) -> None:
        """`rate_hz` is that of estimates; 0: every fused frame, and one a second when blind."""
        self.rate_hz = rate_hz
        self.begun_s = nan  # from when periods count; NaN: not yet
        self.taken_s = 0.0  # when time last went on
        self.fused_s = 0.0  # when a sample was last fused
        self.latest_s = 0.0  # how far time had gone when something was last fused, late frames apart
        self.observed = -inf  # turn that the rules looked in last; the first may be -1, where frames come late
        self.given = -inf  # turn that an estimate was last given out in

    @property
    def have_begun(self) -> bool:
        """Whether time has gone on at all."""
        return not isnan(self.begun_s)

    @property
    def is_blind(self) -> bool:
        """Whether nothing was fused for long; a clock that was set back does not undo a silence."""
        return abs(self.taken_s - self.fused_s) > BLIND_S

    @property
    def due_s(self) -> float:
        """Before which time no frame makes anything due."""
        if self.rate_hz == 0.0 or not self.have_begun:
            return self.taken_s
        return self.begun_s + min((self.observed + 1) * OBSERVATION_PERIOD_S, (self.given + 1) / self.rate_hz)

    def go_on(self, time_s: float, fused_s: float | None) -> None:
        """Let time go on; `fused_s`: when a sample was last fused meanwhile."""
        self.taken_s = time_s
        if not self.have_begun:
            self.begun_s = self.fused_s = time_s
        if fused_s is not None:
            self.fused_s = fused_s

    def come_to(self, time_s: float) -> float:
        """How far time has gone: no period begins again for a frame that came late."""
        if not 0.0 < self.latest_s - time_s <= MOST_LATE_S:
            self.latest_s = time_s
        return self.latest_s

    def look(self) -> bool:
        """Begin the turn of the rules' looks; whether it is a new one."""
        turn, before = floor((self.latest_s - self.begun_s) / OBSERVATION_PERIOD_S), self.observed
        self.observed = turn
        return turn != before

    def give(self, is_fused: bool) -> bool:
        """Begin the turn of estimates; whether one is to be given out: at the first chance in each."""
        if self.rate_hz == 0.0 and is_fused:
            return True
        turn, before = floor((self.latest_s - self.begun_s) * (self.rate_hz or 1.0)), self.given
        self.given = turn
        return turn != before
