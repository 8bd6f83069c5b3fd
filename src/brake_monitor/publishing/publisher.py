"""Outputs → Zenoh, from a thread of its own: whatever the network does, the estimator never waits for it.

Two queues with opposite promises. Of estimates only the newest counts, so they wait in a single slot and congested
links drop them. Alarms and wear are events: they wait in order, are kept in the outbox before they are sent, and reach
an advanced subscriber exactly once and in order, over outages and restarts. Last values answer a query.
"""

import logging
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple, Self, TypeVar

import msgspec
import zenoh
from msgspec.structs import replace

from brake_monitor.errors import BrakeMonitorError, WorkError
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brakes import Brakes
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.answers import Answerer, RefusedError
from brake_monitor.publishing.health import Counters, Intake, health_of
from brake_monitor.publishing.outbox import Event, EventLog, MemoryOutbox, Outbox, message_of
from brake_monitor.publishing.payloads import (
    AdhesionMessage,
    AlarmMessage,
    AxleAdhesionMessage,
    FrictionMessage,
    HealthMessage,
    Message,
    MetaMessage,
    WearMessage,
    encode,
)
from brake_monitor.publishing.published import Payload, Published, PublishedEstimate
from brake_monitor.publishing.zenoh_link import ZenohLink
from brake_monitor.publishing.zenoh_session import chooses_port, endpoints_of, reason_of, session_config
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings

EVENTS_WAITING = 10_000  # for the thread; each is about 1 kB
EVENTS_AGAIN = (
    1000  # of an earlier run are sent again: some subscriber may have missed them, plain ones hear them twice
)
ACKNOWLEDGEMENTS_WAITING = 100
META_EVERY = 60  # with so many healths meta is told again: at the start nobody is connected yet
TURN_S = 0.25  # the thread shows a heartbeat at least this often
RETRY_S = 0.5  # between attempts to reach a router
OPEN_S = 3.0  # `start` waits no longer for a router that does not even refuse
CLOSE_S = 1.0

log = logging.getLogger(__name__)
T = TypeVar("T")


class _News(NamedTuple):
    """An event that is not numbered yet: the stream it counts in, its key below the wagon's, how to put it."""

    stream: str
    key: str
    message: Callable[[int, float], Message]  # sequence, publish_time_s → the message
    over: bool


class Publisher:
    """Publishes one wagon's outputs. Only `start` and `close` may wait; everything else takes microseconds.

    `outbox` is only used by the publisher's thread. InputError when the prefix, the wagon's id or an endpoint is
    malformed, or a certificate cannot be read.
    """

    def __init__(
        self,
        settings: ZenohSettings,
        wagon_id: str,
        *,
        outbox: Outbox | None = None,
        about: MetaMessage | None = None,
    ) -> None:
        self.counters = Counters()
        self.endpoints: tuple[str, ...] = ()  # that subscribers can connect to, with their real ports; after `start`
        self.health: HealthMessage | None = None  # as last published
        self._keys = KeySpace(settings.prefix, wagon_id)
        self._settings = settings
        self._about = about
        self._outbox = outbox or MemoryOutbox()
        self._published = Published()
        session_config(settings)  # refuses what is malformed
        self._news = threading.Condition()  # guards what waits, _closing and _acknowledgeable
        self._estimate: tuple[int, Estimate] | None = None
        self._intake: Intake | None = None
        self._waiting: deque[_News] = deque()
        self._open: tuple[Alarm, ...] | None = None  # at the start, until the thread has compared it
        self._lost: Counter[str] = Counter()  # events that waited in vain, by stream, and not yet skipped
        self._acknowledged: deque[str] = deque()
        self._acknowledgeable = True
        self._estimates_given = 0
        self._newest: tuple[float, Status] | None = None
        self._health_sequence = 0
        self._unkept: dict[int, bytes] = {}  # the outbox could not take them yet
        self._unsent: deque[Event] = deque()
        self._log: EventLog | None = None
        self._closing = False
        self._tried = threading.Event()  # the first attempt to open a session is over
        self._is_awaited = True  # by `start`, to raise what goes wrong
        self._failure: BrakeMonitorError | None = None
        self._begun_s = self._beat_s = time.monotonic()
        self._looking = True
        self._thread = threading.Thread(target=self._run, name="zenoh", daemon=True)

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(self, *exc_info: object) -> None:
        self.close()

    # -- for other threads -------------------------------------------------------------------------------------

    def start(self) -> None:
        """Open the session; a router may be absent, it is looked for from then on.

        WorkError when an endpoint cannot be listened on, InputError when it makes no sense.
        """
        self._thread.start()
        self._is_awaited = self._tried.wait(OPEN_S)
        if self._failure is not None:
            raise self._failure

    def give_up_waiting(self) -> None:
        """Let `start` return now, for the program is to end; before it or while it waits, from any thread."""
        self._tried.set()

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
                self._waiting.append(self._alarm_news(alarm))
            self._limit_waiting()
            self._news.notify()

    def publish_wear(self, brakes: Brakes, settings: WearSettings) -> None:
        """Hand the state of all brake units over."""
        with self._news:
            for i in range(1, len(brakes.units) + 1):
                key = self._below(self._keys.wear(i))
                self._waiting.append(_News(key, key, partial(WearMessage.of, brakes, i, settings), False))
            self._limit_waiting()
            self._news.notify()

    def publish_open_alarms(self, alarms: Sequence[Alarm]) -> None:
        """Hand over all that are open when the daemon begins, so that nobody is left with what an earlier run told.

        Of an open alarm that it could not tell subscribers hear now; an alarm that nobody knows any more is cleared.
        """
        with self._news:
            self._open = tuple(alarms)
            self._news.notify()

    def publish_health(self, intake: Intake) -> None:
        """Hand over how the daemon does."""
        with self._news:
            self._intake = intake
            self._news.notify()

    def acknowledged(self) -> list[str]:
        """The ids of alarms that remote parties have acknowledged since the last call."""
        if not self._acknowledged:
            return []
        return [self._acknowledged.popleft() for _ in range(len(self._acknowledged))]

    def refuse_acknowledgements(self) -> None:
        """From now on; those that were accepted can still be fetched."""
        with self._news:
            self._acknowledgeable = False

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
            who = "the router does not answer" if self._looking else "a subscriber hangs"
            log.warning("the Zenoh session has not closed within %.1f s: %s; leaving it", CLOSE_S, who)

    def _alarm_news(self, alarm: Alarm) -> _News:
        key = self._below(self._keys.alarm(alarm.kind, alarm.wheelset))
        return _News("alarm", key, partial(AlarmMessage.of, alarm), alarm.cleared_time_s is not None)

    def _below(self, key: str) -> str:
        return key.removeprefix(f"{self._keys.wagon}/")

    def _limit_waiting(self) -> None:
        while len(self._waiting) > EVENTS_WAITING:
            self._lost[self._waiting.popleft().stream] += 1  # the newest tell most; subscribers see the gap
            self.counters.events_lost += 1

    # -- the thread --------------------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._resume()
            link = self._connect()
        except BrakeMonitorError as error:
            self._failure = error
            if not self._is_awaited:
                log.warning("%s; nothing is published", error)
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

    def _resume(self) -> None:
        """Take up what an earlier run has kept, but for what the disk has spoilt since."""
        try:
            kept = self._outbox.kept()
        except BrakeMonitorError as error:
            log.warning("kept events cannot be read, subscribers may miss some: %s", error)
            kept = ()
        self._log = EventLog(kept)
        readable = [event for event in self._log.kept if _is_readable(event)]
        if damaged := self._log.damaged + len(self._log.kept) - len(readable):
            log.warning("kept events left out, for they are damaged: %d; subscribers may miss them", damaged)
        for event in readable:
            self._note(event)
        # Those of another source were told when the memory could not be read; told again, they would be new.
        again = readable[-EVENTS_AGAIN:]
        self._unsent.extend(event for event in again if event.source == self._log.source)
        self._log.kept = []

    def _connect(self) -> ZenohLink | None:
        """Open the session; a client asks again until a router answers. None when closed before."""
        assert self._log is not None
        config = session_config(self._settings, self._log.source)
        answerer = Answerer(self._keys, self._published, self._settings.encoding)
        while True:
            try:
                session = zenoh.open(config)
                link = ZenohLink(session, self._keys, answerer, self._acknowledge, self.counters)
                link.open()
            except zenoh.ZError as error:
                reason = reason_of(error)
                if self._settings.mode == "peer":
                    wanted = endpoints_of(self._settings)
                    raise WorkError(f"the Zenoh session {wanted} cannot be opened: {reason}") from None
                if not self._tried.is_set():
                    log.warning("no Zenoh router yet, trying on: %s", reason)
                    self._tried.set()
                with self._news:
                    closing = self._news.wait_for(lambda: self._closing, RETRY_S)
                self._keep_waiting()
                if closing:
                    return None
            else:
                if self._settings.mode == "peer":
                    self.endpoints = link.locators() if chooses_port(self._settings) else self._settings.listen
                listening = ", ".join(self.endpoints) if chooses_port(self._settings) else ""
                log.info("Zenoh session open, %s", listening or endpoints_of(self._settings))
                if self._about is not None:
                    self._put_state(link, self._keys.meta, self._about)
                return link

    def _turn(self, link: ZenohLink) -> bool:
        """Send what waits, or wait for it; False when it was the last turn."""
        with self._news:
            self._news.wait_for(self._has_news, TURN_S)
            closing = self._closing
            estimate, self._estimate = self._estimate, None
            intake, self._intake = self._intake, None
        self._keep_waiting()
        try:
            while self._unsent:
                link.put_event(self._unsent[0])
                self._unsent.popleft()
                self.counters.events_sent += 1
            if estimate is not None:
                self._send_estimate(link, *estimate)
            if intake is not None:
                self._send_health(link, intake)
        except zenoh.ZError as error:
            self._fail("Zenoh refused to publish", reason_of(error))
            with self._news:
                self._news.wait_for(lambda: self._closing, TURN_S)
        return not closing

    def _has_news(self) -> bool:
        return bool(self._estimate or self._waiting or self._intake or self._closing or self._open is not None)

    def _keep_waiting(self) -> None:
        """Number what waits, and put it into the outbox before anything of it is sent."""
        assert self._log is not None
        with self._news:
            waiting, self._waiting = self._waiting, deque()
            lost, self._lost = self._lost, Counter()
            still_open, self._open = self._open, None
        encoding = self._settings.encoding
        for stream, count in lost.items():
            self._log.skip(stream, count)
        if still_open is not None:
            waiting = deque((*self._untold(still_open), *waiting))
        for news in waiting:
            now_s = time.time()
            payload = encode(news.message(self._log.next_sequence(news.stream), now_s), encoding)
            event = self._log.add(news.stream, news.key, payload, encoding, over=news.over)
            self._note(event)
            self._unsent.append(event)
            self._unkept[event.number] = message_of(event)
        if not self._unkept:
            return
        try:
            self._outbox.keep(self._unkept)
        except BrakeMonitorError as error:
            self._fail("events cannot be kept, a restart now would lose them", str(error))
            for number in list(self._unkept)[: max(0, len(self._unkept) - EVENTS_WAITING)]:
                del self._unkept[number]
        else:
            self._unkept = {}

    def _untold(self, still_open: Sequence[Alarm]) -> Iterator[_News]:
        """What subscribers must hear so that what they take for open is what is."""
        told = self._published.open_alarms()
        known = {alarm.id for alarm in still_open}
        for name, (key, unknown) in told.items():
            if name not in known:
                yield _News("alarm", self._below(key), partial(_given_up, unknown), True)
        for alarm in still_open:
            _, last = told.get(alarm.id, (None, None))
            stands = (alarm.severity, alarm.acknowledged_time_s)
            if last is None or (last.severity, last.acknowledged_time_s) != stands:
                yield self._alarm_news(alarm)

    def _note(self, event: Event) -> None:
        """Let those know who ask."""
        key = f"{self._keys.wagon}/{event.key}"
        self._published.set(key, None if event.over else Payload(event.encoding, event.payload))
        if event.key.startswith("alarm/"):
            self._published.add_alarm(key, _content(event, AlarmMessage))

    def _fail(self, what: str, reason: str) -> None:
        self.counters.failures += 1
        if self.counters.failures == 1:
            log.warning("%s: %s", what, reason)

    def _send_estimate(self, link: ZenohLink, sequence: int, estimate: Estimate) -> None:
        now_s = time.time()
        self._newest = (estimate.time_s, estimate.status)
        self._published.add(PublishedEstimate(estimate, sequence, now_s))
        self._put_state(link, self._keys.adhesion, AdhesionMessage.of(estimate, sequence, now_s))
        for i in range(1, len(estimate.wheelsets) + 1):
            self._put_state(link, self._keys.friction(i), FrictionMessage.of(estimate, i, sequence, now_s))
            self._put_state(link, self._keys.axle_adhesion(i), AxleAdhesionMessage.of(estimate, i, sequence, now_s))
        self.counters.estimates_sent += 1
        self.counters.add_latency(now_s - estimate.time_s)

    def _send_health(self, link: ZenohLink, intake: Intake) -> None:
        self._health_sequence += 1
        waiting = len(self._waiting) + len(self._unsent)
        uptime_s = time.monotonic() - self._begun_s
        self.health = health_of(
            intake,
            self.counters,
            self._newest,
            events_waiting=waiting,
            uptime_s=uptime_s,
            sequence=self._health_sequence,
            now_s=time.time(),
        )
        self._put_state(link, self._keys.health, self.health)
        if self._about is not None and self._health_sequence % META_EVERY == 1:
            self._put_state(link, self._keys.meta, self._about)

    def _put_state(self, link: ZenohLink, key: str, message: Message) -> None:
        payload = Payload(self._settings.encoding, encode(message, self._settings.encoding))
        self._published.set(key, payload)
        link.put_state(key, payload)

    # -- the thread that answers -------------------------------------------------------------------------------

    def _acknowledge(self, alarm_id: str) -> None:
        if not self._settings.accept_acknowledgements:
            raise RefusedError("the configuration does not let alarms be acknowledged from here")
        if not self._published.is_open(alarm_id):
            raise RefusedError("no open alarm has this id")
        with self._news:
            if not self._acknowledgeable:
                raise RefusedError("the daemon is about to end or to begin anew; try again later")
            if len(self._acknowledged) >= ACKNOWLEDGEMENTS_WAITING:
                raise RefusedError("too many acknowledgements wait; try again later")
            self._acknowledged.append(alarm_id)


def _content(event: Event, kind: type[T]) -> T:
    decode = msgspec.msgpack.decode if event.encoding == "msgpack" else msgspec.json.decode
    return decode(event.payload, type=kind)


def _is_readable(event: Event) -> bool:
    """Whether subscribers can make sense of it."""
    try:
        _content(event, AlarmMessage if event.key.startswith("alarm/") else WearMessage)
    except (msgspec.MsgspecError, ValueError):
        return False
    return True


def _given_up(alarm: AlarmMessage, sequence: int, publish_time_s: float) -> AlarmMessage:
    """An alarm that was open when an earlier run ended, and that nobody watches any more."""
    over = {"state": "cleared", "time_s": publish_time_s, "cleared_time_s": publish_time_s}
    return replace(alarm, **over, sequence=sequence, publish_time_s=publish_time_s)
