"""A plain Zenoh subscriber, which knows nothing of brake_monitor: prints what comes under a key expression.

usage: subscriber.py ENDPOINT KEY_EXPRESSION
"""

import json
import signal
import sys

import zenoh

endpoint, key_expression = sys.argv[1:]
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", json.dumps([endpoint]))
config.insert_json5("scouting/multicast/enabled", "false")


def show(sample: zenoh.Sample) -> None:
    line = {
        "key": str(sample.key_expr),
        "encoding": str(sample.encoding),
        "payload": json.loads(sample.payload.to_bytes()),
    }
    print(json.dumps(line), flush=True)


with zenoh.open(config) as session:
    subscriber = session.declare_subscriber(key_expression, show)
    print("subscribed", flush=True)
    signal.sigwait({signal.SIGTERM})
    subscriber.undeclare()
