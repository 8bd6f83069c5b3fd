"""Where machine code is kept on disk. To make it takes half a minute: another process does, and nobody waits for it."""

import subprocess
import sys
import time
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from os import environ
from pathlib import Path

import msgspec

from brake_monitor.samples import Channel
from brake_monitor.settings.config import EstimatorSettings, Vehicle

MADE_WITHIN_S = 600.0  # who has been at it for longer was stopped

makers: list[subprocess.Popen[bytes]] = []  # who made them may end before they do


class EstimatorOrder(msgspec.Struct, frozen=True):
    """Of which estimator machine code is wanted."""

    vehicle: Vehicle
    settings: EstimatorSettings
    channels: tuple[Channel, ...]


@cache
def folder() -> Path:
    """Where it is kept, for this very version of our sources and of numba."""
    tag = sha256(version("numba").encode())
    package = Path(__file__).parents[1]
    for pattern in ("*.py", "estimation/*.py", "compiled/*.py"):
        for source in sorted(package.glob(pattern)):
            tag.update(source.read_bytes())
    base = environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brake-monitor" / tag.hexdigest()[:16]


class KeptCode:
    """The machine code of one estimator, as far as it is on disk."""

    def __init__(self, order: EstimatorOrder) -> None:
        self._order = msgspec.msgpack.encode(order)
        self._ready = folder() / f"{sha256(self._order).hexdigest()[:16]}.ready"

    @property
    def is_ready(self) -> bool:
        """Whether it is there and need only be loaded."""
        return self._ready.exists()

    def have_made(self) -> None:
        """Let another process make it, unless one does; OSError where there is no room for it."""
        order = self._ready.with_suffix(".order")
        order.parent.mkdir(parents=True, exist_ok=True)
        if order.exists() and time.time() - order.stat().st_mtime < MADE_WITHIN_S:
            return
        order.write_bytes(self._order)
        quiet = subprocess.DEVNULL
        command = [sys.executable, "-m", "brake_monitor.compiled.code_maker", str(order)]
        makers.append(subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True))
