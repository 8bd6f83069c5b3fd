"""Events on their way: numbered, kept in the outbox before any is sent, and sent again after a restart."""

import logging
import time
from collections import deque
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import islice

from msgspec.structs import replace

from brake_monitor.errors import BrakeMonitorError
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.publishing.encoding import Format, NotUnderstoodError, decode, encode
from brake_monitor.publishing.handover import EVENTS_WAITING, Events, News
from brake_monitor.publishing.health import Counters
from brake_monitor.publishing.outbox import Event, EventLog, Outbox, message_of
from brake_monitor.publishing.payloads import AlarmMessage, WearMessage
from brake_monitor.publishing.published import Payload, Published
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.settings.wear_settings import WearSettings

# So many of an earlier run are sent again: a subscriber may have missed them; plain subscribers hear them twice.
EVENTS_AGAIN = 1000

log = logging.getLogger(__name__)


def alarm_news(keys: KeySpace, alarm: Alarm) -> News:
    """The event that tells how an alarm stands now."""
    key = keys.below(keys.alarm(alarm.kind, alarm.wheelset))
    return News(key, partial(AlarmMessage.of, alarm), alarm.cleared_time_s is not None)


def wear_news(keys: KeySpace, brakes: Brakes, settings: WearSettings) -> Iterator[News]:
    """The events that tell how the pads of each wheelset are."""
    for wheelset in range(1, len(brakes.units) + 1):
        yield News(keys.below(keys.wear(wheelset)), partial(WearMessage.of, brakes, wheelset, settings), over=False)


class EventQueue:
    """Only the thread that publishes uses it, for it is the only one that may call the outbox."""

    def __init__(
        self, outbox: Outbox, keys: KeySpace, published: Published, encoding: Format, counters: Counters
    ) -> None:
        """Go on with what an earlier run has kept, except what the disk has damaged since."""
        self._outbox, self._keys, self._published, self._encoding = outbox, keys, published, encoding
        self._counters = counters
        self._unkept: dict[int, bytes] = {}  # the outbox could not take them yet
        self._senseless = 0  # kept events that subscribers could make nothing of
        again: deque[Event] = deque(maxlen=EVENTS_AGAIN)
        try:
            self._log = EventLog(outbox.kept(), lambda event: self._take_up(event, again))
        except BrakeMonitorError as error:
            log.warning("kept events cannot be read, subscribers may miss some: %s", error)
            again.clear()
            published.clear()
            self._log = EventLog(())
        if damaged := self._log.damaged + self._senseless:
            log.warning("kept events left out, for they are damaged: %d; subscribers may miss them", damaged)
        # Those of another source were sent while the memory could not be read; sent again, they would count as new.
        self.unsent: deque[Event] = deque(event for event in again if event.source == self._log.source)
        self.source = self._log.source  # id of the session that is to publish them

    def put(self, events: Events) -> None:
        """Number them and put them into the outbox. WorkError when that fails now; the next call tries again.

        Each that cannot be kept is counted once, however often that is tried.
        """
        untried = 0
        for stream, count in events.lost.items():
            self._log.skip(stream, count)
        for news in self._in_order(events):
            payload = encode(news.message(self._log.next_sequence(news.stream), time.time()), self._encoding)
            event = self._log.add(news.stream, news.key, payload, self._encoding, over=news.over)
            self._note(event)
            self.unsent.append(event)
            self._unkept[event.number] = message_of(event)
            untried += 1
        while len(self.unsent) > EVENTS_WAITING:  # no router has ever answered
            self.unsent.popleft()
            self._counters.events_lost += 1
        if self._unkept:
            try:
                self._outbox.keep(self._unkept)
            except BrakeMonitorError:
                self._counters.publish_failures += untried
                for number in list(self._unkept)[: max(0, len(self._unkept) - EVENTS_WAITING)]:
                    del self._unkept[number]
                raise
            self._unkept = {}

    def _in_order(self, events: Events) -> Iterator[News]:
        """The news, and between them what the alarms that are open call for, by all that was noted before."""
        news = iter(events.news)
        yield from islice(news, events.older)
        if events.still_open is not None:
            yield from self._untold(events.still_open)
        yield from news

    def _untold(self, still_open: Sequence[Alarm]) -> Iterator[News]:
        """What subscribers must hear so that the alarms they take for open are those that are."""
        told = self._published.open_alarms()
        known = {alarm.id for alarm in still_open}
        for name, (key, unknown) in told.items():
            if name not in known:
                yield News(self._keys.below(key), partial(_given_up, unknown), True)
        for alarm in still_open:
            _, last = told.get(alarm.id, (None, None))
            stands = (alarm.severity, alarm.acknowledged_time_s)
            if last is None or (last.severity, last.acknowledged_time_s) != stands:
                yield alarm_news(self._keys, alarm)

    def _take_up(self, event: Event, again: deque[Event]) -> None:
        """Keep what an earlier run has kept for those who ask, and to be sent again."""
        try:
            self._note(event)
        except NotUnderstoodError:
            self._senseless += 1
        else:
            again.append(event)

    def _note(self, event: Event) -> None:
        """Keep the event for those who ask later; NotUnderstoodError when nobody could make sense of it."""
        kind = AlarmMessage if event.key.startswith("alarm/") else WearMessage
        message, key = decode(event.payload, kind, event.encoding), self._keys.under(event.key)
        self._published.set(key, None if event.over else Payload(event.encoding, event.payload))
        if isinstance(message, AlarmMessage):
            self._published.add_alarm(key, message)


def _given_up(alarm: AlarmMessage, sequence: int, publish_time_s: float) -> AlarmMessage:
    """An alarm that was open when an earlier run ended, and that nobody watches any more."""
    over = {"state": "cleared", "time_s": publish_time_s, "cleared_time_s": publish_time_s}
    return replace(alarm, **over, sequence=sequence, publish_time_s=publish_time_s)
