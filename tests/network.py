"""A publisher of ours and sessions of somebody else, for tests of what is seen of us over a network."""

import json
import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import zenoh

from brake_monitor.publishing import publisher, zenoh_link
from brake_monitor.publishing.outbox import Outbox
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from program import PATIENCE_S

# A daemon that opens a session holds nothing else up for long; here a busy machine has all the time that it needs.
publisher.OPEN_S = zenoh_link.INFO_S = PATIENCE_S


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
