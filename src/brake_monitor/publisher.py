"""Outputs → Zenoh, from a thread of its own: whatever the network does, the estimator never waits for it.

Two queues with opposite promises. Of estimates only the newest counts, so they wait in a single slot and congested
links drop them. Alarms are events: they wait in order, are resent from a cache to subscribers that ask (Zenoh's
advanced publisher) and are never dropped for congestion. Last values and open alarms answer a query, for late joiners.
One gap is known, and shows in `sequence`: alarms sent in the milliseconds in which the link to a new subscriber opens.
"""

import json
import logging
import threading
import time
from collections import deque
from dataclasses import dataclass
from typing import Any, Self

import zenoh
from zenoh import ext

from brake_monitor.config import ZenohSettings
from brake_monitor.errors import BrakeMonitorError, InputError, WorkError
from brake_monitor.estimator import Estimate
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.payloads import AdhesionMessage, AlarmMessage, FrictionMessage, KeySpace, encode
from brake_monitor.pipeline import Outputs

ALARMS_WAITING = 10_000  # while there is no session; each is about 1 kB
ALARMS_CACHED = 1000  # per key, for subscribers that come back
TURN_S = 0.25  # the thread shows a heartbeat at least this often
RETRY_S = 0.5  # between attempts to reach a router
OPEN_S = 3.0  # `start` waits no longer for a router that does not even refuse
CLOSE_S = 1.5
MISS_HEARTBEAT_S = 0.5  # tells advanced subscribers the newest sequence number, so that a lost last one is noticed
LEASE_MS = 2500  # silent for longer, we count as gone
BLOCKED_US = 1_000_000  # a neighbour that blocks an alarm for longer is cut off; it recovers from the cache

_JSON = zenoh.Encoding.APPLICATION_JSON
_PROTOCOLS = ("tcp", "udp", "tls", "quic", "ws")

log = logging.getLogger(__name__)


@dataclass(slots=True)
class Counters:
    """What became of the outputs since the start."""

    estimates_sent: int = 0
    estimates_replaced: int = 0  # by a newer one, before they were sent
    alarms_sent: int = 0
    alarms_lost: int = 0  # more waited than may wait
    failures: int = 0  # calls that Zenoh refused


class Publisher:
    """Publishes one wagon's outputs. Only `start` and `close` may wait; `publish` takes microseconds.

    InputError when the prefix, the wagon's id or an endpoint is malformed.
    """

    def __init__(self, settings: ZenohSettings, wagon_id: str) -> None:
        self.counters = Counters()
        self.endpoints: tuple[str, ...] = ()  # that subscribers can connect to, with their real ports; after `start`
        self._keys = KeySpace(settings.prefix, wagon_id)
        self._settings = settings
        self._config = session_config(settings)
        self._news = threading.Condition()  # guards the two queues and _closing
        self._estimate: tuple[int, Estimate] | None = None
        self._alarms: deque[tuple[int, Alarm]] = deque()
        self._estimates_given = 0
        self._alarms_given = 0
        self._closing = False
        self._tried = threading.Event()  # the first attempt to open a session is over
        self._failure: BrakeMonitorError | None = None
        self._beat_s = time.monotonic()
        self._looking = True
        self._thread = threading.Thread(target=self._run, name="zenoh", daemon=True)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    def start(self) -> None:
        """Open the session; a router may be absent, it is looked for from then on.

        WorkError when an endpoint cannot be listened on, InputError when it makes no sense.
        """
        self._thread.start()
        self._tried.wait(OPEN_S)
        if self._failure is not None:
            raise self._failure

    def publish(self, outputs: Outputs) -> None:
        """Hand the outputs over; never waits for the network, never raises because of it."""
        if outputs.estimate is None and not outputs.alarms:
            return
        with self._news:
            if outputs.estimate is not None:
                self._estimates_given += 1
                self.counters.estimates_replaced += self._estimate is not None
                self._estimate = (self._estimates_given, outputs.estimate)
            for alarm in outputs.alarms:
                self._alarms_given += 1
                self._alarms.append((self._alarms_given, alarm))
            while len(self._alarms) > ALARMS_WAITING:
                self._alarms.popleft()  # the newest tell most; subscribers see the gap in `sequence`
                self.counters.alarms_lost += 1
            self._news.notify()

    def heartbeat_age_s(self) -> float:
        """Seconds since the thread last completed a turn; it does so several times a second when all is well.

        0 while a router is looked for: an attempt may take long, and nothing else waits for it.
        """
        return 0.0 if self._looking else time.monotonic() - self._beat_s

    def close(self) -> None:
        """Send what waits, say good-bye and end the thread, within CLOSE_S; a second call does nothing."""
        with self._news:
            self._closing = True
            self._news.notify()
        if self._thread.is_alive():
            self._thread.join(CLOSE_S)
        if self._thread.is_alive():
            log.warning("the Zenoh session has not closed within %.1f s: a subscriber hangs; leaving it", CLOSE_S)

    def _run(self) -> None:
        try:
            link = self._connect()
        except BrakeMonitorError as error:
            self._failure = error
            return
        finally:
            self._beat_s, self._looking = time.monotonic(), False
            self._tried.set()
        if link is not None:
            try:
                while self._turn(link):
                    self._beat_s = time.monotonic()
            finally:
                link.close()

    def _connect(self) -> "_Link | None":
        """Open the session; a client asks again until a router answers. None when closed before."""
        while True:
            try:
                link = _Link(zenoh.open(self._config), self._keys)
            except zenoh.ZError as error:
                reason = _reason(error)
                if self._settings.mode == "peer":
                    wanted = _endpoints_of(self._settings)
                    raise WorkError(f"the Zenoh session {wanted} cannot be opened: {reason}") from None
                if not self._tried.is_set():
                    log.warning("no Zenoh router yet, trying on: %s", reason)
                    self._tried.set()
                with self._news:
                    if self._news.wait_for(lambda: self._closing, RETRY_S):
                        return None
            else:
                self.endpoints = link.locators() if self._settings.mode == "peer" else ()
                log.info("Zenoh session open, %s", ", ".join(self.endpoints) or _endpoints_of(self._settings))
                return link

    def _turn(self, link: "_Link") -> bool:
        """Send what waits, or wait for it; False when it was the last turn."""
        with self._news:
            self._news.wait_for(lambda: self._estimate or self._alarms or self._closing, TURN_S)
            closing = self._closing
            estimate, self._estimate = self._estimate, None
            alarms, self._alarms = self._alarms, deque()
        try:
            while alarms:
                self._send_alarm(link, *alarms[0])
                alarms.popleft()
            if estimate is not None:
                self._send_estimate(link, *estimate)
        except zenoh.ZError as error:
            self.counters.failures += 1
            if self.counters.failures == 1:
                log.warning("Zenoh refused to publish: %s", _reason(error))
        if alarms:
            with self._news:
                self._alarms.extendleft(reversed(alarms))
                self._news.wait_for(lambda: self._closing, TURN_S)
        return not closing

    def _send_alarm(self, link: "_Link", sequence: int, alarm: Alarm) -> None:
        key = self._keys.alarm(alarm.kind, alarm.wheelset)
        payload = encode(AlarmMessage.of(alarm, sequence, time.time()))
        link.put_event(key, payload, over=alarm.cleared_time_s is not None)
        self.counters.alarms_sent += 1

    def _send_estimate(self, link: "_Link", sequence: int, estimate: Estimate) -> None:
        now_s = time.time()
        link.put_state(self._keys.adhesion, encode(AdhesionMessage.of(estimate, sequence, now_s)))
        for wheelset in range(1, len(estimate.wheelsets) + 1):
            message = FrictionMessage.of(estimate, wheelset, sequence, now_s)
            link.put_state(self._keys.friction(wheelset), encode(message))
        self.counters.estimates_sent += 1


class _Link:
    """The open session and what is declared on it. Only Zenoh's own threads and the publisher's come here."""

    def __init__(self, session: zenoh.Session, keys: KeySpace) -> None:
        self._session = session
        self._states: dict[str, zenoh.Publisher] = {}
        self._events: dict[str, ext.AdvancedPublisher] = {}
        self._current: dict[str, bytes] = {}  # newest payload of every state and of every open event
        self._lock = threading.Lock()  # guards _current: queries come in Zenoh's threads
        self._token = session.liveliness().declare_token(keys.wagon)
        self._queryable = session.declare_queryable(keys.everything, self._answer)

    def locators(self) -> tuple[str, ...]:
        """The endpoints listened on, as the session itself reports them: port 0 has become a number."""
        key = f"@/{self._session.info.zid()}/peer"
        for reply in self._session.get(key, timeout=CLOSE_S):
            if reply.ok is not None:
                return tuple(json.loads(reply.ok.payload.to_bytes())["locators"])
        return ()

    def put_state(self, key: str, payload: bytes) -> None:
        """Publish a value that the next one supersedes."""
        publisher = self._states.get(key)
        if publisher is None:
            publisher = self._session.declare_publisher(
                key, encoding=_JSON, congestion_control=zenoh.CongestionControl.DROP
            )
            self._states[key] = publisher
        with self._lock:
            self._current[key] = payload
        publisher.put(payload)

    def put_event(self, key: str, payload: bytes, *, over: bool) -> None:
        """Publish an event that nobody may miss; `over` when late joiners need not hear of it any more."""
        publisher = self._events.get(key) or self._declare_event(key)
        with self._lock:
            if over:
                self._current.pop(key, None)
            else:
                self._current[key] = payload
        publisher.put(payload)

    def _declare_event(self, key: str) -> ext.AdvancedPublisher:
        publisher = ext.declare_advanced_publisher(
            self._session,
            key,
            encoding=_JSON,
            congestion_control=zenoh.CongestionControl.BLOCK,
            priority=zenoh.Priority.INTERACTIVE_HIGH,
            cache=ext.CacheConfig(max_samples=ALARMS_CACHED),
            sample_miss_detection=ext.MissDetectionConfig(heartbeat=MISS_HEARTBEAT_S, sporadic_heartbeat=None),
            publisher_detection=True,
        )
        self._events[key] = publisher
        return publisher

    def close(self) -> None:
        """Say good-bye and close. A neighbour that is frozen with data on the way holds the closing up for 10 s."""
        self._token.undeclare()  # type: ignore[no-untyped-call]
        # The callback of the queryable would keep the process from ending.
        self._queryable.undeclare()  # type: ignore[no-untyped-call]
        try:
            self._session.close()  # type: ignore[no-untyped-call]
        except zenoh.ZError as error:
            log.warning("the Zenoh session did not close: %s", _reason(error))
        self._session.close()  # type: ignore[no-untyped-call]

    def _answer(self, query: zenoh.Query) -> None:
        with self._lock:
            current = list(self._current.items())
        with query:
            for key, payload in current:
                if query.key_expr.intersects(key):
                    query.reply(key, payload, encoding=_JSON)


def session_config(settings: ZenohSettings) -> zenoh.Config:
    """A session that opens without a router, finds it when it comes, and speaks to nobody it was not told of.

    InputError when an endpoint is malformed.
    """
    for name, endpoints in (("connect", settings.connect), ("listen", settings.listen)):
        for endpoint in endpoints:
            _check_endpoint(name, endpoint)
    if settings.mode == "client" and not settings.connect:
        raise InputError("[zenoh] connect: a client needs the endpoint of a router, such as tcp/192.0.2.1:7447")
    peer = settings.mode == "peer"
    config = zenoh.Config()
    values: dict[str, Any] = {
        "mode": settings.mode,
        "connect/endpoints": settings.connect,
        "connect/timeout_ms": -1 if peer else 0,  # a peer connects later; a client's session needs its router
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5},
        "listen/endpoints": settings.listen if peer else (),
        "listen/exit_on_failure": True,
        # Gossip stays on: it only uses links that exist, and without it peers behind one router hear nothing.
        "scouting/multicast/enabled": False,
        "scouting/delay": 0,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/tx/queue/congestion_control/block/wait_before_close": BLOCKED_US,
        "adminspace/enabled": True,  # read-only; tells the ports that are really listened on
        "adminspace/permissions": {"read": True, "write": False},
    }
    for key, value in values.items():
        config.insert_json5(key, json.dumps(value))
    return config


def _check_endpoint(name: str, endpoint: str) -> None:
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.partition("?")[0].partition("#")[0].rpartition(":")
    if protocol not in _PROTOCOLS or not host or not (port.isascii() and port.isdigit() and int(port) < 2**16):
        expected = f"<protocol>/<host>:<port> with {', '.join(_PROTOCOLS)}, such as tcp/192.0.2.1:7447"
        raise InputError(f"[zenoh] {name} {endpoint!r}: expected {expected}")


def _endpoints_of(settings: ZenohSettings) -> str:
    listen, connect = ", ".join(settings.listen), ", ".join(settings.connect)
    if settings.mode == "client":
        return f"with the router at {connect}"
    return " and ".join(part for part in (listen and f"on {listen}", connect and f"to {connect}") if part)


def _reason(error: zenoh.ZError) -> str:
    """Zenoh's own words without the places in its source code that it adds: `…: [ADDRESS: REASON at /…`."""
    return str(error).partition(" at /")[0].rpartition(": [")[2].strip()
