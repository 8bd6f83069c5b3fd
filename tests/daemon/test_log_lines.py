"""What the journal gets to read."""

import io
import json
import logging
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from brake_monitor.daemon.log_lines import ALIKE_MOST, ALIKE_PERIOD_S, Flood, LogFormat, is_journal, log_to

log = logging.getLogger("brake_monitor.test")


@pytest.fixture
def logged() -> Iterator[Callable[[LogFormat, str], io.StringIO]]:
    """Log to a text of one's own; the root logger is put back afterwards."""
    root, python_can = logging.getLogger(), logging.getLogger("can")
    handlers, levels = root.handlers[:], (root.level, python_can.level)

    def begin(log_format: LogFormat, level: str = "info") -> io.StringIO:
        stream = io.StringIO()
        log_to(stream, level, log_format)
        return stream

    yield begin
    root.handlers[:] = handlers
    root.setLevel(levels[0])
    python_can.setLevel(levels[1])


def test_an_event_is_one_line_whatever_is_in_it(logged: Callable[..., io.StringIO]) -> None:
    stream = logged("text")
    log.warning("bus %s", "front\nis\r\ngone")
    assert stream.getvalue() == "WARNING brake_monitor.test: bus front is gone\n"


def test_events_below_the_level_and_of_python_can_are_not_logged(logged: Callable[..., io.StringIO]) -> None:
    stream = logged("text", "warning")
    log.info("all is well")
    logging.getLogger("can.interfaces").error("it says what it raises as well")
    assert stream.getvalue() == ""


def test_json_lines_are_objects_with_time_level_and_message(logged: Callable[..., io.StringIO]) -> None:
    stream = logged("json")
    log.info('listening on %s\n"front"', "can0")
    try:
        _ = 1 / 0
    except ZeroDivisionError:
        log.exception("it failed")
    first, second = map(json.loads, stream.getvalue().splitlines())
    assert (first["level"], first["logger"]) == ("info", "brake_monitor.test")
    assert first["message"] == 'listening on can0\n"front"'
    assert first["time_s"] > 1.7e9
    assert "error" not in first
    assert second["level"] == "error"
    assert second["error"].endswith("ZeroDivisionError: division by zero")


def test_a_flood_of_the_same_is_cut_and_counted() -> None:
    now_s = 0.0
    flood = Flood(lambda: now_s)

    def event(message: str, detail: int) -> logging.LogRecord:
        return logging.LogRecord("a", logging.WARNING, "", 0, message, (detail,), None)

    passed = [flood.filter(event("bus %d failed", number)) for number in range(100)]
    assert passed.count(True) == ALIKE_MOST
    assert flood.filter(event("something else %d", 0))
    now_s = ALIKE_PERIOD_S
    after = event("bus %d failed", 7)
    assert flood.filter(after)
    assert after.getMessage() == f"bus 7 failed ({100 - ALIKE_MOST} more like this were not logged)"
    assert [flood.filter(event("bus %d failed", number)) for number in range(100)].count(True) == ALIKE_MOST - 1
    seldom = event("something else %d", 1)
    assert flood.filter(seldom)
    assert seldom.getMessage() == "something else 1"


SAY = """
import logging, sys
from brake_monitor.daemon.log_lines import log_to
log_to(sys.stderr, "debug", sys.argv[1])
for level in ("debug", "info", "warning", "error", "critical"):
    getattr(logging.getLogger("brake_monitor"), level)("said")
"""


@pytest.mark.parametrize("log_format", ["text", "json"])
def test_the_journal_is_told_the_priority_of_each_line(log_format: str) -> None:
    """As systemd starts a service: standard error is a pipe or socket that $JOURNAL_STREAM names."""
    read, write = os.pipe()
    status = os.fstat(write)
    environment = os.environ | {"JOURNAL_STREAM": f"{status.st_dev}:{status.st_ino}"}
    subprocess.run([sys.executable, "-c", SAY, log_format], stderr=write, env=environment, check=True, timeout=60)
    os.close(write)
    with os.fdopen(read, encoding="utf-8") as stream:
        lines = stream.read().splitlines()
    assert [int(re.match(r"<(\d)>", line)[1]) for line in lines] == [7, 6, 4, 3, 2]
    if log_format == "json":
        assert {json.loads(line[3:])["message"] for line in lines} == {"said"}


def test_another_stream_is_no_journal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("JOURNAL_STREAM", "1:2")
    with Path(os.devnull).open("w", encoding="utf-8") as stream:
        assert not is_journal(stream)
    assert not is_journal(io.StringIO())
