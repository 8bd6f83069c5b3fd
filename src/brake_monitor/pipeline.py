"""The one path: frame → samples → estimate → alarms. No threads, no clock, no I/O: time is the frames'."""

from math import floor
from typing import Self

from msgspec import Struct

from brake_monitor.alarms import Alarm, AlarmRules
from brake_monitor.config import Settings
from brake_monitor.estimator import Estimate, Estimator
from brake_monitor.frame import Frame
from brake_monitor.samples import Sample
from brake_monitor.signals import SignalDecoder


class Outputs(Struct, frozen=True):
    """What one step gave out: an estimate when one was due, and the alarms that changed."""

    estimate: Estimate | None = None
    alarms: tuple[Alarm, ...] = ()


NOTHING = Outputs()
BLIND_S = 0.5  # without any reading for longer, the estimate says so


class Pipeline:
    """Takes frames in the order they were captured; live, replay, simulation and tests all run this object."""

    def __init__(self, settings: Settings, decoder: SignalDecoder) -> None:
        self.decoder = decoder
        self.estimator = Estimator(settings.vehicle, settings.estimator, decoder.channels)
        self.shadow: Estimator | None = None  # takes the same samples, gives nothing out
        self._rules = AlarmRules(settings.alarms)
        self._rate_hz = settings.output.rate_hz
        self._begun_s: float | None = None  # output periods count from the first mapped frame
        self._turn = -1  # number of the last output period that an estimate was given out in
        self._fused_s = 0.0  # when a sample was last fused

    @classmethod
    def from_settings(cls, settings: Settings) -> Self:
        """Load the DBC files and put the stages together; InputError when the mapping does not fit them."""
        return cls(settings, SignalDecoder.from_settings(settings))

    def step(self, frame: Frame) -> Outputs:
        """Take the next frame."""
        samples = self.decoder.decode(frame)
        if not samples:
            return NOTHING
        return self._take(samples, frame.time_s)

    def advance(self, time_s: float) -> Outputs:
        """Nothing arrived until time_s: inputs may have become stale."""
        return self._take(self.decoder.expire(time_s), time_s)

    def _take(self, samples: list[Sample], time_s: float) -> Outputs:
        fused = False
        for sample in (*self.decoder.expire(time_s), *samples):
            fused |= self.estimator.take(sample)
            if self.shadow is not None:
                self.shadow.take(sample)
        if self._begun_s is None:
            self._begun_s = self._fused_s = time_s
        if fused:
            self._fused_s = time_s
        blind = time_s - self._fused_s > BLIND_S
        if not (fused or blind) or not self._is_due(fused, time_s - self._begun_s):
            return NOTHING
        estimate = self.estimator.estimate(time_s if blind else self.estimator.time_s)
        return Outputs(estimate, self._rules.see(estimate))

    def _is_due(self, fused: bool, elapsed_s: float) -> bool:
        """The first chance in each output period; at rate 0 every fused frame, and one a second when blind."""
        if self._rate_hz == 0.0 and fused:
            return True
        turn = floor(elapsed_s * (self._rate_hz or 1.0))
        is_new = turn != self._turn
        self._turn = turn
        return is_new
