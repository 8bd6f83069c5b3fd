"""Memory failing: the gateway's disk is full, read-only or gone, and what is to outlive the daemon is not written."""

from math import inf

from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, Finding, Rule, Verdict
from brake_monitor.settings.alarm_settings import MemoryFailingRule

AGAIN_S = 10.0  # on a disk with hardly any room some of what is written fails


class MemoryFailing(Rule[MemoryFailingRule]):
    """Passes on what the memory says of itself; in a replay there is none."""

    kind = "memory_failing"

    def __init__(self, settings: MemoryFailingRule) -> None:
        super().__init__(settings)
        self._reason = ""  # of the last failure, ...
        self._failed_s = -inf  # ... when that was, ...
        self._fails_again = False  # ... and whether it came soon after another one
        self._fails = False

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """Judge the gateway. One that works for moments only, fails."""
        is_soon = 0.0 <= seen.time_s - self._failed_s <= AGAIN_S
        if seen.memory_failure:
            self._fails_again = self._fails_again if self._fails else is_soon
            self._reason, self._failed_s = seen.memory_failure, seen.time_s
        self._fails = bool(seen.memory_failure)
        if not (self._fails or (self._fails_again and is_soon)):
            return (FINE,)
        message = f"The memory cannot be written: {self._reason}; a restart would lose what is new."
        return (Finding(Severity.WARNING, message, {"reason": self._reason}),)
