"""Work that is spread over processes: each task once, and nobody left behind."""

import os
import signal
import subprocess
import sys
import time
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path

import pytest

from brake_monitor.errors import InputError, WorkError
from brake_monitor.host import processes
from brake_monitor.host.processes import spread
from brake_monitor.host.whole_file import whole_file
from program import PATIENCE_S, until

ENDLESS = """
import signal, time
from brake_monitor.host.processes import spread
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in what a shell runs in the background
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
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state != "Z"


def test_every_task_is_done_once_in_one_process_or_in_many() -> None:
    for jobs in (1, 3):
        assert sorted(spread(doubled, range(10), jobs)) == list(range(0, 20, 2))


def killed(number: int) -> int:
    if number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_workers_end_with_who_was_killed(number: signal.Signals) -> None:
    with subprocess.Popen([sys.executable, "-c", ENDLESS], stderr=subprocess.PIPE) as child:
        try:
            until(lambda: len(workers_of(child.pid)) == 2)
            workers = workers_of(child.pid)
            child.send_signal(number)
            assert child.wait(PATIENCE_S) == -number
            until(lambda: not any(map(is_alive, workers)))
        finally:
            child.kill()


def test_a_worker_that_is_killed_ends_the_work_with_one_sentence() -> None:
    with pytest.raises(WorkError, match="ended in the midst of its part of the work"):
        list(spread(killed, range(4), 2))


def wrong(number: int) -> int:
    raise InputError(f"{number} is none")


def test_what_goes_wrong_in_a_worker_is_raised_here() -> None:
    with pytest.raises(InputError, match="7 is none"):
        list(spread(wrong, [7, 7], 2))


def large(_: int) -> bytes:
    return bytes(5_000_000)


def test_results_that_are_on_their_way_hold_nothing_up() -> None:
    """Workers are killed in the midst of sending: nobody waits for the rest."""
    for _ in range(2):
        results = spread(large, range(100), 3)
        assert len(next(results)) == 5_000_000
        results.close()  # type: ignore[attr-defined]


def killed_while_it_sends(number: int) -> bytes:
    send = Connection._send

    def send_half(pipe: Connection, part: bytes) -> None:
        if len(part) < 100:
            send(pipe, part)  # how long the result is
        else:
            os.write(pipe.fileno(), part[: len(part) // 2])
            os.kill(os.getpid(), signal.SIGKILL)

    if number == 1:
        Connection._send = send_half
    return bytes(5_000_000)


def test_a_worker_that_is_killed_in_the_midst_of_a_result_ends_the_work() -> None:
    with pytest.raises(WorkError, match="ended in the midst of its part of the work"):
        list(spread(killed_while_it_sends, range(3), 2))


def test_where_not_all_processes_can_be_started_none_is_left_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    start, begun = SpawnProcess.start, []

    def start_one(process: SpawnProcess) -> None:
        if begun:
            raise BlockingIOError("no more processes")
        start(process)
        begun.append(process)

    monkeypatch.setattr(SpawnProcess, "start", start_one)
    with pytest.raises(BlockingIOError, match="no more processes"):
        list(spread(time.sleep, [3600.0, 3600.0], 2))
    (process,) = begun
    assert process.exitcode is not None


def test_results_that_nobody_wants_any_more_are_not_waited_for() -> None:
    """As when writing one of them fails."""
    results = spread(time.sleep, [0.0, 3600.0, 3600.0], 2)
    assert next(results) is None
    workers = workers_of(os.getpid())
    results.close()  # type: ignore[attr-defined]
    until(lambda: not any(map(is_alive, workers)))


def half_written(path: Path | None) -> None:
    if path is not None:
        with whole_file(path) as part:
            part.write_text("half of it")
            time.sleep(3600.0)


def test_what_workers_are_at_when_they_are_ended_leaves_nothing_half(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(processes, "GRACE_S", PATIENCE_S)
    results = spread(half_written, [None, tmp_path / "a.csv", tmp_path / "b.csv"], 2)
    assert next(results) is None
    until(lambda: len(list(tmp_path.iterdir())) == 2)
    results.close()  # type: ignore[attr-defined]
    assert not list(tmp_path.iterdir())


HALF_WRITTEN = """
import sys
from pathlib import Path
from brake_monitor.host.processes import spread
from test_processes import half_written
list(spread(half_written, [Path(name) for name in sys.argv[1:]], 2))
"""


def test_nor_when_who_spread_the_work_is_killed(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HALF_WRITTEN, tmp_path / "a.csv", tmp_path / "b.csv"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([*sys.path, str(Path(__file__).parent)])}
    with subprocess.Popen(command, env=environment) as child:
        try:
            until(lambda: len(list(tmp_path.iterdir())) == 2)
            workers = workers_of(child.pid)
        finally:
            child.kill()
    until(lambda: not any(map(is_alive, workers)))
    assert not list(tmp_path.iterdir())


def deaf(path: Path | None) -> None:
    if path is not None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        path.touch()
        time.sleep(3600.0)


def test_a_worker_that_does_not_end_when_told_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "GRACE_S", 0.1)
    results = spread(deaf, [None, tmp_path / "deaf"], 2)
    assert next(results) is None
    until((tmp_path / "deaf").exists)
    workers = workers_of(os.getpid())
    results.close()  # type: ignore[attr-defined]
    assert not any(map(is_alive, workers))
