"""Where machine code is kept on disk. Making it takes half a minute: another process does it, and nobody waits."""

import subprocess
import sys
import time
from contextlib import suppress
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from pickle import PickleError
from shutil import rmtree
from typing import TYPE_CHECKING, Self

import msgspec
from msgspec.structs import replace

from brake_monitor.compiled.code_folder import folder
from brake_monitor.errors import WorkError
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.samples import Channel
from brake_monitor.settings.config import EstimatorSettings, Preset, TuningOverrides, Vehicle

if TYPE_CHECKING:
    from brake_monitor.compiled.compiled_estimator import CompiledEstimator

MADE_WITHIN_S = 600.0  # a maker that has taken longer was stopped
ORDERED, READY, LOCK = ".order", ".ready", ".lock"
DAMAGED = (PickleError, EOFError, AttributeError, ImportError, LookupError, ValueError)  # what loading may raise

makers: list[subprocess.Popen[bytes]] = []  # the processes; this one may end before they do


class EstimatorOrder(msgspec.Struct, frozen=True):
    """The estimator of which machine code is wanted, but for its noise densities: the code is the same for all."""

    vehicle: Vehicle
    settings: EstimatorSettings
    channels: tuple[Channel, ...]

    @classmethod
    def of(cls, estimator: Estimator) -> Self:
        """The order for an estimator like this."""
        like: Preset = "rig" if estimator.core.tuning.literal else "wagon"
        settings = replace(estimator.settings, preset=like, tuning=TuningOverrides())
        return cls(estimator.vehicle, settings, estimator.channels)

    def estimator(self) -> Estimator:
        """An estimator like the one ordered."""
        return Estimator(self.vehicle, self.settings, self.channels)


def can_be_compiled(estimator: Estimator) -> bool:
    """Whether numba is there, and the steps are those that are compiled."""
    return type(estimator) is Estimator and find_spec("numba") is not None


def have_made(*estimators: Estimator) -> None:
    """Let one process make the machine code of estimators: of those that can have it, and that nobody is at."""
    with suppress(OSError):  # there is no place or no room to keep it
        codes = [KeptCode(EstimatorOrder.of(estimator)) for estimator in estimators if can_be_compiled(estimator)]
        if orders := [str(code.ordered()) for code in codes if not (code.is_ready or code.is_on_order)]:
            quiet = subprocess.DEVNULL
            command = [sys.executable, "-m", "brake_monitor.compiled.code_maker", *orders]
            makers.append(subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True))


def with_machine_code(estimator: Estimator) -> "CompiledEstimator | None":
    """An estimator by its machine code; None where that is not on disk, or cannot be loaded.

    Damaged code, as a power cut may leave it, is thrown away: it is made anew when it is wanted next.
    """
    try:
        if not (can_be_compiled(estimator) and KeptCode(EstimatorOrder.of(estimator)).is_ready):
            return None
        from brake_monitor.compiled.compiled_estimator import CompiledEstimator  # noqa: PLC0415 - loads numba

        return CompiledEstimator(estimator)
    except (OSError, RuntimeError, WorkError):
        return None
    except DAMAGED:
        rmtree(folder(), ignore_errors=True)
        return None


class KeptCode:
    """The machine code of one estimator, as far as it is on disk."""

    def __init__(self, order: EstimatorOrder) -> None:
        self._order = msgspec.msgpack.encode(order)
        self._path = folder() / sha256(self._order).hexdigest()[:16]

    @property
    def is_ready(self) -> bool:
        """Whether it is there and need only be loaded."""
        return self._path.with_suffix(READY).exists()

    @property
    def is_on_order(self) -> bool:
        """Whether a maker is still at work on it."""
        path = self._path.with_suffix(ORDERED)
        return path.exists() and time.time() - path.stat().st_mtime < MADE_WITHIN_S

    def ordered(self) -> Path:
        """The file with the order, which is written; OSError where there is no room for it."""
        path = self._path.with_suffix(ORDERED)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(self._order)
        return path
