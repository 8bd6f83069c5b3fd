"""An open Zenoh session and what is declared on it."""

import json
import logging
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from queue import Full, Queue
from uuid import uuid4

import zenoh
from zenoh import ext

from brake_monitor.publishing.answers import Answerer, QuestionRefusedError, time_range
from brake_monitor.publishing.encoding import MEDIA_TYPES, NotUnderstoodError, decode, encode, format_of
from brake_monitor.publishing.health import Counters
from brake_monitor.publishing.outbox import Event
from brake_monitor.publishing.payloads import LONGEST_REQUEST, AcknowledgeReply, AcknowledgeRequest
from brake_monitor.publishing.published import Payload
from brake_monitor.publishing.zenoh_callback import AwaitedCallback
from brake_monitor.publishing.zenoh_namesake import Namesake
from brake_monitor.publishing.zenoh_neighbour import Neighbour
from brake_monitor.publishing.zenoh_session import reason_of
from brake_monitor.settings.key_space import KeySpace

EVENTS_CACHED = 1000  # per key, for subscribers that come back
QUERIES_WAITING = 64
REST_FACTOR = 2.0  # after a list the answering thread rests this much longer than it worked: it never takes a core
LONGEST_REST_S = 0.5
INFO_S = 1.5  # longest wait for the session's own word on where it listens

log = logging.getLogger(__name__)

Acknowledge = Callable[[str], None]  # takes the id of an open alarm; QuestionRefusedError when that is not wanted


class ZenohLink:
    """Puts what the publisher gives it, answers questions in a thread of its own."""

    def __init__(
        self,
        session: zenoh.Session,
        keys: KeySpace,
        answerer: Answerer,
        acknowledge: Acknowledge,
        counters: Counters,
        *,
        connect: Sequence[str],
    ) -> None:
        """`connect`: the endpoints that the session connects to."""
        self._session = session
        self._keys = keys
        self._answerer = answerer
        self._acknowledge = acknowledge
        self._counters = counters
        self._states: dict[str, zenoh.Publisher] = {}
        self._events: dict[str, ext.AdvancedPublisher] = {}
        self._source = session.new_timestamp().get_id()  # the session's own id: what subscribers know events by
        self._state_source = zenoh.TimestampId(uuid4().bytes)  # another in each run: its clock may have been set back
        self._queries: Queue[zenoh.Query | None] = Queue(QUERIES_WAITING)  # None: wake up and end
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._answer_all, name="zenoh answers", daemon=True)
        self._taking = AwaitedCallback(self._take)
        self._token: zenoh.LivelinessToken | None = None
        self._queryable: zenoh.Queryable[None] | None = None
        self._namesake: Namesake | None = None
        self._neighbour = Neighbour(session, connect)

    def open(self) -> None:
        """Say that we live, and answer questions from now on."""
        self._thread.start()
        self._queryable = self._session.declare_queryable(self._keys.everything, self._taking.handler)
        self._token = self._session.liveliness().declare_token(self._keys.wagon)
        self._namesake = Namesake(self._session, self._keys)

    @property
    def is_answering(self) -> bool:
        """Whether the thread that answers has not ended."""
        return self._thread.is_alive()

    def locators(self) -> tuple[str, ...]:
        """The endpoints listened on, as the session itself reports them: port 0 has become a number."""
        key = f"@/{self._session.info.zid()}/peer"
        for reply in self._session.get(key, timeout=INFO_S):
            if reply.ok is not None:
                return tuple(json.loads(reply.ok.payload.to_bytes())["locators"])
        return ()

    def put_state(self, key: str, payload: Payload) -> None:
        """Publish a value that the next one supersedes."""
        publisher = self._states.get(key)
        if publisher is None:
            publisher = self._session.declare_publisher(key, congestion_control=zenoh.CongestionControl.DROP)
            self._states[key] = publisher
        # Not as of the events' source: who subscribes to both would take an event, whose stamp counts, for an old one.
        stamp = zenoh.Timestamp(self._session.new_timestamp().get_time_as_ntp64(), self._state_source)
        publisher.put(payload.content, encoding=MEDIA_TYPES[payload.encoding], timestamp=stamp)

    def look_around(self) -> None:
        """Tell of a router that is gone or back, and of somebody else who publishes under our name."""
        self._neighbour.look()
        if self._namesake is not None:
            self._namesake.look()

    def put_event(self, event: Event) -> None:
        """Publish an event that nobody may miss."""
        key = self._keys.under(event.key)
        publisher = self._events.get(key) or self._declare_event(key)
        seconds, microseconds = divmod(event.stamp_us, 1_000_000)
        publisher.put(
            event.payload,
            encoding=MEDIA_TYPES[event.encoding],
            timestamp=zenoh.Timestamp(zenoh.NTP64(seconds, microseconds * 1000), self._source),
        )

    def _declare_event(self, key: str) -> ext.AdvancedPublisher:
        # Without sample numbers subscribers order by time stamps, which outlive a restart; a link that comes back is
        # noticed by the publisher's token, and what is missing is taken from the cache.
        publisher = ext.declare_advanced_publisher(
            self._session,
            key,
            congestion_control=zenoh.CongestionControl.BLOCK,
            cache=ext.CacheConfig(max_samples=EVENTS_CACHED),
            publisher_detection=True,
        )
        self._events[key] = publisher
        return publisher

    def close(self) -> None:
        """Say good-bye and close. A neighbour that hangs with data on the way delays closing by 10 s."""
        self._closing.set()
        with suppress(Full):  # then the thread is awake
            self._queries.put_nowait(None)
        if self._token is not None:
            self._token.undeclare()  # type: ignore[no-untyped-call]
        if self._queryable is not None:
            self._queryable.undeclare()  # type: ignore[no-untyped-call]
            self._queryable = None
            self._taking.join()
            self._thread.join(INFO_S)
        if self._namesake is not None:
            self._namesake.close()
        try:
            self._session.close()  # type: ignore[no-untyped-call]
        except zenoh.ZError as error:
            log.warning("the Zenoh session did not close: %s", reason_of(error))

    # -- questions ---------------------------------------------------------------------------------------------

    def _take(self, query: zenoh.Query) -> None:
        """Called in Zenoh's own thread: only queue the question."""
        try:
            self._queries.put_nowait(query)
        except Full:
            self._end(query, self._turn_away)

    def _answer_all(self) -> None:
        while not self._closing.is_set():
            query = self._queries.get()
            if query is None:
                return
            begun_s = time.monotonic()
            self._end(query, self._answer_or_refuse)
            self._closing.wait(min((time.monotonic() - begun_s) * REST_FACTOR, LONGEST_REST_S))

    def _end(self, query: zenoh.Query, reply: Callable[[zenoh.Query], None]) -> None:
        """Reply and let the question go, also where whoever asked is gone."""
        try:
            reply(query)
        except zenoh.ZError as error:
            self._counters.publish_failures += 1
            log.debug("a question could not be answered: %s", reason_of(error))
        query.drop()  # type: ignore[no-untyped-call]

    def _turn_away(self, query: zenoh.Query) -> None:
        self._refuse(query, "too many questions wait; ask again later")

    def _answer_or_refuse(self, query: zenoh.Query) -> None:
        try:
            self._answer(query)
        except QuestionRefusedError as refusal:
            self._refuse(query, str(refusal))

    def _answer(self, query: zenoh.Query) -> None:
        asked = str(query.key_expr)
        if asked == self._keys.acknowledge:
            self._answer_acknowledgement(query)
            return
        if query.payload and query.key_expr.intersects(self._keys.acknowledge):
            raise QuestionRefusedError(f"expected {self._keys.acknowledge}: one wagon's alarm, no wild cards")
        if len(str(query.parameters)) > LONGEST_REQUEST:
            raise QuestionRefusedError(f"expected parameters of at most {LONGEST_REQUEST} bytes")
        wanted = time_range(dict(query.parameters))  # type: ignore[call-overload]  # the stub means an iterator
        meant = query.key_expr.intersects
        answers = self._answerer.newest(asked, meant) if wanted is None else self._answerer.past(meant, wanted)
        for key, payload in answers:
            query.reply(key, payload.content, encoding=MEDIA_TYPES[payload.encoding])
        self._counters.queries_answered += 1

    def _answer_acknowledgement(self, query: zenoh.Query) -> None:
        payload = query.payload
        if payload is None or len(payload) > LONGEST_REQUEST:
            raise QuestionRefusedError(
                f'expected a payload like {{"id": "<alarm>"}} of at most {LONGEST_REQUEST} bytes'
            )
        format = format_of(str(query.encoding))
        try:
            request = decode(payload.to_bytes(), AcknowledgeRequest, format)
        except NotUnderstoodError as error:
            raise QuestionRefusedError(f"not understood: {error}") from None
        self._acknowledge(request.id)
        reply = encode(AcknowledgeReply(request.id), format)
        query.reply(self._keys.acknowledge, reply, encoding=MEDIA_TYPES[format])
        self._counters.queries_answered += 1

    def _refuse(self, query: zenoh.Query, sentence: str) -> None:
        self._counters.queries_refused += 1
        query.reply_err(sentence, encoding=zenoh.Encoding.TEXT_PLAIN)
