"""The Zenoh side of the dashboard, in threads of its own: it hears everything and asks each new daemon for its past."""

import threading
import time
from contextlib import ExitStack, suppress
from queue import Empty, Full, Queue
from typing import NamedTuple

import zenoh

from brake_monitor.dashboard.fleet import Fleet
from brake_monitor.desk.fleet_listener import ask, listen, patient_session
from brake_monitor.errors import BrakeMonitorError

PAGES = 3  # of at most 1000 estimates each; together what a daemon remembers
ALARMS_ASKED = 200
WAITING = 1000  # daemons whose past is still to be asked for
TURN_S = 0.5
ASKED_AGAIN_S = 5.0


class Past(NamedTuple):
    """What is still to be asked of a daemon's last minutes."""

    wagon: str
    to_s: float | None  # what is newer is known; None: nothing is
    pages: int


class Hearing:
    """Tells a fleet what is heard until it is closed; a router may come later."""

    def __init__(self, fleet: Fleet, config: zenoh.Config) -> None:
        self.failure: BrakeMonitorError | None = None
        self._fleet = fleet
        self._config = config
        self._stopping = threading.Event()
        self._to_ask: Queue[str] = Queue(WAITING)
        self._to_ask_again: dict[str, float] = {}  # whom, and from when on; the earliest first
        self._pasts: dict[str, Past] = {}  # by wagon, whoever waits longest first
        self._thread = threading.Thread(target=self._run, name="hearing", daemon=True)

    def start(self) -> None:
        """Begin to look for somebody to hear."""
        self._thread.start()

    def is_over(self) -> bool:
        """Whether it ended by itself, which only a failure makes it do."""
        return not self._thread.is_alive() and not self._stopping.is_set()

    def close(self) -> None:
        """End; returns when the session is closed, or after some seconds when it hangs."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join(3.0)

    def hear(self, sample: zenoh.Sample) -> None:
        """Note a message."""
        with self._fleet.lock:
            self._fleet.take(*_parts(sample), time.monotonic())

    def lives(self, sample: zenoh.Sample) -> None:
        """Note who came or went; a newcomer is asked for its past."""
        key, alive = str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT
        with self._fleet.lock:
            self._fleet.watched.lives(key, alive)
        if alive:
            with suppress(Full):  # what it publishes from now on is heard all the same
                self._to_ask.put_nowait(self._fleet.watched.wagon_of(key))

    def _run(self) -> None:
        try:
            session = patient_session(self._config, self._stopping)
        except BrakeMonitorError as error:
            self.failure = error
            return
        if session is None:
            return
        with ExitStack() as stack:
            stack.enter_context(session)
            listen(session, f"{self._fleet.prefix}/*", self, stack)
            while not self._stopping.is_set():
                answered = session.info.routers_zid() or session.info.peers_zid()
                self._fleet.note_connection(is_connected=bool(answered))
                try:
                    self._ask_now(session, self._next_to_ask())
                except Empty:
                    if self._pasts:
                        self._ask_past(session, self._next_past())

    def _next_to_ask(self) -> str:
        """The next daemon to ask: one that came, or did not answer some time ago. Empty when none comes in time."""
        again = next(iter(self._to_ask_again), None)
        if again is not None and self._to_ask_again[again] <= time.monotonic():
            del self._to_ask_again[again]
            return again
        return self._to_ask.get(timeout=0.0 if self._pasts else TURN_S)

    def _ask_now(self, session: zenoh.Session, name: str) -> None:
        """Ask a daemon that came for last values and alarms, and put its past on the list.

        One that is busy is asked again.
        """
        wagon = f"{self._fleet.prefix}/{name}"
        with self._fleet.lock:
            is_alive = self._fleet.is_alive(name)
        if not is_alive:
            return
        alarms: list[zenoh.Sample] = []
        known = ask(session, f"{wagon}/**", self.hear)
        if not known or ask(session, f"{wagon}/alarm/**?limit={ALARMS_ASKED}", alarms.append) is None:
            self._to_ask_again.setdefault(name, time.monotonic() + ASKED_AGAIN_S)  # once, however often it came
            return
        with self._fleet.lock:
            parts = [_parts(sample) for sample in alarms]
            self._fleet.take_alarms(name, parts, time.monotonic())
        self._pasts[name] = Past(name, None, PAGES)

    def _next_past(self) -> Past:
        """The wagon whose page is open comes first."""
        wanted = self._fleet.looked_at
        return self._pasts.pop(wanted if wanted in self._pasts else next(iter(self._pasts)))

    def _ask_past(self, session: zenoh.Session, past: Past) -> None:
        """Ask a daemon for a page of its last minutes, the newest first; the page before it waits for the others."""
        name, to_s, pages = past
        until = "" if to_s is None else f";to_s={to_s!r}"
        page: list[zenoh.Sample] = []
        for key in ("adhesion", "axle/*/friction"):
            ask(session, f"{self._fleet.prefix}/{name}/{key}?from_s=0{until}", page.append)
        with self._fleet.lock:
            oldest_s = self._fleet.take_past(name, [_parts(sample) for sample in page])
        if pages > 1 and oldest_s not in (None, to_s):
            self._pasts[name] = Past(name, oldest_s, pages - 1)


def _parts(sample: zenoh.Sample) -> tuple[str, str, bytes]:
    return str(sample.key_expr), str(sample.encoding), sample.payload.to_bytes()
