"""A router, wagons and the dashboard as processes of their own, and what is to be seen of them on a page."""

import json
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from network import free_port
from program import Program, Python, Router

HERE = Path(__file__).parent


class Wagon(Python):
    """A publisher process, told what to publish."""

    def __init__(self, endpoint: str, name: str, encoding: str, **first: Any) -> None:
        super().__init__((HERE / "wagon_process.py").read_text(), endpoint, name, encoding)
        self.says(**first)
        self.wait_for("ready")

    def says(self, **told: Any) -> None:
        self.tell(json.dumps(told))


class Dashboard(Program):
    """The command as a person starts it."""

    def __init__(self, *arguments: str) -> None:
        super().__init__(sys.executable, "-m", "brake_monitor", "dashboard", *arguments)
        self.address = self.wait_for(r"http://\S+")[0]
        self.port = int(self.address.rstrip("/").rpartition(":")[2])


class Depot:
    """A router, wagons and a dashboard that hears them."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.address = ""

    def router(self) -> None:
        self.router_child = self._stack.enter_context(Router(self.endpoint))

    def wagon(self, name: str, encoding: str = "json", **first: Any) -> Wagon:
        """One that publishes what it is told first from the beginning."""
        return self._stack.enter_context(Wagon(self.endpoint, name, encoding, **first))

    def dashboard(self, *arguments: str) -> Dashboard:
        listen = self.address.removeprefix("http://").rstrip("/") or "127.0.0.1:0"
        dashboard = Dashboard("--connect", self.endpoint, "--listen", listen, *arguments)
        self.address = dashboard.address
        return self._stack.enter_context(dashboard)


def shown(page: Any, text: str) -> None:
    """Wait until a text is to be seen."""
    page.get_by_text(text).first.wait_for()
