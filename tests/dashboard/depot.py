"""A router, wagons and the dashboard as processes of their own, and what is to be seen of them on a page."""

import json
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from queue import Queue
from typing import Any

from network import PATIENCE_S, free_port, process, router_process

HERE = Path(__file__).parent


class Wagon:
    """A publisher process, told what to publish."""

    def __init__(self, child: subprocess.Popen[str]) -> None:
        self.child = child

    def says(self, **told: Any) -> None:
        assert self.child.stdin is not None
        self.child.stdin.write(json.dumps(told) + "\n")
        self.child.stdin.flush()


@contextmanager
def wagon_process(endpoint: str, name: str, encoding: str, **first: Any) -> Iterator[Wagon]:
    with process((HERE / "wagon_process.py").read_text(), endpoint, name, encoding) as (child, lines):
        wagon = Wagon(child)
        wagon.says(**first)
        assert lines.get(timeout=PATIENCE_S) == "ready"
        yield wagon


@contextmanager
def dashboard_process(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command as a person starts it, and the address that it prints."""
    command = [sys.executable, "-m", "brake_monitor", "dashboard", *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as child:
        lines: Queue[str] = Queue()
        assert child.stdout is not None
        threading.Thread(target=lambda: [lines.put(line) for line in child.stdout or ()], daemon=True).start()
        try:
            said = ""
            while "http://" not in said:
                said = lines.get(timeout=PATIENCE_S)
            yield child, said.split()[-1]
        finally:
            child.kill()


class Depot:
    """A router, wagons and a dashboard that hears them."""

    def __init__(self, stack: ExitStack) -> None:
        self._stack = stack
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.address = ""

    def router(self) -> None:
        self.router_child = self._stack.enter_context(router_process(self.endpoint))

    def wagon(self, name: str, encoding: str = "json", **first: Any) -> Wagon:
        """One that publishes what it is told first from the beginning."""
        return self._stack.enter_context(wagon_process(self.endpoint, name, encoding, **first))

    def dashboard(self, *arguments: str) -> subprocess.Popen[str]:
        listen = self.address.removeprefix("http://").rstrip("/") or "127.0.0.1:0"
        child, self.address = self._stack.enter_context(
            dashboard_process("--connect", self.endpoint, "--listen", listen, *arguments)
        )
        return child


def shown(page: Any, text: str) -> None:
    """Wait until a text is to be seen."""
    page.get_by_text(text).first.wait_for()
