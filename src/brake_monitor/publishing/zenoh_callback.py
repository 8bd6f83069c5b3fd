"""What Zenoh calls, and the end of the thread in which it does."""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, SimpleQueue
from typing import Any

import zenoh

ENDS_WITHIN_S = 0.5  # after its subscriber or queryable was undeclared; less than the time that closing may take


class AwaitedCallback:
    """A callback whose thread can be waited for.

    Zenoh calls Python in a thread that it makes for each callback; made by a daemon thread, it is a daemon thread too.
    One that is still in Zenoh's code when Python ends takes the process with it: "FATAL: exception not rethrown".
    """

    def __init__(self, call: Callable[[Any], None]) -> None:
        self._ended: SimpleQueue[threading.Thread] = SimpleQueue()
        self.handler = zenoh.handlers.Callback(call, lambda: self._ended.put(threading.current_thread()))

    def join(self) -> None:
        """Wait for the thread; what it was declared with has been undeclared before.

        Python cannot see through Zenoh's handler, which would keep whoever is called in memory, and us with it.
        """
        del self.handler
        until_s = time.monotonic() + ENDS_WITHIN_S
        with suppress(Empty):
            self._ended.get(timeout=ENDS_WITHIN_S).join(until_s - time.monotonic())
