"""Alarms as JSON lines: one object per alarm, as it stands at the end of a recording."""

import msgspec

from brake_monitor.monitoring.alarm import Alarm

AGREED = ("kind", "wheelset", "severity", "raised_time_s", "cleared_time_s", "message")


def line(alarm: Alarm) -> str:
    """The agreed keys first, then what else an alarm carries; times in seconds on the recording's own time base."""
    values = msgspec.to_builtins(alarm)
    first = {key: values.pop(key) for key in AGREED}
    return msgspec.json.encode(first | values).decode()
