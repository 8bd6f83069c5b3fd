"""Outputs → Zenoh, from a thread of its own: whatever the network does, the estimator never waits for it.

Estimates and health are states: the newest wins, and congested links drop them. Alarms and wear are events: they are
kept in the outbox before they are sent, and reach an advanced subscriber exactly once and in order, over outages and
restarts. Last values answer a query.
"""

import logging
import threading
import time
from collections.abc import Sequence
from typing import Self

import zenoh
from msgspec.structs import replace

from brake_monitor.errors import BrakeMonitorError, WorkError
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.answers import Answerer, QuestionRefusedError
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.event_queue import EventQueue, alarm_news, wear_news
from brake_monitor.publishing.handover import Handover
from brake_monitor.publishing.health import Counters, Intake, health_of
from brake_monitor.publishing.outbox import NoOutbox, Outbox
from brake_monitor.publishing.payloads import HealthMessage, Message, MetaMessage
from brake_monitor.publishing.published import Payload, Published, PublishedEstimate
from brake_monitor.publishing.zenoh_endpoints import chooses_port, endpoints_of
from brake_monitor.publishing.zenoh_link import ZenohLink
from brake_monitor.publishing.zenoh_opening import Opening
from brake_monitor.publishing.zenoh_session import reason_of, session_config
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings

META_EVERY = 60  # meta is published again after so many healths: at the start nobody is connected yet
TURN_S = 0.25  # the thread shows a heartbeat at least this often
RETRY_S = 0.5  # between attempts to reach a router
OPEN_S = 3.0  # the longest that `start` waits for a router that does not even refuse
CLOSE_S = 1.0

log = logging.getLogger(__name__)


class Publisher:
    """Publishes one wagon's outputs. Only `start` and `close` may wait; everything else takes microseconds.

    `outbox` is only used by the publisher's thread, which closes it in the end. InputError when an endpoint is
    malformed or a certificate cannot be read.
    """

    def __init__(
        self, settings: ZenohSettings, wagon_id: str, *, outbox: Outbox | None = None, about: MetaMessage | None = None
    ) -> None:
        self.counters = Counters()
        self.endpoints: tuple[str, ...] = ()  # that subscribers can connect to, with their real ports; after `start`
        self.health: HealthMessage | None = None  # as last published
        self._keys = KeySpace(settings.prefix, wagon_id)
        self._settings = settings
        self._about = about
        self._outbox = outbox or NoOutbox()
        self._published = Published()
        session_config(settings)  # refuses what is malformed
        self._handover = Handover(self.counters)
        self._last_sent: tuple[float, Status] | None = None  # capture time and status of an estimate
        self._health_sequence = 0
        self._told: set[str] = set()  # what failed, as logged
        self._tried = threading.Event()  # the first attempt to open a session is over
        self._is_awaited = True  # by `start`, to raise what goes wrong
        self._failure: BrakeMonitorError | None = None
        self._begun_s = self._beat_s = time.monotonic()
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
        self._beat_s = time.monotonic()
        self._thread.start()
        self._is_awaited = self._tried.wait(OPEN_S)
        if self._failure is not None:
            raise self._failure

    def give_up_waiting(self) -> None:
        """Let `start` return now, for the program is to end; before it or while it waits, from any thread."""
        self._tried.set()

    def publish(self, outputs: Outputs) -> None:
        """Hand the outputs over; never waits for the network, never raises because of it."""
        if outputs.estimate is not None or outputs.alarms:
            self._handover.give(outputs.estimate, [alarm_news(self._keys, alarm) for alarm in outputs.alarms])

    def publish_wear(self, brakes: Brakes, settings: WearSettings) -> None:
        """Hand the state of all brake units over."""
        self._handover.give(None, wear_news(self._keys, brakes, settings))

    def publish_open_alarms(self, alarms: Sequence[Alarm]) -> None:
        """Hand over all that are open when the daemon begins, so that nobody goes by what an earlier run said.

        Subscribers now hear of open alarms that it could not send; an alarm that no longer exists is cleared.
        """
        self._handover.give_open_alarms(tuple(alarms))

    def publish_health(self, intake: Intake) -> None:
        """Hand over how the daemon is doing."""
        self._handover.give_intake(intake)

    def acknowledged(self) -> list[str]:
        """The ids of alarms that remote parties have acknowledged since the last call."""
        return self._handover.acknowledged()

    def refuse_acknowledgements(self, why: str) -> None:
        """Accept no more acknowledgements; those accepted before can still be fetched."""
        self._handover.refuse_acknowledgements(why)

    def heartbeat_age_s(self) -> float:
        """Seconds since the thread last completed a turn; it does so several times a second when all is well.

        Turns no longer count once the thread that answers questions has ended, which it does of an error of ours.
        """
        return time.monotonic() - self._beat_s

    def close(self) -> None:
        """Send what waits, say good-bye and end the thread, within CLOSE_S; a second call does nothing."""
        self._handover.close()
        if self._thread.is_alive():
            self._thread.join(CLOSE_S)
        if self._thread.is_alive():
            who = "a router, a subscriber or the machine hangs"
            log.warning("the Zenoh session has not closed within %.1f s: %s; leaving it", CLOSE_S, who)

    # -- the thread --------------------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._publish()
        finally:
            self._outbox.close()

    def _publish(self) -> None:
        try:
            events = EventQueue(self._outbox, self._keys, self._published, self._settings.encoding, self.counters)
            link = self._connect(events)
        except BrakeMonitorError as error:
            self._failure = error
            if not self._is_awaited:
                log.warning("%s; nothing is published", error)
            return
        finally:
            self._tried.set()
        if link is not None:
            try:
                while self._turn(link, events):
                    if link.is_answering:
                        self._beat_s = time.monotonic()
            finally:
                link.close()

    def _connect(self, events: EventQueue) -> ZenohLink | None:
        """Open the session; a client asks again until a router answers. None when closed before."""
        config = session_config(self._settings, events.source)
        answerer = Answerer(self._keys, self._published, self._settings.encoding)
        while True:
            opened = self._opened(config, events)
            if opened is None:
                return None
            try:
                if isinstance(opened, zenoh.ZError):
                    raise opened
                return self._link(opened, answerer)
            except zenoh.ZError as error:
                reason = reason_of(error)
                if self._settings.mode == "peer":
                    wanted = endpoints_of(self._settings)
                    raise WorkError(f"the Zenoh session {wanted} cannot be opened: {reason}") from None
                if not self._tried.is_set():
                    log.warning("no Zenoh router yet, still trying: %s", reason)
                    self._tried.set()
                if self._is_closed_within(RETRY_S, events):
                    return None

    def _opened(self, config: zenoh.Config, events: EventQueue) -> zenoh.Session | zenoh.ZError | None:
        """A session, or why there is none; None when closed before. Events are kept meanwhile."""
        opening = Opening(config)
        while (found := opening.found(TURN_S)) is None:
            if self._is_closed_within(0.0, events):
                opening.give_up()
                return None
        return found

    def _is_closed_within(self, span_s: float, events: EventQueue) -> bool:
        """Wait for so long, or until nothing more will be given; whether that is so. All that was given is kept."""
        closing = self._handover.is_closed_within(span_s)
        self._take_events(events)
        self._beat_s = time.monotonic()
        return closing

    def _link(self, session: zenoh.Session, answerer: Answerer) -> ZenohLink:
        """Declare everything in a session; a session in which that fails is closed."""
        link = ZenohLink(
            session, self._keys, answerer, self._acknowledge, self.counters, connect=self._settings.connect
        )
        try:
            link.open()
            self._tell_endpoints(link)
            if self._about is not None:
                self._put_state(link, self._keys.meta, self._about)
        except zenoh.ZError:
            link.close()
            raise
        return link

    def _tell_endpoints(self, link: ZenohLink) -> None:
        if self._settings.mode == "peer":
            self.endpoints = link.locators() if chooses_port(self._settings) else self._settings.listen
        opened = replace(self._settings, listen=self.endpoints or self._settings.listen)
        log.info("Zenoh session open, %s", endpoints_of(opened))

    def _turn(self, link: ZenohLink, events: EventQueue) -> bool:
        """Send what waits, or wait for it; False when it was the last turn."""
        newest = self._handover.newest(TURN_S)
        self._take_events(events)
        try:
            while events.unsent:
                link.put_event(events.unsent[0])
                events.unsent.popleft()
                self.counters.events_sent += 1
            if newest.estimate is not None:
                self._send_estimate(link, *newest.estimate)
            if newest.intake is not None:
                self._send_health(link, newest.intake, len(events.unsent))
        except zenoh.ZError as error:
            self.counters.publish_failures += 1
            self._warn_once("Zenoh refused to publish", reason_of(error))
            self._handover.is_closed_within(TURN_S)
        return not newest.is_last

    def _take_events(self, events: EventQueue) -> None:
        try:
            events.put(self._handover.events())
        except BrakeMonitorError as error:
            self._warn_once("events cannot be kept, a restart now would lose them", str(error))

    def _warn_once(self, what: str, reason: str) -> None:
        if what not in self._told:
            self._told.add(what)
            log.warning("%s: %s", what, reason)

    def _send_estimate(self, link: ZenohLink, sequence: int, estimate: Estimate) -> None:
        now_s = time.time()
        self._last_sent = (estimate.time_s, estimate.status)
        published = PublishedEstimate(estimate, sequence, now_s)
        self._published.add(published)
        for key, message in published.messages(self._keys):
            self._put_state(link, key, message)
        self.counters.estimates_sent += 1
        self.counters.add_latency(now_s - estimate.time_s)

    def _send_health(self, link: ZenohLink, intake: Intake, events_unsent: int) -> None:
        self._health_sequence += 1
        self.health = health_of(
            intake,
            self.counters,
            self._last_sent,
            events_waiting=self._handover.waiting + events_unsent,
            open_alarms=self._published.open_alarms(),
            uptime_s=time.monotonic() - self._begun_s,
            sequence=self._health_sequence,
            now_s=time.time(),
        )
        self._put_state(link, self._keys.health, self.health)
        link.look_around()
        if self._about is not None and self._health_sequence % META_EVERY == 1:
            self._put_state(link, self._keys.meta, self._about)

    def _put_state(self, link: ZenohLink, key: str, message: Message) -> None:
        payload = Payload(self._settings.encoding, encode(message, self._settings.encoding))
        self._published.set(key, payload)
        link.put_state(key, payload)

    # -- the thread that answers -------------------------------------------------------------------------------

    def _acknowledge(self, alarm_id: str) -> None:
        if not self._settings.accept_acknowledgements:
            raise QuestionRefusedError("the configuration does not let alarms be acknowledged from here")
        if alarm_id not in self._published.open_alarms():
            raise QuestionRefusedError("no open alarm has this id")
        self._handover.acknowledge(alarm_id)
