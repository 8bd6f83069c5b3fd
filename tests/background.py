"""What runs until it is told to stop, in a thread beside the test; what it raises there is raised in the test."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread


@contextmanager
def in_background(
    run: Callable[[], object], stop: Callable[[], object], patience_s: float
) -> Iterator[list[Exception]]:
    """Gives what `run` has raised so far; at the end it is told to stop, and has to end within the patience."""
    raised: list[Exception] = []

    def run_and_note() -> None:
        try:
            run()
        except Exception as error:  # noqa: BLE001 - raised below, in the test's own thread
            raised.append(error)

    thread = Thread(target=run_and_note)
    thread.start()
    try:
        yield raised
    finally:
        stop()
        thread.join(patience_s)
    assert not thread.is_alive(), f"told to stop {patience_s:g} s ago, and still running"
    if raised:
        raise raised[0]
