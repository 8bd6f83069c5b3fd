"""Alarms of the last day and adhesion of the last minute.

Run: python history.py [tcp/127.0.0.1:7447 [wagon-8127]]
"""

import json
import sys
import time

import zenoh

endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
wagon = sys.argv[2] if len(sys.argv) > 2 else "*"
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit(f"nobody answers at {endpoint}")
with session:
    if not list(session.liveliness().get(f"brake/v1/{wagon}")):
        sys.exit(f"no daemon answers as brake/v1/{wagon} at {endpoint}")
    for key, seconds in (("alarm/**", 86400), ("adhesion", 60)):
        for reply in session.get(f"brake/v1/{wagon}/{key}?from_s={time.time() - seconds}"):
            for message in json.loads(reply.ok.payload.to_bytes()) if reply.ok else ():
                print(reply.ok.key_expr, message["time_s"], message.get("message", message.get("adhesion")))
