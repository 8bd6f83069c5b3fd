"""Tests marked `vcan` or `systemd` run in a guest kernel (tests/guest/run) where this machine lacks either.

The guest runs the same pytest on those tests and sends its reports back: each counts as if it had run here.
Without a guest they are skipped; continuous integration sets BRAKE_MONITOR_REQUIRE_GUEST=1: then they fail.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

settings.register_profile("patient", deadline=None)  # how busy a machine is decides no test
settings.load_profile("patient")

GUEST = Path(__file__).parent / "guest" / "run"
GUEST_PACKAGES = "user-mode-linux kmod iproute2 can-utils"
GUEST_TIMEOUT_S = 900
CAMPAIGN_TIMEOUT_S = 3600
WHOLE_CAMPAIGN = "BRAKE_MONITOR_WHOLE_CAMPAIGN"  # the file that the table of faults goes to
REPORTS_TO = "BRAKE_MONITOR_GUEST_REPORTS"  # set inside the guest: the file its reports go to
REQUIRED = "BRAKE_MONITOR_REQUIRE_GUEST"

INSIDE = REPORTS_TO in os.environ
RUNS_HERE = {
    # A vcan test takes interfaces down and up again, so it needs root and interfaces nobody else depends on.
    "vcan": INSIDE or (os.geteuid() == 0 and all(Path(f"/sys/class/net/vcan{i}").exists() for i in (0, 1))),
    # A systemd test installs units: never on the machine that one works at.
    "systemd": INSIDE,
}
GUEST_OPTIONS = {"vcan": [], "systemd": ["--systemd"]}

Reports = dict[str, list[pytest.TestReport]]
reports_key = pytest.StashKey[dict[str, Reports]]()


def guest_marker(item: pytest.Item) -> str | None:
    """The marker because of which this test has to run in the guest, or None when it runs here."""
    return next((m for m in RUNS_HERE if item.get_closest_marker(m) and not RUNS_HERE[m]), None)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what only the whole campaign plays; skip what needs a guest where there is none, unless demanded."""
    if not (INSIDE or WHOLE_CAMPAIGN in os.environ):
        left_out = [item for item in items if item.get_closest_marker("whole_campaign")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
    if shutil.which("linux.uml") or os.environ.get(REQUIRED) == "1":
        return
    for item in items:
        if marker := guest_marker(item):
            reason = f"needs {marker}, or a guest that has it: apt-get install {GUEST_PACKAGES}"
            item.add_marker(pytest.mark.skip(reason=reason))


def pytest_runtest_protocol(item: pytest.Item) -> bool | None:
    """Report what the guest found out about this test; it is booted when the first test needs it."""
    marker = guest_marker(item)
    if marker is None or item.get_closest_marker("skip"):
        return None
    sessions = item.session.stash.setdefault(reports_key, {})
    if marker not in sessions:
        sessions[marker] = run_in_guest(marker, [i for i in item.session.items if guest_marker(i) == marker])
    item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in sessions[marker][item.nodeid]:
        item.ihook.pytest_runtest_logreport(report=report)
    item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True


def run_in_guest(marker: str, items: list[pytest.Item]) -> Reports:
    """Boot the guest, run the items in it and return their reports by node id; none goes without."""
    config = items[0].config
    with tempfile.TemporaryDirectory(prefix="guest-reports-") as folder:
        path = Path(folder, "reports.jsonl")
        path.touch()
        timeout_s = CAMPAIGN_TIMEOUT_S if WHOLE_CAMPAIGN in os.environ else GUEST_TIMEOUT_S
        command = [GUEST, *GUEST_OPTIONS[marker], "--share", folder, "--timeout", str(timeout_s), "--"]
        command += ["env", f"{REPORTS_TO}={path}", sys.executable, "-m", "pytest", "-p", "no:cacheprovider"]
        command += ["--rootdir", str(config.rootpath), *(item.nodeid for item in items)]
        guest = subprocess.run(command, cwd=config.rootpath, text=True, capture_output=True, check=False)
        reports: Reports = {item.nodeid: [] for item in items}
        for line in path.read_text().splitlines():
            report = config.hook.pytest_report_from_serializable(config=config, data=json.loads(line))
            reports[report.nodeid].append(report)
    for item in items:
        if not any(report.when == "teardown" for report in reports[item.nodeid]):
            said = f"the guest ended before this test, with status {guest.returncode}; it said:\n"
            said += guest.stdout + guest.stderr
            reports[item.nodeid].append(
                pytest.TestReport(item.nodeid, item.location, {}, "failed", longrepr=said, when="call")
            )
    return reports


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Iterator[None]:
    """Inside the guest: send the report out; a skip is a failure, for the guest has what the test needs."""
    report = yield
    if not INSIDE:
        return report
    if report.skipped and not hasattr(report, "wasxfail"):
        report.outcome = "failed"
        report.longrepr = f"skipped in the guest, which has all it needs: {report.longrepr}"
    data = item.config.hook.pytest_report_to_serializable(config=item.config, report=report)
    with Path(os.environ[REPORTS_TO]).open("a") as file:
        file.write(json.dumps(data) + "\n")
    return report
