"""Tasks spread over processes."""

import multiprocessing
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def spread(work: Callable[[Task], Result], tasks: Sequence[Task], jobs: int) -> Iterator[Result]:
    """Do `work` on all tasks with `jobs` processes; results come as they are ready."""
    if jobs == 1:
        yield from map(work, tasks)
        return
    interruptible = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends the others
    try:
        pool = multiprocessing.get_context("spawn").Pool(min(jobs, len(tasks)))
    finally:
        signal.signal(signal.SIGINT, interruptible)
    with pool:
        yield from pool.imap_unordered(work, tasks)
