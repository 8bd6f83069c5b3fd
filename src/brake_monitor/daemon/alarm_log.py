"""Alarms in the log: what a person would act on, not each update of what is known."""

import logging
from collections.abc import Iterable

from brake_monitor.monitoring.alarm import Alarm, Severity

log = logging.getLogger(__name__)


class AlarmLog:
    """Logs alarms as they are raised, get graver and are cleared."""

    def __init__(self, logged: Iterable[Alarm]) -> None:
        """`logged`: those that are open, and were logged by an earlier run."""
        self._severity: dict[str, Severity] = {alarm.id: alarm.severity for alarm in logged}  # as logged, by id

    def see(self, alarm: Alarm) -> None:
        """Take an alarm as it stands now."""
        logged = self._severity.get(alarm.id)
        if alarm.cleared_time_s is not None:
            self._severity.pop(alarm.id, None)
            log.info("alarm %s cleared: %s", alarm.id, alarm.message)
        elif logged != alarm.severity:
            self._severity[alarm.id] = alarm.severity
            what = "raised" if logged is None else "is graver"
            log.warning("alarm %s %s, severity %s: %s", alarm.id, what, alarm.severity, alarm.message)
