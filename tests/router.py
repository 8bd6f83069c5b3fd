"""A Zenoh router. usage: router.py ENDPOINT|CONFIGURATION"""

import json
import signal
import sys
from pathlib import Path

import zenoh

(place,) = sys.argv[1:]
signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
settings = {"mode": "router", "listen": {"endpoints": [place]}, "scouting": {"multicast": {"enabled": False}}}
with zenoh.open(
    zenoh.Config.from_file(place) if Path(place).exists() else zenoh.Config.from_json5(json.dumps(settings))
):
    print("ready", flush=True)
    signal.sigwait({signal.SIGTERM})
