"""The demo starts the page too, where that is possible, and takes it along when it ends."""

import sys
from contextlib import ExitStack
from http.client import HTTPConnection

import pytest

from program import PATIENCE_S, Program, until

DEMO = (sys.executable, "-u", "-m", "brake_monitor", "demo", "dry", "--speed", "3")


def answers(port: int) -> bool:
    connection = HTTPConnection("127.0.0.1", port, timeout=PATIENCE_S)
    try:
        connection.request("GET", "/")
        return connection.getresponse().status == 200
    except ConnectionError:
        return False
    finally:
        connection.close()


@pytest.mark.parametrize("times", [1, 2])
def test_the_demo_prints_the_address_of_its_page(times: int) -> None:
    """A second demo on the same machine takes other ports."""
    with ExitStack() as stack:
        demos = [stack.enter_context(Program(*DEMO)) for _ in range(times)]
        ports = [int(demo.wait_for(r"^in a browser: http://127.0.0.1:(\d+)/$")[1]) for demo in demos]
        assert len(set(ports)) == times
        assert all(answers(port) for port in ports)
    # They were killed, the hardest way to end: they could not take anything along themselves.
    until(lambda: not any(answers(port) for port in ports))


def test_it_is_left_out_when_not_wanted() -> None:
    with Program(*DEMO, "--no-dashboard") as demo:
        demo.wait_for("published at")
        demo.wait_for("km/h")  # it plays
        demo.end()
    assert not any("browser" in line for line in demo.lines)
