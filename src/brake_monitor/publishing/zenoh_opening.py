"""A Zenoh session on its way: beside a router that accepts and says nothing it takes ten seconds to open none."""

import threading

import zenoh


class Opening:
    """An attempt in a thread of its own, which nothing can break off: who waits for it can do something else."""

    def __init__(self, config: zenoh.Config) -> None:
        self._config = config
        self._guard = threading.Lock()
        self._found: zenoh.Session | zenoh.ZError | None = None
        self._fault: BaseException | None = None
        self._is_wanted = True
        self._thread = threading.Thread(target=self._attempt, name="opening Zenoh", daemon=True)
        self._thread.start()

    def found(self, within_s: float) -> zenoh.Session | zenoh.ZError | None:
        """The session, or why there is none; None when that is not known within this time."""
        self._thread.join(within_s)
        if self._fault is not None:
            raise self._fault
        return self._found

    def give_up(self) -> None:
        """A session that opens all the same is closed."""
        with self._guard:
            self._is_wanted = False
            if isinstance(self._found, zenoh.Session):
                self._found.close()  # type: ignore[no-untyped-call]

    def _attempt(self) -> None:
        found: zenoh.Session | zenoh.ZError
        try:
            found = zenoh.open(self._config)
        except zenoh.ZError as error:
            found = error
        except BaseException as fault:  # noqa: BLE001 - raised where the session is awaited
            self._fault = fault
            return
        with self._guard:
            self._found = found
            if not self._is_wanted and isinstance(found, zenoh.Session):
                found.close()  # type: ignore[no-untyped-call]
