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
from brake_monitor.settings.vehicle_files import example_config
from network import PATIENCE_S, free_port, process

EXAMPLES = Path(__file__).parents[1] / "docs" / "security"
PLACEHOLDER = "tls/zenoh.example.org:7447"

ROUTER = """
import sys, zenoh
session = zenoh.open(zenoh.Config.from_file(sys.argv[1]))
print("ready", flush=True)
sys.stdin.read()
"""


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
        text = (EXAMPLES / "dashboard.json5").read_text().replace(PLACEHOLDER, self._endpoint)
        for file in ("dashboard.pem", "dashboard.key"):
            own = self._folder / authority / file.replace("dashboard", name)
            text = text.replace(f"pki/{file}", str(own))
        return text.replace("pki/ca.pem", str(self._folder / "pki" / "ca.pem"))

    @contextmanager
    def session(self, name: str) -> Iterator[zenoh.Session]:
        with zenoh.open(self.config(name)) as opened:
            yield opened


@pytest.fixture
def fleet(pki: Path, tmp_path: Path) -> Iterator[Fleet]:
    port = free_port()
    router = (EXAMPLES / "router.json5").read_text().replace("0.0.0.0:7447", f"127.0.0.1:{port}")
    for file in ("ca.pem", "router.pem", "router.key"):
        router = router.replace(f'"{file}"', json.dumps(str(pki / "pki" / file)))
    (tmp_path / "router.json5").write_text(router)
    endpoint = f"tls/127.0.0.1:{port}"
    zenoh_part = (EXAMPLES / "gateway.toml").read_text().replace(PLACEHOLDER, endpoint)
    (pki / "wagon.toml").write_text(
        example_config("wagon")
        .read_text()
        .replace('"wagon.dbc"', json.dumps(str(example_config("wagon").parent / "wagon.dbc")))
        + zenoh_part
    )
    settings = load_settings(pki / "wagon.toml")
    with process(ROUTER, str(tmp_path / "router.json5")) as (_, lines):
        assert lines.get(timeout=PATIENCE_S) == "ready"
        with Publisher(settings.zenoh, "wagon-8127", about=about(settings, 0.0)) as publisher:
            yield Fleet(pki, endpoint, publisher)
