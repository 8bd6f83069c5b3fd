"""A day of service through the live path, as fast as it goes. Run: python tests/benchmarks/soak.py [HOURS] (24).

The daemon's own parts from the bus reader to SQLite and Zenoh, in one process, with a dashboard that hears
everything; only the bus is played: ten minutes of ordinary service again and again, its clock running on, on a
slow bus (56 frames a second). Every hour the bus fails once. What must not grow is looked at once an hour.
"""

# ruff: noqa: E402 - what must not be imported is said before the imports

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import closing, suppress
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1]))
sys.modules["asammdf"] = None  # type: ignore[assignment]  # no gateway has it; python-can would load it, and 100 MB

from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.can_source import BusError
from brake_monitor.daemon.service import Service
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.publishing.publisher import Publisher
from brake_monitor.settings.config import CanBus
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.storage.memory import Memory
from brake_monitor.storage.memory_directory import FILE_NAME
from brake_monitor.storage.store_outbox import StoreOutbox
from bus_cycles import SLOW_MS, vehicle_with_cycles
from program import Subscriber

HOUR_S = 3600.0
PLAYED_S = 600.0  # of ordinary service, again and again
PAUSE_S = 5.0  # between two playings, with the bus silent
SETTLED_H = 2  # what is taken in the first hours is kept: caches, pools, the first evidence

GROWTH_BYTES = 16 << 20  # of memory, from when it has settled
DATABASE_BYTES = 40 << 20  # 10,000 alarms and messages and 5000 brake applications at about 1 kB, and the log


class Usage(NamedTuple):
    """What the process holds after so many hours of service."""

    hours: float
    frames: int
    memory_bytes: int
    descriptors: int
    threads: int
    database_bytes: int
    evidence_bytes: int


class PlayedBus:
    """Gives the frames of ordinary service for so long, at once when asked; fails once an hour."""

    dropped = 0
    keeps_time = False

    def __init__(self, frames: Iterator[Frame], until_s: float) -> None:
        self._frames = frames
        self._until_s = until_s
        self._fails_s = 0.0
        self.given = 0
        self.now_s = self.begun_s = 0.0
        self.is_over = threading.Event()

    def __call__(self, _bus: CanBus, _filters: object) -> "PlayedBus":
        return self

    def recv(self, timeout_s: float) -> Frame | None:
        if self.is_over.is_set():
            time.sleep(timeout_s)
            return None
        frame = next(self._frames)
        self.now_s = frame.time_s
        if not self.begun_s:
            self.begun_s = self.now_s
            self._fails_s = self.now_s + HOUR_S / 2
        if self.now_s >= self._fails_s:
            self._fails_s += HOUR_S
            raise BusError("the bus fails as it does once an hour")
        if self.now_s - self.begun_s >= self._until_s:
            self.is_over.set()
        self.given += 1
        return frame

    def close(self) -> None:
        """Nothing to give back."""


def record(config: Path, log: Path) -> None:
    """Simulate what is played; in a process of its own, for the simulator takes much memory."""
    from brake_monitor.simulator.files import write_log  # noqa: PLC0415
    from brake_monitor.simulator.ordinary_service import ordinary_disturbances, ordinary_service  # noqa: PLC0415
    from brake_monitor.simulator.simulate import run as simulate  # noqa: PLC0415

    service, disturbances = ordinary_service(1, PLAYED_S), ordinary_disturbances(1, 2, in_train=False)
    write_log(log, simulate(service, load_settings(config), 1, disturbances, row_s=0.01).frames)


def again_and_again(frames: list[Frame]) -> Iterator[Frame]:
    """For ever; the clock runs on from one playing to the next."""
    for number in count():
        shift_s = number * (PLAYED_S + PAUSE_S)
        for frame in frames:
            yield frame._replace(time_s=frame.time_s + shift_s)


def usage(hours: float, frames: int, state: Path) -> Usage:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return Usage(
        hours,
        frames,
        pages * os.sysconf("SC_PAGE_SIZE"),
        len(list(Path("/proc/self/fd").iterdir())),
        threading.active_count(),
        held_bytes(state.glob(f"{FILE_NAME}*")),
        held_bytes(state.glob("evidence/*")),
    )


def held_bytes(paths: Iterable[Path]) -> int:
    """Of those that are still there when they are looked at: files come and go."""
    total = 0
    for path in paths:
        with suppress(FileNotFoundError):
            total += path.stat().st_size
    return total


def soak(hours: float) -> list[Usage]:
    """Play so many hours; what the process held in between."""
    look_every_h = min(1.0, hours / 6)
    with TemporaryDirectory() as name:
        folder = Path(name)
        state = folder / "state"
        config, log = vehicle_with_cycles("wagon", folder, SLOW_MS), folder / "service.log"
        subprocess.run([sys.executable, __file__, "record", config, log], check=True)
        settings = load_settings(config)
        bus = PlayedBus(again_and_again([*open_log(log, settings.can)]), hours * HOUR_S)
        looked: list[Usage] = []
        pipeline = Pipeline.from_settings(settings)
        with closing(StoreOutbox(state / FILE_NAME, settings.vehicle.id)) as outbox, Memory(pipeline, state) as memory:
            memory.resume()
            with Publisher(settings.zenoh, settings.vehicle.id, outbox=outbox) as publisher:
                service = Service(pipeline, publisher, memory, open_bus=bus)
                running = threading.Thread(target=service.run)
                with Subscriber(publisher.endpoints[0]) as subscriber:
                    running.start()
                    try:
                        while not (bus.is_over.wait(0.2) and service.frames == bus.given):
                            subscriber.lines.clear()
                            assert running.is_alive(), "the service has ended"
                            if (bus.now_s - bus.begun_s) / HOUR_S >= (len(looked) + 1) * look_every_h:
                                looked.append(usage((len(looked) + 1) * look_every_h, service.frames, state))
                                print(told(looked[-1]), flush=True)
                    finally:
                        service.stop()
                        running.join()
                    assert publisher.counters.events_lost == 0
        return looked


def told(seen: Usage) -> str:
    return (
        f"{seen.hours:5.2f} h  {seen.frames:9,} frames  {seen.memory_bytes / 1e6:6.1f} MB  {seen.threads} threads"
        f"  {seen.descriptors} descriptors  database {seen.database_bytes / 1e6:5.1f} MB"
        f"  evidence {seen.evidence_bytes / 1e6:5.1f} MB"
    )


def assert_bounded(looked: list[Usage], evidence_bytes: int) -> None:
    """Nothing has grown beyond its bound since it had settled."""
    settled, *later = [seen for seen in looked if seen.hours >= min(SETTLED_H, looked[-1].hours / 2)]
    for seen in later:
        assert seen.memory_bytes <= settled.memory_bytes + GROWTH_BYTES, seen
        assert seen.descriptors <= settled.descriptors + 2, seen  # a file that is being written
        assert seen.threads <= settled.threads + 1, seen  # that by which the outbox writes an event
        assert seen.database_bytes <= DATABASE_BYTES, seen
        assert seen.evidence_bytes <= evidence_bytes, seen


def main(arguments: list[str]) -> None:
    if arguments[:1] == ["record"]:
        record(Path(arguments[1]), Path(arguments[2]))
        return
    hours = float(arguments[0]) if arguments else 24.0
    begun_s = time.monotonic()
    assert_bounded(soak(hours), example_settings("wagon").store.evidence_max_bytes)
    print(f"{hours:g} h of service in {(time.monotonic() - begun_s) / 60:.0f} min: nothing grows beyond its bounds")


if __name__ == "__main__":
    main(sys.argv[1:])
