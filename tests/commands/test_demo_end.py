"""The demo says what comes, plays to its end, however fast, and says so when it was ended before."""

import re
import shlex
import signal
import subprocess
import sys

import pytest

from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import run
from program import Program

LONGEST_S = 300.0  # on the busiest machine
DEMO = (sys.executable, "-u", "-m", "brake_monitor", "demo", "dry", "--no-dashboard")


def played_s(vehicle: str, speed: str) -> tuple[float, list[str]]:
    """How long what the demo has played lasts, once it has ended, and all that it has said."""
    command = [*DEMO, "--vehicle", vehicle, "--speed", speed]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_S, check=True)
    played = re.search(r"([\d.]+) s of recording", done.stdout)
    assert played
    frames = run("dry", example_settings(vehicle), 0).frames
    assert float(played[1]) == pytest.approx(frames[-1].time_s - frames[0].time_s, abs=1.0)  # it brakes early
    return float(played[1]), done.stdout.splitlines()


def test_at_any_speed_the_demo_plays_to_its_end() -> None:
    """The rig's bus carries a message that nothing is mapped to."""
    played_s("rig", "max")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_demo_that_is_ended_before_its_end_was_interrupted(number: signal.Signals) -> None:
    with Program(*DEMO) as demo:
        demo.wait_for(" km/h ")  # it plays
        status, _ = demo.end(number)
    assert status == 130
    assert demo.wait_for("s of recording")  # and tells what it has seen
    assert demo.lines[-1] == "brake-monitor: interrupted"


def test_the_demo_says_first_that_it_simulates_and_then_how_long_it_plays() -> None:
    speed = 40
    played, (simulates, waits, plays, *later) = played_s("wagon", str(speed))
    assert simulates.startswith("simulating 'dry'")
    assert "nobody to subscribe to yet" in waits
    told = re.search(r"plays for (\d+) s", plays)
    assert told
    assert int(told[1]) == pytest.approx(played / speed, abs=0.6)  # it is told in whole seconds
    assert "ends with it" in plays
    (watches,) = [shlex.split(line) for line in later if " watch --connect tcp/" in line]
    program = watches[: watches.index("watch")]
    assert subprocess.run([*program, "--version"], check=False).returncode == 0  # also where it is not on the path
