"""The newest of everything, and open alarms.

Run: python last_values.py [tcp/127.0.0.1:7447]
"""

import json
import sys

import zenoh

endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit(f"nobody answers at {endpoint}")
with session:
    if not list(session.liveliness().get("brake/v1/*")):
        sys.exit(f"no daemon answers as brake/v1/* at {endpoint}")
    for reply in session.get("brake/v1/*/**"):
        if reply.ok:
            print(reply.ok.key_expr, json.loads(reply.ok.payload.to_bytes()))
