"""A block is decoded to the very samples that its frames give one by one, to the last bit."""

import dataclasses
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from itertools import product
from math import inf, nan
from pathlib import Path
from random import Random

import numpy as np
import pytest
from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from msgspec.structs import replace

from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.candump_log import line_of
from brake_monitor.decoding.block_decoder import BlockDecoder
from brake_monitor.decoding.dbc import BusDatabase, load_bus
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.decoding.mapped_signal import MappedSignal
from brake_monitor.decoding.matching import Matching
from brake_monitor.decoding.message_decoder import MessageDecoder
from brake_monitor.decoding.qualifier import Qualifier
from brake_monitor.decoding.rolling_counter import RollingCounter
from brake_monitor.decoding.routing import Route
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signal_field import MultiplexerCondition, signal_field
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import Channel, Measurand, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings, Signals
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import EXAMPLES, example_config
from brake_monitor.simulator.files import write_log
from test_ordinary_frame import LENGTH, entries, qualifiers

J1939 = Path(__file__).parents[1] / "data" / "mini_j1939.toml"
CONFIGS = {**{name: example_config(name) for name in EXAMPLES}, "j1939": J1939, "qualified": example_config("wagon")}
STEPS_S = (0.001, 0.001, 0.001, 0.001, 0.01, 0.0, -0.0005, 0.3, 3.0, -0.3, -5.0)


@cache
def settings_of(name: str) -> Settings:
    """A vehicle, with a second bus that carries nothing mapped."""
    settings = load_settings(CONFIGS[name])
    if name == "qualified":
        settings = replace(settings, signals=qualified(settings.signals))
    (bus,) = settings.can
    return replace(settings, can=(bus, replace(bus, name="other", channel="can9")))


def qualified(signals: Signals) -> Signals:
    """The wagon's, told by other signals of their messages, one of them on the same page of several."""
    return replace(
        signals,
        speed=replace(signals.speed, qualifier="fix", qualifier_good=(0, 1, 3)),
        axle_speed=tuple(replace(own, qualifier="valve_A", qualifier_good=(0, 1, 2)) for own in signals.axle_speed),
        pressing_force=(replace(signals.pressing_force[0], qualifier="BCU_state"), signals.pressing_force[1]),
        load_force=tuple(replace(own, qualifier="brake_mode", qualifier_good=(1, 3, 5)) for own in signals.load_force),
    )


@cache
def databases(name: str) -> dict[str, BusDatabase]:
    return {bus.name: load_bus(bus.name, bus.dbc) for bus in settings_of(name).can}


def new_decoder(name: str) -> SignalDecoder:
    return SignalDecoder(settings_of(name), databases(name))


@cache
def identifiers(name: str) -> list[tuple[int, bool, int]]:
    """Of the mapped messages, with their lengths; of J1939 ones also as another node sends them."""
    decoder = new_decoder(name)
    found = [(each.can_id, each.extended, 8) for each in decoder.matchings]
    found += [(each.can_id ^ 0x0C000011, True, 8) for each in decoder.matchings if each.by == "pgn"]
    return [(can_id, extended, length) for can_id, extended, _ in found for length in (8, 8, 4, 8)]


@st.composite
def traffic(draw: st.DrawFn, name: str) -> list[Frame]:
    """Frames whose counters often advance as they must and whose values are often in range."""
    random = draw(st.randoms(use_true_random=False))
    buses = [bus.name for bus in settings_of(name).can]
    mapped = identifiers(name)
    frames, time_s, count = [], 100.0, 0
    for _ in range(draw(st.integers(1, 100))):
        time_s = round(time_s + random.choice(STEPS_S[: random.choice((4, 4, 4, 6, len(STEPS_S)))]), 6)
        can_id, extended, length = random.choice(mapped)
        count += random.choice((1, 1, 1, 1, 0, 2, 9))
        nibble = count % 16 if random.random() < 0.9 else random.randrange(16)
        # A byte that is the counter twice holds it wherever it is; small numbers are in range more often.
        data = bytes(random.choice((random.randrange(8), nibble * 0x11, 0xFF, 0xFE)) for _ in range(length))
        if random.random() < 0.7:
            data = (bytes([random.randrange(12)] * 3) + bytes([nibble * 0x11] * 5))[:length]
        bus = buses[random.random() < 0.03]
        kind = FrameKind.DATA
        match random.randrange(30):
            case 0:
                data = data[: random.randrange(8)]
            case 1:
                kind, data = FrameKind.REMOTE, b""
            case 2:
                kind, extended = FrameKind.ERROR, True
            case 3:
                extended = can_id > 0x7FF or not extended
            case 4:
                can_id = random.randrange(0x800)
            case 5:
                data += random.randbytes(4)
        frames.append(Frame(time_s, bus, can_id, extended, data, kind))
    return frames


def singly(decoder: SignalDecoder, frames: list[Frame]) -> list[tuple[int, Sample]]:
    return [(place, sample) for place, frame in enumerate(frames) for sample in decoder.decode(frame)]


def together(decoder: SignalDecoder, blocks: Iterable[FrameBlock]) -> list[tuple[int, Sample]]:
    found: list[tuple[int, Sample]] = []
    passed = 0
    for block in blocks:
        decoded = decoder.decode_block(block)
        found += [(passed + place, each) for place, each in zip(decoded.frame.tolist(), decoded.samples, strict=True)]
        decoder.passage(decoded).settle(len(decoded.frames) - 1)
        passed += len(block)
    return found


def rejected(decoder: SignalDecoder) -> dict[Measurand, int]:
    return {place: qualifier.rejected for place, qualifier in decoder.qualifiers.items()}


def good_s(decoder: SignalDecoder) -> list[float]:
    return [entry.good_s for entry in decoder._by_channel]


def in_memory(settings: Settings, frames: list[Frame], folder: Path) -> Iterator[FrameBlock]:
    for begin in range(0, len(frames), 40):
        yield FrameBlock.of(frames[begin : begin + 40])


def from_candump(settings: Settings, frames: list[Frame], folder: Path) -> Iterator[FrameBlock]:
    channels = {bus.name: bus.channel for bus in settings.can}
    lines = "".join(line_of(frame._replace(bus=channels[frame.bus])) for frame in frames)
    (folder / "x.log").write_text(lines)
    return open_log(folder / "x.log", settings.can).blocks()


def from_blf(settings: Settings, frames: list[Frame], folder: Path) -> Iterator[FrameBlock]:
    write_log(folder / "x.blf", frames, settings.can)
    return open_log(folder / "x.blf", settings.can).blocks()


@pytest.mark.parametrize(
    ("way", "name"),
    [*product([in_memory], CONFIGS), *product([from_candump, from_blf], ["bogie", "qualified"])],
)
@hypothesis_settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_a_block_gives_what_its_frames_give(
    way: Callable[[Settings, list[Frame], Path], Iterator[FrameBlock]],
    name: str,
    data: st.DataObject,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    settings = settings_of(name)
    blocks = list(way(settings, data.draw(traffic(name)), tmp_path_factory.mktemp("logs")))
    frames = [frame for block in blocks for frame in block]
    expected, found = new_decoder(name), new_decoder(name)
    assert repr(together(found, blocks)) == repr(singly(expected, frames))
    assert found.counts == expected.counts
    assert rejected(found) == rejected(expected)
    assert good_s(found) == good_s(expected)


class _Message:
    """Frames of one message with these signals, of which those that name it have a counter in the first byte."""

    def __init__(self, mapped: list[MappedSignal]) -> None:
        message = Message(1, "M", LENGTH, [Signal("counter", 0, 8)], strict=False)
        counter = RollingCounter(signal_field(message, "counter"), timeout_s=1.0)
        self.entries = tuple(
            dataclasses.replace(entry, qualifier=entry.qualifier and dataclasses.replace(entry.qualifier))
            for entry in mapped
        )
        self.counts = DecodeCounts()
        matching = Matching("can0", "M", 1, extended=False, by="id", is_j1939=False, reason="")
        route = Route(matching, message, self.entries, counter, ())
        self.decoder = MessageDecoder(route, range(len(mapped)), self.counts)

    def singly(self, frames: list[Frame]) -> list[tuple[float, float, int]]:
        return [(each.time_s, each.value, int(each.quality)) for frame in frames for each in self.decoder.decode(frame)]

    def together(self, frames: list[Frame]) -> list[tuple[float, float, int]]:
        block = FrameBlock.of(frames)
        parts = BlockDecoder((self.decoder,), self.counts).decode(block, np.zeros(len(frames), dtype=np.int64))
        decoded = SampleBlock.of([entry.channel for entry in self.entries], block.time_s, parts)
        return list(zip(decoded.time_s.tolist(), decoded.value.tolist(), decoded.quality.tolist(), strict=True))


@st.composite
def conditions(draw: st.DrawFn) -> tuple[MultiplexerCondition, ...]:
    """None, a multiplexer in the second byte, or another one in the third beneath it."""
    signals = [Signal("outer", 8, 2), Signal("inner", 16, 2)][: draw(st.integers(0, 2))]
    message, pages = Message(1, "M", LENGTH, signals, strict=False), st.frozensets(st.integers(0, 3))
    known = [(signal_field(message, signal.name), draw(pages), draw(pages)) for signal in signals]
    return tuple(MultiplexerCondition(field, own, own | others) for field, own, others in known)


@given(
    st.lists(st.tuples(entries(), conditions(), qualifiers()), min_size=1, max_size=5),
    st.lists(st.binary(max_size=LENGTH + 2), max_size=20),
    st.booleans(),
)
def test_any_signals_of_any_frames(
    drawn: list[tuple[MappedSignal, tuple[MultiplexerCondition, ...], Qualifier | None]],
    payloads: list[bytes],
    is_small: bool,
) -> None:
    mapped = [
        dataclasses.replace(entry, field=dataclasses.replace(entry.field, conditions=beneath), qualifier=qualifier)
        for entry, beneath, qualifier in drawn
    ]
    for entry in mapped[::2]:
        entry.counter = "counter"
    few = bytes(byte & 3 for byte in range(256)) if is_small else None  # small numbers are in range more often
    payloads = [(bytes([k]) + payload.translate(few))[:LENGTH] for k, payload in enumerate(payloads)]
    frames = [Frame(0.1 * k, "can0", 1, False, payload) for k, payload in enumerate(payloads)]
    alone, tables = _Message(mapped), _Message(mapped)
    assert repr(tables.together(frames)) == repr(alone.singly(frames))
    assert tables.counts == alone.counts
    told = [[entry.qualifier and entry.qualifier.rejected for entry in each.entries] for each in (tables, alone)]
    assert told[0] == told[1]


def test_a_number_that_is_too_long_for_tables_is_good_all_the_same() -> None:
    """Its frames are taken one by one: each counts once, and its counter is judged."""
    long = Signal("long", 8, 56, conversion=BaseConversion.factory(0.5, 0.0))
    field = signal_field(Message(1, "M", LENGTH, [long], strict=False), "long")
    channel = Channel(Quantity.SPEED, 0, "can0", "M", "long", 0.1, 0.0, 1.0)
    mapped = [MappedSignal(channel, field, 1.0, 0.0, -inf, inf, nan, "counter")]
    counts = (0, 1, 2, 2, 3, 9)
    frames = [Frame(0.1 * k, "can0", 1, False, bytes([count, 40 + k, *[0] * 6])) for k, count in enumerate(counts)]
    alone, tables = _Message(mapped), _Message(mapped)
    found = tables.together(frames)
    assert found == alone.singly(frames)
    assert [value for _, value, quality in found if quality == Quality.GOOD] == [20.0, 20.5, 21.0, 22.0, 22.5]
    assert tables.counts == alone.counts
    assert (tables.counts.good, tables.counts.lost_frames) == (5, 5)


def test_ordinary_vehicles_are_decoded_by_tables() -> None:
    """Else all would be right and nothing gained."""
    for name in (*EXAMPLES, "qualified"):
        decoder = new_decoder(name)
        slow = [message.matching.message for message in decoder._messages if not message.fits_tables]
        assert not slow


steps_s = st.lists(st.sampled_from(STEPS_S), min_size=1, max_size=60)


@given(steps_s, st.randoms(use_true_random=False))
def test_time_outs_lapse_at_the_same_frames(steps: list[float], random: Random) -> None:
    """Followed over a block, as `expire` tells them frame by frame; what it would tell begins a passage anew."""
    messages = identifiers("wagon")
    frames, time_s = [], 100.0
    for step_s in steps:
        time_s += step_s
        can_id, extended, length = random.choice(messages)
        frames.append(Frame(time_s, settings_of("wagon").can[0].name, can_id, extended, bytes(length)))
    expected, found = (new_decoder("wagon") for _ in range(2))
    told = []
    for frame in frames:
        samples = expected.decode(frame)
        told += [(frame.time_s, repr(expected.expire(frame.time_s)))] if samples else []
    followed, k = [], 0
    decoded = found.decode_block(FrameBlock.of(frames))
    passage = found.passage(decoded)
    while k < len(decoded.frames):
        end = passage.quiet_until(k, len(decoded.frames))
        followed += [(quiet_s, "[]") for quiet_s in decoded.frame_times_s[k:end].tolist()]
        passage.settle(end if end < len(decoded.frames) else end - 1)
        if end < len(decoded.frames):
            time_s = float(decoded.frame_times_s[end])
            followed.append((time_s, repr(found.expire(time_s))))
        k = end + 1
        passage = found.passage(decoded, k)
    assert followed == told
    assert good_s(found) == good_s(expected)
    assert found.counts == expected.counts
    count = len(decoded.frames)
    assert found.passage(decoded, count).quiet_until(count, count) == count  # also where no frame is left


def test_a_channel_lapses_in_time_though_time_went_back_a_little() -> None:
    decoder = new_decoder("wagon")
    can_id, extended, length = identifiers("wagon")[0]
    for time_s in (100.0, 99.5):
        samples = decoder.decode(Frame(time_s, settings_of("wagon").can[0].name, can_id, extended, bytes(length)))
        assert not decoder.expire(time_s)
    good = {sample.measurand for sample in samples if sample.quality is Quality.GOOD}
    timeout_s = min(channel.timeout_s for channel in decoder.channels if channel.measurand in good)
    assert {sample.measurand for sample in decoder.expire(99.6 + timeout_s)} & good
