"""Alarms and wear reach an advanced subscriber exactly once and in order, whatever goes down meanwhile."""

import json
import signal
import socket
import sqlite3
import threading
import time
import tracemalloc
from collections import Counter, deque
from collections.abc import Iterator, Mapping
from contextlib import closing, nullcontext
from math import inf
from pathlib import Path

import pytest
import zenoh
from zenoh import ext

from brake_monitor.errors import WorkError
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes, BrakeUnit
from brake_monitor.monitoring.brake_units.wear import PadWear
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.event_queue import EVENTS_AGAIN, EventQueue, alarm_news
from brake_monitor.publishing.handover import EVENTS_WAITING, Events, Handover
from brake_monitor.publishing.health import Counters
from brake_monitor.publishing.outbox import Event, EventLog, NoOutbox, Outbox, message_of
from brake_monitor.publishing.payloads import AlarmMessage
from brake_monitor.publishing.published import Published
from brake_monitor.publishing.zenoh_session import session_config
from brake_monitor.settings.key_space import KeySpace
from brake_monitor.settings.wear_settings import WearSettings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_outbox import StoreOutbox
from estimates import alarm, estimate
from network import free_port, running, session
from program import Python, Router, until

# An advanced subscriber as somebody else would write it; one line per event: key and sequence.
ADVANCED_SUBSCRIBER = """
import json, sys, zenoh
from zenoh import ext
config = zenoh.Config()
config.insert_json5("mode", json.dumps(sys.argv[2]))
config.insert_json5("scouting/multicast/enabled", "false")
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
config.insert_json5("connect/retry", '{"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}')
def told(sample):
    message = json.loads(sample.payload.to_string())
    print(json.dumps([str(sample.key_expr), message["sequence"], message["message"]]), flush=True)
with zenoh.open(config) as session:
    with ext.declare_advanced_subscriber(
        session, "brake/v1/*/alarm/**", told, history=ext.HistoryConfig(detect_late_publishers=True)
    ):
        print("ready", flush=True)
        sys.stdin.read()
"""

# A daemon that keeps its events in a file; publishes as many alarms, of three kinds, as it is told.
DAEMON = """
import json, sys
from pathlib import Path
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from test_event_delivery import FileOutbox
from program import until
from estimates import alarm
publisher = Publisher(ZenohSettings(connect=(sys.argv[1],)), "wagon-1", outbox=FileOutbox(Path(sys.argv[2])))
publisher.start()
print("started", flush=True)
kinds = ("low_adhesion", "hot_disc", "dragging_brake")
number = int(sys.argv[3])
for line in sys.stdin:
    if line == "close\\n":
        break
    before = publisher.counters.events_sent
    for _ in range(int(line)):
        publisher.publish(Outputs(None, (alarm(kind=kinds[number % 3], message=str(number)),)))
        number += 1
    until(lambda: publisher.counters.events_sent >= before + int(line))
    print(number, flush=True)
publisher.close()
"""


class FileOutbox:
    """Keeps events in a file, one line each: what survives a killed process, as the daemon's memory does."""

    def __init__(self, path: Path) -> None:
        self._path = path

    def keep(self, messages: dict[int, bytes]) -> None:
        with self._path.open("a") as file:
            file.writelines(message.hex() + "\n" for message in messages.values())

    def kept(self) -> list[bytes]:
        return [bytes.fromhex(line) for line in self._path.read_text().splitlines()] if self._path.exists() else []


class Daemon(Python):
    def __init__(self, endpoint: str, path: Path, number: int) -> None:
        super().__init__(DAEMON, endpoint, path, str(number))
        self.wait_for("started")

    def publish(self, count: int) -> int:
        return int(self.ask(str(count)))

    def close(self) -> None:
        self.tell("close")
        assert self.wait() == 0


class Subscriber(Python):
    """What another process was told, in the order that it was told."""

    def __init__(self, endpoint: str, mode: str) -> None:
        super().__init__(ADVANCED_SUBSCRIBER, endpoint, mode)
        self.wait_for("ready")

    def has(self, count: int) -> bool:
        """Wait for as many, and a little longer for what must not come."""
        until(lambda: len(self.told()) >= count)
        time.sleep(0.3)
        return self.told() == list(range(count))

    def told(self) -> list[int]:
        heard = [json.loads(line) for line in self.lines[1:]]
        assert all(sequence == int(message) + 1 for _, sequence, message in heard)  # gapless over restarts
        return [int(message) for _, _, message in heard]


@pytest.mark.parametrize("mode", ["client", "peer"])
def test_every_event_once_and_in_order_over_outages_and_restarts(mode: str, tmp_path: Path) -> None:
    endpoint, path = f"tcp/127.0.0.1:{free_port()}", tmp_path / "outbox"
    with Router(endpoint), Subscriber(endpoint, mode) as heard:
        with Daemon(endpoint, path, 0) as first:
            number = first.publish(30)
            assert heard.has(number)
        # killed; the next goes on where it was
        with Daemon(endpoint, path, number) as second:
            number = second.publish(10)
            assert heard.has(number)
            second.close()
        with Daemon(endpoint, path, number) as third:
            assert heard.has(number)  # nothing is told again
            number = third.publish(1)
            assert heard.has(number)


@pytest.mark.parametrize("mode", ["client", "peer"])
def test_events_of_a_daemon_that_died_within_an_outage_are_told_by_the_next(mode: str, tmp_path: Path) -> None:
    endpoint, path = f"tcp/127.0.0.1:{free_port()}", tmp_path / "outbox"
    with Router(endpoint) as router, Subscriber(endpoint, mode) as heard:
        with Daemon(endpoint, path, 0) as first:
            number = first.publish(10)
            assert heard.has(number)
            router.kill()
            number = first.publish(10)  # into the dark, and then it dies
        with Daemon(endpoint, path, number) as second:
            number = second.publish(10)
            with Router(endpoint):
                assert heard.has(number)
                number = second.publish(5)
                assert heard.has(number)


def test_a_subscriber_that_was_frozen_is_told_all_of_it_later(tmp_path: Path) -> None:
    endpoint, path = f"tcp/127.0.0.1:{free_port()}", tmp_path / "outbox"
    with Router(endpoint), Subscriber(endpoint, "client") as heard, Daemon(endpoint, path, 0) as publishing:
        assert heard.has(publishing.publish(3))
        heard.send_signal(signal.SIGSTOP)
        publishing.publish(300)
        time.sleep(12.0)  # longer than the router's lease: it has cut the subscriber off
        number = publishing.publish(300)
        heard.send_signal(signal.SIGCONT)
        assert heard.has(number)


def test_events_reach_an_advanced_subscriber_that_hears_state_under_the_same_expression() -> None:
    heard: list[tuple[str, int]] = []

    def note(sample: zenoh.Sample) -> None:
        heard.append((str(sample.key_expr), json.loads(sample.payload.to_bytes())["sequence"]))

    history = ext.HistoryConfig(detect_late_publishers=True)
    with (
        running() as publisher,
        session(publisher.endpoints[0]) as other,
        ext.declare_advanced_subscriber(other, "brake/v1/**", note, history=history),
    ):
        until(lambda: publisher.publish(Outputs(estimate(), ())) or heard)  # they have met
        for _ in range(3):
            publisher.publish(Outputs(estimate(), (alarm(),)))
        key = "brake/v1/wagon-1/alarm/low_adhesion"
        until(lambda: [sequence for name, sequence in heard if name == key] == [1, 2, 3])
        until(lambda: {name for name, _ in heard} > {key, "brake/v1/wagon-1/axle/1/friction"})


class MemoryOutbox(NoOutbox):
    """Keeps events while the test runs."""

    def __init__(self) -> None:
        self._messages: dict[int, bytes] = {}

    def keep(self, messages: Mapping[int, bytes]) -> None:
        self._messages |= messages

    def kept(self) -> list[bytes]:
        return list(self._messages.values())


def test_a_late_joiner_is_told_of_open_alarms_that_an_earlier_run_raised() -> None:
    outbox = MemoryOutbox()
    with running(outbox=outbox) as first:
        first.publish(Outputs(None, (alarm(), alarm(kind="hot_disc", wheelset=2))))
        first.publish(Outputs(None, (alarm(cleared_time_s=1700000009.0),)))
    with running(outbox=outbox) as second, session(second.endpoints[0]) as other:
        replies = [reply.ok for reply in other.get("brake/v1/wagon-1/**") if reply.ok]
        assert [str(reply.key_expr) for reply in replies] == ["brake/v1/wagon-1/alarm/hot_disc/2"]


def told(other: zenoh.Session) -> dict[str, tuple[str, int]]:
    """Id and sequence of every alarm that who asks takes for open, by kind."""
    found = [json.loads(reply.ok.payload.to_bytes()) for reply in other.get("brake/v1/*/alarm/**") if reply.ok]
    return {alarm["kind"]: (alarm["id"], alarm["sequence"]) for alarm in found}


def test_at_the_start_subscribers_are_told_where_kept_events_and_open_alarms_differ() -> None:
    """A daemon that was killed may have told an alarm and not remembered it, or remembered one and not told it."""
    outbox = MemoryOutbox()
    same, unknown, untold = alarm(id="a"), alarm(id="b", kind="hot_disc"), alarm(id="c", kind="dragging_brake")
    graver = alarm(id="d", kind="slide", severity=Severity.WARNING)
    with running(outbox=outbox) as first:
        first.publish(Outputs(None, (same, unknown, graver)))
        until(lambda: first.counters.events_sent == 3)
    graver = alarm(id="d", kind="slide", severity=Severity.ALARM)
    with running(outbox=outbox) as second, session(second.endpoints[0]) as other:
        assert told(other).keys() == {"low_adhesion", "hot_disc", "slide"}
        second.publish_open_alarms((same, untold, graver))
        until(lambda: told(other).keys() == {"low_adhesion", "dragging_brake", "slide"})
        assert told(other) == {"low_adhesion": ("a", 1), "dragging_brake": ("c", 5), "slide": ("d", 6)}
        over = [json.loads(r.ok.payload.to_bytes()) for r in other.get("brake/v1/*/alarm/hot_disc?limit=1") if r.ok]
    assert [(entry["id"], entry["state"], entry["sequence"]) for (entry,) in over] == [("b", "cleared", 4)]
    with running(outbox=outbox) as third:
        third.publish_open_alarms((same, untold, graver))
        third.publish(Outputs(None, (alarm(id="e"),)))
        until(lambda: third.counters.events_sent == 7)  # where they agree nothing is told


def test_an_alarm_raised_anew_while_the_daemon_was_down_replaces_the_one_that_nobody_watches() -> None:
    outbox = MemoryOutbox()
    with running(outbox=outbox) as first:
        first.publish(Outputs(None, (alarm(id="old"),)))
        until(lambda: first.counters.events_sent == 1)
    with running(outbox=outbox) as second, session(second.endpoints[0]) as other:
        second.publish_open_alarms((alarm(id="new"),))
        until(lambda: second.counters.events_sent == 3)
        assert told(other) == {"low_adhesion": ("new", 3)}


def test_an_alarm_raised_just_before_the_open_ones_are_told_is_told_once_and_what_follows_comes_after() -> None:
    outbox, handover = MemoryOutbox(), Handover(Counters())
    keys = KeySpace("brake/v1", "wagon-1")
    queue = EventQueue(outbox, keys, Published(), "json", Counters())
    kept, raised = alarm(id="kept", kind="hot_disc"), alarm(id="raised")
    handover.give(None, [alarm_news(keys, raised)])
    handover.give_open_alarms((kept, raised))
    handover.give(None, [alarm_news(keys, alarm(id="kept", kind="hot_disc", cleared_time_s=1700000009.0))])
    queue.put(handover.events())
    said = [json.loads(event.payload) for event in queue.unsent]
    assert [(each["id"], each["state"]) for each in said] == [("raised", "open"), ("kept", "open"), ("kept", "cleared")]


def test_events_of_another_source_are_known_but_not_told_again() -> None:
    """The memory could not be read for one run, which therefore began anew, and then it could."""
    outbox, other_run = MemoryOutbox(), MemoryOutbox()
    for number, box in ((1, other_run), (2, outbox)):
        with running(outbox=box) as publisher:
            publisher.publish(Outputs(None, tuple(alarm(id=f"{number}-{i}", kind=f"kind_{i}") for i in range(number))))
            until(lambda publisher=publisher, number=number: publisher.counters.events_sent == number)
    outbox.keep({1: other_run.kept()[0]})
    with running(outbox=outbox) as last, session(last.endpoints[0]) as other:
        assert told(other) == {"kind_0": ("1-0", 1), "kind_1": ("2-1", 2)}
        last.publish(Outputs(None, (alarm(id="new"),)))
        until(lambda: told(other).get("low_adhesion") == ("new", 3))
        until(lambda: last.counters.events_sent >= 2)
        assert last.counters.events_sent == 2


def test_of_many_kept_events_the_newest_are_sent_again_and_all_are_answered_to_who_asks() -> None:
    events, outbox = EventLog(()), MemoryOutbox()
    for number in range(1, EVENTS_AGAIN + 501):
        first = alarm(id="oldest", kind="hot_disc") if number == 1 else alarm(id=str(number))
        payload = encode(AlarmMessage.of(first, number, 1.7e9))
        event = events.add("alarm", f"alarm/{first.kind}", payload, "json", over=False)
        outbox.keep({number: message_of(event)})
    with running(outbox=outbox) as publisher, session(publisher.endpoints[0]) as other:
        publisher.publish(Outputs(None, (alarm(id="new"),)))
        until(lambda: publisher.counters.events_sent == EVENTS_AGAIN + 1)
        assert told(other) == {"hot_disc": ("oldest", 1), "low_adhesion": ("new", EVENTS_AGAIN + 501)}


def kept_alarms(count: int) -> Iterator[bytes]:
    """As an earlier run has kept them, one by one."""
    log = EventLog(())
    for number in range(1, count + 1):
        payload = encode(AlarmMessage.of(alarm(id=str(number), message=1000 * "x"), number, 1.7e9), "json")
        yield message_of(log.add("alarm", "alarm/slide", payload, "json", over=True))


def event_queue(outbox: Outbox, published: Published | None = None) -> EventQueue:
    return EventQueue(outbox, KeySpace("brake/v1", "wagon-1"), published or Published(), "json", Counters())


class Reading:
    """An outbox that holds what it is asked for only as long as it is read."""

    def __init__(self, messages: Iterator[bytes]) -> None:
        self.kept = lambda: messages

    def keep(self, messages: object) -> None:
        raise AssertionError

    def close(self) -> None:
        raise AssertionError


def test_of_thousands_of_kept_events_only_those_to_be_sent_again_stay_in_memory() -> None:
    given = list(kept_alarms(5 * EVENTS_AGAIN))
    tracemalloc.start()
    try:
        events = event_queue(Reading(iter(given)))
        most_bytes = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert len(events.unsent) == EVENTS_AGAIN
    assert most_bytes < 6000 * EVENTS_AGAIN  # as sent, and as told to who asks


def test_a_memory_that_fails_while_it_is_read_is_not_gone_on_with() -> None:
    """The numbers behind the part that was read are taken."""

    def failing() -> Iterator[bytes]:
        yield from given
        raise WorkError("no such sector")

    given = list(kept_alarms(3))
    published = Published()
    events = event_queue(Reading(failing()), published)
    assert not events.unsent
    assert not published.alarms(0.0, inf)
    assert events.source != readable(given)[0].source


def test_stamps_are_in_the_past_of_every_clock_and_grow_even_over_what_could_not_be_kept() -> None:
    events = EventLog(())
    before, unkept = (events.add("alarm", "alarm/x", b"", "json", over=False) for _ in range(2))
    resumed = EventLog([message_of(before)])
    later = resumed.add("axle/1/wear", "axle/1/wear", b"", "json", over=False)
    assert 0 < before.stamp_us < unkept.stamp_us < later.stamp_us < 365 * 86400e6  # microseconds since 1970
    assert (later.number, later.source) == (2, before.source)
    assert (resumed.next_sequence("alarm"), resumed.next_sequence("axle/1/wear")) == (2, 2)


def readable(messages: list[bytes]) -> list[Event]:
    found: list[Event] = []
    EventLog(messages, found.append)
    return found


def scrambled(message: bytes) -> Iterator[bytes]:
    """With one byte changed: each of them, by each bit and altogether."""
    for place in range(len(message)):
        for mask in (1, 2, 4, 8, 16, 32, 64, 128, 255):
            yield message[:place] + bytes([message[place] ^ mask]) + message[place + 1 :]


@pytest.fixture(scope="module")
def three_events() -> list[bytes]:
    """Two alarms and a wear in between, as they are kept."""
    outbox = MemoryOutbox()
    with running(outbox=outbox) as publisher:
        publisher.publish(Outputs(None, (alarm(id="first"),)))
        publisher.publish_wear(Brakes(1.7e9, (BrakeUnit(PadWear.new(WearSettings()), 15.0),), ()), WearSettings())
        publisher.publish(Outputs(None, (alarm(id="last", kind="hot_disc", wheelset=1),)))
        until(lambda: publisher.counters.events_sent == 3)
    return outbox.kept()


@pytest.mark.parametrize("spoilt", [1, 2])
def test_after_any_flipped_byte_numbering_goes_on_with_what_zenoh_and_the_memory_take(
    spoilt: int, three_events: list[bytes]
) -> None:
    (first,) = readable(three_events[:1])
    for message in scrambled(three_events[spoilt]):
        found: list[Event] = []
        events = EventLog([*three_events[:spoilt], message, *three_events[spoilt + 1 :]], found.append)
        assert len(found) + events.damaged == 3
        session_config(ZenohSettings(), events.source)
        event = events.add("alarm", "alarm/slide", b"", "json", over=False)
        assert event.stamp_us > first.stamp_us
        assert event.number < 1 << 62
        zenoh.NTP64(*divmod(event.stamp_us, 1_000_000))
        assert all(zenoh.KeyExpr(kept.key) for kept in found)


@pytest.mark.parametrize("spoilt", [0, 1, 2])
def test_events_with_any_flipped_byte_are_taken_up(spoilt: int, three_events: list[bytes]) -> None:
    for message in scrambled(three_events[spoilt]):
        outbox = MemoryOutbox()
        outbox.keep(dict(enumerate((*three_events[:spoilt], message, *three_events[spoilt + 1 :]), 1)))
        events = EventQueue(outbox, KeySpace("brake/v1", "wagon-1"), Published(), "json", Counters())
        for event in events.unsent:
            assert json.loads(event.payload)


def test_of_events_for_which_no_router_ever_comes_the_oldest_are_given_up_and_counted() -> None:
    keys, counters = KeySpace("brake/v1", "wagon-1"), Counters()
    events = EventQueue(MemoryOutbox(), keys, Published(), "json", counters)
    for day in range(25):
        news = (alarm_news(keys, alarm(id=f"{day}-{i}")) for i in range(500))
        events.put(Events(deque(news), Counter(), None, 0))
    first, *_, last = (json.loads(event.payload) for event in events.unsent)
    assert len(events.unsent) == EVENTS_WAITING == 10_000
    assert counters.events_lost == 2500
    assert (first["sequence"], last["sequence"]) == (2501, 12_500)  # who counts sees the gap


def source_of(path: Path) -> str:
    """Of the newest event that the memory keeps."""
    with closing(StoreOutbox(path, "wagon-1")) as outbox:
        return EventLog(outbox.kept()).source


@pytest.mark.parametrize("damage", [b"\xff" * 9, b"", "text", 7])
def test_a_damaged_event_is_left_out_with_one_warning_and_its_number_never_told_again(
    damage: bytes | str | int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "memory.db"
    Store.open(path, "wagon-1", 2).close()
    with closing(StoreOutbox(path, "wagon-1")) as outbox, running(outbox=outbox) as first:
        first.publish(Outputs(None, (alarm(id="a"), alarm(id="b", kind="hot_disc"), alarm(id="c", kind="slide"))))
        until(lambda: first.counters.events_sent == 3)
    source = source_of(path)
    with sqlite3.connect(path) as db:
        db.execute("UPDATE outbox SET message = ? WHERE sequence = 3", (damage,))
    db.close()
    with (
        closing(StoreOutbox(path, "wagon-1")) as outbox,
        running(outbox=outbox) as second,
        session(second.endpoints[0]) as other,
    ):
        second.publish(Outputs(None, (alarm(id="d", kind="dragging_brake"),)))
        until(lambda: second.counters.events_sent == 3)
        assert told(other) == {"low_adhesion": ("a", 1), "hot_disc": ("b", 2), "dragging_brake": ("d", 4)}
        assert second._thread.is_alive()
    assert source_of(path) == source
    assert [r.message for r in caplog.records if "kept events" in r.message] == [
        "kept events left out, for they are damaged: 1; subscribers may miss them"
    ]
    caplog.clear()
    with closing(StoreOutbox(path, "wagon-1")) as outbox, running(outbox=outbox) as third:
        third.publish(Outputs(None, (alarm(id="e", kind="uneven_braking"),)))
        until(lambda: third.counters.events_sent == 4)
    assert source_of(path) == source
    assert not [r.message for r in caplog.records if "kept events" in r.message]  # its place was taken


def test_sources_of_memories_that_begin_anew_differ() -> None:
    assert EventLog(()).source != EventLog(()).source


def test_an_outbox_that_fails_is_told_once_counted_and_tried_again(caplog: pytest.LogCaptureFixture) -> None:
    class Full(MemoryOutbox):
        full = True

        def keep(self, messages: dict[int, bytes]) -> None:
            if self.full:
                raise WorkError("no space left on device")
            super().keep(messages)

    outbox = Full()
    with running(outbox=outbox) as publisher:
        publisher.counters.publish_failures += 1  # as when somebody asked and went away
        for _ in range(3):
            sent = publisher.counters.events_sent
            publisher.publish(Outputs(estimate(), (alarm(),)))
            until(lambda sent=sent: publisher.counters.events_sent > sent)  # subscribers are told all the same
        for _ in range(3):  # it is tried again meanwhile: that loses no more
            sent = publisher.counters.estimates_sent
            publisher.publish(Outputs(estimate(), ()))
            until(lambda sent=sent: publisher.counters.estimates_sent > sent)
        assert publisher.counters.publish_failures == 4
        outbox.full = False
        publisher.publish(Outputs(None, (alarm(),)))
        until(lambda: len(outbox.kept()) == 4)
    assert [r.message for r in caplog.records if "cannot be kept" in r.message] == [
        "events cannot be kept, a restart now would lose them: no space left on device"
    ]


def test_a_client_without_a_router_keeps_its_events_meanwhile() -> None:
    outbox = MemoryOutbox()
    settings = ZenohSettings(mode="client", connect=(f"tcp/127.0.0.1:{free_port()}",))
    with running(settings, outbox) as publisher:
        publisher.publish(Outputs(None, (alarm(), alarm())))
        until(lambda: len(outbox.kept()) == 2)


@pytest.mark.parametrize("is_taken", [False, True])
def test_the_thread_that_uses_the_outbox_closes_it(is_taken: bool) -> None:
    """SQLite closes no file that is being written: who tried would wait, and let no other thread run meanwhile."""
    closed_by: list[str] = []

    class Kept(MemoryOutbox):
        def close(self) -> None:
            closed_by.append(threading.current_thread().name)

    with socket.create_server(("127.0.0.1", 0)) as other:
        listen = (f"tcp/127.0.0.1:{other.getsockname()[1]}",) if is_taken else ZenohSettings().listen
        refused = pytest.raises(WorkError) if is_taken else nullcontext()
        with refused, running(ZenohSettings(listen=listen), Kept()):
            assert not closed_by
    until(lambda: closed_by)
    assert closed_by == ["zenoh"]
