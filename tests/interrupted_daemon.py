"""The real daemon in a process of its own, fed from a recording, and what its memory says meanwhile."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from brake_monitor.errors import BrakeMonitorError
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store import Store

PLAYER = Path(__file__).with_name("played_daemon.py")
PATIENCE_S = 300.0
SPEED = 8.0

Daemon = subprocess.Popen[str]


def prepare(folder: Path, zenoh: str, end_s: float) -> None:
    """A configuration with a state directory and this in its [zenoh], and a recording of so many seconds."""
    example = example_config("wagon")
    text = example.read_text().replace('"socketcan"', '"virtual"').replace('"can0"', '"interrupted"')
    text = text.replace('dbc = ["', f'dbc = ["{example.parent}/')
    (folder / "wagon.toml").write_text(f'{text}\n[store]\ndirectory = "state"\n[zenoh]\n{zenoh}\n')
    frames = simulate("wsp", load_settings(folder / "wagon.toml"), 0).frames
    write_log(folder / "wsp.log", [frame for frame in frames if frame.time_s < EPOCH_S + end_s])


@contextmanager
def daemon(folder: Path, from_s: float) -> Iterator[Daemon]:
    command = [sys.executable, PLAYER, folder / "wagon.toml", folder / "wsp.log", str(SPEED), repr(from_s)]
    with (
        (folder / "said.txt").open("a") as said,
        subprocess.Popen(command, stdout=said, stderr=said, text=True) as child,
    ):
        try:
            yield child
        finally:
            child.kill()


@cache
def vehicle_of(folder: Path) -> str:
    """Which is asked for again and again, and never changes."""
    return load_settings(folder / "wagon.toml").vehicle.id


def kept(folder: Path) -> tuple[Brakes | None, list[Alarm]]:
    try:
        with Store.look(folder / "state" / FILE_NAME, vehicle_of(folder)) as store:
            return store.brakes(), store.alarms()
    except BrakeMonitorError:  # not made yet
        return None, []


def kept_until_s(folder: Path) -> float:
    brakes, _ = kept(folder)
    return -1.0 if brakes is None or brakes.time_s is None else brakes.time_s


def wait_until(child: Daemon, folder: Path, time_s: float) -> None:
    """What is kept is of this time: on a busy machine the daemon is behind what is played."""
    deadline_s = time.monotonic() + PATIENCE_S
    while kept_until_s(folder) < time_s:
        said = (folder / "said.txt").read_text()
        assert child.poll() is None, f"{said}\nit ended with {child.returncode}"
        assert time.monotonic() < deadline_s, said
        time.sleep(0.05)
