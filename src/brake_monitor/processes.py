"""Work spread over processes."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.connection import Connection, wait
from typing import Any, TypeVar

from brake_monitor.errors import WorkError

Task = TypeVar("Task")
Result = TypeVar("Result")
Start = Callable[..., Future[Any]]  # gives a worker a function and its arguments


def spread(work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Iterator[Result]:
    """Do `work` on all tasks with `jobs` processes; results come as they are ready.

    WorkError when one of them is killed.
    """
    if jobs == 1:
        yield from map(work, tasks)
        return
    with workers(min(jobs, len(tasks))) as start:
        for done in as_completed([start(work, task) for task in tasks]):
            yield done.result()


@contextmanager
def workers(count: int, begin: Callable[..., None] | None = None, *arguments: Any) -> Iterator[Start]:
    """So many processes, in each of which `begin` is called first. They end with this one, however that ends.

    WorkError when one of them is killed.
    """
    context = multiprocessing.get_context("spawn")
    to_be_closed, end = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(count, context, _begin, (to_be_closed, begin, arguments))

    def start(work: Callable[..., Any], *given: Any) -> Future[Any]:
        interruptible = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends the others
        try:
            return pool.submit(work, *given)
        finally:
            signal.signal(signal.SIGINT, interruptible)

    try:
        yield start
    except BrokenProcessPool:
        raise WorkError("a process that did a part of the work has been killed; is there too little memory?") from None
    finally:
        end.close()
        pool.shutdown(cancel_futures=True)
        to_be_closed.close()


def _begin(to_be_closed: Connection, begin: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    threading.Thread(target=_end_with_parent, args=(to_be_closed,), daemon=True).start()
    if begin is not None:
        begin(*arguments)


def _end_with_parent(to_be_closed: Connection) -> None:
    """Or a campaign that was killed or given up would go on for as long as what it was at."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    wait([parent.sentinel, to_be_closed])
    os._exit(1)
