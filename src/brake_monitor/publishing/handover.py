"""What the daemon's threads give the one that publishes, and what comes back: all that they share, guarded.

Two queues with opposite promises. Of estimates only the newest counts, so they wait in a single slot. Events wait in
order; of too many, the oldest are dropped and counted.
"""

import threading
from collections import Counter, deque
from collections.abc import Callable, Iterable
from typing import NamedTuple

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.publishing.answers import QuestionRefusedError
from brake_monitor.publishing.health import Counters, Intake
from brake_monitor.publishing.payloads import Message

EVENTS_WAITING = 10_000  # for the thread; each is about 1 kB
ACKNOWLEDGEMENTS_WAITING = 100


class News(NamedTuple):
    """An event that is not numbered yet."""

    key: str  # below the wagon's
    message: Callable[[int, float], Message]  # sequence, publish_time_s → the message
    over: bool  # as in `Event`

    @property
    def stream(self) -> str:
        """What it counts in: all alarms are one stream, the wear of each wheelset is its own."""
        return "alarm" if self.key.startswith("alarm/") else self.key


class Newest(NamedTuple):
    """The states that are to be published now."""

    estimate: tuple[int, Estimate] | None  # how many were given so far, and the newest
    intake: Intake | None
    is_last: bool  # nothing more will be


class Events(NamedTuple):
    """The events that are to be published now."""

    news: deque[News]
    lost: Counter[str]  # dropped while they waited, by stream
    still_open: tuple[Alarm, ...] | None  # all that are as the daemon begins ...
    older: int  # ... and how many of the news were given before these


class Handover:
    """Each side takes microseconds; only the thread that publishes waits."""

    def __init__(self, counters: Counters) -> None:
        self._counters = counters
        self._changed = threading.Condition()  # guards all of it
        self._estimate: tuple[int, Estimate] | None = None
        self._estimates_given = 0
        self._intake: Intake | None = None
        self._news: deque[News] = deque()
        self._lost: Counter[str] = Counter()
        self._still_open: tuple[Alarm, ...] | None = None
        self._older = 0  # as in `Events`
        self._acknowledged: deque[str] = deque()
        self._unacknowledgeable = ""  # why, where no acknowledgement is accepted
        self._closing = False

    @property
    def waiting(self) -> int:
        """How many events wait."""
        return len(self._news)

    # -- the daemon's side -------------------------------------------------------------------------------------

    def give(self, estimate: Estimate | None, news: Iterable[News] = ()) -> None:
        """An estimate, which replaces one that waits, and events."""
        with self._changed:
            if estimate is not None:
                self._estimates_given += 1
                self._counters.estimates_replaced += self._estimate is not None
                self._estimate = (self._estimates_given, estimate)
            self._news.extend(news)
            while len(self._news) > EVENTS_WAITING:
                self._lost[self._news.popleft().stream] += 1  # the newest tell most; subscribers see the gap
                self._older = max(0, self._older - 1)
                self._counters.events_lost += 1
            self._changed.notify()

    def give_intake(self, intake: Intake) -> None:
        """Hand over the counts for the next health message."""
        with self._changed:
            self._intake = intake
            self._changed.notify()

    def give_open_alarms(self, alarms: tuple[Alarm, ...]) -> None:
        """Hand over all alarms that are open as the daemon begins."""
        with self._changed:
            self._still_open, self._older = alarms, len(self._news)
            self._changed.notify()

    def acknowledged(self) -> list[str]:
        """The ids of alarms that remote parties have acknowledged since the last call."""
        if not self._acknowledged:
            return []
        return [self._acknowledged.popleft() for _ in range(len(self._acknowledged))]

    def refuse_acknowledgements(self, why: str) -> None:
        """Accept no more acknowledgements; those accepted before can still be fetched."""
        with self._changed:
            self._unacknowledgeable = why

    def close(self) -> None:
        """Tell the publishing thread that nothing more will be given."""
        with self._changed:
            self._closing = True
            self._changed.notify()

    # -- the side of the thread that publishes -----------------------------------------------------------------

    def newest(self, longest_s: float) -> Newest:
        """Wait until there is anything, but no longer than this; the states that there are."""
        with self._changed:
            self._changed.wait_for(self._has_any, longest_s)
            newest = Newest(self._estimate, self._intake, self._closing)
            self._estimate = self._intake = None
            return newest

    def events(self) -> Events:
        """The events that there are."""
        with self._changed:
            events = Events(self._news, self._lost, self._still_open, self._older)
            self._news, self._lost, self._still_open, self._older = deque(), Counter(), None, 0
            return events

    def is_closed_within(self, span_s: float) -> bool:
        """Wait for so long, or until nothing more will be given; whether that is so."""
        with self._changed:
            return self._changed.wait_for(lambda: self._closing, span_s)

    def _has_any(self) -> bool:
        given = self._estimate or self._news or self._intake or self._still_open is not None
        return bool(given or self._closing)

    # -- the side of the thread that answers -------------------------------------------------------------------

    def acknowledge(self, alarm_id: str) -> None:
        """Let the daemon know; QuestionRefusedError when it cannot take it now."""
        with self._changed:
            if self._unacknowledgeable:
                raise QuestionRefusedError(self._unacknowledgeable)
            if len(self._acknowledged) >= ACKNOWLEDGEMENTS_WAITING:
                raise QuestionRefusedError("too many acknowledgements wait; try again later")
            self._acknowledged.append(alarm_id)
