from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.errors import InputError
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings

VEHICLES = Path(__file__).parents[2] / "dbc"

GOOD = """\
[vehicle]
id = "wagon-1"
mass_kg = 36000.0
axle_positions_m = [4.5, -4.5]
cog_height_m = 1.6
wheelset_inertia_kgm2 = 118.0
wheel_radius_m = [0.445, 0.440]
brake_radius_m = 0.247

[can]
interface = "virtual"
channel = "one"
dbc = ["sub/wagon.dbc"]

[signals]
speed = { message = "GNSS", signal = "v", unit = "km/h" }
axle_speed = [
  { message = "WSP", signal = "n_A", unit = "rpm" },
  { message = "WSP", signal = "n_B", unit = "rpm" },
]
pressing_force = [{ message = "BCU", signal = "p_A" }, { message = "BCU", signal = "p_B" }]
"""


N_B = 'signal = "n_B", '  # a piece of GOOD,
N_B_AT = "19: signals.axle_speed[2]."  # and where it stands
VEHICLE, REST = "brake_radius_m = 0.247", "[can]"  # pieces of GOOD, in lines 8 and 10


def load(tmp_path: Path, text: str) -> Settings:
    path = tmp_path / "config.toml"
    path.write_text(text, encoding="utf-8")
    return load_settings(path)


def refusal(tmp_path: Path, text: str) -> str:
    """The sentence, without the path of the file."""
    with pytest.raises(InputError) as caught:
        load(tmp_path, text)
    sentence = str(caught.value)
    assert "\n" not in sentence
    start = f"{tmp_path / 'config.toml'}:"
    assert sentence.startswith(start)
    return sentence.removeprefix(start)


def test_brakes_have_the_size_that_their_forces_have_by_the_same_signal(tmp_path: Path) -> None:
    """Three discs and two, one of them told in kN, and with its sign turned round."""
    more = GOOD.replace('signal = "p_A"', 'signal = "p_A", scale = 27900.0')
    text = more.replace('signal = "p_B"', 'signal = "p_B", unit = "kN", scale = -18.6')
    assert load(tmp_path, text).brake_forces == pytest.approx((1.2, 0.8))
    assert load(tmp_path, GOOD).brake_forces == (1.0, 1.0)
    kilopascals = more.replace('signal = "p_B"', 'signal = "p_B", scale = 186.0')
    assert load(tmp_path, kilopascals).brake_forces == (1.0, 1.0)


def test_brakes_whose_forces_are_mapped_have_the_size_that_the_vehicle_tells(tmp_path: Path) -> None:
    """Motor wheelsets with half the discs: the bus tells newtons, so that all signals have the same scale."""
    told = GOOD.replace("[vehicle]", "[vehicle]\nfull_pressing_force_n = [60000.0, 30000.0]")
    assert load(tmp_path, told).brake_forces == pytest.approx((4 / 3, 2 / 3))


@pytest.mark.parametrize(("name", "wheelsets"), [("rig", 1), ("wagon", 2), ("bogie", 4)])
def test_example_vehicles_load(name: str, wheelsets: int) -> None:
    settings = load_settings(VEHICLES / f"{name}.toml")
    vehicle = settings.vehicle
    assert vehicle.wheelset_count == wheelsets
    assert len(vehicle.wheel_radius_m) == len(vehicle.brake_radius_m) == wheelsets
    assert len(settings.signals.axle_speed) == len(settings.signals.pressing_force) == wheelsets
    assert sum(vehicle.axle_positions_m) == pytest.approx(0.0)  # the weight is shared evenly at rest
    assert all(dbc.is_absolute() and dbc.is_file() for bus in settings.can for dbc in bus.dbc)


def test_loading_completes_what_was_left_out(tmp_path: Path) -> None:
    settings = load(tmp_path, GOOD)
    assert settings.path == tmp_path / "config.toml"
    assert settings.vehicle.wheelset_inertia_kgm2 == (118.0, 118.0)
    assert settings.vehicle.wheel_radius_m == (0.445, 0.440)
    assert settings.can[0].name == "one"
    assert settings.can[0].dbc == (tmp_path / "sub" / "wagon.dbc",)
    assert settings.signals.speed.bus == "one"
    assert {mapping.bus for mapping in settings.signals.axle_speed} == {"one"}
    assert settings.signals.sanding is None


def test_relative_paths_are_relative_to_the_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "etc").mkdir()
    (tmp_path / "etc" / "config.toml").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    assert load_settings(Path("etc/config.toml")).can[0].dbc == (tmp_path / "etc" / "sub" / "wagon.dbc",)


def two_buses(front: str = 'name = "front"', bus: str = 'bus = "rear", ') -> str:
    head, signals = GOOD.partition("[can]")[0], GOOD.partition("[signals]")[2]
    tables = f"""[[can]]
interface = "virtual"
channel = "a"
dbc = ["a.dbc"]
{front}

[[can]]
interface = "virtual"
channel = "b"
dbc = ["b.dbc"]
name = "rear"

[signals]"""
    return head + tables + signals.replace("{ message", "{ " + bus + "message")


def test_several_buses(tmp_path: Path) -> None:
    settings = load(tmp_path, two_buses())
    assert [bus.name for bus in settings.can] == ["front", "rear"]
    assert settings.signals.speed.bus == "rear"
    assert refusal(tmp_path, two_buses(front="")).startswith("10: can[1].name: this key is missing")
    assert "signals.speed.bus: this key is missing" in refusal(tmp_path, two_buses(bus=""))
    assert 'no bus is named "raer", did you mean "rear"?' in refusal(tmp_path, two_buses(bus='bus = "raer", '))
    assert refusal(tmp_path, two_buses(front='name = "rear"')).startswith("20: can[2].name: two buses are named")


def test_a_table_below_one_of_several_is_named_with_its_line(tmp_path: Path) -> None:
    below = two_buses().replace("[signals]", "[can.more]\n[signals]")
    assert refusal(tmp_path, below).startswith("22: can[2].more: unknown key")


def test_two_buses_are_two_interfaces(tmp_path: Path) -> None:
    same = two_buses().replace('channel = "b"', 'channel = "a"')
    sentence = "18: can[2].channel: another bus is virtual a, too: one table takes the DBC files of both"
    assert refusal(tmp_path, same).startswith(sentence)
    other = same.replace('interface = "virtual"', 'interface = "socketcan"', 1)
    assert [bus.channel for bus in load(tmp_path, other).can] == ["a", "a"]


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        (
            "front bus",
            '14: can[1].name: expected ASCII characters without blanks, as recordings name the bus, got "',
        ),
        ("Süd", "14: can[1].name: expected ASCII characters without blanks"),
        ("b", 'can[1].name: "b" is the channel of another bus'),
    ],
)
def test_a_bus_has_a_name_that_recordings_can_tell(tmp_path: Path, name: str, sentence: str) -> None:
    assert sentence in refusal(tmp_path, two_buses(front=f'name = "{name}"'))


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("[alarms.uneven_braking]\nclear_margin = 0.25", "clear_margin: expected less than warning = 0.2, got 0.25"),
        ("[alarms.friction_out_of_band]\nclear_margin = 0.15", "clear_margin: expected less than warning = 0.15"),
        ("[alarms.friction_drift]\nclear_margin = 0.2", "clear_margin: expected less than limit = 0.15, got 0.2"),
        ("[alarms.hot_disc]\nclear_margin_k = 400", "clear_margin_k: expected warning_c - clear_margin_k to be more"),
        (
            "[alarms.pad_near_limit]\nmargin_mm = 31",
            "clear_margin_mm: expected that new pads of 35 mm, as in [w",
        ),
        ("[alarms.pad_at_limit]\nclear_margin_mm = 30", "clear_margin_mm: expected that new pads of 35 mm, as in [w"),
        ("[wear]\nnew_pad_thickness_mm = 8.4", "clear it, which takes more than 8.5 mm: pad_limit_mm and the margins"),
        ("[output]\nrate_hz = 1e308", "output.rate_hz: expected a number not greater than 10000, got 1e+308"),
        ("[wear]\nambient_c = -70", "wear.ambient_c: expected a number not less than -60, got -70"),
        ("[wear]\ndisc_mass_kg = 1e-320", "wear.disc_mass_kg: expected a number not less than 0.001"),
        ("[wear]\ndisc_cooling_per_speed_wpk = 1e308", "disc_cooling_per_speed_wpk: expected a number not greater"),
        ("[wear]\nnew_pad_thickness_mm = 1e300", "new_pad_thickness_mm: expected a number not greater than 1000"),
        ("[wear]\npad_area_cm2 = 1e-300", "wear.pad_area_cm2: expected a number not less than 0.001, got 1e-300"),
        ("[wear]\narchard_mm3_per_nm = 1e300", "wear.archard_mm3_per_nm: expected a number not greater than 1, got"),
        ("[alarms.low_adhesion]\ndebounce_s = 1e300", "debounce_s: expected a number not greater than 86400, got 1e"),
        ("[alarms.slide]\nclear_s = 1e9", "slide.clear_s: expected a number not greater than 86400, got 1"),
    ],
)
def test_an_alarm_that_nothing_would_clear_is_refused(tmp_path: Path, table: str, sentence: str) -> None:
    assert sentence in refusal(tmp_path, f"{GOOD}\n{table}\n")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("mass_kg = 36000.0", "mass_kg = -3", "3: vehicle.mass_kg: expected a number greater than 0, got -3"),
        ("mass_kg = 36000.0", "mass_kg = 0", "3: vehicle.mass_kg: expected a number greater than 0, got 0"),
        ("mass_kg = 36000.0", "mass_kg = nan", "3: vehicle.mass_kg: expected a finite number, got nan"),
        ("mass_kg = 36000.0", "mass_kg = inf", "3: vehicle.mass_kg: expected a finite number, got inf"),
        ("mass_kg = 36000.0", 'mass_kg = "36 t"', '3: vehicle.mass_kg: expected a number greater than 0, got "36'),
        ("mass_kg = 36000.0", "mass_kg = true", "3: vehicle.mass_kg: expected a number greater than 0, got true"),
        ("mass_kg = 36000.0", "mass_kg = " + "9" * 400,
         "3: vehicle.mass_kg: expected a finite number, got a number of more than 40 digits"),
        ("mass_kg = 36000.0", "mass_kg = 0x" + "f" * 5000,
         "3: vehicle.mass_kg: expected a finite number, got a number of more than 40 digits"),
        ("mass_kg = 36000.0", "mass_kg = " + "1" * 5000, "3: expected numbers of 4300 digits at the most"),
        ("[4.5, -4.5]", f"[4.5,\n-{'1_1' * 2500}]", "5: expected numbers of 4300 digits at the most"),
        ("mass_kg = 36000.0", "mas_kg = 36000.0", '3: vehicle.mas_kg: unknown key, did you mean "mass_kg"?'),
        ("mass_kg = 36000.0", "", "1: vehicle.mass_kg: this key is missing"),
        (GOOD[: GOOD.index(REST)], "", "1: vehicle: this key is missing"),
        ("[4.5, -4.5]", "[]", "4: vehicle.axle_positions_m: expected one number per wheelset, got an empty list"),
        ("[4.5, -4.5]", str([*range(33)]), "4: vehicle.axle_positions_m: expected 32 wheelsets at the most, got 33"),
        ("[4.5, -4.5]", "[4.5, nan]", "4: vehicle.axle_positions_m[2]: expected a finite number, got nan"),
        ("[4.5, -4.5]", "[4.5, 4.5]", "4: vehicle.axle_positions_m: expected wheelsets that stand farther apart than"),
        ("[4.5, -4.5]", "[0.2, -0.2]", "4: vehicle.axle_positions_m: expected wheelsets that stand farther apart than"),
        ("[4.5, -4.5]", "4.5", "4: vehicle.axle_positions_m: expected a list, got 4.5"),
        ("[0.445, 0.440]", "[0.445]", "7: vehicle.wheel_radius_m: expected a number or a list of 2 (one per wheelset)"),
        ("[0.445, 0.440]", '"0.445"', '7: vehicle.wheel_radius_m: expected a number or a list of 2 (one p'),
        ("m2 = 118.0", "m2 = true", "6: vehicle.wheelset_inertia_kgm2: expected a number or a list of 2 (one per"),
        ("m2 = 118.0", "m2 = -1.0", "6: vehicle.wheelset_inertia_kgm2: expected a number greater than 0, got -1"),
        ('id = "wagon-1"', 'id = ""', "2: vehicle.id: a part of the Zenoh key is empty"),
        ('id = "wagon-1"', f'id = "{101 * "w"}"', "2: vehicle.id: a part of the Zenoh key has more than 100 char"),
        ('id = "wagon-1"', 'id = "a/b"', '2: vehicle.id: "/" cannot stand in a Zenoh key'),
        ('id = "wagon-1"', 'id = "a b"', '2: vehicle.id: " " cannot stand in a Zenoh key'),
        ('id = "wagon-1"', 'id = "a*"', '2: vehicle.id: "*" cannot stand in a Zenoh key'),
        ('id = "wagon-1"', 'id = "@a"', '2: vehicle.id: a part of the Zenoh key begins with "@"'),
        ('id = "wagon-1"', 'id = "a\\u200bb"', '2: vehicle.id: "\\u200b" is not printed, and cannot stand'),
        ('dbc = ["sub/wagon.dbc"]', "dbc = []", "13: can.dbc: expected at least one DBC file, got an empty list"),
        ('dbc = ["sub/wagon.dbc"]', "dbc = [3]", "13: can.dbc[1]: expected a string, got 3"),
        ("sub/wagon.dbc", "", "13: can.dbc[1]: expected a name, got an empty string"),
        ("[signals]", '[store]\ndirectory = ""\n[signals]', "16: store.directory: expected a name, got an empty str"),
        ("[signals]", '[store]\ndirectory = "config.toml"\n[signals]', "16: store.directory: expected a directory, "),
        ("sub/wagon.dbc", r"sub\u0000.dbc", "13: can.dbc[1]: expected text without the character NUL"),
        ('channel = "one"', "", "10: can.channel: this key is missing"),
        ('channel = "one"', 'chanel = "one"', '12: can.chanel: unknown key, did you mean "channel"?'),
        ('channel = "one"', 'channel = ""', "12: can.channel: expected a name, got an empty string"),
        ('  { message = "WSP", signal = "n_B", unit = "rpm" },\n', "", "17: signals.axle_speed: expected a list of 2"),
        (N_B + 'unit = "rpm"', N_B + 'unit = "knots"', N_B_AT + "unit: expected one"),
        ('[signals]', '[signals]\nsanding = { message = "WSP", signal = "s", unit = "%" }',
         '16: signals.sanding.unit: expected none, as a flag has none, got "%"'),
        ('[signals]', '[signals]\nload_force = [{ message = "WSP", signal = "s", unit = "bar" }]',
         '16: signals.load_force[1].unit: expected one of "N", "kN" (scale and offset make a force of a pressure)'),
        (N_B, N_B + 'scael = 3, ', N_B_AT + 'scael: unknown key, did you mean "s'),
        (N_B, N_B + 'scale = 0, ', N_B_AT + "scale: expected a number other"),
        (N_B, N_B + 'min = 2, max = 1, ', N_B_AT + "min: 2 is greater than max"),
        (N_B, N_B + 'min = 2, max = 2, ', N_B_AT + "min: 2 is max, too: a speed that is always the same tells noth"),
        ("[signals]", '[signals]\nlatitude = { message = "WSP", signal = "a" }',
         "16: signals.latitude: expected longitude beside it, as a place has both"),
        ("[signals]", '[signals]\nlongitude = { message = "WSP", signal = "a" }',
         "16: signals.longitude: expected latitude beside it, as a place has both"),
        (N_B, N_B + 'match = "PGN", ', N_B_AT + 'match: expected one of "id",'),
        (N_B, N_B + 'timeout_s = 0, ', N_B_AT + "timeout_s: expected a number"),
        (N_B, N_B + 'bus = "two", ', N_B_AT + 'bus: no bus is named "two"'),
        (N_B, N_B + 'qualifier = 1, ', N_B_AT + "qualifier: expected a string, got 1"),
        (N_B, N_B + 'qualifier = "q", qualifier_good = 1, ', N_B_AT + "qualifier_good: expected a list, got 1"),
        (N_B, N_B + 'qualifier = "q", qualifier_good = [], ', N_B_AT + "qualifier_good: expected at least one num"),
        (N_B, N_B + 'qualifier = "q", qualifier_good = [1, 1.5], ',
         N_B_AT + "qualifier_good[2]: expected a whole number, got 1.5"),
        (N_B, N_B + 'qualifier = "q", qualifier_good = [true], ',
         N_B_AT + "qualifier_good[1]: expected a whole number, got true"),
        (N_B, N_B + 'qualifier_good = [1], ', N_B_AT + "qualifier_good: expected the key qualifier beside it"),
        ("[signals]", "[signal]", '15: signal: unknown key, did you mean "signals"?'),
        ("[signals]", 'path = "x"\n[signals]', '15: can.path: unknown key'),
        ("[vehicle]\n", 'path = "x"\n[vehicle]\n', "1: path: unknown key"),
        ("[vehicle]\n", "vehicle = 3\n[estimator]\n", "1: vehicle: expected a table, got 3"),
        ("[can]", "[zenoh]\nprefix = \"brake/**\"\n[can]", '11: zenoh.prefix: "*" cannot stand in a Zenoh key'),
        ("[can]", "[alarm.low_adhesion]\n[can]", '10: alarm: unknown key, did you mean "alarms"?'),
        ("[can]", "[[estimator.tuning]]\n[can]", "10: estimator.tuning: expected a table, got a list"),
        ("[can]", "[[wears.x]]\n[can]", '10: wears: unknown key, did you mean "wear"?'),
        ("[can]", "[zenoh]\nprefix = \"\"\n[can]", "11: zenoh.prefix: a part of the Zenoh key is empty"),
        ("[can]", "[zenoh]\nprefix = \"/brake\"\n[can]", "11: zenoh.prefix: a part of the Zenoh key is empty"),
        ("[can]", "[zenoh]\nprefix = \"brake//v1\"\n[can]", "11: zenoh.prefix: a part of the Zenoh key is empty"),
        ("[can]", "[alarms.low_adhesion]\nlow = 0.01\n[can]", "10: alarms.low_adhesion: expected low > very_low"),
        ("[can]", "[zenoh]\nenabled = false\n[metrics]\nport = 9464\n[can]", "13: metrics.port: expected 0 with"),
        ("[can]", "[estimator]\npreset = \"waggon\"\n[can]", '11: estimator.preset: expected one of "rig", "train"'),
        ("[signals]", '[[can]]\nname = "b"\n[signals]', "15: not valid TOML: [[can]] stands twice, once without [["),
        ("[can]", "[estimator\n[can]", "10: not valid TOML: "),
        ("[can]", "[vehicle]\n[can]", "10: not valid TOML: "),
        ('"rpm" },\n]', '"rpm" },\n', "21: not valid TOML: "),
        # values in another unit, or out of order
        ("mass_kg = 36000.0", "mass_kg = 36.0", "3: vehicle.mass_kg: expected a mass that fits"),  # tonnes
        ("mass_kg = 36000.0", "mass_kg = 3.6e7", "3: vehicle.mass_kg: expected a number not greater than 1e+07, got 3"),
        ("[4.5, -4.5]", "[4500, -4500]", "4: vehicle.axle_positions_m[1]: expected a number not greater than 500"),
        ("[4.5, -4.5]", "[9.0, 0.0]", "4: vehicle.axle_positions_m[1]: no weight rests on this wheelset: expected"),
        ("[4.5, -4.5]", "[0.0, -9.0]", "4: vehicle.axle_positions_m[2]: no weight rests on this wheelset: expected p"),
        (VEHICLE, VEHICLE + "\npivot_height_m = 0.9", "9: vehicle.pivot_height_m: expected wheelsets_per_bogie = 2 or"),
        (VEHICLE, VEHICLE + "\nfull_pressing_force_n = [3e4]", "9: vehicle.full_pressing_force_n: expected a list of"),
        (VEHICLE, VEHICLE + "\nwheelsets_per_bogie = 0", "9: vehicle.wheelsets_per_bogie: expected a whole number not"),
        (
            VEHICLE,
            VEHICLE + "\nwheelsets_per_bogie = 2",
            "9: vehicle.wheelsets_per_bogie: expected 2 wheelsets to make two or more such bogies",
        ),
        ("height_m = 1.6", "height_m = 1600", "5: vehicle.cog_height_m: expected a number not greater than 10, got 16"),
        ("m2 = 118.0", "m2 = 1e30", "6: vehicle.wheelset_inertia_kgm2: expected a number not greater than 100000"),
        ("m2 = 118.0", "m2 = 1e-30", "6: vehicle.wheelset_inertia_kgm2: expected more: "),
        ("m2 = 118.0", "m2 = 0.118", "6: vehicle.wheelset_inertia_kgm2: expected more: "),  # t m2
        ("[0.445, 0.440]", "[0.445, 440]", "7: vehicle.wheel_radius_m[2]: expected a number not greater than 2, got 4"),
        ("[0.445, 0.440]", "1e-300", "7: vehicle.wheel_radius_m: expected a number not less than 0.001, got 1e-300"),
        (REST, "[estimator.tuning]\nadhesion_std = 1e300\n[can]", "11: estimator.tuning.adhesion_std: expected a numb"),
        ("[0.445, 0.440]", "44.5", "7: vehicle.wheel_radius_m: expected a number not greater than 2, got 44.5"),  # cm
        (VEHICLE, "brake_radius_m = 1e-300", "8: vehicle.brake_radius_m: expected a number not less than 0.001"),
        (VEHICLE, "brake_radius_m = 247", "8: vehicle.brake_radius_m: expected a number not greater than 5, got 247"),
        (VEHICLE, VEHICLE + "\ntrack_resistance_n = 1e30", "9: vehicle.track_resistance_n: expected a number not gr"),
        (VEHICLE, VEHICLE + "\ndrag_n_per_mps2 = 1e30", "9: vehicle.drag_n_per_mps2: expected a number not greater"),
        (N_B, N_B + "noise_std = 1e300, ", N_B_AT + "noise_std: expected a number not greater than 1e+12, got 1e+300"),
        (N_B, N_B + "scale = 1e300, ", N_B_AT + "scale: expected a number not greater than 1e+12, got 1e+300"),
        (N_B, N_B + "scale = -1e300, ", N_B_AT + "scale: expected a number not less than -1e+12, got -1e+300"),
        (N_B, N_B + "offset = 1e300, ", N_B_AT + "offset: expected a number not greater than 1e+12, got 1e+300"),
        (N_B, N_B + "min = 1e306, ", N_B_AT + "min: expected a number not greater than 1e+12, got 1e+306"),
        (N_B, N_B + "max = -1e306, ", N_B_AT + "max: expected a number not less than -1e+12, got -1e+306"),
        (N_B, N_B + "timeout_s = 1e300, ", N_B_AT + "timeout_s: expected a number not greater than 86400, got 1e+300"),
        (N_B, N_B + "delay_s = 100, ", N_B_AT + "delay_s: expected a number not greater than 30, got 100"),
        (N_B, N_B + "delay_s = -0.01, ", N_B_AT + "delay_s: expected a number not less than 0, got -0.01"),
        (REST, "[estimator]\nfriction_nominal = 0.61\n[can]", "11: estimator.friction_nominal: expected a number not "),
        (REST, "[wear]\npad_limit_mm = 40\n[can]", "11: wear.pad_limit_mm: expected less than new_pad_thickness_mm"),
        (REST, "[wear]\nnew_pad_thickness_mm = 4\n[can]", "10: wear.pad_limit_mm: expected less than new_pad_thick"),
        (
            REST,
            "[wear]\nleast_specific_wear_cm3_per_mj = 2\n[can]",
            "11: wear.least_specific_wear_cm3_per_mj: expected no more than specific_wear_cm3_per_mj = 0.2, got 2",
        ),
        (
            REST,
            "[wear]\nspecific_wear_cm3_per_mj = 2\n[can]",
            "11: wear.specific_wear_cm3_per_mj: expected no more than greatest_specific_wear_cm3_per_mj = 1, got 2",
        ),
        (
            REST,
            "[alarms.hot_disc]\nwarning_c = 600\n[can]",
            "11: alarms.hot_disc.warning_c: expected no more than alarm_c = 500, got 600",
        ),
        (
            REST,
            "[alarms.friction_out_of_band]\nalarm = 0.1\n[can]",
            "10: alarms.friction_out_of_band.warning: expected no more than alarm = 0.1, got 0.15",
        ),
        (REST, "[alarms.uneven_braking]\nwarning = 0.5\n[can]", "11: alarms.uneven_braking.warning: expected no more"),
        (REST, "[alarms.uneven_braking]\nwarning = 20\n[can]", "11: alarms.uneven_braking.warning: expected a number"),
        (REST, "[alarms.slide]\nmin_distance_m = 20\n[can]", "11: alarms.slide.min_distance_m: expected no more than "),
        (REST, "[alarms.slide]\nflat_likely_m = 5\n[can]", "10: alarms.slide.flat_possible_m: expected no more than f"),
        (REST, "[alarms.friction_drift]\nmin_stops = 25\n[can]", "11: alarms.friction_drift.min_stops: expected no mo"),
        (REST, "[alarms.low_adhesion]\nlow = 10\n[can]", "11: alarms.low_adhesion.low: expected a number not greater"),
        (REST, "[alarms.bus_silent]\nsilent_s = 1e6\n[can]", "11: alarms.bus_silent.silent_s: expected a number not "),
        (REST, "[alarms.bus_fault]\nwindow_s = 1e6\n[can]", "11: alarms.bus_fault.window_s: expected a number not g"),
        (REST, "[alarms.dragging_brake]\nalone_s = 1e6\n[can]", "11: alarms.dragging_brake.alone_s: expected a numb"),
        (REST, "[alarms.dragging_brake]\nmin_force_n = 1e9\n[can]", "11: alarms.dragging_brake.min_force_n: expected "),
        (REST, "[alarms.dragging_brake]\nhidden_force_n = 1e9\n[can]", "11: alarms.dragging_brake.hidden_force_n: ex"),
        (REST, "[alarms.brake_not_applied]\nothers_force_n = 1e9\n[can]", "11: alarms.brake_not_applied.others_force"),
        *(
            (REST, f"[alarms.{kind}]\nmin_speed_mps = 1389\n[can]", f"11: alarms.{kind}.min_speed_mps: expected a num")
            for kind in ("low_adhesion", "wheelset_not_rotating", "dragging_brake", "brake_not_applied")
        ),  # mm/s
        (REST, "[alarms.slide]\nflat_likely_m = 1e6\n[can]", "11: alarms.slide.flat_likely_m: expected a number not g"),
        (REST, "[alarms.hot_disc]\nalarm_c = 4000\n[can]", "11: alarms.hot_disc.alarm_c: expected a number not gr"),
        (REST, "[alarms.bus_fault]\nerror_frames = 1000000\n[can]", "11: alarms.bus_fault.error_frames: expected a"),
        (REST, "[alarms.input_lost]\nlosses_per_minute = 9999\n[can]", "11: alarms.input_lost.losses_per_minute: "),
        *(
            (REST, f"[alarms.{kind}]\nmin_energy_j = 1e12\n[can]", f"11: alarms.{kind}.min_energy_j: expected a num")
            for kind in ("uneven_braking", "friction_out_of_band", "friction_drift")
        ),
        (
            REST,
            "[store]\nevidence_before_s = 600\n[can]",
            "11: store.evidence_before_s: expected no more than 450 s together with evidence_after_s = 10, got 600",
        ),
        (REST, "[store]\nevidence_after_s = 331\n[can]", "10: store.evidence_before_s: expected no more than 450 s to"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_its_place(tmp_path: Path, old: str, new: str, sentence: str) -> None:
    assert old in GOOD
    assert refusal(tmp_path, GOOD.replace(old, new)).startswith(sentence)


def test_a_wheelset_without_a_brake_or_motor_may_be_told_of_by_a_signal_that_is_held(tmp_path: Path) -> None:
    old = 'signal = "p_B" '
    assert old in GOOD
    mapping = load(tmp_path, GOOD.replace(old, 'signal = "p_B", min = 0.0, max = 0.0 ')).signals.pressing_force[1]
    assert (mapping.min, mapping.max) == (0.0, 0.0)


MOTOR = 'wheel_torque = [{ message = "T", signal = "M_A" }, '  # of the first wheelset


def test_a_wheelset_without_a_motor_needs_no_signal_for_one(tmp_path: Path) -> None:
    signals = load(tmp_path, GOOD + MOTOR + '"none"]').signals
    assert signals.wheel_torque[1] == "none"
    torques = [(place, mapping.signal) for name, place, mapping in signals.mapped() if name == "wheel_torque"]
    assert torques == [(0, "M_A")]


@pytest.mark.parametrize("other", ['"nothing"', "0", "[]"])
def test_a_motor_is_a_signal_or_none(tmp_path: Path, other: str) -> None:
    sentence = refusal(tmp_path, f"{GOOD}{MOTOR}{other}]")
    assert sentence.startswith('22: signals.wheel_torque[2]: expected a table or "none", got ')


def test_only_a_motor_can_be_missing(tmp_path: Path) -> None:
    new = GOOD.replace('{ message = "BCU", signal = "p_B" }', '"none"')
    assert "expected a table, got" in refusal(tmp_path, new)


# mass, inertia of a wheelset, its wheel and brake radius: published orders of magnitude, not measurements
VEHICLES_OF_ALL_KINDS = {
    "hand trolley": (250.0, 3.0, 0.2, 0.2),
    "tram, its discs on geared shafts": (18_000.0, 60.0, 0.3, 0.9),
    "underframe of a wagon for 800 t": (830_000.0, 160.0, 0.46, 0.25),
    "steam engine": (120_000.0, 4000.0, 1.15, 1.15),
    "electric locomotive with geared motors": (84_000.0, 2500.0, 0.625, 0.3),
    "rig at a scale of one to ten": (20.0, 1.2e-3, 0.046, 0.025),
    "rig with a flywheel": (12_000.0, 1300.0, 0.46, 0.25),
}


@pytest.mark.parametrize("kind", VEHICLES_OF_ALL_KINDS)
def test_every_kind_of_vehicle_is_taken(tmp_path: Path, kind: str) -> None:
    mass_kg, inertia_kgm2, wheel_radius_m, brake_radius_m = VEHICLES_OF_ALL_KINDS[kind]
    text = GOOD.replace("36000.0", f"{mass_kg}").replace("118.0", f"{inertia_kgm2}")
    text = text.replace("[0.445, 0.440]", f"{wheel_radius_m}").replace("0.247", f"{brake_radius_m}")
    assert load(tmp_path, text).vehicle.brake_radius_m == (brake_radius_m, brake_radius_m)


@pytest.mark.parametrize("delay_s", [0.0, 0.005, 30.0])
def test_a_sensor_may_lag_by_milliseconds_and_up_to_half_a_minute(tmp_path: Path, delay_s: float) -> None:
    late = load(tmp_path, GOOD.replace(N_B, f"{N_B}delay_s = {delay_s}, "))
    assert [signal.delay_s for signal in late.signals.axle_speed] == [0.0, delay_s]


def test_an_id_may_have_a_hundred_characters(tmp_path: Path) -> None:
    assert load(tmp_path, GOOD.replace("wagon-1", 100 * "w")).vehicle.id == 100 * "w"


def load_bogies(tmp_path: Path, positions_m: str, pivot_height_m: float) -> tuple[float, ...]:
    """The places of the wheelsets of the example wagon, whose centre of gravity is 1.9 m high, its bogies told."""
    text = (VEHICLES / "bogie.toml").read_text().replace('"bogie.dbc"', f'"{VEHICLES / "bogie.dbc"}"')
    assert "[9.5, 7.0, -7.0, -9.5]\n" in text
    told = f"{positions_m}\nwheelsets_per_bogie = 2\npivot_height_m = {pivot_height_m}\n"
    return load(tmp_path, text.replace("[9.5, 7.0, -7.0, -9.5]\n", told)).vehicle.axle_positions_m


@pytest.mark.parametrize(
    ("positions_m", "pivot_height_m"),
    [
        ("[9.5, 7.0, -7.0, -9.5]", 1.9),
        ("[-9.5, -7.0, 7.0, 9.5]", 0.9),
        ("[18.0, 15.5, 1.0, -1.5]", 0.9),  # of the last bogie a little bears: its middle is behind the centre
    ],
)
def test_bogies_stand_one_behind_the_other(tmp_path: Path, positions_m: str, pivot_height_m: float) -> None:
    assert str(list(load_bogies(tmp_path, positions_m, pivot_height_m))) == positions_m


@pytest.mark.parametrize(
    ("positions_m", "pivot_height_m", "sentence"),
    [
        ("[9.5, -7.0, 7.0, -9.5]", 0.9, "axle_positions_m: with bogies, expected places in order along the vehicle"),
        ("[9.5, 7.0, -7.0, -9.5]", 0.0, "pivot_height_m: bogies need the height of their pivots above the rail"),
        ("[9.5, 7.0, -7.0, -9.5]", 1.95, "pivot_height_m: bogies need the height of their pivots above the rail, at"),
        ("[1.0, -1.5, -15.5, -18.0]", 0.9, "axle_positions_m[3]: no weight rests on this wheelset"),
    ],
)
def test_what_no_bogies_are_is_refused(tmp_path: Path, positions_m: str, pivot_height_m: float, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        load_bogies(tmp_path, positions_m, pivot_height_m)
    assert f": vehicle.{sentence}" in str(caught.value)


def test_files_that_are_no_configuration(tmp_path: Path) -> None:
    garbage = tmp_path / "garbage.toml"
    garbage.write_bytes(bytes(range(256)))
    empty = tmp_path / "empty.toml"
    empty.write_bytes(b"")
    for path, part in [
        (tmp_path / "none.toml", "No such file"),
        (tmp_path, "Is a directory"),
        (garbage, "not text in UTF-8"),
        (empty, "vehicle: this key is missing"),
    ]:
        with pytest.raises(InputError, match=part) as caught:
            load_settings(path)
        assert str(caught.value).startswith(str(path))


@given(st.integers(0, len(GOOD) - 1), st.text(max_size=3), st.integers(0, 3))
def test_a_damaged_file_raises_nothing_but_input_errors(
    tmp_path_factory: pytest.TempPathFactory, start: int, new: str, removed: int
) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.toml"
    path.write_bytes((GOOD[:start] + new + GOOD[start + removed :]).encode("utf-8", "surrogatepass"))
    with suppress(InputError):
        assert load_settings(path).vehicle.wheelset_count >= 1
