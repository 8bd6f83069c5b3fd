"""Plays a log onto wire0 by a clock that nobody sets, which canplayer does not. usage: player.py LOG"""

import sys
from pathlib import Path

import can

from brake_monitor.bus.candump_log import parse_line
from brake_monitor.simulator.live import play

with can.Bus(interface="socketcan", channel="wire0") as wire:
    play(map(parse_line, Path(sys.argv[1]).read_text().splitlines()), wire, speed=1.0)
