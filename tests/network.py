"""Other processes, routers and sessions of somebody else, for tests of what is seen of us over a network."""

import json
import os
import random
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from queue import Queue
from typing import Any

import zenoh

from brake_monitor.publishing import publisher, zenoh_link
from brake_monitor.publishing.outbox import Outbox
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings

PATIENCE_S = 120.0  # how long a test waits for what must come; never how long it takes

# A daemon that opens a session holds nothing else up for long; here a busy machine has all the time that it needs.
publisher.OPEN_S = zenoh_link.INFO_S = PATIENCE_S

# Any subscriber, as somebody else would write it: plain zenoh, none of our code. One JSON line per sample.
SUBSCRIBER = """
import json, sys, zenoh
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("scouting/multicast/enabled", "false")
config.insert_json5("connect/endpoints", json.dumps([sys.argv[1]]))
with zenoh.open(config) as session:
    with session.declare_subscriber(sys.argv[2]) as subscriber:
        print("ready", flush=True)
        for sample in subscriber:
            print(json.dumps([str(sample.key_expr), sample.payload.to_string(), str(sample.encoding)]), flush=True)
"""

ROUTER = """
import json, sys, zenoh
config = zenoh.Config()
config.insert_json5("mode", '"router"')
config.insert_json5("scouting/multicast/enabled", "false")
config.insert_json5("listen/endpoints", json.dumps([sys.argv[1]]))
session = zenoh.open(config)
print("ready", flush=True)
sys.stdin.read()
"""


@contextmanager
def process(script: str, *arguments: str) -> Iterator[tuple[subprocess.Popen[str], Queue[str]]]:
    """A Python process, and its lines on standard output as they come; killed at the end."""
    child = subprocess.Popen(
        [sys.executable, "-c", script, *arguments],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},  # it may import what this one may
    )
    lines: Queue[str] = Queue()
    assert child.stdout is not None

    def read() -> None:
        for line in child.stdout or ():
            lines.put(line.strip())

    reader = threading.Thread(target=read, daemon=True)
    reader.start()
    try:
        yield child, lines
    finally:
        child.kill()
        child.wait()
        reader.join()
        child.stdout.close()
        assert child.stdin is not None
        child.stdin.close()


@contextmanager
def subscriber_process(endpoint: str, key: str) -> Iterator[tuple[subprocess.Popen[str], Queue[str]]]:
    with process(SUBSCRIBER, endpoint, key) as (child, lines):
        assert lines.get(timeout=PATIENCE_S) == "ready"
        yield child, lines


@contextmanager
def router_process(endpoint: str) -> Iterator[subprocess.Popen[str]]:
    with process(ROUTER, endpoint) as (child, lines):
        assert lines.get(timeout=PATIENCE_S) == "ready"
        yield child


@contextmanager
def session(endpoint: str, mode: str = "client") -> Iterator[zenoh.Session]:
    """A session of somebody else in this process, connected when it is a client."""
    config = zenoh.Config()
    values: dict[str, Any] = {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "connect/endpoints": [endpoint],
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5},
    }
    for key, value in values.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config) as opened:
        yield opened


@contextmanager
def running(settings: ZenohSettings | None = None, outbox: Outbox | None = None) -> Iterator[Publisher]:
    """A publisher; afterwards it has closed, be that within the time that it gives itself or not."""
    running = Publisher(settings or ZenohSettings(), "wagon-1", outbox=outbox)
    running.start()
    try:
        yield running
    finally:
        running.close()
        running._thread.join(PATIENCE_S)


def is_answered(other: zenoh.Session, key: str) -> bool:
    """Whether somebody gives a last value when asked for it."""
    return any(reply.ok for reply in other.get(key, timeout=PATIENCE_S))


def free_port() -> int:
    """A port below the ephemeral ones: nobody's outgoing connection takes it while it waits for its router."""
    while True:
        port = random.randrange(20_000, 30_000)
        with socket.socket() as probe, suppress(OSError):
            probe.bind(("127.0.0.1", port))
            return port


def until(condition: Callable[[], object]) -> None:
    """Poll for what only the other side of a network can bring about."""
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline, "what was waited for did not come"
        time.sleep(0.02)
