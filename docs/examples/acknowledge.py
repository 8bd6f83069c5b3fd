"""Acknowledges an alarm by its id, or all latched ones that are open; the wagon needs accept_acknowledgements = true.

Run: python acknowledge.py [tcp/127.0.0.1:7447 [wagon-8127 [dragging_brake-1-1767225600000]]]
"""

import json
import sys

import zenoh

LATCHED = ("wheelset_not_rotating", "dragging_brake", "pad_at_limit")  # by default
endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
wagon = sys.argv[2] if len(sys.argv) > 2 else "wagon-8127"
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit(f"nobody answers at {endpoint}")
with session:
    if not list(session.liveliness().get(f"brake/v1/{wagon}")):
        sys.exit(f"no daemon answers as brake/v1/{wagon} at {endpoint}")
    wanted = sys.argv[3:]
    if not wanted:
        replies = [reply.ok for reply in session.get(f"brake/v1/{wagon}/alarm/**") if reply.ok]
        alarms = [json.loads(reply.payload.to_bytes()) for reply in replies]  # those that are open
        wanted = [a["id"] for a in alarms if a["kind"] in LATCHED and a["acknowledged_time_s"] is None]
        if not wanted:
            print(f"{wagon} tells of no alarm that waits to be acknowledged")
    for alarm_id in wanted:
        for reply in session.get(f"brake/v1/{wagon}/acknowledge", payload=json.dumps({"id": alarm_id})):
            answer = reply.ok or reply.err
            print(alarm_id, answer.payload.to_string() if answer else "no answer", flush=True)
