"""Writes the table of faults: what was expected of each and what was seen, in the order of the campaign."""

import os
from pathlib import Path

import pytest

TABLE = os.environ.get("BRAKE_MONITOR_WHOLE_CAMPAIGN")
HEAD = """\
# What the daemon survives

Written by `tests/fault_campaign/run`, which plays every fault on the shipped unit, one after the other: systemd as the
first process, virtual CAN interfaces, a Zenoh router and a peer behind it, all real, in a guest kernel. The wagon
drives and brakes meanwhile, and nothing is wrong with it. A test run (`tests/run`) plays those marked *.

Of every fault it is asked besides: no alarm about the brakes, no more restarts than told, no frame sent (the kernel
counts them), no traceback, no flood in the journal, and alarms that reach the peer once and in order (but where the
disk that keeps them is what fails). Times are those of a slow virtual machine with one processor.

| fault | expected | seen |
|---|---|---|
"""

rows: dict[str, str] = {}


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    told = dict(report.user_properties)
    if TABLE and "expected" in told and (report.when == "call" or report.failed):
        name = report.nodeid.partition("[")[2].removesuffix("]")
        mark = "" if told.get("whole") else " *"
        rows[name] = f"| {name}{mark} | {told['expected']} | {told.get('seen') or '**not as expected**'} |\n"


def pytest_sessionfinish() -> None:
    if TABLE and rows:
        Path(TABLE).write_text(HEAD + "".join(rows.values()), encoding="utf-8")
