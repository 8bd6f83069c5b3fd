"""`check` shows which frames were taken for what, so that a wrong guess cannot be missed."""

import re
import shutil
from collections.abc import Iterable
from math import ceil
from pathlib import Path

import numpy as np
import pytest

from brake_monitor.cli import main
from brake_monitor.host import extras

VEHICLES = Path(__file__).parents[2] / "dbc"
DATA = Path(__file__).parents[1] / "data"
GOLDEN = Path(__file__).parents[1] / "golden" / "slide.log.gz"


def check(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, list[str]]:
    """The exit code and the lines that were printed, with single spaces."""
    code = main(["check", "-c", *map(str, arguments)])
    return code, [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]


class Wagon:
    """The example wagon in a folder of its own, what its bus carried, and what is said of both."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self.capsys = folder, capsys
        self.config, self.log = folder / "wagon.toml", folder / "x.log"
        for name in ("wagon.toml", "wagon.dbc"):
            shutil.copy(VEHICLES / name, folder)

    def change(self, old: str, new: str) -> None:
        """One thing in its configuration or its DBC."""
        for name in ("wagon.toml", "wagon.dbc"):
            text = (self.folder / name).read_text()
            (self.folder / name).write_text(text.replace(old, new))

    def record(self, *frames: str) -> None:
        """A frame a second."""
        self.record_at(enumerate(frames))

    def record_at(self, frames: Iterable[tuple[float, str]]) -> None:
        """Frames with their times, s."""
        self.log.write_text("".join(f"({time_s:.6f}) can0 {frame}\n" for time_s, frame in sorted(frames)))

    def lines(self, code: int = 0) -> list[str]:
        """What is printed; it ends with this exit code, 1 where an essential signal is not in the recording."""
        got, lines = check(self.capsys, self.config, *[self.log] * self.log.exists())
        assert got == code
        return lines

    def remarks(self, code: int = 0) -> list[str]:
        return [line.removeprefix("remark: ") for line in self.lines(code) if line.startswith("remark: ")]


@pytest.fixture
def wagon(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Wagon:
    return Wagon(tmp_path, capsys)


def test_each_message_is_shown_with_the_frames_that_are_taken_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, VEHICLES / "bogie.toml")
    assert code == 0
    assert "wsp_active 1 WspState.wsp_1 - 0.10 s 0.000 s" in lines  # a flag is no measurement
    assert 'WheelSpeeds PGN 0xFF20, J1939: its VFrameFormat is "J1939PG"' in lines
    assert "BrakeLead id 0x08FF3021, J1939, but BrakeTrail has the same PGN" in lines
    _, lines = check(capsys, VEHICLES / "wagon.toml")
    assert "WSP id 0x1A0" in lines
    assert "Sander id 0x18FF5030" in lines


def test_a_long_name_stands_apart_from_what_follows_it(wagon: Wagon) -> None:
    name = "ActualVelocityOfEachOfAllWheelsets"  # a DBC may have names of any length
    wagon.change("WSP: 8", f"{name}: 8")
    wagon.change('"WSP"', f'"{name}"')
    lines = wagon.lines()
    assert f"{name} id 0x1A0" in lines
    assert f"axle_speed 1 {name}.n_A 0.0225 rad/s 0.10 s 0.000 s" in lines


def test_several_senders_under_one_pgn_are_remarked(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, DATA / "mini_j1939.toml", DATA / "mini_j1939.log")
    assert code == 0
    assert any(line.startswith("remark: VehicleSpeed came under 2 ids") for line in lines)
    assert any("0x0CFF0421, 0x18FF0400" in line for line in lines)


def test_a_pgn_that_came_from_another_sender_than_the_id_says_is_remarked(wagon: Wagon) -> None:
    wagon.record("0CFF5031#00000000")
    sentence = "Sander never came, but its PGN did, under 0x0CFF5031"
    assert any(told.startswith(sentence) for told in wagon.remarks(code=1))


def test_a_message_that_came_without_its_signals_did_come(wagon: Wagon) -> None:
    wagon.record("18FF5030#")
    assert not [told for told in wagon.remarks(code=1) if "never came" in told]


def test_a_number_of_the_other_width_is_remarked(wagon: Wagon) -> None:
    wagon.record("000001A0#00", "2A0#00", "18FF0000#00")
    (remark,) = wagon.remarks(code=1)
    assert "0x000001A0 is on the bus and not mapped, while the DBC gives WSP this number with 11 bits" in remark


def test_a_recorder_that_pads_its_ids_needs_no_configuration(wagon: Wagon) -> None:
    wagon.record("000001A0#E803E80300000000", "00000120#0000000000000000", "000002A0#D007000000000000")
    assert f"{wagon.log}: every id has eight digits and none is above 7FF: taken for 11-bit ids" in wagon.remarks()


N_A = 'signal = "n_A", unit = "km/h"'
V = 'signal = "v_ground", unit = "m/s"'
SCALED = "scale = 18600.0, offset = -4650.0, min = 0.0, noise_std"


@pytest.mark.parametrize(
    ("old", "new", "remarks"),
    [
        ("", "", []),
        (N_A, 'signal = "n_A"',
         ['signals.axle_speed[1]: the DBC has "n_A" in km/h, and without `unit` it is taken as']),
        (V, 'signal = "v_ground", unit = "km/h"',
         ['signals.speed: the DBC has "v_ground" in m/s, the mapping takes it as km/h']),
        ("p_A\", " + SCALED, "p_A\", noise_std",
         ['signals.pressing_force[1]: the DBC has "p_A" in bar, and without `unit` it']),
        ('[0|150] "m/s"', '[0|150] "mps"', []),
        ('[0|400] "km/h"', '[0|400] "Km/h"', []),
        ('[0|150] "m/s"', '[0|150] ""', []),
        ('(0.005,0) [0|150] "m/s"', '(0.005,0) [0|150] "kn"', ['signals.speed: the DBC has "v_ground" in kn']),
        ('[0|150] "m/s"', '[0|0] "m/s"', []),
        ('[0|150] "m/s"', '[150|0] "m/s"', ['signals.speed: the DBC gives "v_ground" the range [150|0], which holds']),
        ('[-90|90] "deg"', '[-90|90] ""', ['signals.latitude: neither the mapping nor the DBC names a unit']),
        ("brake_radius_m = 0.247", "brake_radius_m = 0.5", ["vehicle.brake_radius_m: 0.5 m is more than the wheel's"]),
        ("brake_radius_m = 0.247", "brake_radius_m = 0.44",
         ["vehicle.brake_radius_m: pads at the wheel's radius are blocks, whose friction rises as they slow down"]),
        ("wheel_radius_m = 0.445", "wheel_radius_m = 0.89",
         ["vehicle.wheel_radius_m: 0.89 m is more than railway wheels have; is it the diameter?"]),
        ("wheelset_inertia_kgm2 = 118.0", "wheelset_inertia_kgm2 = 11.8",
         ["vehicle.wheelset_inertia_kgm2: 11.8 kg m2 at this wheel radius stand for 60 kg of the 18000 kg on each"]),
        ("wheelset_inertia_kgm2 = 118.0", "wheelset_inertia_kgm2 = [118.0, 1180.0]",
         ["vehicle.wheelset_inertia_kgm2: 1180 kg m2 at this wheel radius stand for 5959 kg of the 18000 kg on each"]),
        (V, V + ", delay_s = 20", ["signals.speed.delay_s: 20 s is more than sensors lag; is it in milliseconds?"]),
        (N_A, N_A + ", timeout_s = 100",
         ["signals.axle_speed[1].timeout_s: for 100 s a value that is lost would count as good; is it in mill"]),
        ('signal = "p_B"', 'signal = "p_A"',
         ['signals.pressing_force[1] and signals.pressing_force[2] are both "p_A" of "BCU", which one cylinder']),
        ('signal = "n_B"', 'signal = "n_A"',
         ['signals.axle_speed[1] and signals.axle_speed[2] are both "n_A" of "WSP", which only coupled wheelsets']),
        ('"GNSS", signal = "v_ground", unit = "m/s"', '"WSP", signal = "n_B", unit = "km/h"',
         ['signals.speed and signals.axle_speed[2] are both "n_B" of "WSP", so that no slip is seen']),
        ('interface = "socketcan"', 'interface = "socketcn"', ['bus can0: python-can has no interface "socketcn"']),
        ('interface = "socketcan"', 'interface = "virtual"', []),
        ('interface = "socketcan"', 'interface = "pcan"', ["bus can0: nobody can tell whether pcan only listens"]),
        ('interface = "socketcan"', 'interface = "pcan"\nallow_active = true', []),
        ("[vehicle]", '[zenoh]\nlisten = ["tcp/0.0.0.0:7447"]\n[vehicle]',
         ["zenoh.listen: tcp/0.0.0.0:7447 lets everybody in who reaches it"]),
        ("[vehicle]", '[zenoh]\nlisten = ["tcp/[::1]:7447", "tcp/localhost:7448"]\n[vehicle]', []),
        ("[vehicle]", '[zenoh]\nconnect = ["tls/192.0.2.1:7447"]\n[vehicle]',
         ["zenoh: tls/192.0.2.1:7447 needs certificates, and there is no [zenoh.tls]"]),
    ],
)  # fmt: skip
def test_what_is_possible_but_not_likely_is_remarked(wagon: Wagon, old: str, new: str, remarks: list[str]) -> None:
    wagon.change(old, new)
    told = wagon.remarks()
    assert len(told) == len(remarks), told
    for line, start in zip(told, remarks, strict=True):
        assert line.startswith(start)


def test_blocks_whose_friction_may_follow_their_speed_are_not_remarked(wagon: Wagon) -> None:
    wagon.change("brake_radius_m = 0.247", "brake_radius_m = 0.44")
    wagon.change("[vehicle]", "[estimator.tuning]\nfriction = 1e-4\n[vehicle]")
    assert wagon.remarks() == []


def test_in_a_train_that_is_remarked(wagon: Wagon) -> None:
    wagon.change("brake_radius_m = 0.247", "brake_radius_m = 0.44")
    wagon.change('preset = "wagon"', 'preset = "train"')
    assert wagon.remarks() == []
    wagon.change("[vehicle]", "[estimator.tuning]\nfriction = 1e-4\n[vehicle]")
    (told,) = wagon.remarks()
    assert told.startswith("estimator.tuning.friction: what blocks need by themselves leaves hardly any friction valid")


def test_an_extra_that_the_daemon_will_want_is_remarked(wagon: Wagon, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(extras.PACKAGES, "metrics", "no_such_package")
    assert wagon.remarks() == []  # it wants none
    wagon.change("[vehicle]", "[metrics]\nport = 9464\n[vehicle]")
    (told,) = wagon.remarks()
    assert told.startswith("metrics.port: the daemon needs the extra 'metrics' for it: pip install")


def test_certificates_that_are_not_here_are_remarked(wagon: Wagon) -> None:
    """They may be on the gateway only; where the daemon runs it is the last chance to notice."""
    (wagon.folder / "ca.pem").touch()
    tls = '[zenoh]\nlisten = []\nconnect = ["tls/192.0.2.1:7447"]\n[zenoh.tls]\nroot_ca = "ca.pem"\n'
    wagon.change("[vehicle]", f'{tls}certificate = "wagon.pem"\nprivate_key = "wagon.key"\n[vehicle]')
    assert wagon.remarks() == [
        f"zenoh.tls.{name}: {wagon.folder / file} cannot be read here; where the daemon runs it must be"
        for name, file in (("certificate", "wagon.pem"), ("private_key", "wagon.key"))
    ]


def test_speeds_that_differ_by_their_unit_are_remarked(wagon: Wagon) -> None:
    """36 km/h at both wheelsets and 10 m/s of the wagon agree; taken as km/h and m/s, or as rad/s, they do not."""
    wagon.record(*wheels_turn("100E"), *brakes_have("0000"), *3 * ["2A0#D007000000000000"])
    assert wagon.remarks() == []
    wagon.change('signal = "v_ground", unit = "m/s"', 'signal = "v_ground", scale = 3.6')  # the DBC cannot tell
    told = wagon.remarks()
    assert len(told) == 2
    assert told[0] == (
        "axle_speed 1 turns its wheel at up to 10 m/s, speed goes up to 36 m/s: look at unit and scale of the two, "
        "and at vehicle.wheel_radius_m"
    )


@pytest.mark.parametrize(("scale", "is_remarked"), [(0.8, True), (0.92, False), (1.08, False), (1.2, True)])
def test_a_wheel_speed_is_held_against_the_vehicle_speed(wagon: Wagon, scale: float, is_remarked: bool) -> None:
    """A wheel may be worn by a tenth; more is a gear or a number of teeth that is wrong."""
    wagon.record(*wheels_turn("100E"), *brakes_have("0000"), *3 * ["2A0#D007000000000000"])
    wagon.change('signal = "n_A"', f'signal = "n_A", scale = {scale}')
    assert [remark.partition(" turns")[0] for remark in wagon.remarks()] == ["axle_speed 1"] * is_remarked


@pytest.mark.parametrize("in_the_tunnel", [None, 5.0])
def test_a_wagon_that_is_fastest_while_its_speed_is_away_or_repeats_itself_is_not_remarked(
    wagon: Wagon, in_the_tunnel: float | None
) -> None:
    """Five seconds at 5 m/s, then three in a tunnel at 10 m/s. A unit that is wrong shows all the time."""
    frames = []
    for k in range(80):
        time_s, speed_mps = k * 0.1, 5.0 if k < 50 else 10.0
        told_mps = speed_mps if k < 50 else in_the_tunnel
        turns = round(3.6 * speed_mps * 100).to_bytes(2, "little").hex()
        frames += [(time_s, f"1A0#{turns}{turns}000000{k % 16:02X}"), (time_s, brakes_have("0000", 1, k)[0])]
        frames += [] if told_mps is None else [(time_s, goes(told_mps))]
    wagon.record_at(frames)
    assert "turns its wheel at up to" not in "".join(wagon.remarks())
    wagon.change('signal = "v_ground", unit = "m/s"', 'signal = "v_ground", scale = 3.6')
    assert "".join(wagon.remarks()).count("turns its wheel at up to 10 m/s") == 2


def test_a_speed_that_is_always_0_while_the_others_are_not_is_remarked(wagon: Wagon) -> None:
    """As of a signal that the DBC has and nobody sends. Half a km/h, a crawl, says nothing."""
    wagon.record(*wheels_turn("100E"), *brakes_have("0000"), *3 * [goes(0.0)])
    assert wagon.remarks() == ["speed is always 0, while wheels turn at up to 10 m/s: is it the signal that is sent?"]
    wagon.record(*(f"1A0#0000100E0000{count:04X}" for count in range(3)), *brakes_have("0000"), *3 * [goes(10.0)])
    assert wagon.remarks() == [
        "axle_speed 1 is always 0, while speed goes up to 10 m/s: is it the signal that is sent, and does the wheelset "
        "turn?"
    ]
    for said in (goes(0.0), goes(10.0)):  # too few values to tell it from a sensor that begins
        wagon.record(*wheels_turn("100E"), *brakes_have("0000"), said)
        assert wagon.remarks() == []
    wagon.record(*wheels_turn("3200"), *brakes_have("0000"), *3 * [goes(0.0)])
    assert wagon.remarks() == []


CALIBRATION = "scale = 18600.0, offset = -4650.0, min = 0.0"
TWO_BAR, TWELVE_BAR = "03E8", "1770"


def brakes_have(pressure: str, times: int = 3, first: int = 0) -> list[str]:
    return [f"120#{pressure}{pressure}000000{(first + count) % 16:02X}" for count in range(times)]


def wheels_turn(speed: str) -> list[str]:
    return [f"1A0#{speed}{speed}000000{count:02X}" for count in range(3)]


def goes(speed_mps: float) -> str:
    return f"2A0#{round(speed_mps * 200).to_bytes(2, 'little').hex()}000000000000"


BRAKING = (  # 72 km/h, brakes off; then 2 bar for 20 s, and a standstill
    *(*wheels_turn("201C"), *brakes_have("0000"), *3 * ["2A0#A00F000000000000"]),
    *(*brakes_have(TWO_BAR, first=3), *(goes(16.0 - k) if k % 2 else "7FF#00" for k in range(16)), *3 * [goes(0.0)]),
)
SIXTY_TONNES = 3 * ["320#0000170200000000"]


def too_weak(forces: str) -> str:
    return (
        f"the vehicle slows down by up to 1 m/s², and the pressing forces meanwhile, up to {forces} m/s²: unless "
        'others did that, as a train does (preset = "train"), look at unit, scale (of all pads together) and the sign '
        "of it, and at offset, min, max and vehicle.mass_kg"
    )


@pytest.mark.parametrize(
    ("calibration", "remarks"),
    [
        (CALIBRATION, []),
        ("scale = 18600.0, offset = 4650.0, min = 0.0",
         [f"pressing_force {place} never falls below 4650 N while speed goes from 0 to 20 m/s: if its brake was "
          "ever released, look at its offset" for place in (1, 2)]),
        ("scale = 186.0, offset = -46.5, min = 0.0",
         ["no pressing_force goes beyond 326 N while speed goes from 0 to 20 m/s, and below estimator.contact_force_n, "
          "2000 N, no pad presses: if it braked, look at unit and scale"]),
        ("scale = -18600.0, offset = 0.0",
         ["no pressing_force goes beyond 0 N while speed goes from 0 to 20 m/s, and below estimator.contact_force_n, "
          "2000 N, no pad presses: if it braked, look at unit and scale"]),
        ("scale = -18600.0, offset = 0.0, min = 0.0",
         [too_weak("0 N, would do 0")]),
        ("scale = -18600.0, offset = 4650.0, min = 0.0", [too_weak("0 N, would do 0")]),
        ("scale = 4650.0, offset = -1162.5, min = 0.0", [too_weak("8140 N, would do 0.088")]),
        ("scale = 186000.0, offset = -46500.0, min = 0.0",
         ["pressing forces of up to 326000 N would brake 36000 kg by 3.5 m/s²: look at their unit and scale, and at "
          "vehicle.mass_kg"]),
    ],
    ids=["right", "offset", "too small", "wrong sign", "nothing left", "upside down", "one pad", "too large"],
)  # fmt: skip
def test_forces_that_no_brake_has_are_remarked(wagon: Wagon, calibration: str, remarks: list[str]) -> None:
    wagon.record(*BRAKING)
    wagon.change(CALIBRATION, calibration)
    assert wagon.remarks() == remarks


@pytest.mark.parametrize(("slowest_mps", "is_remarked"), [(9.0, True), (11.0, False)])
def test_only_who_has_slowed_down_by_10_mps_will_have_braked(
    wagon: Wagon, slowest_mps: float, is_remarked: bool
) -> None:
    """From 20 m/s, with 0.3 bar, which does not take the pads to the disc."""
    wagon.record(*wheels_turn("201C"), *brakes_have("0096"), *3 * [goes(20.0)], *3 * [goes(slowest_mps)])
    told = [remark for remark in wagon.remarks() if remark.startswith("no pressing_force goes beyond 930 N while")]
    assert bool(told) is is_remarked


def test_a_brake_that_never_presses_beside_another_is_remarked(wagon: Wagon) -> None:
    """2 bar are 32 550 N on the other wheelset."""
    wagon.record(*BRAKING)
    old = f'signal = "p_B", {CALIBRATION}'
    wagon.change(old, old.replace("scale = ", "scale = -"))
    assert wagon.remarks() == [
        "pressing_force 2 never goes beyond 0 N while another goes up to 32600 N: if its brake is not cut out, look "
        "at its scale and the sign of it, and at its offset, min and max"
    ]


@pytest.mark.parametrize("preset", ["wagon", "train"])
def test_a_train_may_brake_a_wagon_more_than_it_does_itself(wagon: Wagon, preset: str) -> None:
    wagon.record(*BRAKING)
    wagon.change(CALIBRATION, "scale = 4650.0, offset = -1162.5, min = 0.0")
    wagon.change('preset = "wagon"', f'preset = "{preset}"')
    assert bool(wagon.remarks()) is (preset == "wagon")


@pytest.mark.parametrize(("unit", "is_remarked"), [("kN", False), ("N", True)])
def test_a_load_that_no_such_wagon_has_is_remarked(wagon: Wagon, unit: str, is_remarked: bool) -> None:
    """The estimator would leave it out without a word."""
    wagon.record(*BRAKING, *SIXTY_TONNES)
    wagon.change('unit = "kN"', f'unit = "{unit}"')
    assert [told for told in wagon.remarks() if "load_force" in told] == is_remarked * [
        "load_force adds up to 60 kg, and is not used: beside vehicle.mass_kg, 36000, it is out of all proportion; "
        "look at its unit, scale and offset"
    ]


def test_who_never_brakes_needs_no_force(wagon: Wagon) -> None:
    """From 90 to 36 km/h, rolling out for 15 minutes, and from 36 to 72 km/h, pulled."""
    speeds_mps = [25.0 - 0.05 * k for k in range(301)] + [10.0 + 0.5 * k for k in range(21)]
    wagon.record(
        *(
            frame
            for k, speed_mps in enumerate(speeds_mps)
            for frame in (
                f"1A0#{2 * round(speed_mps * 360).to_bytes(2, 'little').hex()}000000{k % 16:02X}",
                f"120#00000000000000{k % 16:02X}",
                goes(speed_mps),
            )
        )
    )
    assert not [told for told in wagon.remarks() if "scale" in told]


@pytest.mark.parametrize("times", [1, 2, 3])
def test_a_spike_of_a_force_is_not_taken_for_what_the_brake_does(wagon: Wagon, times: int) -> None:
    """12 bar, once, twice, and as a brake that has them would."""
    wagon.record(*BRAKING, *brakes_have(TWELVE_BAR, times, first=6), *brakes_have(TWO_BAR, first=6 + times))
    told = [line.split(" N would")[0] for line in wagon.remarks()]
    assert told == ["pressing forces of up to 219000"] * (times > 2)


def test_a_loaded_wagon_is_judged_by_its_load(wagon: Wagon) -> None:
    """12 bar would be too much for 36 t, not for 60."""
    wagon.record(*BRAKING, *brakes_have(TWELVE_BAR, first=6), *SIXTY_TONNES)
    assert wagon.remarks() == []


def test_the_ranges_in_a_recording_have_units(wagon: Wagon) -> None:
    wagon.record("1A0#100E100E00000000", "120#0000000000000000", "2A0#D007000000000000")
    lines = wagon.lines()
    assert "speed 1 1 - 2.000 s 10 10 m/s - there only from 2 to 2 s" in lines
    assert "axle_speed 1 1 - 2.000 s 22.472 22.472 rad/s - there only from 0 to 0 s" in lines
    assert "sanding 1 0 - - - - -" in lines


def test_frames_of_another_width_are_not_of_a_message_for_its_number(wagon: Wagon) -> None:
    wagon.record("1A0#100E100E00000000", "00000120#0000000000000000", "120#0000000000000000")
    assert [line for line in wagon.lines(1) if line.startswith("can0 0x00000120")] == ["can0 0x00000120: 1"]


def test_a_good_recording_leaves_no_question(capsys: pytest.CaptureFixture[str]) -> None:
    """BCU_Status has its load on one of its three pages."""
    code, lines = check(capsys, VEHICLES / "wagon.toml", GOLDEN)
    assert code == 0
    assert re.fullmatch(r"can0 0x320: \d+, of BCU_Status without its mapped signals", lines[-2])
    assert lines[-1] == "nothing to remark in this recording"


def test_its_tables_fit_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    main(["check", "-c", str(VEHICLES / "wagon.toml"), str(GOLDEN)])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


def test_one_frame_of_one_id_is_not_several(wagon: Wagon) -> None:
    wagon.record("7FF#00")
    assert "1 frame of 1 id without a mapped value" in wagon.lines(code=1)


def test_frames_and_values_are_counted_apart(wagon: Wagon) -> None:
    """A frame carries several values: more good ones than frames look like a mistake in one row."""
    wagon.record(*BRAKING, "1A0#50C350C300000000", "120#00")
    (line,) = [line for line in wagon.lines() if line.startswith("x.log: ")]
    assert re.fullmatch(
        r"x.log: [\d.]+ s; frames \d+, mapped \d+, unmapped \d+, short frames 1; values: good \d+, out of range 2", line
    )


def test_a_list_that_is_cut_short_says_by_how_much(wagon: Wagon) -> None:
    wagon.record(*[f"7{i:02X}#00" for i in range(64)])
    lines = wagon.lines(code=1)
    shown = lines.index("64 frames of 64 ids without a mapped value")
    assert lines[shown + 10].startswith("can0 0x7")
    assert lines[shown + 11] == "and 54 more"
    wagon.record(*[f"7{i:02X}#00" for i in range(10)])
    assert not [line for line in wagon.lines(code=1) if line.endswith("more")]


def test_a_force_of_zero_has_no_sign(wagon: Wagon) -> None:
    wagon.record(*brakes_have("0000"))
    wagon.change(CALIBRATION, "scale = -18600.0")
    assert "pressing_force 1 3 1000.0 ms 1.000 s 0 0 N -" in wagon.lines(code=1)


def test_gaps_count_from_the_beginning_of_a_recording_and_to_its_end(wagon: Wagon) -> None:
    """Wheel speeds every 20 ms for 40 s; a vehicle speed every 0.1 s, but only from 25 to 35 s of them."""
    frames = [(k * 0.02, f"1A0#100E100E000000{k % 16:02X}") for k in range(2001)]
    frames += [(25.0 + k * 0.1, "2A0#D007000000000000") for k in range(101)]
    wagon.record_at(frames)
    lines = wagon.lines(code=1)
    assert "speed 1 101 100.0 ms 25.000 s 10 10 m/s - there only from 25 to 35 s" in lines
    assert "axle_speed 1 2001 20.0 ms 0.020 s 22.472 22.472 rad/s -" in lines
    assert "pressing_force 1 0 - - - - N -" in lines


def test_a_recording_that_runs_backwards_has_periods_all_the_same(wagon: Wagon) -> None:
    """Wheel speeds every 20 ms, and one that was lost."""
    frames = [f"({k * 0.02:.6f}) can0 1A0#100E100E000000{k % 16:02X}\n" for k in range(200) if k != 100]
    wagon.log.write_text("".join(reversed(frames)))
    assert any(line.startswith("axle_speed 1 199 20.0 ms 0.040 s ") for line in wagon.lines(code=1))


SLOW_WHEELS = (
    "axle_speed 1, 2: a value comes every {} ms, and jumps of adhesion in a slide are then read as friction; map "
    "speeds that come every 20 ms if there are any"
)
SLOW_FORCES = (
    "pressing_force 1, 2: a value comes every {} ms, and in slides friction is then held and adhesion up to three "
    "times as uncertain; map forces that come every 10 to 20 ms if there are any"
)
LOST = "{} 1, 2: a value comes every 100 ms, and counts as lost {} ms after it came: timeout_s should be about 0.5"
LOST_FORCES = LOST.format("pressing_force", 50)
LOST_WHEELS = [LOST.format("axle_speed", 100), LOST.format("wsp_active", 100)]


@pytest.mark.parametrize(
    ("wheels_ms", "forces_ms", "remarks"),
    [
        (20, 10, []),
        (50, 20, []),
        (100, 10, [SLOW_WHEELS.format(100), *LOST_WHEELS]),
        (20, 30, []),
        (20, 40, [SLOW_FORCES.format(40)]),
        (67, 100, [SLOW_WHEELS.format(67), SLOW_FORCES.format(100), LOST_FORCES]),
    ],
)
def test_sensors_that_come_too_seldom_are_remarked(
    wagon: Wagon, wheels_ms: int, forces_ms: int, remarks: list[str]
) -> None:
    """36 km/h and no brake for ten seconds, with some jitter and a gap."""
    messages = (("1A0#100E100E000000", wheels_ms), ("120#00000000000000", forces_ms))
    wagon.record_at(
        ((place * period_ms + (place % 5 == 0) + 3000 * (place > 50)) / 1000, f"{data}{place % 16:02X}")
        for data, period_ms in messages
        for place in range(10_000 // period_ms)
    )
    assert wagon.remarks(code=1) == remarks


BUNCHES = (
    "{}: values come in bunches, every {} ms, as a gateway hands on what it has gathered, and are taken as measured "
    "when they come; map them where they come one by one"
)
BUNCHES_OF_100 = [
    BUNCHES.format("axle_speed 1, 2", 100),
    BUNCHES.format("pressing_force 1, 2", 100),
    LOST_WHEELS[0],
    LOST_FORCES,
    LOST_WHEELS[1],
]


@pytest.mark.parametrize(
    ("every_ms", "lost", "remarks"),
    [
        (20, (), []),
        (40, (), [BUNCHES.format("pressing_force 1, 2", 40)]),  # two of the wheel speeds are soon enough
        (100, (), BUNCHES_OF_100),
        (100, range(300, 600), BUNCHES_OF_100),
        (1, range(100, 900), []),  # the bus was off for most of the time
    ],
)
def test_values_that_come_in_bunches_are_remarked(
    wagon: Wagon, every_ms: int, lost: Iterable[int], remarks: list[str]
) -> None:
    """Wheel speeds are measured every 20 ms and pressures every 10, and all that there are handed on at once."""
    wagon.record_at(
        ((ceil(10 * tick / every_ms) * every_ms + 0.01 * (tick % 10)) / 1000, f"{data}{count % 16:02X}")
        for data, step in (("1A0#100E100E000000", 2), ("120#00000000000000", 1))
        for count, tick in enumerate(range(0, 1000, step))
        if tick not in lost
    )
    told = [remark for remark in wagon.remarks(code=1) if "counter" not in remark]
    short = [remark for remark in told if "in batches about every 20 ms" in remark]
    assert len(short) == (every_ms == 20)
    assert told == short + remarks


def test_values_that_come_as_they_change_are_no_bunches(wagon: Wagon) -> None:
    """A pressure that is told every 5 s while the brake is off, every 60 ms as it leaks, and every 10 as it moves."""
    tell_s = [*range(0, 60, 5), *np.arange(60.0, 63.0, 0.01), *np.arange(63.0, 65.0, 0.06), *range(65, 125, 5)]
    told = [(float(at_s), f"120#00000000000000{count % 16:02X}") for count, at_s in enumerate(tell_s)]
    wheels = [(0.02 * count, f"1A0#100E100E000000{count % 16:02X}") for count in range(6000)]
    wagon.record_at([*told, *wheels])
    lost = (
        "pressing_force 1, 2: a value comes every 5000 ms, and counts as lost 50 ms after it came: timeout_s should be"
    )
    assert wagon.remarks(code=1) == [f"{lost} about 25"]


@pytest.mark.parametrize(
    ("counts", "share"),
    [
        (range(100), None),
        ([count for count in range(125) if count % 5], None),  # a fifth was lost
        ([*range(80), *[80] * 20], None),  # its sender froze
        ([0] * 100, "99%"),  # of the first one nothing is known
        ([k // 2 for k in range(100)], "50%"),  # everything is there twice
        ([0, 1] * 50, "49%"),
    ],
    ids=["good", "frames lost", "frozen at last", "standing", "twice", "a bit"],
)
def test_a_counter_that_does_not_count_is_remarked(wagon: Wagon, counts: Iterable[int], share: str | None) -> None:
    """36 km/h every 20 ms, in frames that count so."""
    wagon.record_at((0.02 * k, f"1A0#100E100E000000{count % 16:02X}") for k, count in enumerate(counts))
    assert wagon.remarks(code=1) == [
        f"WSP.WSP_counter does not advance as a counter does in {share} of its frames, which are not used: is it one, "
        "and is every frame here once?"
    ] * (share is not None)


@pytest.mark.parametrize(
    ("endpoint", "said"),
    [
        ("router:7447", "[zenoh] connect 'router:7447': expected <protocol>/<host>:<port>"),
        ("tcp/router:7447?;#key=secret", "[zenoh] connect 'tcp/router:7447': expected ?<name>=<value>"),
    ],
)
def test_an_endpoint_that_zenoh_would_not_take_is_found(wagon: Wagon, endpoint: str, said: str) -> None:
    wagon.change("[vehicle]", f'[zenoh]\nconnect = ["{endpoint}"]\n[vehicle]')
    assert main(["check", "-c", str(wagon.config)]) == 2
    told = wagon.capsys.readouterr().err
    assert said in told
    assert "secret" not in told


V_GROUND = 'signal = "v_ground", unit = "m/s", noise_std = 0.02'


@pytest.mark.parametrize(("lag_s", "told_s", "said"), [
    (0.0, 0.5, "earlier than the axle speeds: its delay_s should be about 0 (leave it out), not 0.5"),
    (0.0, 2.0, "earlier than the axle speeds: its delay_s should be about 0 (leave it out), not 2"),
    (0.5, 0.0, "later than the axle speeds: its delay_s should be about 0."),
    (0.5, 0.5, ""),
])  # fmt: skip
def test_a_delay_that_is_told_wrongly_is_remarked(wagon: Wagon, lag_s: float, told_s: float, said: str) -> None:
    """The simulator's sensors lag as its configuration says."""
    wagon.change(V_GROUND, f"{V_GROUND}, delay_s = {lag_s}")
    assert main(["simulate", "dry", "-c", str(wagon.config), "-o", str(wagon.log)]) == 0
    wagon.change(f"delay_s = {lag_s}", f"delay_s = {told_s}")
    told = [line for line in wagon.lines() if "delay_s should be" in line]
    assert len(told) == bool(said)
    assert all(said in line for line in told)


CYLINDER = "noise_std = 100.0"


def test_a_force_that_is_said_to_come_late_and_does_not_is_remarked(wagon: Wagon) -> None:
    assert main(["simulate", "leaf", "-o", str(wagon.log)]) == 0
    wagon.change(CYLINDER, f"{CYLINDER}, delay_s = 0.06")
    late = [line.split(", as slides show: ")[1] for line in wagon.remarks() if "delay_s" in line]
    assert late == [f"of pressing_force {i} the delay_s should be about 0 (leave it out), not 0.06" for i in (1, 2)]


def test_a_qualifier_is_shown_with_its_signal_and_with_how_many_values_it_rejected(wagon: Wagon) -> None:
    wagon.change('signal = "v_ground"', 'signal = "v_ground", qualifier = "fix", qualifier_good = [3, 2]')
    used = [line for line in wagon.lines() if "used while" in line]
    assert len(used) == 1
    assert used[0].startswith("speed 1 GNSS.v_ground")
    assert used[0].endswith("used while fix is 2 or 3")
    fixes = [f"2A0#D0070000{fix}000000" for fix in ("02", "00", "01", "03")]
    wagon.record(*wheels_turn("100E"), *brakes_have("0000"), *fixes, "2A0#FFFF000000000000")
    speed = next(line for line in wagon.lines() if line.startswith("speed 1 5 "))
    assert "not_available 3, 3 of them by fix" in speed
    assert not any("qualifier_good" in remark for remark in wagon.remarks())
    wagon.record(*wheels_turn("100E"), *brakes_have("0000"), *["2A0#D007000000000000"] * 30)
    remark = next(remark for remark in wagon.remarks(code=1) if "qualifier_good" in remark)
    assert "GNSS.v_ground was never believed, as fix is 2 or 3 in none of 30 frames with it" in remark
