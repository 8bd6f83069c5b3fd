"""The daemon as `brake-monitor run` starts it, with a recording played to its virtual bus.

python played_daemon.py CONFIG LOG SPEED [FROM_S]
"""

# ruff: noqa: E402 - what must not be imported is said before the imports

import sys
import threading
import time
from pathlib import Path

from brake_monitor.host.python_can import load_without_asammdf

load_without_asammdf()  # as `brake-monitor` does

import can

from brake_monitor.bus.can_log import open_log
from brake_monitor.cli import main
from brake_monitor.daemon import service
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.live import play


def play_slowly(settings: Settings, log: Path, speed: float, from_s: float, listening: threading.Event) -> None:
    listening.wait()
    with can.Bus(interface="virtual", channel=settings.can[0].channel, preserve_timestamps=True) as bus:
        play([frame for frame in open_log(log, settings.can) if frame.time_s >= from_s], bus, speed)
    time.sleep(60.0)


if __name__ == "__main__":
    config, log, speed = Path(sys.argv[1]), Path(sys.argv[2]), float(sys.argv[3])
    listening = threading.Event()
    say = service.notify

    def hear(*states: str) -> None:
        if "READY=1" in states:
            listening.set()
        say(*states)

    service.notify = hear
    from_s = float(sys.argv[4]) if len(sys.argv) > 4 else 0.0
    settings = load_settings(config)  # not in two threads at once: msgspec 0.22 dies when both are the first to
    threading.Thread(target=play_slowly, args=(settings, log, speed, from_s, listening), daemon=True).start()
    sys.exit(main(["run", "-c", str(config)]))
