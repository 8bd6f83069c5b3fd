"""Whether the vehicle's speed has another scale than before: all wheels seem to have grown or shrunk, by as much.

A radar in snow says too little for minutes. Its wheelsets say so together, each of which rolls against the others as it
did. Wheels do not change within minutes, nor all alike: it is the vehicle's speed, unless all wheels were turned or
changed while the wagon stood.
"""

from collections.abc import Sequence
from math import inf, log
from statistics import fmean

from brake_monitor.estimation.rolling.radius_calibration import TURNED_S
from brake_monitor.monitoring.creep_meter import nearer
from brake_monitor.monitoring.passing_time import Steps

LEAST_SPEED_MPS = 10.0  # below it noise counts too much, ...
STEADY_MPS2 = 0.15  # ... and while the wagon gains or loses more than that, how much the speed lags
TREND_S = 3.0
AVERAGE_S = 1.0
STEADY_S = 3.0  # so long it has rolled freely and steadily, before it teaches or shows anything
KNOWN_S = 15.0  # of such rolling, by when the scale is known, ...
MEMORY_S = 300.0  # ... that is remembered, and by when another scale is the usual one: the first may have been wrong
OFF = 0.03  # relative; satellites and curves do less for as long
ALIKE = 0.01  # the wheelsets beside each other
SHOWS_S = 5.0
AGREES, AGREES_S = 0.015, 3.0  # then it is believed again


class SpeedScale:
    """Sees the speeds of a wagon with several wheelsets at each observation, in order of time."""

    def __init__(self) -> None:
        self.is_off = False  # it is another one
        self._steps = Steps()
        self._rolled_s = -inf
        self._trend_mps = 0.0  # of the wheelsets' mean, behind it by TREND_S
        self._lately: list[float] = []  # of each wheelset, logarithm of its own speed over the vehicle's
        self._usual: list[float] = []
        self._known_s = self._steady_s = 0.0  # of rolling that taught it, and up to now
        self._shows_s = self._agrees_s = 0.0

    def see(self, time_s: float, speed_mps: float, rolling_mps: Sequence[float], *, is_free: bool) -> None:
        """Take the vehicle's speed, those of all wheelsets, and whether these have rolled freely for a while."""
        step_s = self._steps.until(time_s)
        if min(speed_mps, *rolling_mps) < LEAST_SPEED_MPS or not step_s:
            self._lately, self._steady_s, self._agrees_s = [], 0.0, 0.0
            return
        if time_s - self._rolled_s > TURNED_S:
            self.is_off, self._known_s = False, 0.0
        self._rolled_s = time_s
        mean_mps = fmean(rolling_mps)
        now = [log(own_mps / speed_mps) for own_mps in rolling_mps]
        if not self._lately:
            self._trend_mps, self._lately = mean_mps, now
        self._trend_mps += (mean_mps - self._trend_mps) * min(step_s / TREND_S, 1.0)
        self._lately = nearer(self._lately, now, min(step_s / AVERAGE_S, 1.0))
        is_steady = is_free and abs(mean_mps - self._trend_mps) < STEADY_MPS2 * TREND_S
        self._steady_s = self._steady_s + step_s if is_steady else 0.0
        self._judge(step_s)

    def _judge(self, step_s: float) -> None:
        off = [lately - usual for lately, usual in zip(self._lately, self._usual or self._lately, strict=True)]
        most = max(map(abs, off))
        if self._known_s < KNOWN_S:
            if most > OFF and self._steady_s >= STEADY_S:  # begin anew: one of both was wrong
                self._known_s = 0.0
            self._learn(step_s)
            return
        if self.is_off:
            self._agrees_s = self._agrees_s + step_s if most < AGREES else 0.0
            self._shows_s += step_s if self._steady_s >= STEADY_S else 0.0
            self.is_off = self._agrees_s < AGREES_S and self._shows_s < MEMORY_S
            if self._shows_s >= MEMORY_S:
                self._usual, self._known_s = self._lately, KNOWN_S
            return
        shows = self._steady_s >= STEADY_S and min(map(abs, off)) > OFF and max(off) - min(off) < ALIKE
        self._shows_s = self._shows_s + step_s if shows else 0.0
        if self._shows_s >= SHOWS_S:
            self.is_off, self._agrees_s = True, 0.0
        elif most < AGREES:
            self._learn(step_s)

    def _learn(self, step_s: float) -> None:
        if self._steady_s >= STEADY_S:
            self._known_s = min(self._known_s + step_s, MEMORY_S)
            self._usual = nearer(self._usual or self._lately, self._lately, step_s / self._known_s)
