"""A Zenoh router. usage: router.py ENDPOINT"""

import json
import signal
import sys

import zenoh

signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
settings = {"mode": "router", "listen": {"endpoints": [sys.argv[1]]}}
config = zenoh.Config.from_json5(json.dumps(settings | {"scouting": {"multicast": {"enabled": False}}}))
with zenoh.open(config):
    print("ready", flush=True)
    signal.sigwait({signal.SIGTERM})
