"""The shipped example of a secured fleet, played: its certificates, its router, a wagon and its subscribers."""

import json
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh

from brake_monitor.publishing.about import about
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config
from network import free_port
from program import Router

EXAMPLES = Path(__file__).parents[1] / "docs" / "security"
PLACEHOLDER = "tls/zenoh.example.org:7447"


@pytest.fixture(scope="module")
def pki(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates made by the shipped script, and others of a stranger's authority."""
    folder = tmp_path_factory.mktemp("fleet")
    names = ("router=127.0.0.1", "wagon-8127", "dashboard", "workshop", "unknown")
    for directory in ("pki", "stranger"):
        subprocess.run([EXAMPLES / "make-certificates", folder / directory, *names], check=True, timeout=60)
    return folder


class Fleet:
    """A router and a wagon as the examples say; `config` is a subscriber's, with a certificate of somebody's."""

    def __init__(self, folder: Path, endpoint: str, publisher: Publisher) -> None:
        self._folder, self._endpoint = folder, endpoint
        self.publisher = publisher

    def config(self, name: str, authority: str = "pki") -> zenoh.Config:
        return zenoh.Config.from_json5(self.config_text(name, authority))

    def config_text(self, name: str, authority: str = "pki") -> str:
        return dashboard_config(self._folder / "pki", self._endpoint, self._folder / authority / name)

    @contextmanager
    def session(self, name: str) -> Iterator[zenoh.Session]:
        with zenoh.open(self.config(name)) as opened:
            yield opened


def router_config(certificates: Path, port: int) -> str:
    """The example's, on this machine."""
    text = (EXAMPLES / "router.json5").read_text().replace("0.0.0.0:7447", f"127.0.0.1:{port}")
    for file in ("ca.pem", "router.pem", "router.key"):
        text = text.replace(f'"{file}"', json.dumps(str(certificates / file)))
    return text


def gateway_config(endpoint: str) -> str:
    """The example's part of a wagon's configuration."""
    return (EXAMPLES / "gateway.toml").read_text().replace(PLACEHOLDER, endpoint)


def dashboard_config(certificates: Path, endpoint: str, own: Path) -> str:
    """The example's, of somebody whose certificate and key have that path but for `.pem` and `.key`."""
    text = (EXAMPLES / "dashboard.json5").read_text().replace(PLACEHOLDER, endpoint)
    return text.replace("pki/dashboard", str(own)).replace("pki/ca.pem", str(certificates / "ca.pem"))


@pytest.fixture
def fleet(pki: Path, tmp_path: Path) -> Iterator[Fleet]:
    port = free_port()
    (tmp_path / "router.json5").write_text(router_config(pki / "pki", port))
    endpoint = f"tls/127.0.0.1:{port}"
    (pki / "wagon.toml").write_text(
        example_config("wagon")
        .read_text()
        .replace('"wagon.dbc"', json.dumps(str(example_config("wagon").parent / "wagon.dbc")))
        + gateway_config(endpoint)
    )
    settings = load_settings(pki / "wagon.toml")
    with (
        Router(tmp_path / "router.json5"),
        Publisher(settings.zenoh, "wagon-8127", about=about(settings, 0.0)) as wagon,
    ):
        yield Fleet(pki, endpoint, wagon)
