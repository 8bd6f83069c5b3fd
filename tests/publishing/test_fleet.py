"""Many at once: fifty subscribers at one wagon, and a small fleet through one router."""

import json
import time

from benchmarks.fleet import main
from brake_monitor.processing.pipeline import Outputs
from estimates import alarm, estimate
from network import PATIENCE_S, process, running

FIFTY = """
import json, sys, zenoh
counts = [0] * 50
def counting(i):
    def note(sample):
        counts[i] += 1
    return note
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [sys.argv[1]]}}))
sessions = [zenoh.open(config) for _ in counts]
subscribers = [s.declare_subscriber("brake/v1/*/alarm/**", counting(i)) for i, s in enumerate(sessions)]
estimates = [s.declare_subscriber("brake/v1/*/adhesion", lambda sample: None) for s in sessions]
print("ready", flush=True)
for line in sys.stdin:
    print(json.dumps(counts), flush=True)
"""


def test_fifty_subscribers_each_hear_every_alarm_and_the_pipeline_waits_for_none() -> None:
    with running() as publisher, process(FIFTY, publisher.endpoints[0]) as (child, lines):
        assert lines.get(timeout=PATIENCE_S) == "ready"
        time.sleep(1.0)  # for the last of the subscriptions to reach the publisher
        for _ in range(20):
            publisher.publish(Outputs(estimate(), (alarm(),)))
        deadline = time.monotonic() + PATIENCE_S
        counts: list[int] = []
        while counts != [20] * 50:
            assert time.monotonic() < deadline, counts
            print(file=child.stdin, flush=True)
            counts = json.loads(lines.get(timeout=PATIENCE_S))
    assert publisher.counters.events_lost == 0


def test_a_small_fleet_loses_nothing() -> None:
    """The benchmark of the README, in small: 8 wagons, each with one alarm."""
    figures = main(8, 6.0)
    assert figures["estimates given, replaced, sent"][0] == 480
    assert figures["estimates lost on the way"] == figures["wheelset messages lost"] == 0
    assert figures["alarms sent, heard"] == [8, 8]
