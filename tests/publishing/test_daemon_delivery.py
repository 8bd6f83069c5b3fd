"""The real daemon with its memory, killed in mid-braking and cut off: subscribers hear every event once, in order."""

import json
import signal
from contextlib import ExitStack
from pathlib import Path

import msgspec

from brake_monitor.publishing.outbox import Event
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store_outbox import StoreOutbox
from interrupted_daemon import daemon, kept_until_s, prepare, wait_until
from network import free_port
from program import PATIENCE_S, Python, Router, until

KILLED_S, CUT_OFF_S, BACK_S, END_S = 55.0, 65.0, 80.0, 95.0  # seconds of the recording; wheels slide from 48 s on

SUBSCRIBER = """
import json, sys, zenoh
from zenoh import ext
values = {"mode": sys.argv[2], "connect": {"endpoints": [sys.argv[1]]}, "scouting": {"multicast": {"enabled": False}}}
history = ext.HistoryConfig(detect_late_publishers=True)
def tell(sample):
    message = json.loads(sample.payload.to_bytes())
    print(json.dumps([str(sample.key_expr).partition("wagon-8127/")[2], message["sequence"]]), flush=True)
with zenoh.open(zenoh.Config.from_json5(json.dumps(values))) as session:
    with (
        ext.declare_advanced_subscriber(session, "brake/v1/*/alarm/**", tell, history=history),
        ext.declare_advanced_subscriber(session, "brake/v1/*/axle/*/wear", tell, history=history),
    ):
        print("ready", flush=True)
        sys.stdin.read()
"""


def kept_events(folder: Path) -> dict[bool, list[tuple[str, int]]]:
    """Key and sequence of what the memory has kept, in order: of alarms (True) and of wear (False)."""
    outbox = StoreOutbox(folder / "state" / FILE_NAME, "wagon-8127")
    found: dict[bool, list[tuple[str, int]]] = {True: [], False: []}
    for message in outbox.kept():
        event = msgspec.msgpack.decode(message, type=Event)
        found[event.key.startswith("alarm/")].append((event.key, json.loads(event.payload)["sequence"]))
    outbox.close()
    return found


def test_every_alarm_and_wear_once_and_in_order_over_a_kill_a_router_that_dies_and_a_stop(tmp_path: Path) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    prepare(tmp_path, f'connect = ["{endpoint}"]', END_S)
    with ExitStack() as stack:
        router = stack.enter_context(Router(endpoint))
        subscriber = stack.enter_context(Python(SUBSCRIBER, endpoint, "client"))
        subscriber.wait_for("ready")
        with daemon(tmp_path, 0.0) as first:
            wait_until(first, tmp_path, EPOCH_S + KILLED_S)
            first.send_signal(signal.SIGKILL)
        second = stack.enter_context(daemon(tmp_path, kept_until_s(tmp_path) + 0.001))
        wait_until(second, tmp_path, EPOCH_S + CUT_OFF_S)
        router.kill()
        before = len(kept_events(tmp_path)[True])
        wait_until(second, tmp_path, EPOCH_S + BACK_S)
        until(lambda: len(kept_events(tmp_path)[True]) > before)  # something happens in the dark
        stack.enter_context(Router(endpoint))
        wait_until(second, tmp_path, EPOCH_S + END_S - 0.5)
        second.send_signal(signal.SIGTERM)
        assert second.wait(PATIENCE_S) == 0
        third = stack.enter_context(daemon(tmp_path, EPOCH_S + END_S))  # tells what the second could not
        expected = kept_events(tmp_path)

        until(lambda: len(subscriber.lines) > sum(map(len, expected.values())))  # ... and that it was ready
        third.send_signal(signal.SIGTERM)
    told: dict[bool, list[tuple[str, int]]] = {True: [], False: []}
    for key, sequence in map(json.loads, subscriber.lines[1:]):
        told[key.startswith("alarm/")].append((key, sequence))
    for kind, events in expected.items():
        assert told[kind][: len(events)] == events
    alarms = [sequence for _, sequence in told[True]]
    assert alarms == list(range(1, len(alarms) + 1))
    assert len(expected[False]) >= 4  # of two wheelsets, at two starts
