"""What the demo plays, and that it does not outlive the service that it plays to."""

import threading
import time
from collections.abc import Iterable
from dataclasses import replace
from queue import Queue
from types import SimpleNamespace

import pytest

from brake_monitor.commands import demo
from brake_monitor.errors import WorkError
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.scenarios import SCENARIOS, steps
from program import PATIENCE_S, next_of, until

LONG_COASTING = replace(SCENARIOS["dry"], demand=steps((40.0, 0.5)))


def frame(time_s: float) -> Frame:
    return Frame(time_s, "can0", 0x7FF, False, b"")  # that nothing is mapped to


def test_it_begins_some_seconds_before_the_first_braking() -> None:
    played = demo._from_first_braking([frame(1.7e9 + second) for second in range(100)], LONG_COASTING)
    assert 1.7e9 + 30.0 <= played[0].time_s < 1.7e9 + 40.0
    assert played[-1].time_s == 1.7e9 + 99.0


def test_a_service_that_fails_ends_it_and_frames_are_played_as_of_now(monkeypatch: pytest.MonkeyPatch) -> None:
    played, goes_on = Queue[Frame](), threading.Event()
    opened_s: list[float] = []

    def play(frames: Iterable[Frame], *_: object) -> None:
        played.put(next(iter(frames)))
        assert goes_on.wait(PATIENCE_S)

    def show(_config: object, stopping: threading.Event, _prefix: str) -> None:
        assert stopping.wait(PATIENCE_S), "it goes on without a service"

    def fail() -> None:
        raise WorkError("no bus any more")

    monkeypatch.setattr(demo, "play", play)
    monkeypatch.setattr(demo.watch, "show", show)
    buses = SimpleNamespace(open=lambda: opened_s.append(time.time()))
    service = SimpleNamespace(buses=buses, run=fail, stop=lambda: None)
    pipeline = Pipeline.from_settings(example_settings("wagon"))
    with pytest.raises(WorkError, match="no bus any more"):
        demo._play_to_the_end([frame(5.0)], 1.0, service, pipeline, "tcp/127.0.0.1:1")
    assert opened_s[0] <= next_of(played).time_s <= time.time()  # what was done before is no latency
    goes_on.set()
    until(lambda: not any(thread.name == "player" for thread in threading.enumerate()))
