"""Frames that bear the time of their batch are told from those that are only rounded, lost or sent together."""

from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.arrays import Floats
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.inspection import arrivals
from brake_monitor.inspection.remarks import remarks_on_mapping
from brake_monitor.inspection.traffic import Traffic
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import EXAMPLES, example_settings
from brake_monitor.simulator.simulate import run as simulate

Stamps = Callable[[Floats], Floats]


@cache
def drive(vehicle: str) -> tuple[Frame, ...]:
    """The first 40 s of a drive, as they were captured."""
    frames = simulate("wsp", example_settings(vehicle), 1).frames
    return tuple(frame for frame in frames if frame.time_s < frames[0].time_s + 40.0)


def remarks(vehicle: str, stamps: Stamps, kept: float = 1.0) -> list[str]:
    """What is said of batches where the frames of a vehicle are stamped so, and a share of them arrives."""
    settings, frames = example_settings(vehicle), drive(vehicle)
    times_s = stamps(np.array([frame.time_s for frame in frames]))
    arrives = np.random.default_rng(0).random(len(frames)) < kept
    return said_of([f._replace(time_s=t) for f, t, a in zip(frames, times_s, arrives, strict=True) if a], settings)


def said_of(frames: Sequence[Frame], settings: Settings, of: str = "in batches") -> list[str]:
    decoder = SignalDecoder.from_settings(settings)
    traffic, block = Traffic(decoder.channels), FrameBlock.of(frames)
    traffic.see_block(block, decoder.decode_block(block))
    return [said for said in remarks_on_mapping(traffic, decoder, settings) if of in said]


def as_captured(times_s: Floats) -> Floats:
    return times_s


def in_steps(step_s: float) -> Stamps:
    return lambda times_s: np.round(times_s / step_s) * step_s


def in_batches(every_s: float, apart_s: float = 0.0) -> Stamps:
    """Handed on together, and stamped one after the other."""

    def stamps(times_s: Floats) -> Floats:
        handed_on_s = np.ceil(times_s / every_s) * every_s
        _, first, which = np.unique(handed_on_s, return_index=True, return_inverse=True)
        return handed_on_s + apart_s * (np.arange(len(times_s)) - first[which])

    return stamps


@pytest.mark.parametrize("vehicle", EXAMPLES)
@pytest.mark.parametrize(("every_ms", "apart_s"), [(8, 0.0), (16, 80e-6), (30, 0.0)])
def test_batches_are_remarked_with_their_length(vehicle: str, every_ms: int, apart_s: float) -> None:
    (remark,) = remarks(vehicle, in_batches(every_ms / 1000.0, apart_s))
    assert remark.startswith("bus can0: ")
    assert f"in batches about every {every_ms} ms" in remark
    assert "hardware time stamps" in remark


@pytest.mark.parametrize("vehicle", EXAMPLES)
@pytest.mark.parametrize(
    ("stamps", "kept"),
    [(as_captured, 1.0), (in_steps(1e-4), 1.0), (in_steps(1e-3), 1.0), (in_steps(1e-3), 0.8), (in_batches(1e-3), 1.0)],
    ids=["as captured", "0.1 ms", "1 ms", "1 ms, a fifth lost", "a queue that is emptied each millisecond"],
)
def test_what_is_in_order_is_not(vehicle: str, stamps: Stamps, kept: float) -> None:
    assert remarks(vehicle, stamps, kept) == []


@pytest.mark.parametrize(("every_s", "of_batches"), [(0.03, True), (0.1, False)])
def test_of_batches_that_are_too_long_for_forces_their_own_remark_tells_alone(every_s: float, of_batches: bool) -> None:
    """Values come in bunches then, and too seldom."""
    settings, frames = example_settings("wagon"), drive("wagon")
    times_s = in_batches(every_s)(np.array([frame.time_s for frame in frames])).tolist()
    late = [frame._replace(time_s=time_s) for frame, time_s in zip(frames, times_s, strict=True)]
    assert bool(said_of(late, settings)) is of_batches
    assert bool(said_of(late, settings, "in bunches")) is not of_batches


def wheels_and_pressures(gap_s: Callable[[int], float]) -> list[Frame]:
    """What one control unit sends at once, in frames that a driver stamps together."""
    times_s = np.cumsum([gap_s(k) for k in range(2000)])
    return [Frame(time_s, "can0", can_id, False, bytes(8)) for time_s in times_s.tolist() for can_id in (0x120, 0x1A0)]


def test_what_is_sent_together_may_come_together() -> None:
    settings = example_settings("wagon")
    assert said_of(wheels_and_pressures(lambda k: 0.02), settings) == []
    assert said_of(wheels_and_pressures(lambda k: 0.016 if k % 3 else 0.032), settings)  # else nothing would tell


def test_a_signal_that_few_frames_of_its_message_carry_hides_no_batches() -> None:
    """As on a page of its own, or behind the end of frames that are cut short."""
    frames = wheels_and_pressures(lambda k: 0.016 if k % 3 else 0.032)
    short = [frame._replace(data=bytes(8 if k % 100 < 2 else 2)) for k, frame in enumerate(frames)]
    assert said_of(short, example_settings("wagon")) == said_of(frames, example_settings("wagon")) != []
    once = [*frames, frames[-1]._replace(can_id=0x2A0)]
    assert said_of(once, example_settings("wagon")) != []


def test_batches_are_told_from_the_time_that_is_kept_of_every_message(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a message that comes more often, less time is kept: the other one then seems to come alone."""
    monkeypatch.setattr(arrivals, "MOST_KEPT", 300)
    frames = wheels_and_pressures(lambda k: 0.016 if k % 3 else 0.032)
    seldom = [frame for k, frame in enumerate(frames) if k % 2 or k % 4 == 0]
    assert said_of(seldom, example_settings("wagon")) != []


def test_frames_of_two_buses_may_come_together() -> None:
    settings = example_settings("wagon")
    (bus,), signals = settings.can, settings.signals
    rear = tuple(replace(mapping, bus="rear") for mapping in signals.pressing_force)
    settings = replace(
        settings,
        can=(bus, replace(bus, name="rear", channel="can1")),
        signals=replace(signals, pressing_force=rear),
    )
    frames = wheels_and_pressures(lambda k: 0.016 if k % 3 else 0.032)
    apart = [frame._replace(bus="rear") if frame.can_id == 0x120 else frame for frame in frames]
    assert said_of(apart, settings) == []
