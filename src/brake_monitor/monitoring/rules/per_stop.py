"""Verdicts that stand from the end of one brake application to the end of the next."""

from collections.abc import Callable

from brake_monitor.monitoring.brake_units.stop_record import StopRecord
from brake_monitor.monitoring.rule import UNKNOWN, Verdict

Stops = tuple[StopRecord, ...]


class PerStop:
    """Judges each wheelset only when a brake application has ended; before the first one nothing is known."""

    def __init__(self, judge: Callable[[int, Stops], Verdict], wheelset_count: int) -> None:
        """`judge` is asked for one wheelset, from 0."""
        self._judge = judge
        self._last: StopRecord | None = None
        self._verdicts: tuple[Verdict, ...] = (UNKNOWN,) * wheelset_count

    def see(self, stops: Stops) -> tuple[Verdict, ...]:
        """One verdict per wheelset, of these applications, oldest first."""
        if stops and stops[-1] is not self._last:
            self._last = stops[-1]
            self._verdicts = tuple(self._judge(i, stops) for i in range(len(self._verdicts)))
        return self._verdicts
