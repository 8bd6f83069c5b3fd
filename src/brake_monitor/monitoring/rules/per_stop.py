"""Verdicts that stand from the end of one brake application to the end of the next."""

from abc import ABC, abstractmethod

from brake_monitor.monitoring.brake_units.stop_record import StopRecord
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import UNKNOWN, Verdict

Stops = tuple[StopRecord, ...]


class PerStop(ABC):
    """Judges each wheelset only when a brake application has ended; before the first one nothing is known."""

    def __init__(self, wheelset_count: int) -> None:
        self.places = tuple(range(1, wheelset_count + 1))
        self._last: StopRecord | None = None
        self._verdicts: tuple[Verdict, ...] = (UNKNOWN,) * wheelset_count

    def judge(self, seen: Observation) -> tuple[Verdict, ...]:
        """One verdict per wheelset."""
        stops = seen.brakes.stops
        if stops and stops[-1] is not self._last:
            self._last = stops[-1]
            self._verdicts = tuple(self._judge_stops(i, stops) for i in range(len(self._verdicts)))
        return self._verdicts

    @abstractmethod
    def _judge_stops(self, i: int, stops: Stops) -> Verdict:
        """Judge wheelset i, from 0, by these applications, oldest first."""
