"""Two buses in one daemon: each bogie's units on a bus of its own, with the same ids and a DBC file of its own."""

import re
import shutil
from pathlib import Path
from typing import Any

import pytest

from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import run as simulate
from program import Daemon, Program, Subscriber, run, until

pytestmark = pytest.mark.vcan

WAGON = "brake/v1/wagon-8127"
BRAKING = Scenario(
    name="braking",
    summary="coasting, then a light braking",
    initial_speed_mps=25.0,
    duration_s=12.0,
    demand=steps((4.0, 0.4)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
BUSES = """\
[[can]]
name = "front"
interface = "socketcan"
channel = "vcan0"
dbc = ["wagon.dbc"]

[[can]]
name = "rear"
interface = "socketcan"
channel = "vcan1"
dbc = ["rear.dbc"]

[signals]
speed = { bus = "front", message = "GNSS", signal = "v_ground", unit = "m/s", noise_std = 0.02 }
axle_speed = [
  { bus = "front", message = "WSP", signal = "n_A", unit = "km/h", noise_std = 0.036, counter = "WSP_counter" },
  { bus = "rear", message = "WSP", signal = "n_A", unit = "km/h", noise_std = 0.036, counter = "WSP_counter" },
]
pressing_force = [
  { bus = "front", message = "BCU", signal = "p_A", scale = 18600.0, offset = -4650.0, min = 0.0, noise_std = 100.0 },
  { bus = "rear", message = "BCU", signal = "p_A", scale = 18600.0, offset = -4650.0, min = 0.0, noise_std = 100.0 },
]
"""


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """The example wagon with its units on two buses; the rear one's speed sensor counts in steps twice as fine."""
    example = example_config("wagon")
    dbc = shutil.copy(example.with_name("wagon.dbc"), tmp_path)
    rear, changed = re.subn(r"(SG_ n_A .*)\(0\.01,0\)", r"\1(0.005,0)", Path(dbc).read_text())
    assert changed == 1
    (tmp_path / "rear.dbc").write_text(rear)
    vehicle = example.read_text().partition("[can]")[0]
    path = tmp_path / "wagon.toml"
    path.write_text(vehicle + BUSES)
    return path


def told(subscriber: Subscriber, key: str) -> list[dict[str, Any]]:
    return subscriber.payloads(f"{WAGON}/{key}")


def test_each_wheelset_is_read_from_its_own_bus_by_its_own_dbc(config: Path, tmp_path: Path) -> None:
    log = tmp_path / "braking.log"
    frames = simulate(BRAKING, load_settings(config), seed=1).frames
    assert {frame.bus for frame in frames} == {"front", "rear"}
    write_log(log, frames)
    with Daemon(config) as daemon, Subscriber(daemon.endpoint) as subscriber:
        assert run("canplayer", "-I", log, "vcan0=front", "vcan1=rear").returncode == 0
        subscriber.wait_for('"status": "valid"')
        until(lambda: any((p["pressing_force_n"] or 0.0) > 10_000.0 for p in told(subscriber, "axle/2/friction")))
        subscriber.end()
        assert daemon.end()[0] == 0
    braked = {p["time_s"]: p for p in told(subscriber, "adhesion") if p["status"] == "valid"}
    for i in (1, 2):
        wheels = {p["time_s"]: p for p in told(subscriber, f"axle/{i}/friction")}
        both = braked.keys() & wheels.keys()  # of the first and the last estimate only a part may be heard
        assert len(both) > len(braked) / 2
        for time_s in both:
            assert wheels[time_s]["omega_radps"] * 0.445 == pytest.approx(braked[time_s]["speed_mps"], rel=0.03)


def test_one_bus_that_fails_takes_nothing_from_the_other(config: Path, tmp_path: Path) -> None:
    log = tmp_path / "braking.log"
    write_log(log, simulate(BRAKING, load_settings(config), seed=1).frames)

    def played(assignment: str) -> Program:
        return Program("canplayer", "-l", "i", "-I", log, assignment)

    with Daemon(config) as daemon, Subscriber(daemon.endpoint) as subscriber:
        with played("vcan0=front"):
            with played("vcan1=rear"):
                subscriber.wait_for('"status": "valid"')
                assert run("ip", "link", "set", "vcan1", "down").returncode == 0
            try:
                assert "rear" in subscriber.wait_for(r"/alarm/bus_fault.*")[0]
                subscriber.wait_for(r'/adhesion".*"reasons": \["axle_speed 2 lost", "pressing_force 2 lost"\]')
                subscriber.wait_for(r'/health".*"buses_down": \["socketcan:vcan1"\]')
            finally:
                assert run("ip", "link", "set", "vcan1", "up").returncode == 0
            daemon.wait_for("vcan1 is back")
            with played("vcan1=rear"):
                subscriber.wait_for('"status": "valid"', after=len(subscriber.lines))
        assert daemon.end()[0] == 0
