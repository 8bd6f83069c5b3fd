"""Random and mutated input for everything that reads: frames, configurations, DBC files, recordings, memories.

What cannot be used may be refused by one of our own errors, in one sentence; nothing else may happen.
"""

import random
import shutil
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache, partial
from itertools import islice
from math import isfinite
from pathlib import Path
from typing import NamedTuple

import can

from brake_monitor.bus.can_log import open_log
from brake_monitor.errors import BrakeMonitorError, InputError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.publishing.encoding import encode
from brake_monitor.publishing.payloads import AdhesionMessage, FrictionMessage
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.example_vehicles import example_config, example_settings
from brake_monitor.simulator.files import to_message
from brake_monitor.storage.store import Store
from brake_monitor.storage.store_batch import Batch

MAPPED = [(0x120, False), (0x1A0, False), (0x2A0, False), (0x2A1, False), (0x320, False), (0x18FF5030, True)]
GOLDEN = Path(__file__).parents[1] / "golden" / "slide.log.gz"
ODD_STEPS_S = (0.0, -0.01, -1.0, 1.0, 30.0, 90.0, 3600.0, -3600.0, 1e6)
ODD_TEXT = (b"0", b"-1", b"1e999", b"nan", b"4294967296", b"9" * 40, b'"', b"\0", b"\xff", b"[", b"]", b"=", b"\n")


def mutated(content: bytes, dice: random.Random) -> bytes:
    """The content with a few things wrong with it."""
    spoilt = bytearray(content)
    for _ in range(dice.choice((1, 1, 2, 4))):
        place = dice.randint(0, len(spoilt))
        end = min(len(spoilt), place + dice.choice((1, 1, 2, 8, 40)))
        match dice.randrange(7):
            case 0 if place < len(spoilt):
                spoilt[place] ^= 1 << dice.randrange(8)
            case 1:
                spoilt[place:end] = dice.randbytes(end - place)
            case 2:
                del spoilt[place:end]
            case 3:
                spoilt[place:place] = spoilt[place:end]
            case 4:
                spoilt[place:end] = dice.choice(ODD_TEXT)
            case 5:
                other = dice.randint(0, len(spoilt))
                spoilt[place:place] = spoilt[other : other + 40]
            case _:
                if dice.random() < 0.2:
                    del spoilt[place:]
    return bytes(spoilt)


# -- frames --------------------------------------------------------------------------------------------------------


def random_frames(dice: random.Random) -> Iterator[Frame]:
    """For ever: mostly mapped ids with plausible time stamps, everything else as it falls."""
    time_s = 1_700_000_000.0
    while True:
        time_s += dice.choice(ODD_STEPS_S) if dice.random() < 0.001 else dice.expovariate(200.0)
        can_id, extended = dice.choice(MAPPED) if dice.random() < 0.9 else (dice.getrandbits(29), True)
        length = 8 if dice.random() < 0.9 else dice.randrange(65)
        data = (
            dice.randbytes(length)
            if dice.random() < 0.5
            else bytes(dice.choice((0, 1, 16, 254)) for _ in range(length))
        )
        kind = FrameKind.DATA if dice.random() < 0.99 else dice.choice(list(FrameKind))
        yield Frame(time_s, "can0" if dice.random() < 0.99 else "other", can_id, extended, data, kind)


def judge(outputs: Outputs) -> None:
    """What comes out of nonsense is doubtful, not nonsense; it can be published."""
    estimate = outputs.estimate
    if estimate is None:
        return
    assert isfinite(estimate.adhesion) and estimate.adhesion_std >= 0.0  # noqa: PT018
    for number, wheelset in enumerate(estimate.wheelsets, start=1):
        assert isfinite(wheelset.friction) and wheelset.friction_std >= 0.0  # noqa: PT018
        encode(FrictionMessage.of(estimate, number, 0, 0.0), "json")
    encode(AdhesionMessage.of(estimate, 0, 0.0), "json")


def play(frames: Iterator[Frame], count: int) -> int:
    """Let the pipeline have them, as the daemon does; how many estimates came of it."""
    pipeline = Pipeline.from_settings(wagon())
    estimates = 0
    for number in range(count):
        frame = next(frames)
        outputs = pipeline.step(frame)
        judge(outputs)
        estimates += outputs.estimate is not None
        if number % 1000 == 0:
            judge(pipeline.advance(frame.time_s + 0.1))
            with suppress(InputError):  # what was learned of nonsense is not gone on with
                Pipeline.from_settings(wagon()).resume(pipeline.remembered())
    return estimates


# -- files ---------------------------------------------------------------------------------------------------------


@cache
def wagon() -> Settings:
    return example_settings("wagon")


def read_configuration(content: bytes, folder: Path) -> None:
    """A TOML file beside a good DBC file."""
    shutil.copy(example_config("wagon").with_name("wagon.dbc"), folder)
    path = folder / "wagon.toml"
    path.write_bytes(content)
    Pipeline.from_settings(load_settings(path))


def read_dbc(content: bytes, folder: Path) -> None:
    """A DBC file beside a good configuration."""
    path = Path(shutil.copy(example_config("wagon"), folder))
    (folder / "wagon.dbc").write_bytes(content)
    pipeline = Pipeline.from_settings(load_settings(path))
    frames = random_frames(random.Random(len(content)))
    for _ in range(50):
        pipeline.step(next(frames))


def read_recording(content: bytes, folder: Path, suffix: str) -> None:
    """A recording in one of the formats."""
    path = folder / f"some{suffix}"
    path.write_bytes(content)
    pipeline = Pipeline.from_settings(wagon())
    for frame in open_log(path, wagon().can):
        judge(pipeline.step(frame))


def read_memory(content: bytes, folder: Path) -> None:
    """A daemon's memory, as at a start: what is good in it is used and written again."""
    path = folder / "memory.db"
    for leftover in folder.glob("memory.db*"):
        leftover.unlink()
    path.write_bytes(content)
    with Store.open(path, "wagon-8127", 2) as store:
        pipeline = Pipeline.from_settings(wagon())
        remembered = store.remembered()
        pipeline.resume(remembered)
        store.applications()
        store.alarms()
        store.gauges()
        list(store.messages())
        store.write(Batch(alarms={alarm.id: alarm for alarm in remembered.open_alarms}))


class Target(NamedTuple):
    """Something that reads, and the good content that is spoilt for it."""

    read: Callable[[bytes, Path], None]
    good: Callable[[Path], bytes]  # made in a folder


def good_recording(suffix: str) -> Callable[[Path], bytes]:
    def made(folder: Path) -> bytes:
        path = folder / f"good{suffix}"
        with can.Logger(path) as writer:
            for frame in islice(random_frames(random.Random(1)), 150):
                if len(frame.data) <= 8:  # not every format knows CAN FD
                    writer(to_message(frame))
        return path.read_bytes()

    return made


def good_memory(folder: Path) -> bytes:
    path = folder / "good.db"
    pipeline = Pipeline.from_settings(wagon())
    for frame in open_log(GOLDEN, wagon().can):
        pipeline.step(frame)
    state = pipeline.remembered()
    alarms = {alarm.id: alarm for alarm in state.open_alarms}
    with Store.open(path, "wagon-8127", 2) as store:
        store.write(Batch(alarms=alarms, brakes=state.brakes, learned=state.learned, messages={1: b"message"}))
    return path.read_bytes()


TARGETS = {
    "configuration": Target(read_configuration, lambda _: example_config("wagon").read_bytes()),
    "DBC": Target(read_dbc, lambda _: example_config("wagon").with_name("wagon.dbc").read_bytes()),
    "memory": Target(read_memory, good_memory),
    **{
        f"recording {suffix}": Target(partial(read_recording, suffix=suffix), good_recording(suffix))
        for suffix in (".log", ".asc", ".blf", ".trc", ".csv")
    },
}


def is_taken(read: Callable[[bytes, Path], None], content: bytes, folder: Path) -> bool:
    """Whether it is read, and not refused."""
    try:
        read(content, folder)
    except BrakeMonitorError as error:
        refusal = str(error)
    else:
        return True
    assert "\n" not in refusal, "a refusal is one sentence"
    return False
