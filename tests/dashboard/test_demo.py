"""The demo starts the page too, where that is possible, and takes it along when it ends."""

import subprocess
import sys
from http.client import HTTPConnection

import pytest

from program import PATIENCE_S, until

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
    demos = [subprocess.Popen(DEMO, stdout=subprocess.PIPE, text=True) for _ in range(times)]
    ports = []
    for demo in demos:
        assert demo.stdout is not None
        said = next(line for line in demo.stdout if line.startswith("in a browser: http://127.0.0.1:"))
        ports.append(int(said.strip().rstrip("/").rpartition(":")[2]))
    assert len(set(ports)) == times
    assert all(answers(port) for port in ports)
    for demo in demos:
        demo.kill()  # the hardest way to end: it cannot take anything along itself
        demo.communicate(timeout=PATIENCE_S)
    until(lambda: not any(answers(port) for port in ports))


def test_it_is_left_out_when_not_wanted() -> None:
    with subprocess.Popen((*DEMO, "--no-dashboard"), stdout=subprocess.PIPE, text=True) as demo:
        assert demo.stdout is not None
        said = [next(demo.stdout) for _ in range(8)]
        demo.terminate()
        said.append(demo.communicate(timeout=PATIENCE_S)[0])
    assert "published at" in "".join(said)
    assert "browser" not in "".join(said)
