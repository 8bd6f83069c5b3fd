"""Tasks spread over processes."""

import multiprocessing
import signal
from collections.abc import Container, Iterator, Sequence
from functools import partial

from brake_monitor.validation.cases import Case
from brake_monitor.validation.runs import Outcome, Task


def outcomes(tasks: Sequence[Task], drawn: Container[Case], jobs: int) -> Iterator[list[Outcome]]:
    """Do all tasks with `jobs` processes; outcomes come as they are ready, one list per task."""
    judge = partial(Task.judge, drawn=drawn)
    if jobs == 1:
        yield from map(judge, tasks)
        return
    interruptible = signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the parent, which ends the others
    try:
        pool = multiprocessing.get_context("spawn").Pool(min(jobs, len(tasks)))
    finally:
        signal.signal(signal.SIGINT, interruptible)
    with pool:
        yield from pool.imap_unordered(judge, tasks)
