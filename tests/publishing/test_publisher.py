"""What is published is seen by other processes, whatever the network and the other side do."""

import gc
import json
import logging
import os
import signal
import socket
import time
import weakref
from contextlib import ExitStack, suppress
from pathlib import Path
from queue import Queue
from typing import Any, NoReturn

import pytest
import zenoh
from zenoh import ext

from brake_monitor.errors import InputError, WorkError
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.publishing import handover
from brake_monitor.publishing import publisher as publisher_module
from brake_monitor.publishing.about import about
from brake_monitor.publishing.answers import Answerer
from brake_monitor.publishing.health import intake_of
from brake_monitor.publishing.payloads import AdhesionMessage, FrictionMessage
from brake_monitor.publishing.publisher import CLOSE_S, Publisher
from brake_monitor.publishing.zenoh_link import ZenohLink
from brake_monitor.publishing.zenoh_session import LEASE_MS
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate
from health import INTAKE
from network import free_port, running, session
from program import PATIENCE_S, Python, Router, Subscriber, until

IN_NO_TIME_S = 5.0  # on a busy machine; who waits for somebody that hangs takes ten

PUBLISHING_PROCESS = """
import sys, time
from brake_monitor.settings.zenoh_settings import ZenohSettings
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing import publisher as publisher_module
from estimates import alarm, estimate
publisher_module.CLOSE_S = 60.0  # as long as it takes
publisher = publisher_module.Publisher(ZenohSettings(), "wagon-1")
publisher.start()
print(publisher.endpoints[0], flush=True)
while sys.stdin.readline() != "end\\n":
    publisher.publish(Outputs(estimate()))
publisher.publish(Outputs(None, (alarm(message="last words"),)))
before = time.monotonic()
publisher.close()
print(time.monotonic() - before, flush=True)
"""


def publish_until_heard(publisher: Publisher, subscriber: Subscriber) -> None:
    """Publish estimates until one arrives: the subscription has then reached the publisher."""
    until(lambda: publisher.publish(Outputs(estimate())) or subscriber.samples())


def newest(subscriber: Subscriber) -> dict[str, dict[str, Any]]:
    """The newest samples by key, checked to be declared as JSON."""
    samples = subscriber.samples()
    assert {sample["encoding"] for sample in samples} <= {"application/json"}
    return {sample["key"]: sample["payload"] for sample in samples}


def test_another_process_reads_what_the_contract_says_without_any_router() -> None:
    with running() as publisher, Subscriber(publisher.endpoints[0]) as subscriber:
        before_s = time.time()
        publish_until_heard(publisher, subscriber)
        publisher.publish(Outputs(estimate(), (alarm(), alarm(kind="locked_wheelset", wheelset=2))))
        until(lambda: len(newest(subscriber)) == 7)
        samples = newest(subscriber)
    wagon = samples["brake/v1/wagon-1/adhesion"]
    assert wagon.keys() == set(AdhesionMessage.__struct_fields__)
    assert (wagon["adhesion"], wagon["status"], wagon["saturated"]) == (0.08, "valid", True)
    assert before_s <= wagon["publish_time_s"] <= time.time()
    for wheelset, friction in ((1, 0.34), (2, 0.31)):
        axle = samples[f"brake/v1/wagon-1/axle/{wheelset}/friction"]
        assert axle.keys() == set(FrictionMessage.__struct_fields__)
        assert (axle["wheelset"], axle["friction"], axle["time_s"]) == (wheelset, friction, 1700000000.25)
    assert samples["brake/v1/wagon-1/alarm/low_adhesion"]["state"] == "open"
    assert samples["brake/v1/wagon-1/alarm/locked_wheelset/2"]["sequence"] == 2


def test_of_estimates_the_newest_is_sent_and_of_alarms_every_one() -> None:
    publisher = Publisher(ZenohSettings(), "wagon-1")
    for speed_mps in (30.0, 20.0, 10.0):  # nothing is open yet, so all of it waits
        publisher.publish(Outputs(estimate(speed_mps=speed_mps), (alarm(message=f"{speed_mps}"),)))
    publisher.start()
    try:
        until(lambda: publisher.counters.estimates_sent and publisher.counters.events_sent == 3)
        with session(publisher.endpoints[0]) as other:
            replies = {str(r.ok.key_expr): json.loads(r.ok.payload.to_string()) for r in other.get("brake/**") if r.ok}
    finally:
        publisher.close()
    newest = replies["brake/v1/wagon-1/adhesion"]
    assert (newest["speed_mps"], newest["sequence"]) == (10.0, 3)  # the gap in `sequence` shows what was passed over
    assert publisher.counters.estimates_replaced == 2
    assert replies["brake/v1/wagon-1/alarm/low_adhesion"]["sequence"] == 3


def test_meta_is_told_again_to_who_came_later() -> None:
    settings = example_settings("wagon")
    pipeline = Pipeline.from_settings(settings)
    with (
        Publisher(ZenohSettings(), "wagon-8127", about=about(settings, 0.0)) as publisher,
        session(publisher.endpoints[0]) as other,
        other.declare_subscriber("brake/v1/*/meta") as heard,
    ):

        def told() -> object:
            publisher.publish_health(intake_of(pipeline))
            return heard.try_recv()

        until(told)


def test_a_late_joiner_is_told_open_alarms_and_not_those_that_are_over() -> None:
    with running() as publisher, session(publisher.endpoints[0]) as other:
        publisher.publish(Outputs(None, (alarm(), alarm(kind="locked_wheelset", wheelset=1))))
        publisher.publish(Outputs(None, (alarm(cleared_time_s=1700000005.0),)))
        until(lambda: publisher.counters.events_sent == 3)
        keys = [str(reply.ok.key_expr) for reply in other.get("brake/v1/wagon-1/alarm/**") if reply.ok]
    assert keys == ["brake/v1/wagon-1/alarm/locked_wheelset/1"]


def test_a_session_that_is_closed_leaves_no_file_open() -> None:
    """A daemon opens one at each reload."""

    def in_shared_memory() -> int:
        count = 0
        for link in Path("/proc/self/fd").iterdir():
            with suppress(FileNotFoundError):  # closed meanwhile
                count += link.readlink().is_relative_to("/dev/shm")
        return count

    before = in_shared_memory()
    for _ in range(2):
        with running():
            pass
    until(lambda: in_shared_memory() <= before)


def test_a_publisher_that_is_closed_is_forgotten() -> None:
    """With five minutes of estimates and a thousand alarms."""
    with running() as publisher:
        closed = weakref.ref(publisher)
    del publisher

    def is_forgotten() -> bool:
        gc.collect()
        return closed() is None

    until(is_forgotten)


def test_health_tells_which_alarms_are_open() -> None:
    with running() as publisher:
        publisher.publish(Outputs(None, (alarm(id="a"), alarm(id="b"))))
        publisher.publish(Outputs(None, (alarm(id="a", cleared_time_s=1700000005.0),)))
        publisher.publish_health(INTAKE)
        until(lambda: publisher.health)
        assert publisher.health is not None
        assert publisher.health.open_alarms == ("b",)


def test_the_liveliness_token_lives_as_long_as_the_publisher() -> None:
    changes: Queue[zenoh.SampleKind] = Queue()
    with ExitStack() as stack:
        publisher = stack.enter_context(running())
        other = stack.enter_context(session(publisher.endpoints[0]))
        token = "brake/v1/wagon-1"
        listener = other.liveliness().declare_subscriber(token, lambda s: changes.put(s.kind), history=True)
        stack.enter_context(listener)
        assert changes.get(timeout=PATIENCE_S) == zenoh.SampleKind.PUT
        publisher.close()
        assert changes.get(timeout=PATIENCE_S) == zenoh.SampleKind.DELETE


def test_who_is_frozen_counts_as_gone_after_the_lease_and_is_back_when_it_goes_on() -> None:
    assert 2000 <= LEASE_MS <= 3000
    changes: Queue[zenoh.SampleKind] = Queue()
    with (
        Python(PUBLISHING_PROCESS) as child,
        session(child.wait_for("tcp/.*")[0]) as other,
        other.liveliness().declare_subscriber("brake/v1/*", lambda s: changes.put(s.kind), history=True),
    ):
        for number, expected in (
            (signal.SIGCONT, zenoh.SampleKind.PUT),
            (signal.SIGSTOP, zenoh.SampleKind.DELETE),
            (signal.SIGCONT, zenoh.SampleKind.PUT),
            (signal.SIGKILL, zenoh.SampleKind.DELETE),
        ):
            child.send_signal(number)
            while changes.get(timeout=PATIENCE_S) != expected:
                pass  # a machine that was too busy for the lease: gone and back


@pytest.mark.parametrize("mode", ["peer", "client"])
def test_without_a_router_it_starts_and_finds_it_when_it_comes(mode: Any) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with running(ZenohSettings(mode=mode, connect=(endpoint,))) as publisher:
        publisher.publish(Outputs(None, (alarm(),)))
        with Router(endpoint), session(endpoint) as other, other.declare_subscriber("brake/**") as heard:

            def arrives() -> object:
                publisher.publish(Outputs(estimate()))
                return heard.try_recv()

            until(arrives)
        assert publisher.counters.events_lost == 0


def test_the_journal_tells_where_it_listens_and_which_router_it_looks_for(caplog: pytest.LogCaptureFixture) -> None:
    router = f"tcp/127.0.0.1:{free_port()}"
    with caplog.at_level("INFO"), running(ZenohSettings(connect=(router,))) as publisher:
        (listening,) = publisher.endpoints
    assert f"Zenoh session open, on {listening} and to {router}" in caplog.text
    assert not listening.endswith(":0")


def test_a_session_in_which_nothing_can_be_declared_is_closed_before_another_is_opened(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    links: list[ZenohLink] = []
    open_link = ZenohLink.open

    def fails_at_first(link: ZenohLink) -> None:
        open_link(link)
        links.append(link)
        if len(links) == 1:
            raise zenoh.ZError("session closed")

    monkeypatch.setattr(ZenohLink, "open", fails_at_first)
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with Router(endpoint), running(ZenohSettings(mode="client", connect=(endpoint,))):
        until(lambda: len(links) == 2)
        assert links[0]._session.is_closed()
        assert not links[0]._thread.is_alive()
        assert not links[1]._session.is_closed()


def test_alarms_arrive_once_and_in_order_over_the_death_of_the_router() -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    sequences: list[int] = []

    def note(sample: zenoh.Sample) -> None:
        sequences.append(json.loads(sample.payload.to_string())["sequence"])

    with ExitStack() as stack:
        publisher = stack.enter_context(running(ZenohSettings(connect=(endpoint,))))
        with Router(endpoint):
            other = stack.enter_context(session(endpoint, "peer"))
            stack.enter_context(
                ext.declare_advanced_subscriber(
                    other,
                    "brake/v1/*/alarm/**",
                    note,
                    history=ext.HistoryConfig(detect_late_publishers=True),
                    recovery=ext.RecoveryConfig(heartbeat=True, periodic_queries=None),
                )
            )
            until(lambda: publisher.publish(Outputs(None, (alarm(),))) or sequences)  # they have met
            first = sequences[0]
        reached = publisher.counters.events_sent
        for _ in range(10):  # into the dark: the router was killed
            publisher.publish(Outputs(None, (alarm(),)))
        until(lambda: publisher.counters.events_sent >= reached + 10)
        with Router(endpoint):
            until(lambda: publisher.publish(Outputs(None, (alarm(),))) or sequences[-1] > reached + 10)
            publisher.publish(Outputs(None, (alarm(),)))
            until(lambda: publisher.counters.events_sent == sequences[-1])
    assert sequences == list(range(first, first + len(sequences)))
    assert sequences[-1] > reached + 10


def test_a_frozen_subscriber_holds_up_nobody() -> None:
    heavy = alarm(evidence={"log": "x" * 100_000})  # 200 of them overflow every buffer on the way
    with ExitStack() as stack:
        publisher = stack.enter_context(running())
        endpoint = publisher.endpoints[0]
        frozen = stack.enter_context(Subscriber(endpoint))
        publish_until_heard(publisher, frozen)
        other = stack.enter_context(session(endpoint))
        sequences: list[int] = []
        healthy = other.declare_subscriber(
            "brake/v1/*/alarm/**", lambda s: sequences.append(json.loads(s.payload.to_string())["sequence"])
        )
        stack.enter_context(healthy)
        until(lambda: publisher.publish(Outputs(None, (alarm(),))) or sequences)  # both are known to the publisher
        first = sequences[0]
        frozen.send_signal(signal.SIGSTOP)
        for _ in range(200):
            publisher.publish(Outputs(estimate(), (heavy,)))
        until(lambda: len(sequences) > 200)
        until(lambda: publisher.counters.events_sent == sequences[-1])
        tokens = stack.enter_context(other.liveliness().declare_subscriber("brake/v1/*", history=True))
        assert tokens.recv().kind == zenoh.SampleKind.PUT
        before_s = time.monotonic()
        publisher.close()
        assert time.monotonic() - before_s < CLOSE_S + IN_NO_TIME_S
        until(lambda: (change := tokens.try_recv()) and change.kind == zenoh.SampleKind.DELETE)
    assert sequences == list(range(first, first + len(sequences)))


def test_closing_is_quick_sends_the_last_alarm_and_lets_the_process_end() -> None:
    with Python(PUBLISHING_PROCESS) as child, Subscriber(child.wait_for("tcp/.*")[0]) as subscriber:
        until(lambda: child.tell("again") or subscriber.samples())
        took_s = float(child.ask("end"))
        assert subscriber.wait_for("/alarm/low_adhesion.*last words")
        assert took_s < IN_NO_TIME_S
        assert child.wait() == 0


def test_closing_without_a_session_or_twice_is_harmless() -> None:
    never_started = Publisher(ZenohSettings(), "wagon-1")
    never_started.close()
    with running(ZenohSettings(mode="client", connect=(f"tcp/127.0.0.1:{free_port()}",))) as publisher:
        assert publisher.endpoints == ()
        assert publisher.heartbeat_age_s() < PATIENCE_S
        publisher.close()
        publisher.close()
        publisher.publish(Outputs(estimate(), (alarm(),)))  # too late, and still no exception


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_the_heart_stops_when_questions_are_no_longer_answered(monkeypatch: pytest.MonkeyPatch) -> None:
    """The watchdog then has the daemon started anew, rather than nobody notice."""

    def fail(*_: object) -> NoReturn:
        raise RuntimeError("an error of ours")

    monkeypatch.setattr(Answerer, "newest", fail)
    with running() as publisher, session(publisher.endpoints[0]) as other:
        list(other.get("brake/v1/wagon-1/estimate", timeout=1.0))
        until(lambda: publisher.heartbeat_age_s() > 3.0)  # ten turns


def test_more_alarms_than_may_wait_are_counted_and_the_newest_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(handover, "EVENTS_WAITING", 3)
    publisher = Publisher(ZenohSettings(), "wagon-1")
    publisher.publish(Outputs(None, tuple(alarm() for _ in range(5))))
    assert publisher.counters.events_lost == 2
    publisher.start()
    try:
        until(lambda: publisher.counters.events_sent == 3)
        with session(publisher.endpoints[0]) as other:
            (reply,) = other.get("brake/v1/*/alarm/**")
        assert reply.ok is not None
        assert json.loads(reply.ok.payload.to_string())["sequence"] == 5
    finally:
        publisher.close()


def test_an_address_in_use_fails_the_start_with_its_name() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        endpoint = f"tcp/127.0.0.1:{taken.getsockname()[1]}"
        publisher = Publisher(ZenohSettings(listen=(endpoint,)), "wagon-1")
        with pytest.raises(WorkError, match=f"{endpoint}.*Address already in use") as caught:
            publisher.start()
    assert "cargo" not in str(caught.value)
    publisher.close()


def test_what_fails_after_the_start_has_given_up_waiting_is_logged(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """On a machine that is short of time."""
    monkeypatch.setattr(publisher_module, "OPEN_S", 0.0)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        publisher = Publisher(ZenohSettings(listen=(f"tcp/127.0.0.1:{taken.getsockname()[1]}",)), "wagon-1")
        with suppress(WorkError):
            publisher.start()
            until(lambda: "nothing is published" in caplog.text)
            assert "Address already in use" in caplog.text
    publisher.close()


@pytest.mark.parametrize(
    "endpoint",
    [
        "",
        "bogus",
        "tcp/127.0.0.1",
        "tcp/127.0.0.1:",
        "tcp/:7447",
        "xyz/127.0.0.1:1",
        "tcp/a:-1",
        "tcp/a:99999",
        "tcp/a:" + 5000 * "9",
    ],
)
def test_a_malformed_endpoint_is_refused_before_anything_is_opened(endpoint: str) -> None:
    with pytest.raises(InputError, match=r"\[zenoh\] connect.*expected <protocol>/<host>:<port>"):
        Publisher(ZenohSettings(connect=(endpoint,)), "wagon-1")
    with pytest.raises(InputError, match=r"\[zenoh\] listen"):
        Publisher(ZenohSettings(listen=(endpoint,)), "wagon-1")


@pytest.mark.parametrize("behind", ["?;", "#=", "?", "#", "?prio=1#=secret", "?=secret"])
def test_what_zenoh_does_not_understand_behind_an_address_is_refused_without_showing_it(behind: str) -> None:
    for name in ("connect", "listen"):
        with pytest.raises(InputError) as caught:
            Publisher(ZenohSettings(**{name: (f"tcp/127.0.0.1:7447{behind}",)}), "wagon-1")
        assert str(caught.value).startswith(f"[zenoh] {name} 'tcp/127.0.0.1:7447': expected ")
        assert "secret" not in str(caught.value)


def test_what_stands_behind_an_address_is_never_shown(caplog: pytest.LogCaptureFixture) -> None:
    """Zenoh takes a private key there."""
    caplog.set_level(logging.DEBUG)
    endpoint = f"tcp/127.0.0.1:{free_port()}#connect_private_key_base64=secret"
    with running(ZenohSettings(listen=(endpoint,), connect=(endpoint,))):
        pass
    with pytest.raises(InputError) as caught:
        Publisher(ZenohSettings(connect=(endpoint.replace("tcp", "xyz"),)), "wagon-1")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        blocked = Publisher(ZenohSettings(listen=(f"tcp/127.0.0.1:{taken.getsockname()[1]}#x=secret",)), "wagon-1")
        with pytest.raises(WorkError) as in_use:
            blocked.start()
    assert "127.0.0.1" in caplog.text
    assert "secret" not in caplog.text + str(caught.value) + str(in_use.value)


def test_nothing_is_told_of_the_daemon_itself_and_nobody_configures_it_from_outside() -> None:
    port = free_port()
    with running(ZenohSettings(listen=(f"tcp/127.0.0.1:{port}",))) as publisher:
        assert publisher.endpoints == (f"tcp/127.0.0.1:{port}",)
        with session(publisher.endpoints[0]) as other:
            theirs = [str(reply.ok.key_expr) for reply in other.get("@/**", timeout=PATIENCE_S) if reply.ok]
            assert not [key for key in theirs if str(other.zid()) not in key]
    with running() as publisher, session(publisher.endpoints[0]) as other:
        (admin,) = (str(r.ok.key_expr) for r in other.get("@/*/peer", timeout=PATIENCE_S) if r.ok)
        other.put(f"{admin}/config/connect/endpoints", b'["tcp/127.0.0.1:1"]')
        other.put(f"{admin}/config/mode", b'"router"')
        other.delete(f"{admin}/config/listen/endpoints")
        publisher.publish(Outputs(None, (alarm(),)))
        until(lambda: publisher.counters.events_sent)
        (same,) = (str(r.ok.key_expr) for r in other.get("@/*/peer", timeout=PATIENCE_S) if r.ok)
        assert same == admin
        assert [r for r in other.get(f"{admin}/config/**", timeout=PATIENCE_S) if r.ok] == []


def test_a_message_larger_than_any_of_ours_does_not_get_in_and_hurts_nobody() -> None:
    with running(ZenohSettings(accept_acknowledgements=True)) as publisher:
        endpoint = publisher.endpoints[0]
        with session(endpoint) as other:
            huge = other.get("brake/v1/wagon-1/acknowledge", payload=b" " * (8 << 20), timeout=3.0)
            assert not [reply for reply in huge if reply.ok]
        with socket.create_connection(("127.0.0.1", int(endpoint.rpartition(":")[2]))) as garbage:
            garbage.sendall(os.urandom(1 << 16))
        publisher.publish(Outputs(estimate()))
        with session(endpoint) as other:
            until(lambda: [reply for reply in other.get("brake/v1/wagon-1/adhesion", timeout=3.0) if reply.ok])
        assert publisher.acknowledged() == []


def test_a_client_without_a_router_to_connect_to_is_refused() -> None:
    with pytest.raises(InputError, match=r"\[zenoh\] connect"):
        Publisher(ZenohSettings(mode="client"), "wagon-1")
