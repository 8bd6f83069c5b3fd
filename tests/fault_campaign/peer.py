"""Another party on the network, which knows nothing of brake_monitor: prints what it hears as JSON lines.

usage: peer.py ENDPOINT
"""

import json
import signal
import sys
import threading
import time

import zenoh
from zenoh import ext

signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
retry = {"period_init_ms": 100, "period_max_ms": 500, "period_increase_factor": 1.5}
settings = {"mode": "client", "connect": {"endpoints": [sys.argv[1]], "retry": retry}}
config = zenoh.Config.from_json5(json.dumps(settings | {"scouting": {"multicast": {"enabled": False}}}))
alone = threading.Lock()


def show(sample: zenoh.Sample) -> None:
    line = {"heard_s": time.monotonic(), "key": str(sample.key_expr), "payload": json.loads(sample.payload.to_bytes())}
    with alone:
        print(json.dumps(line), flush=True)


with zenoh.open(config) as session:
    history = ext.HistoryConfig(detect_late_publishers=True)
    declared = [
        session.declare_subscriber("brake/v1/*/adhesion", show),
        session.declare_subscriber("brake/v1/*/health", show),
        ext.declare_advanced_subscriber(session, "brake/v1/*/alarm/**", show, history=history),
    ]
    print("ready", flush=True)
    signal.sigwait({signal.SIGTERM})
    for subscriber in declared:
        subscriber.undeclare()
