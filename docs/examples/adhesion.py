"""Adhesion of every wagon, as it comes.

Run: python adhesion.py [tcp/127.0.0.1:7447]
"""

import json
import signal
import sys

import zenoh

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends it without a word
endpoint = sys.argv[1] if len(sys.argv) > 1 else "tcp/127.0.0.1:7447"
config = zenoh.Config.from_json5(json.dumps({"mode": "client", "connect": {"endpoints": [endpoint]}}))
try:
    session = zenoh.open(config)
except zenoh.ZError:
    sys.exit(f"nobody answers at {endpoint}")
with session, session.declare_subscriber("brake/v1/*/adhesion") as subscriber:
    for sample in subscriber:
        message = json.loads(sample.payload.to_bytes())
        if message["quality"] == "good":
            meaning = "all that the rail gives" if message["saturated"] else "in use"
            print(sample.key_expr, f"{message['adhesion']:z.3f} ± {message['adhesion_std']:.3f}", meaning, flush=True)
