"""Work spread over processes."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from multiprocessing.pool import Pool
from typing import Any, TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def spread(work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Iterator[Result]:
    """Do `work` on all tasks with `jobs` processes; results come as they are ready."""
    if jobs == 1:
        yield from map(work, tasks)
        return
    with workers(min(jobs, len(tasks))) as pool:
        yield from pool.imap_unordered(work, tasks)


@contextmanager
def workers(count: int, begin: Callable[..., None] | None = None, *arguments: Any) -> Iterator[Pool]:
    """So many processes, in each of which `begin` is called first. They end with this one, however that ends."""
    interruptible = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends the others
    try:
        pool = multiprocessing.get_context("spawn").Pool(count, _begin, (begin, arguments))
    finally:
        signal.signal(signal.SIGINT, interruptible)
    with pool:
        yield pool


def _begin(begin: Callable[..., None] | None, arguments: tuple[Any, ...]) -> None:
    threading.Thread(target=_end_with_parent, daemon=True).start()
    if begin is not None:
        begin(*arguments)


def _end_with_parent() -> None:
    """Or a campaign that was killed would go on for as long as what it was at."""
    parent = multiprocessing.parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
