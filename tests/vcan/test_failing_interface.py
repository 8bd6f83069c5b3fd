"""The daemon on an interface that fails: it tells, lives on, and listens again once the interface is back."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import run as simulate
from program import BRAKE_MONITOR, Daemon, Program, Subscriber, run, write_config

pytestmark = pytest.mark.vcan

NAME = "vcantest2"
ROLLING = Scenario(
    name="rolling",
    summary="a few seconds of coasting",
    initial_speed_mps=25.0,
    duration_s=5.0,
    demand=steps(),
    rail_over_time=Profile(((0.0, 0.45),)),
)
ESTIMATE = r'/adhesion".*"status": "(valid|converging)"'
NO_ESTIMATE = r'/adhesion".*"status": "invalid"'


@pytest.fixture
def interface() -> Iterator[str]:
    """An interface of the test's own, to be taken down or away."""
    come_up()
    yield NAME
    run("ip", "link", "del", NAME)


def come_up() -> None:
    run("ip", "link", "add", NAME, "type", "vcan")  # unless it is there
    assert run("ip", "link", "set", NAME, "up").returncode == 0


@pytest.mark.parametrize("failure", [("set", NAME, "down"), ("del", NAME)], ids=["down", "gone"])
def test_silence_is_published_and_ends_when_the_interface_is_back(
    failure: tuple[str, ...], interface: str, tmp_path: Path
) -> None:
    config = write_config(tmp_path / "wagon.toml", interface, rate_hz=5.0)
    log = tmp_path / "rolling.log"
    write_log(log, simulate(ROLLING, load_settings(config), seed=1).frames)
    again_and_again = ("canplayer", "-l", "i", "-I", log, f"{interface}={interface}")
    with Daemon(config) as daemon, Subscriber(daemon.endpoint) as subscriber:
        with Program(*again_and_again):
            subscriber.wait_for(ESTIMATE)
            assert run("ip", "link", *failure).returncode == 0
            daemon.wait_for(f"{interface}.* failed while listening")
        subscriber.wait_for(NO_ESTIMATE, after=len(subscriber.lines))
        come_up()
        daemon.wait_for(f"{interface} is back")
        with Program(*again_and_again):
            subscriber.wait_for(ESTIMATE, after=len(subscriber.lines))
        assert daemon.end()[0] == 0


def test_an_interface_that_is_not_there_at_the_start_is_refused_in_one_sentence(tmp_path: Path) -> None:
    config = write_config(tmp_path / "wagon.toml", "vcan99", rate_hz=5.0)
    ended = run(BRAKE_MONITOR, "run", "-c", config, "--log-level", "warning")
    assert (ended.returncode, ended.stdout) == (2, "")
    (sentence,) = ended.stderr.splitlines()
    assert sentence.startswith("brake-monitor: ")
    assert "vcan99" in sentence
