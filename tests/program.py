"""Programs in processes of their own, which a test starts, speaks to, listens to and ends; and what is waited for."""

import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from typing import Any, Self, TypeVar

from background import raise_failure
from brake_monitor.settings.example_vehicles import example_config

HERE = Path(__file__).parent
BRAKE_MONITOR = Path(sys.executable).with_name("brake-monitor")
PATIENCE_S = 120.0  # how long a test waits for what must come, on the busiest machine; never how long it takes
LOOK_AROUND_S = 0.1  # for what keeps from coming what a test waits for
STOP_S = 5.0  # that the unit gives the daemon to end; it takes some tenths of a second

Item = TypeVar("Item")


def until(condition: Callable[[], object]) -> None:
    """Ask again and again, for what cannot be waited for."""
    deadline_s = time.monotonic() + PATIENCE_S
    while not condition():
        raise_failure()
        assert time.monotonic() < deadline_s, "what was waited for did not come"
        time.sleep(0.01)


def next_of(queue: "Queue[Item]") -> "Item":
    """What comes out of a queue next."""
    got: list[Item] = []

    def has_come() -> bool:
        with suppress(Empty):
            got.append(queue.get(timeout=LOOK_AROUND_S))
        return bool(got)

    until(has_come)
    return got[0]


class Program:
    """A process whose lines, of standard output and error alike, can be waited for; killed when the test is over."""

    def __init__(self, *command: str | Path, env: Mapping[str, str] | None = None) -> None:
        self.lines: list[str] = []
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=subprocess.STDOUT, text=True, env=env)
        self._news = threading.Condition()
        self._ended = False
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as stream:
            for line in stream:
                with self._news:
                    self.lines.append(line.rstrip("\n"))
                    self._news.notify()
        with self._news:
            self._ended = True
            self._news.notify()

    @property
    def pid(self) -> int:
        return self._process.pid

    def wait_for(self, pattern: str, after: int = 0) -> re.Match[str]:
        """The first line, of those after the first `after`, that the pattern is found in; waits until there is one."""
        deadline_s = time.monotonic() + PATIENCE_S
        with self._news:
            while True:
                for line in self.lines[after:]:
                    after += 1
                    if match := re.search(pattern, line):
                        return match
                rest_s = deadline_s - time.monotonic()
                if self._ended or rest_s < 0.0:
                    raise AssertionError(f"never said {pattern!r}, but:\n" + "\n".join(self.lines[-50:]))
                self._news.wait(rest_s)

    def tell(self, text: str = "") -> None:
        """Give it a line."""
        print(text, file=self._process.stdin, flush=True)

    def ask(self, text: str = "") -> str:
        """The line that it says when it is given one."""
        before = len(self.lines)
        self.tell(text)
        return self.wait_for("", after=before).string

    def send_signal(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def wait(self) -> int:
        """Exit status, when it has ended and all that it said is there."""
        status = self._process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        return status

    def end(self, number: signal.Signals = signal.SIGTERM) -> tuple[int, float]:
        """Exit status after the signal, and how many seconds it took."""
        begun_s = time.monotonic()
        self._process.send_signal(number)
        self._process.wait(PATIENCE_S)
        took_s = time.monotonic() - begun_s
        return self.wait(), took_s

    def kill(self) -> None:
        """End it the hardest way."""
        self._process.kill()
        self.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exc_info: object) -> None:
        self._process.kill()
        with self._process:  # closes what it reads from
            self._reader.join()


# python-can would load asammdf where it is installed, and pandas and sympy with it, which takes a second.
WITHOUT_ASAMMDF = "import sys; sys.modules['asammdf'] = None"


class Python(Program):
    """A script, which may import what this process may, but for asammdf."""

    def __init__(self, script: str, *arguments: str | Path) -> None:
        env = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
        super().__init__(sys.executable, "-c", f"{WITHOUT_ASAMMDF}\n{script}", *arguments, env=env)


def daemon_command(config: Path) -> tuple[str | Path, ...]:
    return (BRAKE_MONITOR, "run", "-c", config)


class Daemon(Program):
    """`brake-monitor run`, once it listens."""

    def __init__(self, config: Path) -> None:
        super().__init__(*daemon_command(config))
        self.endpoint = self.wait_for(r"Zenoh session open, (?:on )?(\S+)")[1]
        self.wait_for("listening on")


class Subscriber(Program):
    """A plain Zenoh subscriber that knows nothing of brake_monitor."""

    def __init__(self, endpoint: str) -> None:
        super().__init__(sys.executable, HERE / "subscriber.py", endpoint, "brake/v1/**")
        self.wait_for("subscribed")

    def samples(self) -> list[dict[str, Any]]:
        """What was received: key, encoding, decoded payload."""
        return [json.loads(line) for line in self.lines if line.startswith("{")]

    def payloads(self, key: str) -> list[dict[str, Any]]:
        return [sample["payload"] for sample in self.samples() if sample["key"] == key]


class Router(Program):
    """A Zenoh router at an endpoint, or as a configuration file says."""

    def __init__(self, place: str | Path) -> None:
        super().__init__(sys.executable, HERE / "router.py", place)
        self.wait_for("ready")


def run(*command: str | Path) -> subprocess.CompletedProcess[str]:
    """What a program did and said that ends by itself."""
    return subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S, check=False)


def write_config(path: Path, channel: str, rate_hz: float) -> Path:
    """The example wagon, on another channel."""
    example = example_config("wagon")
    text = example.read_text()
    for key, value in {"channel": channel, "dbc": [str(example.with_name("wagon.dbc"))]}.items():
        text, count = re.subn(rf"^{key} = .*$", f"{key} = {json.dumps(value)}", text, flags=re.MULTILINE)
        assert count == 1
    path.write_text(f"{text}\n[output]\nrate_hz = {rate_hz}\n")
    return path
