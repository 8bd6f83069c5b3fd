"""Memory failing: the gateway's disk is full, read-only or gone, and what is to outlive the daemon is not written."""

from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.observation import Observation
from brake_monitor.monitoring.rule import FINE, Finding, Verdict
from brake_monitor.settings.alarm_settings import MemoryFailingRule


class MemoryFailing:
    """Passes on what the memory says of itself; in a replay there is none."""

    kind = "memory_failing"
    wheelsets = (None,)

    def __init__(self, settings: MemoryFailingRule) -> None:
        self.settings = settings

    def judge(self, seen: Observation) -> tuple[Verdict]:
        """Judge the gateway."""
        if not seen.memory_failure:
            return (FINE,)
        message = f"The memory cannot be written: {seen.memory_failure}; a restart would lose what is new."
        return (Finding(Severity.WARNING, message, {"reason": seen.memory_failure}),)
