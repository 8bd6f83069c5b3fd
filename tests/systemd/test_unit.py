"""The unit that is shipped, installed as its README says, under a real systemd and on a real vcan."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from installation import SERVICE, STATE, install, run, shown, wait_until

pytestmark = pytest.mark.systemd

MAPPED_FRAME = "120#0002000000000000"  # wheel speeds of the example wagon
DYNAMIC_USERS = range(61184, 65520)  # systemd.exec(5)


@pytest.fixture(scope="module", autouse=True)
def bus() -> Iterator[None]:
    """The program, and a bus for it."""
    install()
    run("systemctl", "start", "vcan@can0")
    yield
    run("systemctl", "stop", SERVICE)
    run("systemctl", "stop", "vcan@can0")


@pytest.fixture
def process() -> int:
    """The running service's; `systemctl start` returns once it has said that it is ready, at once when it runs."""
    run("systemctl", "start", SERVICE)
    return int(shown("MainPID"))


def test_systemd_finds_nothing_wrong_with_the_units() -> None:
    assert run("systemd-analyze", "verify", SERVICE, "vcan@can0.service") == ""


def test_little_is_exposed() -> None:
    said = run("systemd-analyze", "security", "--no-pager", SERVICE)
    exposure = re.search(r"Overall exposure level .*: ([\d.]+)", said)
    assert exposure is not None
    assert float(exposure[1]) <= 1.6


def test_it_runs_as_a_user_of_its_own_without_capabilities(process: int) -> None:
    status = dict(line.split(":\t", 1) for line in Path(f"/proc/{process}/status").read_text().splitlines())
    users = {int(user) for user in status["Uid"].split()}
    assert users <= set(DYNAMIC_USERS)
    assert users == {STATE.stat().st_uid}
    assert {int(status[of], 16) for of in ("CapPrm", "CapEff", "CapBnd", "CapAmb")} == {0}


def test_it_hears_the_bus_and_says_so_in_its_status(process: int) -> None:
    wait_until(lambda: shown("StatusText").startswith("0 frames"))  # soon after it was ready
    run("cansend", "can0", MAPPED_FRAME)
    wait_until(lambda: shown("StatusText").startswith("1 frame,"))
    assert int(shown("MainPID")) == process


def test_it_is_started_again_when_it_was_killed(process: int) -> None:
    run("systemctl", "kill", "--signal=KILL", SERVICE)
    wait_until(lambda: shown("ActiveState") == "active" and shown("MainPID") not in ("0", str(process)))
    assert shown("NRestarts") == "1"


def test_it_stops_in_order_before_systemd_would_kill_it(process: int) -> None:
    run("systemctl", "stop", SERVICE)
    assert (shown("Result"), shown("ExecMainStatus")) == ("success", "0")
    assert not Path(f"/proc/{process}").exists()
