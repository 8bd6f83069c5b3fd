"""From truth to frames and files: what the bus carries is the truth within the sensors' errors, seed by seed."""

import csv
import errno
import gzip
import json
import logging
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import can
import cantools
import msgspec
import numpy as np
import pytest
from cantools.database.can import Message, Signal
from cantools.database.conversion import BaseConversion
from hypothesis import given
from hypothesis import strategies as st

import brake_monitor
from brake_monitor.bus.can_log import open_log
from brake_monitor.cli import main
from brake_monitor.commands import simulate as simulate_command
from brake_monitor.decoding.signal_field import signal_field
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.samples import Quality, Quantity
from brake_monitor.settings.config import CanBus, Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.can_encoder import put
from brake_monitor.simulator.due.alarm import AFTERMATH_S
from brake_monitor.simulator.files import write_log, write_truth
from brake_monitor.simulator.live import play
from brake_monitor.simulator.plant import GRAVITY_MPS2, Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.sensor_faults import BUS_OFF
from brake_monitor.simulator.simulate import EPOCH_S, Recording, brake_gears, run

VEHICLES = Path(brake_monitor.__file__).parent / "vehicles"
SHORT = Scenario("short", "", 20.0, 4.0, steps((1.0, 1.0)), Profile(((0.0, 0.05),)), sanding_from_s=3.0)


def settings(name: str) -> Settings:
    return load_settings(VEHICLES / f"{name}.toml")


@pytest.fixture(scope="module", params=["rig", "wagon", "bogie"])
def recording(request: pytest.FixtureRequest) -> Recording:
    return run(SHORT, settings(request.param), seed=5)


def decoded(recording: Recording, message: str, signal: str) -> tuple[np.ndarray, np.ndarray]:
    """Times since the start and physical values of one signal, by cantools."""
    database = cantools.database.load_file(recording.settings.can[0].dbc[0])
    layout = database.get_message_by_name(message)
    found = [
        (frame.time_s - EPOCH_S, values[signal])
        for frame in recording.frames
        if (frame.can_id, frame.extended) == (layout.frame_id, layout.is_extended_frame)
        for values in [layout.decode(frame.data, decode_choices=False)]
        if signal in values
    ]
    times, values = zip(*found, strict=True)
    return np.array(times), np.array(values)


def truth_at(recording: Recording, column: np.ndarray, times_s: np.ndarray) -> np.ndarray:
    return np.interp(times_s, np.arange(len(column)) * recording.trace.step_s, column)


def test_speeds_on_the_bus_are_the_truth_within_the_sensors_noise(recording: Recording) -> None:
    speed = recording.settings.signals.speed
    times, values = decoded(recording, speed.message, speed.signal)
    error = values - truth_at(recording, recording.trace.wagon("speed_mps"), times)
    assert speed.noise_std is not None
    assert np.std(error) < 1.3 * speed.noise_std + 0.003
    assert abs(np.mean(error)) < 0.3 * speed.noise_std + 0.002


def test_a_wheel_that_stands_gives_no_pulses_and_one_that_turns_scatters() -> None:
    stop = Scenario("stop", "", 8.0, 20.0, steps((1.0, 1.0)), Profile(((0.0, 0.3),)))
    stopped = run(stop, settings("wagon"), seed=5)
    mapping, radius_m = stopped.settings.signals.axle_speed[0], stopped.settings.vehicle.wheel_radius_m[0]
    times, kmh = decoded(stopped, mapping.message, mapping.signal)
    turning = truth_at(stopped, stopped.trace.wheelset(0, "omega_radps"), times)
    assert mapping.noise_std is not None
    scatter = np.std((kmh - turning * radius_m * 3.6)[turning > 1.0])
    assert scatter == pytest.approx(mapping.noise_std, rel=0.2)
    assert np.count_nonzero(turning == 0.0) > 20
    assert not np.any(kmh[turning == 0.0])


def test_wheel_speeds_use_the_configured_radius_though_the_wheel_is_worn() -> None:
    worn = run(SHORT, settings("wagon"), seed=5, modifiers=Modifiers(wheel_radius_factor=(0.95,)))
    mapping = worn.settings.signals.axle_speed[0]
    times, kmh = decoded(worn, mapping.message, mapping.signal)
    coasting = times < 1.0
    assert np.mean(kmh[coasting]) == pytest.approx(20.0 / 0.95 * 3.6, rel=0.003)


def test_the_cylinder_pressure_gives_the_pressing_force_through_the_mapping(recording: Recording) -> None:
    for i, mapping in enumerate(recording.settings.signals.pressing_force):
        times, values = decoded(recording, mapping.message, mapping.signal)
        force_n = np.maximum(values * mapping.scale + mapping.offset, 0.0)
        truth_n = truth_at(recording, recording.trace.wheelset(i, "pressing_force_n"), times)
        assert np.max(truth_n) > 10e3
        assert np.max(np.abs(force_n - truth_n)) < 0.02 * np.max(truth_n)


def test_flags_and_load_are_on_the_bus() -> None:
    heavy = run(SHORT, settings("wagon"), seed=5, modifiers=Modifiers(mass_factor=1.3))
    signals = heavy.settings.signals
    times, flags = decoded(heavy, signals.wsp_active[1].message, signals.wsp_active[1].signal)
    assert set(flags.tolist()) == {0, 1}
    assert np.mean(flags == np.round(truth_at(heavy, heavy.trace.wheelset(1, "wsp"), times))) > 0.98
    assert signals.sanding is not None
    sanding = decoded(heavy, signals.sanding.message, signals.sanding.signal)[1]
    assert (sanding[0], sanding[-1]) == (0, 1)
    load = signals.load_force[0]
    kilonewton = decoded(heavy, load.message, load.signal)[1] * load.scale + load.offset
    assert np.mean(kilonewton) == pytest.approx(1.3 * 36.0 * GRAVITY_MPS2, rel=0.01)


def test_each_message_keeps_its_cycle_and_every_signal_fits_its_range(recording: Recording) -> None:
    database = cantools.database.load_file(recording.settings.can[0].dbc[0])
    seen = set()
    for message in database.messages:
        frames = [
            f for f in recording.frames if (f.can_id, f.extended) == (message.frame_id, message.is_extended_frame)
        ]
        seen.update(frames)
        assert message.cycle_time is not None
        assert len(frames) == pytest.approx(recording.duration_s / message.cycle_time * 1e3, abs=1)
        spacing = np.diff([frame.time_s for frame in frames])
        assert np.all(np.abs(spacing - message.cycle_time / 1e3) < 1.5e-3)
        for frame in frames:
            assert len(frame.data) == message.length
            for name, value in message.decode(frame.data, decode_choices=False).items():
                signal = message.get_signal_by_name(name)
                assert signal.minimum is None or value >= signal.minimum - 1e-9
                assert signal.maximum is None or value <= signal.maximum + 1e-9
    assert seen == set(recording.frames)
    times = [frame.time_s for frame in recording.frames]
    assert times == sorted(times)


def test_qualifiers_call_what_is_simulated_good() -> None:
    """Two that ask the same signal for other numbers get the one that is good for both."""
    wagon = settings("wagon")
    replace = msgspec.structs.replace
    forces = [
        replace(own, qualifier="BCU_state", qualifier_good=good)
        for own, good in zip(wagon.signals.pressing_force, [(1, 2), (2, 3)], strict=True)
    ]
    speed = replace(wagon.signals.speed, qualifier="fix")
    signals = replace(wagon.signals, speed=speed, pressing_force=tuple(forces))
    made = run(SHORT, replace(wagon, signals=signals), seed=5)
    assert set(decoded(made, "BCU", "BCU_state")[1]) == {2}
    assert set(decoded(made, "GNSS", "fix")[1]) == {1}


def test_counters_advance_by_one_and_show_what_was_lost() -> None:
    mapping = settings("wagon").signals.pressing_force[0]
    whole = run(SHORT, settings("wagon"), seed=5)
    counts = decoded(whole, mapping.message, mapping.counter)[1]
    assert set(np.diff(counts) % 16) == {1}
    lossy = run(SHORT, settings("wagon"), seed=5, modifiers=Modifiers(frame_loss=0.1))
    assert len(lossy.frames) == pytest.approx(0.9 * len(whole.frames), rel=0.05)
    assert set(lossy.frames) < set(whole.frames)
    steps_seen = np.diff(decoded(lossy, mapping.message, mapping.counter)[1]) % 16
    assert np.max(steps_seen) > 1


def test_a_pole_wheel_that_runs_out_tells_too_much_and_too_little_once_a_revolution() -> None:
    """And nothing else changes: not the truth, not what the other sensors say."""
    share = 0.01
    sound, uneven = (run(SHORT, settings("wagon"), seed=5, modifiers=Modifiers(run_out=r)) for r in (0.0, share))
    assert np.array_equal(sound.trace.values, uneven.trace.values)
    for message, signal in (("GNSS", "v_ground"), ("BCU", "p_A")):
        assert np.array_equal(decoded(sound, message, signal), decoded(uneven, message, signal))
    time_s, speed_kmh = decoded(sound, "WSP", "n_A")
    relative = decoded(uneven, "WSP", "n_A")[1] / speed_kmh - 1.0
    rolls = time_s < 1.0  # at 20 m/s
    turns = np.count_nonzero((relative[rolls][1:] > 0.0) & (relative[rolls][:-1] <= 0.0))
    assert turns == pytest.approx(20.0 / (2.0 * np.pi * sound.settings.vehicle.wheel_radius_m[0]), abs=1.0)
    assert np.max(np.abs(relative[rolls])) == pytest.approx(share, rel=0.05)
    assert np.mean(relative[rolls]) == pytest.approx(0.0, abs=0.1 * share)


def test_hydraulic_brakes_are_no_air_brakes_that_never_press() -> None:
    """Their springs alone take more than the pressure of air gives."""
    wagon = settings("wagon")
    forces = tuple(msgspec.structs.replace(own, scale=520.0, offset=-2080.0) for own in wagon.signals.pressing_force)
    hydraulic = msgspec.structs.replace(wagon, signals=msgspec.structs.replace(wagon.signals, pressing_force=forces))
    for gear, by_air in zip(brake_gears(hydraulic), brake_gears(wagon), strict=True):
        assert 0.3 * by_air.full_force_n < gear.full_force_n < 3.0 * by_air.full_force_n


def test_pages_of_a_multiplexed_message_take_turns() -> None:
    pages = decoded(run(SHORT, settings("wagon"), seed=5), "BCU_Status", "Status_page")[1]
    assert pages[:6].tolist() == [0, 1, 2, 0, 1, 2]


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others(tmp_path: Path) -> None:
    contents = []
    for name, seed in (("a", 1), ("b", 1), ("c", 2)):
        recording = run(SHORT, settings("wagon"), seed=seed)
        write_log(tmp_path / f"{name}.log", recording.frames)
        write_truth(tmp_path / f"{name}.csv", recording)
        contents.append((tmp_path.joinpath(f"{name}.log").read_bytes(), tmp_path.joinpath(f"{name}.csv").read_bytes()))
    assert contents[0] == contents[1]
    assert contents[0][0] != contents[2][0]
    assert contents[0][1] != contents[2][1]


def test_the_truth_file(recording: Recording, tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    write_truth(path, recording)
    with path.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    count = recording.trace.wheelset_count
    header = list(rows[0])
    assert header[:5] == ["time_s", "speed_mps", "adhesion", "saturated", "gradient"]
    assert header[-8:] == [
        f"omega_{count}_radps",
        f"slip_{count}",
        f"adhesion_{count}",
        f"friction_{count}",
        f"pressing_force_{count}_n",
        f"wsp_{count}",
        f"disc_temperature_{count}_c",
        f"motor_torque_{count}_nm",
    ]
    times = np.array([float(row["time_s"]) for row in rows])
    np.testing.assert_allclose(np.diff(times), 0.01, atol=2e-6)
    assert times[0] == EPOCH_S
    assert {row["saturated"] for row in rows} == {"0", "1"}
    wheels = [np.mean([float(row[f"adhesion_{i + 1}"]) for row in rows]) for i in range(count)]
    assert np.mean([float(row["adhesion"]) for row in rows]) == pytest.approx(np.mean(wheels), rel=0.01)


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf", ".trc", ".csv", ".log.gz"])
def test_every_log_format_reads_back_as_it_was(suffix: str, tmp_path: Path) -> None:
    frames = run(SHORT, settings("wagon"), seed=5).frames[:500]
    path = tmp_path / f"run{suffix}"
    write_log(path, frames)
    assert [p.name for p in tmp_path.iterdir()] == [path.name]
    with can.LogReader(path) as reader:
        read = list(reader)
    assert [(m.arbitration_id, m.is_extended_id, bytes(m.data)) for m in read] == [
        (f.can_id, f.extended, f.data) for f in frames
    ]
    spans = [message.timestamp - read[0].timestamp for message in read]
    np.testing.assert_allclose(spans, [f.time_s - frames[0].time_s for f in frames], atol=1e-3)


def test_a_name_may_have_dots(tmp_path: Path) -> None:
    frames = run(SHORT, settings("wagon"), seed=5).frames[:500]
    plain, packed = tmp_path / "run.log", tmp_path / "monday.v2.log.gz"
    write_log(plain, frames)
    write_log(packed, frames)
    assert gzip.decompress(packed.read_bytes()) == plain.read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.fixture(scope="module")
def sliding() -> Recording:
    """Something is due of it."""
    return run("wsp", settings("wagon"))


@pytest.mark.parametrize("name", ["run.log", "run.asc", "RUN.ASC", "run.asc.gz", "run.blf"])
def test_the_truth_has_the_times_of_its_log(
    name: str, sliding: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(simulate_command, "simulate", lambda *_: sliding)
    log, truth, due = tmp_path / name, tmp_path / "truth.csv", tmp_path / "due.jsonl"
    assert main(["simulate", "wsp", "-o", str(log), "--truth", str(truth), "--due", str(due)]) == 0
    times_s = [frame.time_s for frame in open_log(log, sliding.settings.can)]
    first_s = sliding.frames[0].time_s - EPOCH_S  # after the truth's first row
    with truth.open() as stream:
        assert float(next(csv.DictReader(stream))["time_s"]) == pytest.approx(times_s[0] - first_s, abs=1e-4)
    dues = [json.loads(line) for line in due.read_text().splitlines()]
    assert dues
    for one in dues:
        assert times_s[0] <= one["from_s"] < one["until_s"] <= times_s[-1] + AFTERMATH_S


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf", ".trc", ".mf4"])
def test_every_bus_reads_back_as_it_was(suffix: str, tmp_path: Path) -> None:
    if suffix == ".mf4":
        pytest.importorskip("asammdf")
    buses = tuple(CanBus("virtual", f"channel {name}", (), name) for name in ("rear", "front"))
    frames = run(SHORT, settings("wagon"), seed=5).frames[:200]
    frames = [frame._replace(bus="front" if frame.can_id == 0x1A0 else "rear") for frame in frames]
    path = tmp_path / f"run{suffix}"
    write_log(path, frames, buses)
    log = open_log(path, buses)
    assert [(f.bus, f.can_id, f.data) for f in log] == [(f.bus, f.can_id, f.data) for f in frames]
    assert log.remarks == ()


def test_what_does_not_name_its_buses_is_not_written_and_told_of_when_read(tmp_path: Path) -> None:
    buses = tuple(CanBus("virtual", name, (), name) for name in ("rear", "front"))
    with pytest.raises(InputError, match=r"run\.csv: \.csv does not say which of 2 buses a frame was on"):
        write_log(tmp_path / "run.csv", [], buses)
    assert not list(tmp_path.iterdir())
    write_log(tmp_path / "run.csv", run(SHORT, settings("wagon"), seed=5).frames[:10])
    log = open_log(tmp_path / "run.csv", buses)
    assert {frame.bus for frame in log} == {""}
    (remark,) = log.remarks
    assert "run.csv: it does not say which of 2 buses a frame was on" in remark


FD = Frame(1.1, "can0", 0x1A0, False, bytes(24))
ERROR = Frame(1.2, "can0", 0x88, False, bytes(8), FrameKind.ERROR)
BUS_IS_OFF = Frame(1.3, "can0", BUS_OFF, False, bytes(8), FrameKind.ERROR)


@pytest.mark.parametrize(("odd", "kind"), [(FD, "CAN FD frames"), (ERROR, "error frames")])
def test_what_a_format_would_lose_is_not_written(
    odd: Frame, kind: str, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    frames = [Frame(1.0, "can0", 0x1A0, False, b"\1"), odd]
    with pytest.raises(InputError, match=rf"run\.trc: \.trc is written without {kind}, and there are some; \.log"):
        write_log(tmp_path / "run.trc", frames)
    assert not list(tmp_path.iterdir())
    assert caplog.messages == []


@pytest.mark.parametrize("suffix", [".log", ".asc", ".blf", ".csv", ".mf4"])
def test_the_other_formats_hold_every_kind_of_frame(suffix: str, tmp_path: Path) -> None:
    if suffix == ".mf4":
        pytest.importorskip("asammdf")
    bus = CanBus("virtual", "can0", (), "can0")
    frames = [Frame(1.0, "can0", 0x1A0 | BUS_OFF, False, b"\1"), FD, ERROR]  # the bit says so of error frames alone
    write_log(tmp_path / f"run{suffix}", frames, [bus])
    read = list(open_log(tmp_path / f"run{suffix}", [bus]))
    assert [frame.kind for frame in read] == [frame.kind for frame in frames]
    assert [frame.data for frame in read[:2]] == [frame.data for frame in frames[:2]]


@pytest.mark.parametrize("suffix", [".log", ".log.gz", ".blf", ".csv", ".mf4"])
def test_an_error_frame_still_says_that_the_controller_is_off_the_bus(suffix: str, tmp_path: Path) -> None:
    if suffix == ".mf4":
        pytest.importorskip("asammdf")
    bus = CanBus("virtual", "can0", (), "can0")
    write_log(tmp_path / f"run{suffix}", [BUS_IS_OFF], [bus])
    (read,) = open_log(tmp_path / f"run{suffix}", [bus])
    assert (read.kind, read.can_id) == (FrameKind.ERROR, BUS_OFF)


def test_asc_does_not_hold_that_the_controller_is_off_the_bus(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.asc: \.asc is written without bus-off, and there is one; \.log"):
        write_log(tmp_path / "run.asc", [BUS_IS_OFF])
    assert not list(tmp_path.iterdir())


def test_a_log_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run\.xyz"):
        write_log(tmp_path / "run.xyz", [])
    with pytest.raises(WorkError, match="cannot be written"):
        write_log(tmp_path / "missing" / "run.log", [])
    assert not list(tmp_path.iterdir())


def test_a_missing_extra_is_told_of_before_anything_is_simulated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "asammdf", None)
    monkeypatch.setattr(simulate_command, "simulate", lambda *_: pytest.fail("it was simulated all the same"))
    assert main(["simulate", "leaf", "-o", str(tmp_path / "x.mf4")]) == 2
    sentence = f"{tmp_path / 'x.mf4'}: writing .mf4 needs the extra 'mf4': pip install '.[mf4]' in the checkout"
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("address", ["kvaser:0", "socketcand:x", "nosuch:0"])
def test_a_bus_that_cannot_be_opened_is_told_of_before_anything_is_simulated(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(simulate_command, "simulate", lambda *_: pytest.fail("it was simulated all the same"))
    assert main(["simulate", "dry", "--bus", address, "-o", str(tmp_path / "x.log")]) == 2
    (sentence,) = capsys.readouterr().err.splitlines()
    assert sentence.startswith(f"brake-monitor: --bus {address}: cannot be opened: ")
    assert not list(tmp_path.iterdir())


def test_what_python_can_says_beside_a_refusal_is_not_told(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """As it does of a bus that it could not set up, when it throws that away."""

    def half_open(**_: str) -> None:
        logging.getLogger("can.bus").warning("UdpMulticastBus was not properly shut down")
        raise OSError("no such group")

    monkeypatch.setattr(can, "Bus", half_open)
    assert main(["simulate", "dry", "--bus", "udp_multicast:192.0.2.1"]) == 2
    assert caplog.records == []


def test_a_machine_without_can_is_named_as_one(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def no_family(**_: str) -> None:
        raise OSError(errno.EAFNOSUPPORT, os.strerror(errno.EAFNOSUPPORT))

    monkeypatch.setattr(can, "Bus", no_family)
    assert main(["simulate", "dry", "--bus", "socketcan:can0"]) == 2
    assert "cannot be opened: this machine's kernel has no SocketCAN" in capsys.readouterr().err


def test_what_is_to_be_played_is_told_before(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    simulated = run(SHORT, settings("wagon"), seed=5)
    monkeypatch.setattr(simulate_command, "simulate", lambda *_: simulated)
    told: list[str] = []
    monkeypatch.setattr(simulate_command, "play", lambda *_: told.append(capsys.readouterr().out))
    assert main(["simulate", "dry", "--bus", "virtual:command-test"]) == 0
    (before,) = told
    assert before.startswith("dry: ")


def test_the_command_plays_onto_the_bus_what_it_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    simulated = run(SHORT, settings("wagon"), seed=5)
    monkeypatch.setattr(simulate_command, "simulate", lambda *_: simulated)
    log = tmp_path / "x.log"
    with can.Bus(interface="virtual", channel="command-test") as listener:
        assert main(["simulate", "dry", "--bus", "virtual:command-test", "--speed", "max", "-o", str(log)]) == 0
        heard = [listener.recv(0.0) for _ in simulated.frames]
    written = [(frame.can_id, frame.data) for frame in open_log(log, simulated.settings.can)]
    assert [(m.arbitration_id, bytes(m.data)) for m in heard if m] == written


def test_a_directory_in_the_place_of_a_log_is_named(tmp_path: Path) -> None:
    (tmp_path / "run.log").mkdir()
    with pytest.raises(WorkError, match=r"run\.log: cannot be written: it is a directory"):
        write_log(tmp_path / "run.log", [])


def test_an_interrupted_log_leaves_nothing_behind(tmp_path: Path) -> None:
    def interrupted() -> Iterator[Frame]:
        yield from run(SHORT, settings("wagon"), seed=5).frames[:10]
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_log(tmp_path / "run.log", interrupted())
    assert not list(tmp_path.iterdir())


def test_an_unknown_scenario_is_refused() -> None:
    with pytest.raises(InputError, match="'snow': expected one of wsp"):
        run("snow", settings("wagon"))


def test_playing_sends_every_frame_in_order() -> None:
    frames = run(SHORT, settings("wagon"), seed=5).frames[:50]
    with (
        can.Bus(interface="virtual", channel="simulator-test") as sender,
        can.Bus(interface="virtual", channel="simulator-test") as listener,
    ):
        play(frames, sender, speed=1000.0)
        heard = [listener.recv(1.0) for _ in frames]
    assert [(m.arbitration_id, bytes(m.data)) for m in heard if m] == [(f.can_id, f.data) for f in frames]


def test_the_brake_gear_follows_the_mapping_or_the_mass(recording: Recording) -> None:
    vehicle = recording.settings.vehicle
    for gear, mapping in zip(brake_gears(recording.settings), recording.settings.signals.pressing_force, strict=True):
        assert 1.0 < gear.full_force_n * vehicle.wheelset_count / vehicle.mass_kg < 8.0
        if mapping.scale != 1.0:
            assert (gear.force_per_bar_n, gear.offset_n) == (mapping.scale, mapping.offset)
        if mapping.max is not None:
            assert gear.full_force_n <= mapping.max * (1.0 + 1e-12)


def test_a_sensor_that_lags_shows_the_past() -> None:
    known = settings("wagon")
    forces = tuple(msgspec.structs.replace(mapping, delay_s=0.2) for mapping in known.signals.pressing_force)
    late = msgspec.structs.replace(known, signals=msgspec.structs.replace(known.signals, pressing_force=forces))
    mapping = known.signals.pressing_force[0]
    prompt_times, prompt = decoded(run(SHORT, known, seed=5), mapping.message, mapping.signal)
    late_times, lagging = decoded(run(SHORT, late, seed=5), mapping.message, mapping.signal)
    rises = [times[int(np.argmax(values > 1.0))] for times, values in ((prompt_times, prompt), (late_times, lagging))]
    assert rises[1] - rises[0] == pytest.approx(0.2, abs=0.02)


def test_a_mapping_to_a_signal_that_does_not_exist_is_refused() -> None:
    known = settings("wagon")
    wrong = msgspec.structs.replace(known.signals.speed, signal="v_grnd")
    unknown = msgspec.structs.replace(known, signals=msgspec.structs.replace(known.signals, speed=wrong))
    with pytest.raises(InputError, match="v_grnd"):
        run(SHORT, unknown).frames  # noqa: B018 - the frames are made when they are asked for


def with_dbc(folder: Path, old: str, new: str) -> Settings:
    """The wagon, with one line of its DBC another."""
    for suffix in (".toml", ".dbc"):
        shutil.copy(VEHICLES / f"wagon{suffix}", folder)
    text = (folder / "wagon.dbc").read_text()
    assert text.count(old) == 1
    (folder / "wagon.dbc").write_text(text.replace(old, new))
    return load_settings(folder / "wagon.toml")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("heading : 16|16@1+", "heading : 60|16@1+"),
        ("heading : 16|16@1+ (0.01,0)", "heading : 16|16@1+ (0,0)"),
        ("sand_level : 8|8@1+ (0.5,0)", f"sand_level : 8|8@1+ ({'9' * 400},0)"),
        ("sand_level : 8|8@1+", 'page M : 30|8@1+ (1,0) [0|2] "" Monitor\n SG_ sand_level m1 : 8|8@1+'),
        ('BA_DEF_ BO_ "GenMsgCycleTime" INT 0 60000;', 'BA_DEF_ BO_ "GenMsgCycleTime" STRING ;'),
        ("BCU_counter : 59|4@0+ (1,0) [0|15]", "BCU_counter : 59|4@0+ (1,0) [0|14]"),
        ("BCU_counter : 59|4@0+ (1,0) [0|15]", "BCU_counter : 59|4@0+ (1,1) [1|15]"),
        ("v_ground : 0|16@1+ (0.005,0) [0|150]", "v_ground : 0|16@1+ (0.005,0) [0.0|0.0]"),
        ("v_ground : 0|16@1+ (0.005,0) [0|150]", "v_ground : 0|16@1+ (0.005,0) [1|1]"),
    ],
)
def test_whatever_dbc_the_decoder_takes_is_simulated_and_decoded_to_the_truth(
    tmp_path: Path, old: str, new: str
) -> None:
    changed = with_dbc(tmp_path, old, new)
    decoder = SignalDecoder.from_settings(changed)
    recording = run(SHORT, changed, seed=5)
    samples = [sample for frame in recording.frames for sample in decoder.decode(frame)]
    assert {sample.quality for sample in samples} == {Quality.GOOD}
    speeds = [sample for sample in samples if sample.quantity is Quantity.SPEED]
    truth = truth_at(recording, recording.trace.wagon("speed_mps"), np.array([s.time_s - EPOCH_S for s in speeds]))
    np.testing.assert_allclose([sample.value for sample in speeds], truth, atol=0.15)
    assert decoder.counts.lost_frames == 0


def test_a_message_that_is_longer_than_a_frame_is_none(tmp_path: Path) -> None:
    recording = run(SHORT, with_dbc(tmp_path, "BO_ 673 GNSS_Position: 8", "BO_ 673 GNSS_Position: 65"), seed=5)
    assert {frame.can_id for frame in recording.frames} == {288, 416, 672, 800, 2566869040 - (1 << 31)}


FIELDS = [
    Signal("intel", 3, 11, "little_endian"),
    Signal("intel_signed", 17, 9, "little_endian", is_signed=True),
    Signal("motorola", 39, 13, "big_endian"),
    Signal("motorola_signed", 53, 5, "big_endian", is_signed=True),
    Signal("fraction", 56, 32, "little_endian", conversion=BaseConversion.factory(is_float=True)),
]


@given(
    st.tuples(
        st.integers(0, 2**11 - 1),
        st.integers(-(2**8), 2**8 - 1),
        st.integers(0, 2**13 - 1),
        st.integers(-(2**4), 2**4 - 1),
        st.floats(width=32, allow_nan=False),
    )
)
def test_bits_go_where_the_dbc_says(values: tuple[float, ...]) -> None:
    message = Message(1, "any", 16, FIELDS)
    payload = np.zeros((2, 16), dtype=np.uint8)
    for field, value in zip(FIELDS, values, strict=True):
        put(payload, signal_field(message, field.name), np.array([value, value]))
    expected = message.encode({field.name: value for field, value in zip(FIELDS, values, strict=True)}, scaling=False)
    assert [row.tobytes() for row in payload] == [expected, expected]
