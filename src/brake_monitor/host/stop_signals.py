"""SIGTERM, Ctrl-C and SIGHUP, for programs that end, or start again, in an orderly way."""

import logging
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import SimpleQueue
from types import FrameType
from typing import NoReturn

log = logging.getLogger(__name__)


@contextmanager
def stopped_by_signals(stop: Callable[[], None], reload: Callable[[], None] | None = None) -> Iterator[None]:
    """Call `stop` at the first SIGTERM or SIGINT. Main thread only.

    A second SIGINT does what it does by default. A second SIGTERM does nothing: `timeout` sends two, which would cut
    the stop short.

    With `reload`, that is called at each SIGHUP. Both are called from a thread of their own: a handler runs in the
    midst of whatever the main thread does, and would wait for ever for a lock that the main thread holds.
    """
    arrived: SimpleQueue[signal.Signals | None] = SimpleQueue()  # its `put` may interrupt itself

    def handle(number: int, _frame: FrameType | None) -> None:
        if number == signal.SIGINT:
            signal.signal(number, previous[signal.SIGINT])
        elif number == signal.SIGTERM:
            signal.signal(number, lambda *_: None)  # SIG_IGN: Python tells of one that has just come
        arrived.put(signal.Signals(number))

    def act() -> None:
        while (number := arrived.get()) is not None:
            log.info("%s: %s", number.name, "reloading" if number is signal.SIGHUP else "stopping")
            if number is not signal.SIGHUP:
                stop()
            elif reload is not None:
                reload()

    actor = threading.Thread(target=act, name="signals", daemon=True)
    actor.start()
    numbers = [signal.SIGTERM, signal.SIGINT, *([] if reload is None else [signal.SIGHUP])]
    previous = {number: signal.getsignal(number) for number in numbers}  # a handler may be called from now on
    for number in numbers:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        arrived.put(None)
        actor.join()


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Raise SystemExit at SIGTERM or SIGHUP, as Ctrl-C raises KeyboardInterrupt: nothing is left half done.

    What is ignored stays so, as with nohup. Main thread only.
    """
    numbers = [number for number in (signal.SIGTERM, signal.SIGHUP) if signal.getsignal(number) is signal.SIG_DFL]

    def end(number: int, _frame: FrameType | None) -> NoReturn:
        for other in numbers:  # `timeout` and terminals send more than one, which would cut the cleaning up short
            signal.signal(other, lambda *_: None)  # SIG_IGN: Python tells of one that has just come
        raise SystemExit(128 + number)

    for number in numbers:
        signal.signal(number, end)
    try:
        yield
    finally:
        for number in numbers:
            signal.signal(number, signal.SIG_DFL)
