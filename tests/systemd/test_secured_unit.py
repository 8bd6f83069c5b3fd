"""The shipped unit behind the example's router, with the key where only root can read it, as systemd/README.md says."""

import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from brake_monitor.settings.example_vehicles import example_config
from installation import CONFIG, ETC, SERVICE, UNITS, install, run
from program import Python, Router
from secured_fleet import EXAMPLES, dashboard_config, gateway_config, router_config

pytestmark = pytest.mark.systemd

PORT = 7461
ENDPOINT = f"tls/127.0.0.1:{PORT}"
KEY = '"pki/wagon-8127.key"'
KEY_OF_THE_SERVICE = '"/run/credentials/brake-monitor.service/wagon.key"'
DROP_IN = Path("/etc/systemd/system") / f"{SERVICE}.d" / "tls.conf"

DASHBOARD = """
import sys, zenoh
with zenoh.open(zenoh.Config.from_file(sys.argv[1])) as session:
    with session.declare_subscriber("brake/v1/*/health") as subscriber:
        print(next(iter(subscriber)).key_expr, flush=True)
"""


@pytest.fixture
def pki(tmp_path: Path) -> Path:
    folder = tmp_path / "pki"
    run(EXAMPLES / "make-certificates", folder, "router=127.0.0.1", "wagon-8127", "dashboard")
    return folder


@pytest.fixture
def router(pki: Path) -> Iterator[None]:
    config = pki / "router.json5"
    config.write_text(router_config(pki, PORT))
    with Router(config):
        yield


@pytest.fixture
def service(pki: Path, router: None) -> Iterator[None]:
    install()
    (ETC / "pki").mkdir()
    for file, mode in (("ca.pem", "644"), ("wagon-8127.pem", "644"), ("wagon-8127.key", "600")):
        run("install", "-m", mode, pki / file, ETC / "pki")
    DROP_IN.parent.mkdir()
    shutil.copy(UNITS / DROP_IN.name, DROP_IN)
    zenoh = gateway_config(ENDPOINT).replace(KEY, KEY_OF_THE_SERVICE)
    CONFIG.write_text(example_config("wagon").read_text() + zenoh)
    run("systemctl", "daemon-reload")
    run("systemctl", "start", "vcan@can0", SERVICE)
    yield
    run("systemctl", "stop", SERVICE, "vcan@can0")
    shutil.rmtree(DROP_IN.parent)
    shutil.rmtree(ETC / "pki")
    shutil.copy(example_config("wagon"), CONFIG)
    run("systemctl", "daemon-reload")


def hears(pki: Path) -> str:
    """The key under which a dashboard with its own certificate hears the daemon's health."""
    config = pki / "dashboard.json5"
    config.write_text(dashboard_config(pki, ENDPOINT, pki / "dashboard"))
    with Python(DASHBOARD, config) as dashboard:
        return dashboard.wait_for("^brake/").string


@pytest.mark.usefixtures("service")
def test_a_dashboard_hears_the_service_also_after_a_reload(pki: Path) -> None:
    assert hears(pki) == "brake/v1/wagon-8127/health"
    run("systemctl", "reload", SERVICE)
    assert hears(pki) == "brake/v1/wagon-8127/health"
