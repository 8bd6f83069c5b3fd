"""A recording played by the block must give, to the bit, what it gives frame by frame."""

import gzip
from collections.abc import Callable, Iterable, Iterator
from itertools import dropwhile
from pathlib import Path

import pytest
from msgspec.structs import replace

from brake_monitor.bus import candump_blocks
from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.candump_log import line_of, parse_line
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.monitoring.reports import BusReport
from brake_monitor.processing.pipeline import NOTHING, Outputs, Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config, example_settings
from mixed_traffic import GOLDEN, braking, cut, mixed, two_buses

J1939 = Path(__file__).parents[1] / "data"
CHANNELS = {"can0": "can0", "rear": "can1", "": "can7"}


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


@pytest.mark.parametrize("rate_hz", [0.0, 1.0, 10.0, 50.0])
@pytest.mark.parametrize("ahead_s", [0.005, 0.04, 0.09, 0.2])
def test_a_first_frame_that_is_ahead_of_those_behind_it(rate_hz: float, ahead_s: float) -> None:
    """As two buses may begin, here with a force, of which no estimate is made. The rules look before one is."""
    settings = two_buses()
    settings = replace(settings, output=replace(settings.output, rate_hz=rate_hz))
    ids = {m.message: m.can_id for m in Pipeline.from_settings(settings).decoder.matchings}
    force = next(frame for frame in braking() if frame.can_id == ids["BCU"])
    behind = list(dropwhile(lambda frame: frame.can_id != ids["WSP"], braking()))[:300]
    frames = [force._replace(time_s=behind[0].time_s + ahead_s), *behind]
    expected = stepped(settings, frames)
    assert len(expected) > 3
    assert played(settings, cut(frames, 3)) == expected


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
