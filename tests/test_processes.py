"""Work that is spread over processes: each task once, and nobody left behind."""

import signal
import subprocess
import sys
from pathlib import Path

from brake_monitor.processes import spread
from network import PATIENCE_S, until

ENDLESS = """
import time
from brake_monitor.processes import spread
list(spread(time.sleep, [3600.0, 3600.0], 2))
"""


def doubled(number: int) -> int:
    return 2 * number


def workers_of(pid: int) -> list[int]:
    """The processes that were started by this one to work for it."""
    found = []
    for process in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((process / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == pid and b"spawn_main" in (process / "cmdline").read_bytes():
                found.append(int(process.name))
        except (FileNotFoundError, ProcessLookupError):  # it has just ended
            continue
    return found


def is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def test_every_task_is_done_once_in_one_process_or_in_many() -> None:
    for jobs in (1, 3):
        assert sorted(spread(doubled, range(10), jobs)) == list(range(0, 20, 2))


def test_workers_end_with_who_was_killed() -> None:
    with subprocess.Popen([sys.executable, "-c", ENDLESS]) as child:
        try:
            until(lambda: len(workers_of(child.pid)) == 2)
            workers = workers_of(child.pid)
            child.send_signal(signal.SIGKILL)
            assert child.wait(PATIENCE_S) == -signal.SIGKILL
            until(lambda: not any(map(is_alive, workers)))
        finally:
            child.kill()
