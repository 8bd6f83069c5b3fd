"""Tests marked `vcan`, `systemd` or `mount` run in a pytest of their own, one after the other.

It runs in a guest kernel (tests/guest/run) where this machine lacks what they need, and sends its reports back: each
counts as if it had run here. A guest mostly waits, so it does while this machine runs the other tests; what it found is
told last. Without a guest they are skipped; continuous integration sets BRAKE_MONITOR_REQUIRE_GUEST=1: then they fail.
Where the other tests run in several processes (pytest-xdist), these are the business of the one that started them.
"""

# ruff: noqa: E402 - what must not be imported is said before the imports

import gc
import json
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from hypothesis import settings

from brake_monitor.host.python_can import load_without_asammdf

load_without_asammdf()  # as `brake-monitor` does: it takes a second, in each process

from brake_monitor.compiled.kept_code import makers

pytest_plugins = ("secured_fleet",)  # fixtures

settings.register_profile("patient", deadline=None)  # how busy a machine is decides no test
settings.load_profile("patient")

GUEST = Path(__file__).parent / "guest" / "run"
GUEST_PACKAGES = "user-mode-linux kmod iproute2 can-utils"
GUEST_TIMEOUT_S = 900
CAMPAIGN_TIMEOUT_S = 3600
WHOLE_CAMPAIGN = "BRAKE_MONITOR_WHOLE_CAMPAIGN"  # the file that the table of faults goes to
REPORTS_TO = "BRAKE_MONITOR_GUEST_REPORTS"  # set inside the guest: the file its reports go to
REQUIRED = "BRAKE_MONITOR_REQUIRE_GUEST"


def can_mount() -> bool:
    """Whether a disk can be mounted here; a container often refuses it, even to root."""
    with tempfile.TemporaryDirectory(prefix="mount-") as folder:
        mount = ["mount", "-t", "tmpfs", "none", folder]
        if subprocess.run(mount, capture_output=True, check=False).returncode:
            return False
        subprocess.run(["umount", folder], check=True)
    return True


INSIDE = REPORTS_TO in os.environ
NEEDS_NO_GUEST = {
    # A vcan test takes interfaces down and up again, so it needs root and interfaces nobody else depends on.
    "vcan": os.geteuid() == 0 and all(Path(f"/sys/class/net/vcan{i}").exists() for i in (0, 1)),
    # A systemd test installs units: never on the machine that one works at.
    "systemd": False,
    "mount": INSIDE or can_mount(),
}
GUEST_OPTIONS = {"vcan": [], "systemd": ["--systemd"], "mount": []}

Reports = dict[str, list[pytest.TestReport]]


@pytest.fixture(scope="session", autouse=True)
def makers_of_machine_code_end() -> Iterator[None]:
    """They are meant to outlive who started them, within half a minute: here the tests end after them."""
    yield
    for maker in makers:
        maker.wait()


def marker_of(item: pytest.Item) -> str | None:
    """The marker because of which this test runs in a pytest of its own; None for one that runs in this one."""
    if INSIDE or item.get_closest_marker("skip"):
        return None
    return next((marker for marker in NEEDS_NO_GUEST if item.get_closest_marker(marker)), None)


def pytest_collection_finish() -> None:
    """What has been collected stays to the end: the garbage collector need not go through all of it again and again.

    Nor so often through what tests keep for others, tens of thousands of frames and estimates.
    """
    gc.freeze()
    gc.set_threshold(10_000)


def is_worker(config: pytest.Config) -> bool:
    """Whether this process was started by another one that wants some of the tests run."""
    return hasattr(config, "workerinput")


def has_workers(config: pytest.Config) -> bool:
    """Whether this process is the one that started them."""
    return config.pluginmanager.hasplugin("dsession")


def has_own_runs(path: Path) -> bool:
    """Whether tests in a file run in a pytest of their own."""
    text = path.read_text(encoding="utf-8")
    return any(f"pytest.mark.{marker}" in text for marker in NEEDS_NO_GUEST)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Who has workers leaves them the files without such tests: to load all takes ten seconds."""
    is_left = has_workers(config) and collection_path.suffix == ".py" and not has_own_runs(collection_path)
    return is_left or None


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what only the whole campaign plays; skip what needs a guest where there is none, unless demanded."""
    if not (INSIDE or WHOLE_CAMPAIGN in os.environ):
        left_out = [item for item in items if item.get_closest_marker("whole_campaign")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]
    guest_is_due = shutil.which("linux.uml") or os.environ.get(REQUIRED) == "1"
    for item in items:
        marker = marker_of(item)
        if marker and not (NEEDS_NO_GUEST[marker] or guest_is_due):
            reason = f"needs {marker}, or a guest that has it: apt-get install {GUEST_PACKAGES}"
            item.add_marker(pytest.mark.skip(reason=reason))
    if is_worker(config):
        assert all(has_own_runs(item.path) for item in items if marker_of(item)), "they would run nowhere"
        items[:] = [item for item in items if not marker_of(item)]


class OwnRuns:
    """The runs of pytest for tests with a marker: one after the other, beside the tests that run in this one."""

    def __init__(self, items: list[pytest.Item]) -> None:
        self._running: subprocess.Popen[str] | None = None
        self._starter = ThreadPoolExecutor(max_workers=1)
        self._ended = False
        markers = dict.fromkeys(marker for item in items if (marker := marker_of(item)))
        items_of = {marker: [item for item in items if marker_of(item) == marker] for marker in markers}
        self._found = [(of, self._starter.submit(self._run, marker, of)) for marker, of in items_of.items()]

    def report(self) -> None:
        """Tell what they found out, once they have ended."""
        for items, found in self._found:
            reports = found.result()
            for item in items:
                item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
                for report in reports[item.nodeid]:
                    item.ihook.pytest_runtest_logreport(report=report)
                item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)

    def end(self) -> None:
        """End what still runs: nobody waits for it any more."""
        self._ended = True
        if self._running is not None:
            self._running.terminate()
        self._starter.shutdown(cancel_futures=True)

    def _run(self, marker: str, items: list[pytest.Item]) -> Reports:
        """Run the items, in a guest where one is needed, and return their reports by node id; none goes without."""
        config = items[0].config
        with tempfile.TemporaryDirectory(prefix="guest-reports-") as folder:
            path = Path(folder, "reports.jsonl")
            path.touch()
            timeout_s = CAMPAIGN_TIMEOUT_S if WHOLE_CAMPAIGN in os.environ else GUEST_TIMEOUT_S
            guest = [GUEST, *GUEST_OPTIONS[marker], "--share", folder, "--timeout", str(timeout_s), "--"]
            command = [] if NEEDS_NO_GUEST[marker] else guest
            command += ["env", f"{REPORTS_TO}={path}", sys.executable, "-m", "pytest", "-p", "no:cacheprovider"]
            command += ["--rootdir", str(config.rootpath), *(item.nodeid for item in items)]
            with Path(folder, "said").open("w+") as said:
                self._running = subprocess.Popen(command, cwd=config.rootpath, text=True, stdout=said, stderr=said)
                if self._ended:
                    self._running.terminate()
                status = self._running.wait()
                said.seek(0)
                told = said.read()
            reports: Reports = {item.nodeid: [] for item in items}
            for line in path.read_text().splitlines():
                report = config.hook.pytest_report_from_serializable(config=config, data=json.loads(line))
                reports[report.nodeid].append(report)
        for item in items:
            if not any(report.when == "teardown" for report in reports[item.nodeid]):
                longrepr = f"its pytest ended before this test, with status {status}; it said:\n{told}"
                reports[item.nodeid].append(
                    pytest.TestReport(item.nodeid, item.location, {}, "failed", longrepr=longrepr, when="call")
                )
        return reports


@pytest.hookimpl(wrapper=True)
def pytest_runtestloop(session: pytest.Session) -> Iterator[None]:
    """Start what runs on its own; the loop itself is pytest's, here or in workers; tell what was found in the end."""
    if session.config.option.collectonly or is_worker(session.config):
        return (yield)
    if has_workers(session.config):
        session.perform_collect()  # else it is left to them
    own = [item for item in session.items if marker_of(item)]
    own_runs = OwnRuns(own)
    session.items[:] = [item for item in session.items if not marker_of(item)]
    try:
        result = yield
        if has_workers(session.config):
            session.testscollected += len(own)  # they told of theirs alone
        own_runs.report()
    finally:
        own_runs.end()
    return result


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
