"""Recordings of two buses with whatever a bus may carry, for tests of what plays them by the block."""

import gzip
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from random import Random

from msgspec.structs import replace

from brake_monitor.bus.candump_log import parse_line
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.bus_watch import BUS_OFF
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings

GOLDEN = Path(__file__).parent / "golden" / "slide.log.gz"
GAPS_S = (0.05, 0.099999, 0.1, 0.100001, 0.35, 0.7, 3.0, 70.0, -0.000001, -0.05, -0.7, -1.5, -100.0)
JUMPS_S = (0.099999, 0.100001, 0.35, 3.0, -0.000001, -0.05, -0.7, -1.5)  # of traffic between mapped frames
UNMAPPED = (0x100, 0x2A0 | 1 << 11, 0x7FF, 0x18FF5031, 0x1FFFFFFF)


@cache
def two_buses() -> Settings:
    """The example wagon, with a second bus that carries nothing mapped."""
    settings = example_settings("wagon")
    (bus,) = settings.can
    return replace(settings, can=(bus, replace(bus, name="rear", channel="can1")))


@cache
def braking() -> list[Frame]:
    """Four seconds of the golden recording, from before the brakes come on."""
    frames = [parse_line(line) for line in gzip.decompress(GOLDEN.read_bytes()).decode().splitlines()]
    return [frame for frame in frames if 4.0 <= frame.time_s - frames[0].time_s < 8.0]


def other(random: Random, time_s: float, frame: Frame) -> Frame:
    """A frame that the mapping has no use for, or that looks like one that it has."""
    bus = random.choice(("can0", "can0", "rear", ""))
    match random.randrange(12):
        case 0:
            return Frame(time_s, bus, random.choice((0x4, BUS_OFF, 0x20)), True, bytes(8), FrameKind.ERROR)
        case 1:
            return Frame(time_s, bus, frame.can_id, frame.extended, b"", FrameKind.REMOTE)
        case 2:
            return frame._replace(time_s=time_s, data=frame.data[:1])
        case 3:
            return frame._replace(time_s=time_s, bus=bus, extended=True)  # other width, or the very same
        case 4:
            return Frame(time_s, bus, random.choice(UNMAPPED) & 0x7FF, False, random.randbytes(16))
    can_id = random.choice(UNMAPPED)
    return Frame(time_s, bus, can_id, can_id > 0x7FF, random.randbytes(random.randrange(9)))


def mixed(seed: int) -> list[Frame]:
    """The braking with other traffic between, with silences, messages that are lost for a while and set clocks."""
    random = Random(seed)
    frames: list[Frame] = []
    shift_s = 0.0
    lost = 0
    for frame in braking():
        if random.random() < 0.004:
            shift_s += random.choice(GAPS_S)
        if random.random() < 0.002:
            lost = random.randrange(300)
        lost -= 1
        time_s = frame.time_s + shift_s
        if lost < 0:
            frames.append(frame._replace(time_s=time_s))
        for _ in range(random.randrange(6)):
            time_s += random.choice(JUMPS_S) if random.random() < 0.002 else 0.0008 * random.random()
            frames.append(other(random, time_s, frame))
    return [frame._replace(time_s=round(frame.time_s, 6)) for frame in frames]


def cut(frames: list[Frame], seed: int) -> Iterator[FrameBlock]:
    """Blocks of any size."""
    random = Random(seed)
    while frames:
        size = random.choice((1, 2, 10, 500))
        yield FrameBlock.of(frames[:size])
        frames = frames[size:]
