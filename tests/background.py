"""What runs until it is told to stop, in a thread beside the test; what it raises there is raised in the test."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread, current_thread

_failures: dict[Thread, Exception] = {}  # what has ended those that should run now


def raise_failure() -> None:
    """Raise what has ended one of them: what it was to do need not be waited for any more."""
    if _failures:
        raise next(iter(_failures.values()))


@contextmanager
def in_background(run: Callable[[], object], stop: Callable[[], object], patience_s: float) -> Iterator[None]:
    """At the end it is told to stop, and has to end within the patience."""

    def run_and_note() -> None:
        try:
            run()
        except Exception as error:  # noqa: BLE001 - raised in the test's own thread
            _failures[current_thread()] = error

    thread = Thread(target=run_and_note)
    thread.start()
    try:
        yield
    finally:
        stop()
        thread.join(patience_s)
        failure = _failures.pop(thread, None)
    assert not thread.is_alive(), f"told to stop {patience_s:g} s ago, and still running"
    if failure is not None:
        raise failure
