"""Verdicts that stand from the end of one brake application to the end of the next."""

from abc import ABC, abstractmethod
from itertools import takewhile
from typing import Generic, TypeVar

from brake_monitor.monitoring.brake_units.stop_record import StopRecord
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, UNKNOWN, Verdict
from brake_monitor.settings.alarm_settings import RuleSettings

Stops = tuple[StopRecord, ...]
Settings = TypeVar("Settings", bound=RuleSettings)


class PerStop(ABC, Generic[Settings]):
    """Judges each wheelset only when a brake application has ended, or pads were fitted.

    Before the first application nothing is known.
    """

    def __init__(self, settings: Settings, friction_nominal: float, wheelset_count: int) -> None:
        self.settings = settings
        self.wheelsets = tuple(range(1, wheelset_count + 1))
        self._nominal = friction_nominal
        self._last: StopRecord | None = None
        self._fitted_s: list[float | None] = []  # when each wheelset's pads were
        self._verdicts: tuple[Verdict, ...] = (UNKNOWN,) * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        stops, pads = seen.brakes.stops, [unit.pads for unit in seen.brakes.units]
        fitted_s = [own.fitted_time_s for own in pads]
        if stops and (stops[-1] is not self._last or fitted_s != self._fitted_s):
            self._last, self._fitted_s = stops[-1], fitted_s
            comparable = _comparable(stops)
            self._verdicts = tuple(self._judge_stops(i, comparable, pads[i]) for i in range(len(self.wheelsets)))
        return self._verdicts

    @abstractmethod
    def _judge_stops(self, i: int, stops: Stops, pads: PadWear) -> Verdict:
        """Judge wheelset i, from 0, which has these pads, by these applications, oldest first."""


class PerStopOfPads(PerStop[Settings]):
    """Judges each wheelset's pads by their own applications: what those before them rubbed says nothing of them."""

    def _judge_stops(self, i: int, stops: Stops, pads: PadWear) -> Verdict:
        if pads.fitted_time_s is None:  # since the monitor was installed
            return self._judge_pads(i, stops)
        own = round(pads.since_fitted.stops)  # the clock may have been wrong then, or since
        return self._judge_pads(i, stops[-own:]) if own else FINE  # nothing speaks against pads just fitted

    @abstractmethod
    def _judge_pads(self, i: int, stops: Stops) -> Verdict:
        """Judge the pads of wheelset i, from 0, by these applications, oldest first."""


def _comparable(stops: Stops) -> Stops:
    """Those since the last one whose friction was told by another mass, force or brake radius."""
    alike = takewhile(lambda stop: stop.calibration in (None, stops[-1].calibration), reversed(stops))
    return tuple(alike)[::-1]
