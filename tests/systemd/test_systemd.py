"""The test bed itself: the guest's first process is systemd, and it has come up."""

import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.systemd


def test_systemd_runs_the_guest_without_a_failed_unit() -> None:
    assert Path("/proc/1/comm").read_text().strip() == "systemd"
    answer = subprocess.run(["systemctl", "is-system-running", "--wait"], capture_output=True, text=True, check=False)
    failed = subprocess.run(["systemctl", "--failed", "--no-legend"], capture_output=True, text=True, check=True)
    assert (answer.stdout.strip(), failed.stdout) == ("running", "")
