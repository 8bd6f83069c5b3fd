"""A recording played by the block must give, to the bit, what it gives frame by frame."""

import gzip
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from random import Random

import pytest
from msgspec.structs import replace

from brake_monitor.bus import candump_blocks
from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.candump_log import line_of, parse_line
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import FrameBlock
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.traffic import Found, Traffic
from brake_monitor.monitoring.bus_watch import BUS_OFF, BusWatch
from brake_monitor.monitoring.reports import BusReport
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.report.page import page
from brake_monitor.report.recording import Recording
from brake_monitor.samples import Quality, Sample
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config, example_settings

GOLDEN = Path(__file__).parents[1] / "golden" / "slide.log.gz"
J1939 = Path(__file__).parents[1] / "data"
CHANNELS = {"can0": "can0", "rear": "can1", "": "can7"}
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


def mixed(seed: int, per_mapped: int = 3) -> list[Frame]:
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
        for _ in range(random.randrange(2 * per_mapped)):
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


def written(frames: list[Frame], path: Path, *, pads: bool = False) -> Path:
    lines = [line_of(frame._replace(bus=CHANNELS[frame.bus], extended=pads or frame.extended)) for frame in frames]
    path.write_text("".join(lines))
    return path


def told(settings: Settings, play: Callable[[Pipeline], Iterator[Outputs]]) -> list[str]:
    """All that is given out, reported by the buses and counted; `repr` gives every bit of a number, and NaN is NaN."""
    pipeline = Pipeline.from_settings(settings)
    found: list[str] = []
    watch = pipeline._bus_watch
    reports = watch.reports

    def heard(time_s: float) -> tuple[BusReport, ...]:
        found.append(repr((time_s, reports(time_s))))
        return reports(time_s)

    watch.reports = heard
    found += [repr(each) for each in play(pipeline) if each is not NOTHING]
    return [*found, repr(pipeline.decoder.counts), repr(pipeline.remembered())]


def stepped(settings: Settings, frames: list[Frame]) -> list[str]:
    return told(settings, lambda pipeline: map(pipeline.step, frames))


def played(settings: Settings, blocks: Iterable[FrameBlock]) -> list[str]:
    return told(settings, lambda pipeline: (outputs for block in blocks for outputs in pipeline.play(block)))


@pytest.mark.parametrize("seed", range(8))
def test_a_pipeline_gives_the_same(seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    frames = mixed(seed)
    expected = stepped(two_buses(), frames)
    assert len(expected) > 20
    assert played(two_buses(), cut(frames, seed)) == expected
    monkeypatch.setattr(candump_blocks, "CHUNK_BYTES", 2000 * (seed + 1))
    log = open_log(written(frames, tmp_path / "x.log"), two_buses().can)
    assert list(log) == frames
    assert played(two_buses(), log.blocks()) == expected


@pytest.mark.parametrize("rate_hz", [0.0, 1.0, 50.0])
def test_any_rate_of_output(rate_hz: float) -> None:
    settings = two_buses()
    settings = replace(settings, output=replace(settings.output, rate_hz=rate_hz))
    frames = mixed(9)
    assert played(settings, cut(frames, 9)) == stepped(settings, frames)


@pytest.mark.parametrize("rate_hz", [0.0, 10.0, 100.0])
@pytest.mark.parametrize("late", ["speed", "pressing_force", "axle_speed"])
def test_samples_that_wait_for_others(late: str, rate_hz: float) -> None:
    """With a sensor's delay any frame may let a reading be fused that came before."""
    settings = two_buses()
    mapping = getattr(settings.signals, late)
    delayed = replace(mapping, delay_s=0.05) if late == "speed" else (replace(mapping[0], delay_s=0.05), *mapping[1:])
    settings = replace(
        settings,
        signals=replace(settings.signals, **{late: delayed}),
        output=replace(settings.output, rate_hz=rate_hz),
    )
    frames = mixed(9)
    assert played(settings, cut(frames, 9)) == stepped(settings, frames)


def test_padded_identifiers(tmp_path: Path) -> None:
    settings = example_settings("wagon")
    frames = [frame._replace(bus="can0") for frame in mixed(1) if frame.can_id <= 0x7FF and not frame.extended]
    log = open_log(written(frames, tmp_path / "x.log", pads=True), settings.can)
    assert log.remarks
    assert list(log) == frames
    assert played(settings, log.blocks()) == stepped(settings, frames)


@pytest.mark.parametrize(
    ("config", "path"), [(example_config("wagon"), GOLDEN), (J1939 / "mini_j1939.toml", J1939 / "mini_j1939.log")]
)
def test_recordings_of_the_tests(config: Path, path: Path) -> None:
    settings = load_settings(config)
    content = path.read_bytes()
    lines = (gzip.decompress(content) if path.suffix == ".gz" else content).decode().splitlines()
    frames = [parse_line(line)._replace(bus=settings.can[0].name) for line in lines if line]
    assert played(settings, open_log(path, settings.can).blocks()) == stepped(settings, frames)


def note(traffic: Traffic, frame: Frame, samples: list[Sample]) -> None:
    """A frame and its samples, one by one."""
    traffic._first_s, traffic._last_s = min(traffic._first_s, frame.time_s), max(traffic._last_s, frame.time_s)
    for sample in samples:
        found = traffic.found[sample.quantity, sample.wheelset]
        found.times_s.append(sample.time_s)
        found.can_ids.add(frame.can_id)
        if sample.quality is Quality.GOOD:
            found.good += 1
            found.least, found.greatest = min(found.least, sample.value), max(found.greatest, sample.value)
            note_kept(found, sample.value)
            note_reading(traffic.first_hour, sample)
        else:
            found.bad[sample.quality] += 1
    if not samples and frame.kind is FrameKind.DATA:
        traffic.unmapped[frame.bus, frame.extended, frame.can_id] += 1


def note_kept(found: Found, value: float) -> None:
    """What three in a row had."""
    three = [*found._last, value]
    if len(three) == 3:
        found.kept_least = min(found.kept_least, max(three))
        found.kept_greatest = max(found.kept_greatest, min(three))
    found._last = three[-2:]


def note_reading(first_hour: FirstHour, sample: Sample) -> None:
    """A good sample, if it is of a kind that is kept. No mapped signal of these lags."""
    place = (sample.quantity, sample.wheelset)
    if place in first_hour._times_s:
        first_hour._times_s[place].append(sample.time_s)
        first_hour._values[place].append(sample.value)


def everything(traffic: Traffic) -> dict[str, object]:
    """What was noted of a recording; of when it began, only what its readings say."""
    readings = {name: kept for name, kept in vars(traffic.first_hour).items() if name != "_begun_s"}
    return vars(traffic) | {"first_hour": readings}


@pytest.mark.parametrize("seed", range(3))
def test_a_report_says_the_same(seed: int) -> None:
    frames = mixed(seed)
    expected, found = Recording(two_buses()), Recording(two_buses())
    for frame in frames:
        note(expected.traffic, frame, expected.decoder.decode(frame))
        expected._take(expected.pipeline.step(frame))
    expected.play([], tuple)
    found.play(cut(frames, seed), tuple)
    assert everything(found.traffic) == everything(expected.traffic)
    assert any(found.traffic.first_hour._times_s.values())
    assert list(found.traffic.unmapped) == list(expected.traffic.unmapped)
    assert found.decoder.counts == expected.decoder.counts
    assert found.curves.table().tobytes() == expected.curves.table().tobytes()
    assert (found.stops, found.alarms, found.statuses) == (expected.stops, expected.alarms, expected.statuses)
    assert page(found, "x.log", "") == page(expected, "x.log", "")


@pytest.mark.parametrize("seed", range(20))
def test_a_bus_watch_hears_the_same(seed: int) -> None:
    random = Random(seed)
    frames = [
        Frame(random.uniform(0.0, 10.0), random.choice(("can0", "rear", "")), 0x100, False, b"") for _ in range(30)
    ]
    block = FrameBlock.of(frames)
    begin, end = sorted(random.sample(range(31), 2))
    singly, together = (BusWatch(("can0", "rear"), ()) for _ in range(2))
    for watch in (singly, together):
        watch.reports(0.5)
        watch.see(Frame(1.0, "can0", BUS_OFF, True, b"", FrameKind.ERROR))
    for frame in frames[begin:end]:
        singly.see(frame)
    together.pass_over(block, begin, end)
    assert together.reports(10.0) == singly.reports(10.0)


@pytest.mark.parametrize("back_s", [30.0, 600.0])
def test_a_clock_that_is_set_back_in_a_silence(back_s: float) -> None:
    """Only the brake's own message comes any more."""
    settings, frames = two_buses(), braking()
    decoder = Pipeline.from_settings(settings).decoder
    silent = {m.can_id for m in decoder.matchings if m.message in ("WSP", "GNSS")}
    begun_s = frames[0].time_s
    heard = [f for f in frames if f.can_id not in silent or f.time_s < begun_s + 0.5]
    set_back = [f if f.time_s < begun_s + 2.0 else f._replace(time_s=f.time_s - back_s) for f in heard]
    expected = stepped(settings, set_back)
    assert len(expected) > 30
    assert played(settings, cut(set_back, 3)) == expected
