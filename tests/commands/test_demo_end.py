"""The demo plays to its end, however fast."""

import re
import subprocess
import sys

import pytest

from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.vehicle_files import example_config
from brake_monitor.simulator.simulate import run

LONGEST_S = 300.0  # on the busiest machine


@pytest.mark.parametrize("vehicle", ["rig", "wagon"])  # the rig's bus carries a message that nothing is mapped to
def test_at_any_speed_the_demo_plays_to_its_end(vehicle: str) -> None:
    command = [sys.executable, "-m", "brake_monitor", "demo", "dry", "--vehicle", vehicle, "--speed", "max"]
    command += ["--no-dashboard"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=True)
    frames = run("dry", load_settings(example_config(vehicle)), 0).frames
    played = re.search(r"([\d.]+) s of recording", done.stdout)
    assert played
    assert float(played[1]) == pytest.approx(frames[-1].time_s - frames[0].time_s, abs=1.0)  # it brakes early
