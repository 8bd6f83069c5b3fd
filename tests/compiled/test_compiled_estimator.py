"""The estimator as machine code: the same numbers as sample by sample, whatever happens on the way."""

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, nullcontext
from functools import cache
from math import inf
from pathlib import Path
from shutil import copytree

import msgspec
import numpy as np
import pytest

from brake_monitor.alarm_campaign.drives import Drive
from brake_monitor.compiled import code_folder, code_maker, kept_code
from brake_monitor.compiled.compiled_core import OBJECTS, FilterTuple
from brake_monitor.compiled.compiled_estimator import CompiledEstimator
from brake_monitor.compiled.numba_classes import class_of, record_type
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.core.core import Core
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.estimation.model.wagon import Wagon
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing import playing
from brake_monitor.processing.aligned_taker import block_taker
from brake_monitor.processing.block_taker import OneByOne
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.config import EstimatorSettings, OutputSettings, Preset, Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, SLIDE
from drives import drive as simulated
from faults import frozen, lagging, lost, scattered, silence
from machine_code import by_machine_code
from motor_drives import SLIPPERY, recording, scaled
from program import until

PATIENCE_S = 60.0

BLOCK = 1000
EVERY_FRAME, OFTEN = OutputSettings(rate_hz=0.0), OutputSettings(rate_hz=25.0)
FEW = 15_000  # frames
BRAKING_S = 6.0  # into `DRY`
BRAKES_ID = 0x120  # of the wagon
WITHOUT_A_HOME = """
import os
from brake_monitor.compiled.kept_code import have_made, with_machine_code
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.example_vehicles import example_settings
from pathlib import Path
estimator = Pipeline.from_settings(example_settings("wagon")).estimator
def no_home():
    raise RuntimeError("Could not determine home directory.")
Path.home = no_home
os.environ.pop("XDG_CACHE_HOME", None)
have_made(estimator)
print(with_machine_code(estimator))
"""
# With what the compiled core leaves to the estimator: outliers, losses, restarts, frozen and jumping signals.
DRIVES = {
    "sliding": ("wagon/wsp/0", EstimatorSettings()),
    "in a train, four wheelsets": ("bogie/wsp/1", EstimatorSettings(preset="train")),
    "the paper's covariances": ("single/leaf/0", EstimatorSettings(preset="rig")),
    "friction that relaxes": ("wagon/locked/0", EstimatorSettings(friction_model="first-order")),
    "a speed that fails": ("wagon/speed-error/0", EstimatorSettings()),
    "lost wheel speeds": ("bogie/lost-wheel-speeds/0", EstimatorSettings()),
    "an impossible wheel speed": ("wagon/impossible-wheel-speed/0", EstimatorSettings()),
    "a silent bus": ("wagon/silent/0", EstimatorSettings()),
}


@cache
def drive(path: str, estimator: EstimatorSettings) -> tuple[Settings, list[Frame]]:
    vehicle, name, seed = path.split("/")
    recording = Drive(vehicle, name, int(seed)).simulate()
    settings = msgspec.structs.replace(recording.settings, estimator=estimator, output=OFTEN)
    return settings, list(recording.frames)[:FEW]


def played(pipeline: Pipeline, frames: list[Frame]) -> Iterator[Outputs]:
    for begin in range(0, len(frames), BLOCK):
        yield from pipeline.play(FrameBlock.of(frames[begin : begin + BLOCK]))


def numbers(thing: object) -> Iterator[object]:
    """Everything in the outputs, in order."""
    if isinstance(thing, dict):
        for item in thing.items():
            yield from numbers(item)
    elif isinstance(thing, (list, tuple)):
        for part in thing:
            yield from numbers(part)
    elif isinstance(thing, msgspec.Struct):
        yield from numbers(msgspec.structs.astuple(thing))
    else:
        yield thing


@pytest.fixture
def makers(monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[bytes]]:
    """The processes that were started to make machine code."""
    started: list[subprocess.Popen[bytes]] = []
    monkeypatch.setattr(kept_code, "makers", started)
    return started


@pytest.fixture
def short_is_long(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(playing, "LONG_FRAMES", 2 * BLOCK)


@contextmanager
def keeping_code_in(place: Path) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_CACHE_HOME", str(place))
        code_folder.folder.cache_clear()
        yield
    code_folder.folder.cache_clear()


@pytest.fixture
def nothing_kept(tmp_path: Path) -> Iterator[None]:
    with keeping_code_in(tmp_path):
        yield


@pytest.fixture
def nothing_kept_yet(tmp_path: Path) -> Iterator[None]:
    """As on a new machine; on one that is, what is made serves the tests that follow."""
    estimator = Pipeline.from_settings(drive(*DRIVES["sliding"])[0]).estimator
    is_kept = kept_code.KeptCode(kept_code.EstimatorOrder.of(estimator)).is_ready
    with keeping_code_in(tmp_path) if is_kept else nullcontext():
        yield


def play_long(blocks: int, *, read: float = 0.0) -> Pipeline:
    """As many blocks of a recording; `read`: what share of it they are said to be."""
    settings, frames = drive(*DRIVES["sliding"])
    pipeline = Pipeline.from_settings(settings)
    some = [FrameBlock.of(frames[begin : begin + BLOCK]) for begin in range(0, blocks * BLOCK, BLOCK)]
    found = playing.play(pipeline, some, progress=lambda: read)
    assert sum(outputs.estimate is not None for outputs in found) > 100
    return pipeline


@pytest.mark.usefixtures("short_is_long", "nothing_kept_yet")
def test_long_ones_are_played_by_machine_code_once_another_process_has_made_it(
    makers: list[subprocess.Popen[bytes]],
) -> None:
    assert isinstance(play_long(2).taker, OneByOne)
    assert makers == []
    assert isinstance(play_long(4).taker, OneByOne)
    (maker,) = makers  # one, though two blocks would have been glad of it
    assert maker.wait(timeout=900) == 0
    assert isinstance(play_long(2).taker, OneByOne)
    assert isinstance(play_long(3).taker, CompiledEstimator)
    assert isinstance(play_long(1, read=0.5).taker, OneByOne)
    assert isinstance(play_long(1, read=0.3).taker, CompiledEstimator)  # from the beginning
    assert len(makers) == 1


def seldom_told_and_released(frames: list[Frame]) -> list[Frame]:
    """Pressures every tenth of a second, of brakes that are off in every third second, whatever the wheels do."""
    told = [frame for frame in frames if frame.can_id == BRAKES_ID][::10]
    released = [f._replace(data=bytes(4) + f.data[4:]) if int(f.time_s) % 3 == 0 else f for f in told]
    return sorted([*(f for f in frames if f.can_id != BRAKES_ID), *released], key=lambda frame: frame.time_s)


@pytest.mark.parametrize("name", DRIVES)
def test_machine_code_gives_the_same_numbers(name: str) -> None:
    assert_the_same(*drive(*DRIVES[name]))


def test_machine_code_gives_the_same_numbers_of_brakes_that_may_have_filled_unseen() -> None:
    settings, frames = drive(*DRIVES["sliding"])
    assert_the_same(settings, seldom_told_and_released(frames))


def test_machine_code_gives_the_same_numbers_of_sensors_that_are_late() -> None:
    settings, frames = drive(*DRIVES["sliding"])
    for message in ("GNSS", "BCU"):
        assert_the_same(settings, lagging(message, 0.1)(frames))


@pytest.mark.parametrize("name", ["sliding", "an impossible wheel speed", "a silent bus"])
def test_machine_code_gives_the_same_numbers_of_samples_that_wait_for_slower_sensors(name: str) -> None:
    settings, frames = drive(*DRIVES[name])
    back = frames[: FEW // 2] + [f._replace(time_s=f.time_s - 20.0) for f in frames[FEW // 2 :]]  # a clock is set
    assert_the_same(delayed(settings), back)


def test_machine_code_gives_the_same_numbers_of_wheelsets_that_are_found_to_turn_again_after_a_silence() -> None:
    """They alone tell the speed then, and turn slower than the wagon ran before: no slide, for all one knows."""
    settings, frames = drive("wagon/locked/0", EstimatorSettings())
    locked_until_s = 46.5
    silent = silence(locked_until_s - 3.0, locked_until_s + 5.0)(frames)
    assert_the_same(settings, lost("GNSS", locked_until_s - 6.0, inf)(silent))


@pytest.mark.parametrize("sensor", ["vehicle speed", "wheel speed"])
def test_machine_code_gives_the_same_numbers_of_speeds_that_spike_and_freeze_in_a_slide(sensor: str) -> None:
    """What spiked is taken back, and what was known before it froze is gone back to."""
    recording = simulated(SLIDE)
    settings = msgspec.structs.replace(recording.settings, output=EVERY_FRAME)
    spiked = scattered("wheel speed", 3.0, 0.02, seed=1)(list(recording.frames))
    assert_the_same(settings, frozen(sensor, 9.0, 12.0)(spiked))


def test_machine_code_gives_the_same_numbers_of_a_brake_that_shows_to_be_isolated() -> None:
    """That is known beyond the estimator, from the middle of the first application on."""
    recording = simulated(DRY, Modifiers(brake_faults=(BrakeFault(0, isolated=True),)))
    settings = msgspec.structs.replace(recording.settings, output=EVERY_FRAME)
    assert_the_same(settings, list(recording.frames))


def test_machine_code_gives_the_same_numbers_of_a_wagon_that_reverses() -> None:
    settings, frames = drive(*DRIVES["in a train, four wheelsets"])
    backwards = msgspec.structs.replace(settings.signals.speed, scale=-settings.signals.speed.scale)
    signals = msgspec.structs.replace(settings.signals, speed=backwards)
    assert_the_same(msgspec.structs.replace(settings, signals=signals), frames)


def test_machine_code_gives_the_same_numbers_of_motors_that_err() -> None:
    railcar = recording(SLIPPERY, (0, 1, 2, 3))
    settings = msgspec.structs.replace(railcar.settings, output=EVERY_FRAME)
    assert_the_same(settings, [scaled(0.85)(frame) for frame in railcar.frames])


def test_machine_code_gives_the_same_numbers_of_a_wheel_that_is_worn() -> None:
    """Until it is known to be, from the first coasting on, it seems to run faster than the wagon, which is no slide."""
    recording = simulated(DRY, Modifiers(wheel_radius_factor=(0.98, 1.0)))
    settings = msgspec.structs.replace(recording.settings, output=EVERY_FRAME)
    assert_the_same(settings, [frame for frame in recording.frames if frame.time_s > EPOCH_S + BRAKING_S])


def delayed(settings: Settings) -> Settings:
    """The vehicle speed is 0.08 s late, the forces 0.03 s: wheel speeds wait for both."""
    signals = settings.signals
    speed = msgspec.structs.replace(signals.speed, delay_s=0.08)
    forces = tuple([msgspec.structs.replace(force, delay_s=0.03) for force in signals.pressing_force])
    return msgspec.structs.replace(
        settings, signals=msgspec.structs.replace(signals, speed=speed, pressing_force=forces)
    )


def assert_the_same(settings: Settings, frames: list[Frame]) -> None:
    plain, compiled = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    taker = compiled.taker = block_taker(compiled.estimator, by_machine_code(compiled.estimator))
    expected, found = list(played(plain, frames)), list(played(compiled, frames))
    assert isinstance(plain.taker, OneByOne)
    assert compiled.taker is taker
    assert len(found) == len(expected)
    assert sum(outputs.estimate is not None for outputs in found) > 1000
    assert_equal_or_near(list(numbers(found)), list(numbers(expected)))
    for count in ("outlier_count", "late_count", "reset_count"):
        assert getattr(compiled.estimator, count) == getattr(plain.estimator, count)
    assert compiled.decoder.counts == plain.decoder.counts


def assert_equal_or_near(mine: list[object], theirs: list[object]) -> None:
    """What is a number with a fraction may differ in its tenth digit. Half a million of them: all at once."""
    near = [isinstance(other, float) for other in theirs]
    assert [isinstance(own, float) for own in mine] == near
    assert [own for own, is_near in zip(mine, near, strict=True) if not is_near] == [
        other for other, is_near in zip(theirs, near, strict=True) if not is_near
    ]
    own, other = (np.array([value for value in values if isinstance(value, float)]) for values in (mine, theirs))
    is_same, finite = (own == other) | (np.isnan(own) & np.isnan(other)), np.isfinite(other)
    tolerance = np.maximum(1e-9 * np.abs(other[finite]), 1e-12)
    is_same[finite] |= np.abs(own[finite] - other[finite]) <= tolerance
    assert is_same.all(), (own[~is_same][:3], other[~is_same][:3])


@pytest.mark.parametrize("name", ["sliding", "a speed that fails"])
def test_the_numbers_are_the_same_to_the_last_bit(name: str) -> None:
    """What differs by a bit, as `hypot` and `**` do, is not written so: a recording gives the same bytes either way."""
    settings, frames = drive(*DRIVES[name])
    plain, compiled = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    compiled.taker = by_machine_code(compiled.estimator)
    assert list(map(repr, played(compiled, frames))) == list(map(repr, played(plain, frames)))


@pytest.mark.parametrize("has_delays", [False, True])
def test_what_was_played_in_blocks_goes_on_frame_by_frame(has_delays: bool) -> None:
    settings, frames = drive(*DRIVES["sliding"])
    settings = delayed(settings) if has_delays else settings
    plain, compiled = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    compiled.taker = block_taker(compiled.estimator, by_machine_code(compiled.estimator))
    expected = [plain.step(frame) for frame in frames]
    found = [*played(compiled, frames[:6000]), *map(compiled.step, frames[6000:9000]), *played(compiled, frames[9000:])]
    last = [[o.estimate for o in some if o.estimate is not None][-1] for some in (expected, found)]
    assert last[1].adhesion == pytest.approx(last[0].adhesion, rel=1e-9)
    assert last[1].time_s == last[0].time_s


def test_what_an_earlier_run_has_learned_may_come_between_blocks() -> None:
    """From a disk that failed at first; before any brake was applied."""
    settings, frames = drive(*DRIVES["sliding"])
    plain, compiled = Pipeline.from_settings(settings), Pipeline.from_settings(settings)
    compiled.taker = block_taker(compiled.estimator, by_machine_code(compiled.estimator))
    found = []
    for pipeline in (plain, compiled):
        list(played(pipeline, frames[:BLOCK]))
        learned = pipeline.estimator.learned()
        assert learned is not None
        pipeline.estimator.resume(msgspec.structs.replace(learned, friction=(0.28, 0.28), friction_std=(0.01, 0.01)))
        list(played(pipeline, frames[BLOCK : 2 * BLOCK]))
        found.append([own.friction for own in pipeline.estimator.estimate().wheelsets])
    assert found[1] == pytest.approx(found[0], rel=1e-9)
    assert found[0] == pytest.approx([0.28, 0.28])


def test_machine_code_is_the_same_for_vehicles_of_any_size() -> None:
    """But for their equations: arrays may have any length, while a record that holds one knows how long it is."""
    cores = [Pipeline.from_settings(example_settings(name)).estimator.core for name in ("rig", "wagon", "bogie")]
    kinds = [[record_type(thing) for thing in recorded(core)] for core in cores]
    assert len(kinds[0]) > 5
    assert kinds[0] == kinds[1] == kinds[2]


def recorded(core: Core) -> list[object]:
    """What of it becomes records, one of each kind."""
    found = [getattr(core, name) for name in OBJECTS]
    return [thing[0] if isinstance(thing, Sequence) else thing for thing in found]


def record_classes(core: Core) -> list[type]:
    """The classes that records are made of, those of the objects in them as well."""
    for thing in recorded(core):
        record_type(thing)
    return [kind for kind in class_of.values() if kind.__module__.startswith("brake_monitor.")]


class Unusual(Estimator):
    """An estimator with steps of its own, which are not compiled."""


@pytest.mark.usefixtures("nothing_kept")
def test_a_maker_that_was_stopped_does_not_stand_in_the_way_for_ever() -> None:
    """Its order stays, as after a power cut."""
    code = kept_code.KeptCode(
        kept_code.EstimatorOrder.of(Pipeline.from_settings(drive(*DRIVES["sliding"])[0]).estimator)
    )
    assert not code.is_on_order
    order = code.ordered()
    assert code.is_on_order
    begun_s = time.time() - kept_code.MADE_WITHIN_S - 1.0
    os.utime(order, (begun_s, begun_s))
    assert not code.is_on_order
    assert not code.is_ready


def test_code_made_of_other_sources_is_not_taken() -> None:
    """All that is compiled counts, wherever it stands: numba looks at the outermost function's source alone."""
    core = Pipeline.from_settings(example_settings("wagon")).estimator.core
    kinds = {kind.__module__ for kind in (*record_classes(core), FilterTuple, Core, Wagon)}
    compiled = {Path(sys.modules[name].__file__ or "") for name in kinds}
    assert len({source.parent for source in compiled}) > 2
    assert compiled <= set(code_folder.sources())


@pytest.mark.usefixtures("short_is_long", "nothing_kept")
class TestLongRecordings:
    """Who takes the samples of a recording."""

    def test_one_process_makes_all_that_a_campaign_wants_once(
        self, monkeypatch: pytest.MonkeyPatch, makers: list[subprocess.Popen[bytes]]
    ) -> None:
        commands: list[list[str]] = []
        monkeypatch.setattr(subprocess, "Popen", lambda command, **_: commands.append(command))
        presets: tuple[Preset, ...] = ("wagon", "train")  # whose machine code is the same
        vehicles = [example_settings(name) for name in ("rig", "wagon")]
        channels = [SignalDecoder.from_settings(settings).channels for settings in vehicles]
        wanted = [
            kind(settings.vehicle, msgspec.structs.replace(settings.estimator, preset=preset), those)
            for settings, those in zip(vehicles, channels, strict=True)
            for preset in presets
            for kind in (Estimator, Unusual)
        ]
        kept_code.have_made(*wanted)
        kept_code.have_made(*wanted)
        (command,) = commands
        orders = [Path(word) for word in command if word.endswith(kept_code.ORDERED)]
        assert {order.parent for order in orders} == {code_folder.folder()}
        assert len(orders) == len(vehicles)

    def test_without_numba_they_are_played_all_the_same(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(kept_code, "find_spec", lambda _: None)
        assert isinstance(play_long(3).taker, OneByOne)

    def test_without_room_for_machine_code_they_are_played_all_the_same(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, makers: list[subprocess.Popen[bytes]]
    ) -> None:
        (tmp_path / "file").touch()
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
        assert isinstance(play_long(3).taker, OneByOne)
        assert makers == []

    def test_where_machine_code_cannot_be_loaded_they_are_played_all_the_same(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        """It was made, and what keeps it has been spoilt since."""
        monkeypatch.setattr(kept_code.KeptCode, "is_ready", True)
        (tmp_path / "file").touch()
        monkeypatch.setattr("brake_monitor.compiled.machine_code.folder", lambda: tmp_path / "file" / "cache")
        assert isinstance(play_long(3).taker, OneByOne)

    def test_damaged_machine_code_is_thrown_away(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        """A power cut may leave no more than the beginning of the files in which numba looks it up."""
        monkeypatch.setattr(kept_code.KeptCode, "is_ready", True)
        FilterTuple.of(Pipeline.from_settings(example_settings("wagon")).estimator.filter)
        whole = copytree(code_folder.folder(), tmp_path / "whole")
        for left in (0, 20):
            copytree(whole, code_folder.folder(), dirs_exist_ok=True)
            indexes = list(code_folder.folder().rglob("*.nbi"))
            assert indexes
            for index in indexes:
                index.write_bytes(index.read_bytes()[:left])
            assert isinstance(play_long(3).taker, OneByOne)
            assert not code_folder.folder().exists()

    def test_machine_code_of_another_estimator_is_thrown_away(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """numba then looks in vain for what it wants to call."""

        def load(estimator: Estimator) -> CompiledEstimator:
            raise KeyError(estimator.vehicle.id)

        monkeypatch.setattr(kept_code.KeptCode, "is_ready", True)
        monkeypatch.setattr("brake_monitor.compiled.compiled_estimator.CompiledEstimator", load)
        code_folder.folder().mkdir(parents=True)
        assert isinstance(play_long(3).taker, OneByOne)
        assert not code_folder.folder().exists()

    def test_one_maker_waits_for_another(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Told to make the same, it then has nothing to do."""
        made: list[str] = []
        others = threading.Event()

        def slow(estimator: Estimator) -> None:
            made.append(estimator.vehicle.id)
            assert others.wait(PATIENCE_S)

        monkeypatch.setattr(code_maker, "CompiledEstimator", slow)
        orders = []
        for name in ("wagon", "wagon", "bogie"):
            estimator = Pipeline.from_settings(example_settings(name)).estimator
            orders.append(kept_code.KeptCode(kept_code.EstimatorOrder.of(estimator)).ordered())
        with ThreadPoolExecutor(3) as pool:
            making = [pool.submit(code_maker.make, order) for order in orders]
            until(lambda: made)
            at_once = len(made)
            others.set()
            for maker in making:
                maker.result(PATIENCE_S)
        assert at_once == 1
        assert sorted(made) == ["bogie-3105", "wagon-8127"]
        assert all(order.with_suffix(kept_code.READY).exists() for order in orders)


def test_classes_that_would_look_alike_are_refused() -> None:
    """A record knows its class by its fields alone."""

    class One:
        def __init__(self) -> None:
            self.only_here = 1.0

    class Other:
        def __init__(self) -> None:
            self.only_here = 2.0

    record_type(One())
    with pytest.raises(TypeError, match="One and Other have the same fields"):
        record_type(Other())


def test_a_user_without_a_home_does_without_machine_code() -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT_A_HOME], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("None\n", "")
