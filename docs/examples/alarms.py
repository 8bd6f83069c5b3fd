"""Every change of every alarm, once and in order, over outages and restarts.

Run: python alarms.py [tcp/127.0.0.1:7447]
"""

import json
import signal
import sys

import zenoh
from zenoh import ext

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a word
endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
history = ext.HistoryConfig(detect_late_publishers=True)
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit(f"nobody answers at {endpoint}")
with session, ext.declare_advanced_subscriber(session, "brake/v1/*/alarm/**", history=history) as subscriber:
    for sample in subscriber:
        alarm = json.loads(sample.payload.to_bytes())
        state = alarm["state"] + (", acknowledged" if alarm["acknowledged_time_s"] else "")
        print(alarm["sequence"], alarm["id"], state, alarm["severity"], alarm["message"], flush=True)
