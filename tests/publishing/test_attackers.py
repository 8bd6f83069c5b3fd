"""Who can reach the daemon's port and means it ill: it goes on, and lets others in afterwards."""

import os
import socket
from contextlib import ExitStack, suppress

import zenoh

from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.publisher import Publisher
from estimates import alarm, estimate
from network import running, session
from program import until


def answers(publisher: Publisher) -> bool:
    """Whether a newcomer is let in and told what is open now."""
    publisher.publish(Outputs(estimate()))
    with suppress(zenoh.ZError), session(publisher.endpoints[0]) as newcomer:
        return any(reply.ok for reply in newcomer.get("brake/v1/wagon-1/alarm/**", timeout=3.0))
    return False


def tells_alarms(publisher: Publisher) -> bool:
    sent = publisher.counters.events_sent
    publisher.publish(Outputs(estimate(), (alarm(),)))
    until(lambda: publisher.counters.events_sent > sent)
    return True


def test_connections_that_say_nothing_or_garbage() -> None:
    with running() as publisher, ExitStack() as stack:
        address = ("127.0.0.1", int(publisher.endpoints[0].rpartition(":")[2]))
        for _ in range(300):
            stack.enter_context(socket.create_connection(address))
        assert tells_alarms(publisher)
        for _ in range(20):
            with suppress(OSError), socket.create_connection(address) as garbage:
                garbage.sendall(os.urandom(20_000))
        assert tells_alarms(publisher)
        until(lambda: answers(publisher))  # those that said nothing are put out after ten seconds
        assert publisher.counters.events_lost == 0


def test_a_neighbour_that_declares_puts_and_asks_without_end() -> None:
    with running() as publisher, session(publisher.endpoints[0]) as enemy:
        assert tells_alarms(publisher)
        declared = [enemy.declare_subscriber(f"brake/v1/*/{number}/**", lambda _: None) for number in range(2000)]
        tokens = [enemy.liveliness().declare_token(f"brake/v1/fake-{number}") for number in range(2000)]
        until(lambda: answers(publisher))
        for _ in range(50):
            enemy.put("brake/v1/wagon-1/alarm/low_adhesion", os.urandom(900_000))
        questions = [enemy.get("brake/v1/wagon-1/**?from_s=0", timeout=10.0) for _ in range(300)]
        assert tells_alarms(publisher)
        until(lambda: answers(publisher))
        assert [reply for replies in questions for reply in replies]
        assert publisher.counters.events_lost == 0
        for one in (*declared, *tokens):
            one.undeclare()
