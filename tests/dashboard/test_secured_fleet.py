"""The dashboard in the shipped example of a secured fleet: it hears, and asks for the past, with its certificate."""

import shutil
from pathlib import Path
from typing import Any

import pytest

from brake_monitor.processing.pipeline import Outputs
from depot import Dashboard
from estimates import alarm, estimate
from live import first_words
from program import until
from secured_fleet import Fleet

pytestmark = pytest.mark.skipif(not shutil.which("openssl"), reason="needs openssl: apt-get install openssl")


def test_it_hears_a_wagon_through_mutual_tls(fleet: Fleet, tmp_path: Path) -> None:
    config = tmp_path / "dashboard.json5"
    config.write_text(fleet.config_text("dashboard"))
    fleet.publisher.publish(Outputs(estimate(), (alarm(),)))
    with Dashboard("--zenoh-config", str(config), "--listen", "127.0.0.1:0") as dashboard:
        port = dashboard.port

        def wagon() -> dict[str, Any]:
            return next(iter(first_words(port)["wagons"]), {})

        until(lambda: wagon().get("speed_mps") == 18.0)
        until(lambda: wagon()["worst"])
        assert wagon()["id"] == "wagon-8127"
