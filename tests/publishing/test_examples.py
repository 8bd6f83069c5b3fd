"""The examples that a subscriber copies run as they are written; so does a client that somebody else wrote."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from brake_monitor.processing.pipeline import Outputs
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.zenoh_settings import ZenohSettings
from estimates import alarm, estimate
from network import free_port, running
from program import PATIENCE_S, Program, Router, run, until

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
ZENOH_CLI = os.environ.get("ZENOH_CLI") or shutil.which("zenoh")


def lines_of(publisher: Publisher, example: str, *arguments: str) -> list[str]:
    """What an example that ends by itself prints."""
    command = [sys.executable, EXAMPLES / example, publisher.endpoints[0], *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=PATIENCE_S).stdout.splitlines()


def listening(publisher: Publisher, example: str) -> Program:
    """An example that listens for ever."""
    return Program(sys.executable, EXAMPLES / example, publisher.endpoints[0])


def test_adhesion() -> None:
    with running() as publisher, listening(publisher, "adhesion.py") as example:
        until(lambda: publisher.publish(Outputs(estimate())) or example.lines)
        assert example.lines[0] == "brake/v1/wagon-1/adhesion 0.080 ± 0.003 all that the rail gives"


@pytest.mark.parametrize("name", ["adhesion.py", "alarms.py"])
def test_ctrl_c_ends_what_listens_without_a_traceback(name: str) -> None:
    with running() as publisher, listening(publisher, name) as example:
        until(lambda: publisher.publish(Outputs(estimate(), (alarm(),))) or example.lines)
        example.end(signal.SIGINT)
    assert not [line for line in example.lines if "Traceback" in line]


def test_alarms() -> None:
    with running() as publisher:
        publisher.publish(Outputs(None, (alarm(id="first"),)))  # before anybody listens
        with listening(publisher, "alarms.py") as example:
            example.wait_for(r"^1 first open alarm The rail gives 0\.03\.$")
            publisher.publish(Outputs(None, (alarm(id="second"),)))
            example.wait_for("^2 second open alarm The rail")
            publisher.publish(Outputs(None, (alarm(id="second", acknowledged_time_s=5010.0),)))
            example.wait_for("^3 second open, acknowledged alarm The rail")


def test_last_values() -> None:
    with running() as publisher:
        publisher.publish(Outputs(estimate(), (alarm(),)))
        until(lambda: publisher.counters.estimates_sent)
        keys = {line.split()[0].removeprefix("brake/v1/wagon-1/") for line in lines_of(publisher, "last_values.py")}
    assert keys == {"adhesion", "alarm/low_adhesion"} | {
        f"axle/{i}/{n}" for i in (1, 2) for n in ("adhesion", "friction")
    }


def test_history() -> None:
    now_s = time.time()
    with running() as publisher:
        over = alarm(raised_time_s=now_s - 3600.0, updated_time_s=now_s - 3500.0, cleared_time_s=now_s - 3500.0)
        publisher.publish(Outputs(estimate(time_s=now_s - 600.0), (over,)))
        until(lambda: publisher.counters.estimates_sent == 1)
        publisher.publish(Outputs(estimate(time_s=now_s - 6.0)))
        until(lambda: publisher.counters.estimates_sent == 2)
        told = [line.split()[0] for line in lines_of(publisher, "history.py", "wagon-1")]
    assert told == ["brake/v1/wagon-1/alarm/low_adhesion", "brake/v1/wagon-1/adhesion"]


def test_acknowledge() -> None:
    """By its id, and all that latch and are open, where the wagon lets it."""
    standing = alarm(id="dragging_brake-1-5000", kind="dragging_brake", wheelset=1)
    with running(ZenohSettings(accept_acknowledgements=True)) as publisher:
        publisher.publish(Outputs(None, (standing, alarm(id="low_adhesion-5000"))))
        until(lambda: publisher.counters.events_sent == 2)
        (one,) = lines_of(publisher, "acknowledge.py", "wagon-1", "low_adhesion-5000")
        (latched,) = lines_of(publisher, "acknowledge.py", "wagon-1")
    assert (one.split()[0], latched.split()[0]) == ("low_adhesion-5000", "dragging_brake-1-5000")
    assert '"accepted":true' in one
    with running() as publisher:
        (refused,) = lines_of(publisher, "acknowledge.py", "wagon-1", "low_adhesion-5000")
        (nothing,) = lines_of(publisher, "acknowledge.py", "wagon-1")
    assert "does not let alarms be acknowledged" in refused
    assert nothing == "wagon-1 tells of no alarm that waits to be acknowledged"


@pytest.mark.parametrize("example", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_where_nobody_answers_an_example_says_so(example: str) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    ended = run(sys.executable, EXAMPLES / example, endpoint)
    assert (ended.returncode, ended.stdout, ended.stderr) == (1, "", f"nobody answers at {endpoint}\n")


@pytest.mark.parametrize(
    ("example", "arguments"),
    [
        ("last_values.py", []),
        ("history.py", []),
        ("history.py", ["wagon-7"]),
        ("acknowledge.py", ["wagon-7", "some-id"]),
    ],
)
def test_who_asks_where_no_daemon_answers_is_told(example: str, arguments: list[str]) -> None:
    """Who listens goes on: a daemon may come."""
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with Router(endpoint):
        ended = run(sys.executable, EXAMPLES / example, endpoint, *arguments)
    (wagon, *_) = (*arguments, "*")
    said = f"no daemon answers as brake/v1/{wagon} at {endpoint}\n"
    assert (ended.returncode, ended.stdout, ended.stderr) == (1, "", said)


@pytest.mark.skipif(not ZENOH_CLI, reason="needs an independent client: pip install zenoh-cli, elsewhere than here")
def test_an_independent_client_reads_it() -> None:
    with running() as publisher:
        publisher.publish(Outputs(estimate(), (alarm(),)))
        until(lambda: publisher.counters.estimates_sent)
        where = ["--mode", "client", "--connect", publisher.endpoints[0]]
        command = [ZENOH_CLI, *where, "get", "-s", "brake/v1/*/adhesion", "--decoder", "json"]
        found = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=True).stdout
    assert json.loads(found)["adhesion"] == 0.08
