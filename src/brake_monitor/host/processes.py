"""Work spread over processes."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.resource_tracker import ensure_running
from typing import Any, Self, TypeVar

from brake_monitor.errors import WorkError
from brake_monitor.host.python_can import load_without_asammdf
from brake_monitor.host.stop_signals import ended_by_signals

GRACE_S = 2.0  # for a process to clean up what it was doing
Task = TypeVar("Task")
Result = TypeVar("Result")


def spread(work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Iterator[Result]:
    """Do `work` on all tasks with `jobs` processes; results come as they are ready.

    WorkError when one of them is killed.
    """
    if jobs == 1:
        yield from map(work, tasks)
        return
    with Crew(min(jobs, len(tasks))) as crew:
        for _, result in crew.each(work, tasks):
            yield result


class Crew:
    """So many processes, in each of which `begin` is called first. They end with the context, and with this process.

    Work still going on when the context ends is left as by SystemExit: no half-written file stays.
    Each has a pipe of its own, whose other end nobody else holds: when one is killed, be it in the midst of a result,
    the pipe ends. (The one queue that Python's pools share for all results does not, and is then waited for for ever.)
    """

    def __init__(self, count: int, begin: Callable[..., None] | None = None, *arguments: Any) -> None:
        self._count, self._begin = count, (begin, arguments)
        self._processes: list[multiprocessing.process.BaseProcess] = []
        self._pipes: list[Connection] = []

    def __enter__(self) -> Self:
        context = multiprocessing.get_context("spawn")
        ensure_running()  # it would let Ctrl-C through
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # Ctrl-C is for us, who end the others
        try:
            for _ in range(self._count):
                ours, theirs = context.Pipe()
                process = context.Process(target=_serve, args=(theirs, *self._begin), daemon=True)
                process.start()
                theirs.close()
                self._processes.append(process)
                self._pipes.append(ours)
        except BaseException:  # such as no more processes, or memory
            self.__exit__()
            raise
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        return self

    def __exit__(self, *exc_info: object) -> None:
        for process in self._processes:
            process.terminate()
        for process, pipe in zip(self._processes, self._pipes, strict=True):
            process.join(GRACE_S)
            process.kill()
            process.join()
            pipe.close()

    def each(self, work: Callable[[Task], Result], tasks: Sequence[Task]) -> Iterator[tuple[int, Result]]:
        """Do `work` on all tasks: their places and results, as they are ready. WorkError when a process is killed."""
        waiting = iter(enumerate(tasks))
        busy: dict[Connection, int] = {}

        def give(pipe: Connection) -> None:
            if (task := next(waiting, None)) is not None:
                busy[pipe] = task[0]
                with suppress(BrokenPipeError):  # then it has ended, as is told below
                    pipe.send((work, task[1]))

        for pipe in self._pipes:
            give(pipe)
        while busy:
            for ready in wait(list(busy)):
                assert isinstance(ready, Connection)
                place, result = busy.pop(ready), _received(ready)
                give(ready)
                yield place, result


def _received(pipe: Connection) -> Any:
    try:
        is_good, result = pipe.recv()
    except (EOFError, OSError):
        raise WorkError("a process ended in the midst of its part of the work: killed, for want of memory?") from None
    if not is_good:
        raise result
    return result


def _serve(pipe: Connection, begin: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    """The main loop of a worker: do the tasks that arrive, until the pipe is closed."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with ended_by_signals(), suppress(EOFError):
        load_without_asammdf()
        if begin is not None:
            begin(*arguments)
        while True:
            work, task = pipe.recv()
            try:
                done = True, work(task)
            except Exception as error:  # noqa: BLE001 - raised where the result is awaited
                done = False, error
            pipe.send(done)


def _end_with_parent() -> None:
    """Else a campaign that was killed would go on until its present tasks end; no half-written file stays."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os.kill(os.getpid(), signal.SIGTERM)
    threading.main_thread().join(GRACE_S)
    os._exit(1)
