"""The daemon is told to read its configuration again, and waits for a bus that is not there yet."""

import re
import signal
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from program import STOP_S, Daemon, Program, Subscriber, daemon_command, run, write_config

pytestmark = pytest.mark.vcan

NAME = "vcantest3"
SPEED = "120#0002000000000000"  # a mapped frame


@pytest.fixture
def config(tmp_path: Path) -> Path:
    return write_config(tmp_path / "wagon.toml", "vcan0", rate_hz=5.0)


def changed(config: Path, old: str, new: str) -> None:
    text = config.read_text()
    assert old in text
    config.write_text(text.replace(old, new))


def hears(daemon: Daemon) -> bool:
    """Whether it publishes what comes over vcan0."""
    with Subscriber(daemon.endpoint) as subscriber:
        run("cansend", "vcan0", SPEED)
        subscriber.wait_for("/adhesion")
        subscriber.end()
    return True


def test_a_new_configuration_is_taken_over_without_a_new_process(config: Path) -> None:
    changed(config, "[output]", '[zenoh]\nlisten = ["tcp/127.0.0.1:17447"]\n[output]')
    with Daemon(config) as daemon:
        changed(config, '"wagon-8127"', '"wagon-9999"')
        changed(config, '"vcan0"', '"vcan1"')
        before = len(daemon.lines)
        daemon.send_signal(signal.SIGHUP)
        daemon.wait_for("socketcan:vcan1", after=before)
        with Subscriber(daemon.endpoint) as subscriber:
            run("cansend", "vcan1", SPEED)
            subscriber.wait_for('"key": "brake/v1/wagon-9999/adhesion"')
            subscriber.end()
            assert all(sample["key"].startswith("brake/v1/wagon-9999/") for sample in subscriber.samples())
        assert daemon.end()[0] == 0


BAD = {  # what is changed in a good configuration, and what the refusal has to name
    "a value": ("mass_kg = 36000.0", "mass_kg = -1.0", "mass_kg"),
    "the mapping": ('message = "GNSS"', 'message = "GNS"', "GNS"),
    "the bus": ('"vcan0"', '"vcan7"', "vcan7"),
    "no TOML": ("[output]", "[output", "not valid TOML"),
    "an endpoint": ("[output]", '[zenoh]\nlisten = ["nonsense"]\n[output]', "nonsense"),
}


def test_a_bad_configuration_is_refused_and_the_old_one_goes_on(config: Path) -> None:
    good = config.read_text()
    with Daemon(config) as daemon:
        for old, new, reason in BAD.values():
            changed(config, old, new)
            before = len(daemon.lines)
            daemon.send_signal(signal.SIGHUP)
            daemon.wait_for(f"the new configuration is refused: .*{reason}", after=before)
            config.write_text(good)
        assert hears(daemon)
        assert daemon.end()[0] == 0
        assert not any("Traceback" in line for line in daemon.lines)


def test_what_shows_only_when_it_is_opened_is_rolled_back_too(config: Path) -> None:
    """Another program has the port that the new configuration wants to listen on."""
    with Daemon(config) as daemon, socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        changed(config, "[output]", f'[zenoh]\nlisten = ["tcp/127.0.0.1:{other.getsockname()[1]}"]\n[output]')
        before = len(daemon.lines)
        daemon.send_signal(signal.SIGHUP)
        daemon.wait_for("the new configuration does not work", after=before)
        daemon.endpoint = daemon.wait_for(r"Zenoh session open, (?:on )?(\S+)", after=before)[1]
        daemon.wait_for("listening on", after=before)
        assert hears(daemon)
        assert daemon.end()[0] == 0


def test_an_end_that_comes_while_it_reloads_is_an_end(config: Path) -> None:
    with Daemon(config) as daemon:
        daemon.send_signal(signal.SIGHUP)
        assert daemon.end()[0] == 0


@pytest.fixture
def no_interface() -> Iterator[None]:
    yield
    run("ip", "link", "del", NAME)


@pytest.mark.usefixtures("no_interface")
def test_a_bus_that_is_missing_or_down_at_the_start_is_waited_for(tmp_path: Path) -> None:
    config = write_config(tmp_path / "wagon.toml", NAME, rate_hz=5.0)
    with Program(*daemon_command(config), "--wait-for-bus") as daemon:
        daemon.wait_for(f'no network interface "{NAME}"; waiting for it')
        run("ip", "link", "add", NAME, "type", "vcan")
        daemon.wait_for(f'"{NAME}" is down.*waiting for it')
        assert not any("listening" in line or "Zenoh session" in line for line in daemon.lines)
        run("ip", "link", "set", NAME, "up")
        daemon.wait_for(f"listening on socketcan:{NAME}")
        assert sum(bool(re.search("waiting for it", line)) for line in daemon.lines) == 2
        assert daemon.end()[0] == 0


def test_it_can_be_ended_while_it_waits(tmp_path: Path) -> None:
    config = write_config(tmp_path / "wagon.toml", NAME, rate_hz=5.0)
    with Program(*daemon_command(config), "--wait-for-bus") as daemon:
        daemon.wait_for("waiting for it")
        status, took_s = daemon.end()
    assert status == 0
    assert took_s < STOP_S
