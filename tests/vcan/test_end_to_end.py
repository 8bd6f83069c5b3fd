"""The whole path on a real bus: canplayer plays a simulated braking, the daemon listens, another process subscribes."""

import csv
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from brake_monitor.bus.candump_log import parse_line
from brake_monitor.daemon.bus_reader import TICK_S
from brake_monitor.frame import Frame
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.files import write_log
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import run as simulate
from program import BRAKE_MONITOR, STOP_S, Daemon, Program, Subscriber, run, until, write_config

pytestmark = pytest.mark.vcan

SLIDE = Scenario(
    name="slide",
    summary="a braking on a good rail, then a full one on adhesion 0.04, where the WSP never comes to rest",
    initial_speed_mps=100.0 / 3.6,
    duration_s=24.0,
    demand=steps((1.0, 0.3), (5.0, 0.0), (8.0, 1.0)),
    rail_over_time=Profile(((6.0, 0.25), (9.0, 0.05))),
)
WAGON = "brake/v1/wagon-8127"
LAST = "7FF#"  # a frame of ours, mapped to nothing, that tells the end of a recording

KEYS = {"adhesion": "adhesion", "axle/1/friction": "friction_1", "axle/2/friction": "friction_2"}  # and the columns
ROUNDING_S = 1e-5
LATE_S = 0.05

Table = list[dict[str, str]]  # the rows of a CSV


@dataclass(frozen=True)
class Braking:
    """What was seen of one run, from outside the daemon."""

    played: Path  # the log that canplayer was given
    recorded: Path  # candump's, from before the daemon's start to after its end, with the kernel's time stamps
    sent_frames: int  # as the kernel counted meanwhile
    subscriber: Subscriber
    exit_status: int
    stop_s: float
    replay: Callable[[Path], Table]  # a log through the same configuration, a row after every fused frame


@pytest.fixture(scope="module")
def braking(tmp_path_factory: pytest.TempPathFactory) -> Braking:
    folder = tmp_path_factory.mktemp("braking")
    config = write_config(folder / "live.toml", "vcan0", rate_hz=20.0)
    every_frame = write_config(folder / "every_frame.toml", "vcan0", rate_hz=0.0)
    played, recorded = folder / "played.log", folder / "recorded.log"
    write_log(played, simulate(SLIDE, load_settings(config), seed=1).frames)

    @cache
    def replay(log: Path) -> Table:
        output = log.with_suffix(".csv")
        done = run(BRAKE_MONITOR, "replay", "-c", every_frame, log, "-o", output)
        assert done.returncode == 0, done.stderr
        with output.open(encoding="utf-8", newline="") as stream:
            return list(csv.DictReader(stream))

    sent_before = frames_sent()
    with Program("candump", "-L", "-r", str(4 << 20), "vcan0,0:0,#FFFFFFFF") as candump:
        until(lambda: "(vcan0: no entry)" not in Path("/proc/net/can/rcvlist_all").read_text())
        with Daemon(config) as daemon, Subscriber(daemon.endpoint) as subscriber:
            subscriber.wait_for("/adhesion")
            assert run("canplayer", "-I", played, "vcan0=vcan0").returncode == 0
            exit_status, stop_s = daemon.end()
            subscriber.end()
        assert run("cansend", "vcan0", LAST).returncode == 0
        candump.wait_for(LAST)
    recorded.write_text("".join(f"{line}\n" for line in candump.lines if not line.endswith(LAST)))
    return Braking(played, recorded, frames_sent() - sent_before - 1, subscriber, exit_status, stop_s, replay)


def frames_sent() -> int:
    return int(Path("/sys/class/net/vcan0/statistics/tx_packets").read_text())


def frames(log: Path) -> list[Frame]:
    return [parse_line(line) for line in log.read_text().splitlines()]


def times_of(log: Path) -> np.ndarray:
    return np.array([frame.time_s for frame in frames(log)])


def column(table: Table, name: str) -> np.ndarray:
    return np.array([float(row[name]) for row in table])


def nearest(times_s: np.ndarray, among_s: np.ndarray) -> np.ndarray:
    """Index of the one in `among_s`, which ascend, that lies nearest to each of the times."""
    right = np.clip(np.searchsorted(among_s, times_s), 1, len(among_s) - 1)
    return right - (times_s - among_s[right - 1] < among_s[right] - times_s)


def test_the_daemon_sends_no_frame(braking: Braking) -> None:
    played, recorded = (
        [(frame.can_id, frame.extended, frame.data, frame.kind) for frame in frames(log)]
        for log in (braking.played, braking.recorded)
    )
    assert recorded == played
    assert braking.sent_frames == len(played)


def test_sigterm_ends_the_daemon_at_once_and_in_order(braking: Braking) -> None:
    assert braking.exit_status == 0
    assert braking.stop_s < STOP_S


def test_all_is_json_under_the_wagons_keys(braking: Braking) -> None:
    samples = braking.subscriber.samples()
    assert {sample["encoding"] for sample in samples} == {"application/json"}
    heard = {sample["key"].removeprefix(f"{WAGON}/") for sample in samples}
    always = {"adhesion", "health", *(f"axle/{i}/{of}" for i in (1, 2) for of in ("adhesion", "friction", "wear"))}
    assert {key for key in heard if not key.startswith("alarm/")} - {"meta"} == always
    assert "alarm/low_adhesion" in heard


def root_mean_square(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else 0.0


def errors_of(braking: Braking, log: Path, key: str, name: str) -> tuple[np.ndarray, np.ndarray]:
    """By how much what was published with each frame is off what `replay` of the log gives with that frame.

    Also the numbers of those frames. While no frame comes the daemon publishes, too; then a replay says nothing.
    """
    table = braking.replay(log)
    arrived_s, logged_s = times_of(braking.recorded), times_of(log)
    payloads = braking.subscriber.payloads(f"{WAGON}/{key}")
    times_s = np.array([payload["time_s"] for payload in payloads])
    published = np.array([payload[key.rpartition("/")[2]] for payload in payloads], dtype=float)
    numbers = nearest(times_s, arrived_s)
    rows = nearest(logged_s[numbers], column(table, "time_s"))
    with_frame = np.abs(times_s - arrived_s[numbers]) < ROUNDING_S
    with_frame &= np.abs(logged_s[numbers] - column(table, "time_s")[rows]) < ROUNDING_S
    return np.abs(published - column(table, name)[rows])[with_frame], numbers[with_frame]


def frames_without_silence(braking: Braking) -> int:
    """How many came before time first went on without them, where a busy machine held up canplayer or the daemon.

    The daemon then estimates on, and publishes that, which no replay does.
    """
    arrived_s = times_of(braking.recorded)
    told_s = np.array([payload["time_s"] for payload in braking.subscriber.payloads(f"{WAGON}/adhesion")])
    told_s = told_s[told_s > arrived_s[0] + ROUNDING_S]
    without_frame_s = told_s[np.abs(told_s - arrived_s[nearest(told_s, arrived_s)]) > ROUNDING_S]
    silences_s = arrived_s[:-1][np.diff(arrived_s) > TICK_S]
    return int(np.searchsorted(arrived_s, min(*without_frame_s, *silences_s, np.inf, np.inf)))


def test_live_gives_what_replay_gives_for_the_same_frames(braking: Braking) -> None:
    """With the kernel's time stamps: the daemon's own, but that candump rounds them to 1 µs."""
    count = frames_without_silence(braking)
    for key, name in KEYS.items():
        errors, numbers = errors_of(braking, braking.recorded, key, name)
        assert len(errors) > SLIDE.duration_s, "of 20 in a second"
        assert np.max(errors[numbers < count], initial=0.0) < 1e-4, name


def test_live_agrees_with_replay_of_the_log_that_was_played(braking: Braking) -> None:
    """Time stamps differ by when canplayer came to send each frame; both tolerances are about one standard deviation.

    10 ms too late (one tick of a slow guest) put a wheel speed that falls at 1 g off by five times its noise. What
    comes after a busy machine has let it be much later tells of that machine.
    """
    arrived_s, played_s = (times_of(log) for log in (braking.recorded, braking.played))
    lateness_s = arrived_s - played_s
    too_late = np.append(lateness_s - np.min(lateness_s) > LATE_S, True)
    for key, name in KEYS.items():
        errors, numbers = errors_of(braking, braking.played, key, name)
        compared = errors[numbers < np.argmax(too_late)]
        assert root_mean_square(compared) < (0.003 if name == "adhesion" else 0.02), name


def test_the_slide_raises_the_low_adhesion_alarm(braking: Braking) -> None:
    alarms = braking.subscriber.payloads(f"{WAGON}/alarm/low_adhesion")
    assert (alarms[0]["state"], alarms[0]["wheelset"]) == ("open", None)
    begun_s = frames(braking.recorded)[0].time_s
    assert 8.0 < alarms[0]["raised_time_s"] - begun_s < 12.0, "soon after the full brake at 8 s"
    numbers = [sample["payload"]["sequence"] for sample in braking.subscriber.samples() if "/alarm/" in sample["key"]]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))  # of all: before it the bus may be silent
