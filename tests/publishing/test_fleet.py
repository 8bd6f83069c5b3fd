"""Many at once: fifty subscribers at one wagon, and a small fleet through one router."""

import json
from itertools import count

from benchmarks.fleet import main
from brake_monitor.processing.pipeline import Outputs
from estimates import alarm, estimate
from network import running
from program import Python, until

# Tells on request the numbers of the alarms that each subscriber has heard.
FIFTY = """
import json, sys, zenoh
heard = [[] for _ in range(50)]
def noting(i):
    return lambda sample: heard[i].append(json.loads(sample.payload.to_bytes())["sequence"])
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [sys.argv[1]]}}))
sessions = [zenoh.open(config) for _ in heard]
subscribers = [s.declare_subscriber("brake/v1/*/alarm/**", noting(i)) for i, s in enumerate(sessions)]
estimates = [s.declare_subscriber("brake/v1/*/adhesion", lambda sample: None) for s in sessions]
print("ready", flush=True)
for line in sys.stdin:
    print(json.dumps(heard), flush=True)
"""


def test_fifty_subscribers_each_hear_every_alarm_and_the_pipeline_waits_for_none() -> None:
    with running() as publisher, Python(FIFTY, publisher.endpoints[0]) as fifty:
        fifty.wait_for("ready")
        numbers = count(1)

        def give() -> int:
            publisher.publish(Outputs(estimate(), (alarm(),)))
            return next(numbers)

        def heard() -> list[list[int]]:
            return json.loads(fifty.ask())

        until(lambda: give() and all(heard()))  # the publisher knows of each
        last = [give() for _ in range(20)][-1]
        until(lambda: all(one[-1] == last for one in heard()))
        assert all(one == list(range(one[0], last + 1)) for one in heard())
    assert publisher.counters.events_lost == 0


def test_a_small_fleet_loses_nothing() -> None:
    """The benchmark of the README, in small: 8 wagons, each with one alarm."""
    figures = main(8, 6.0)
    assert figures["estimates given, replaced, sent"][0] == 480
    assert figures["estimates lost on the way"] == figures["wheelset messages lost"] == 0
    assert figures["alarms sent, heard"] == [8, 8]
