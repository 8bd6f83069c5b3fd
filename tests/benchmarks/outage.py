"""A router that dies and returns: how soon it hears the wagon again, and what became of the alarms meanwhile.

Run: python tests/benchmarks/outage.py [OUTAGE_S …]. The wagon publishes ten estimates and an alarm a second; it, the
router and two advanced subscribers (a client and a peer) are processes of their own.
"""

import json
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # when it is run as a script

from network import free_port
from program import Python

WAGON = """
import sys, time
from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate
with Publisher(ZenohSettings(mode=sys.argv[2], connect=(sys.argv[1],)), "wagon-1") as publisher:
    number = 0
    while True:
        number += 1
        publisher.publish(Outputs(estimate(time_s=time.time()), (alarm(),) if number % 10 == 0 else ()))
        time.sleep(0.1)
"""

# Says how long after it could be reached it hears the wagon.
ROUTER = """
import json, sys, time, zenoh
values = {"mode": "router", "listen": {"endpoints": [sys.argv[1]]}, "scouting": {"multicast": {"enabled": False}}}
with zenoh.open(zenoh.Config.from_json5(json.dumps(values))) as session:
    begun_s = time.monotonic()
    with session.declare_subscriber("brake/v1/*/adhesion") as heard:
        heard.recv()
        print(time.monotonic() - begun_s, flush=True)
        sys.stdin.read()
"""

SUBSCRIBER = """
import json, sys, zenoh
from zenoh import ext
values = {"mode": sys.argv[2], "connect": {"endpoints": [sys.argv[1]]}, "scouting": {"multicast": {"enabled": False}}}
config = zenoh.Config.from_json5(json.dumps(values))
history = ext.HistoryConfig(detect_late_publishers=True)
with (
    zenoh.open(config) as session,
    ext.declare_advanced_subscriber(session, "brake/v1/*/alarm/**", history=history) as subscriber,
):
    for sample in subscriber:
        print(json.loads(sample.payload.to_bytes())["sequence"], flush=True)
"""

SETTLE_S = 8.0  # a plain client looks for its router every 4 s


@contextmanager
def router(endpoint: str) -> Iterator[float]:
    """A router; gives the seconds after which it heard the wagon."""
    with Python(ROUTER, endpoint) as program:
        yield float(program.wait_for(r"^[\d.]+$")[0])


def main(mode: str, outages_s: list[float]) -> dict[str, Any]:
    """Let the router die for as long, one outage after the other."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    returned_s = []
    with Python(WAGON, endpoint, mode), ExitStack() as stack:
        with router(endpoint):
            subscribers = {kind: stack.enter_context(Python(SUBSCRIBER, endpoint, kind)) for kind in ("client", "peer")}
            time.sleep(SETTLE_S)
        for outage_s in outages_s:
            time.sleep(outage_s)
            with router(endpoint) as heard_after_s:
                returned_s.append(round(heard_after_s, 2))
                time.sleep(SETTLE_S)
        told = {kind: [int(line) for line in program.lines] for kind, program in subscribers.items()}
    return {
        "wagon is a": mode,
        "outages, s": outages_s,
        "heard again after, s": returned_s,
        "alarms": max(max(sequences) for sequences in told.values()),
        **{f"once and in order by a {kind}": s == list(range(1, len(s) + 1)) for kind, s in told.items()},
    }


if __name__ == "__main__":
    outages = [float(argument) for argument in sys.argv[1:]] or [1.0, 10.0, 180.0]
    for mode in ("peer", "client"):
        print(json.dumps(main(mode, outages), indent=2), flush=True)
