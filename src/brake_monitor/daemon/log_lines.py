"""How events are logged: one line each, with a priority where the journal listens, and no flood of the same event."""

import json
import logging
import os
import time
from collections.abc import Callable
from typing import Literal, TextIO

LogFormat = Literal["text", "json"]

ALIKE_MOST = 20  # of one kind are logged within the period; what is more is counted
ALIKE_PERIOD_S = 60.0

# sd-daemon(3): "<n>" before a line is its syslog priority.
_PRIORITIES = {logging.CRITICAL: 2, logging.ERROR: 3, logging.WARNING: 4, logging.INFO: 6, logging.DEBUG: 7}


def log_to(stream: TextIO, level: str, log_format: LogFormat) -> None:
    """Log everything from the level on to the stream, from now on."""
    handler = logging.StreamHandler(stream)
    handler.setFormatter(_Lines(log_format, for_journal=is_journal(stream)))
    handler.addFilter(Flood())
    logging.basicConfig(level=level.upper(), handlers=[handler], force=True)
    logging.getLogger("can").setLevel(logging.CRITICAL)  # python-can logs errors that it also raises


def is_journal(stream: TextIO) -> bool:
    """Whether the stream ends in the journal of systemd, which says so in the environment (systemd.exec(5))."""
    try:
        status = os.fstat(stream.fileno())
    except OSError:
        return False
    return os.environ.get("JOURNAL_STREAM") == f"{status.st_dev}:{status.st_ino}"


class _Lines(logging.Formatter):
    def __init__(self, log_format: LogFormat, *, for_journal: bool) -> None:
        super().__init__("%(levelname)s %(name)s: %(message)s")
        self._is_json = log_format == "json"
        self._for_journal = for_journal

    def format(self, record: logging.LogRecord) -> str:
        line = as_json(record) if self._is_json else " ".join(super().format(record).splitlines())
        return f"<{_PRIORITIES.get(record.levelno, 6)}>{line}" if self._for_journal else line


def as_json(record: logging.LogRecord) -> str:
    """One JSON object: `time_s` (Unix), `level`, `logger`, `message`; `error` with the traceback if there is one."""
    event = {
        "time_s": round(record.created, 6),
        "level": record.levelname.lower(),
        "logger": record.name,
        "message": record.getMessage(),
    }
    if record.exc_info:
        event["error"] = logging.Formatter().formatException(record.exc_info)
    return json.dumps(event, ensure_ascii=False)


class Flood(logging.Filter):
    """Lets so many events of a kind pass in a period, whatever their details, and then tells how many did not."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        super().__init__()
        self._clock = clock
        self._kinds: dict[tuple[str, str], tuple[float, int]] = {}  # when its period began, how many since

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the event is logged."""
        kind, now_s = (record.name, str(record.msg)), self._clock()
        begun_s, count = self._kinds.get(kind, (now_s, 0))
        if now_s - begun_s >= ALIKE_PERIOD_S:
            if count > ALIKE_MOST:
                record.msg = f"{record.msg} ({count - ALIKE_MOST} more like this were not logged)"
            begun_s, count = now_s, 0
        self._kinds[kind] = (begun_s, count + 1)
        return count < ALIKE_MOST
