"""The command as its users meet it, with all that can be wrong: one sentence, an exit code, nothing left behind."""

import contextlib
import gzip
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any

import pytest

from brake_monitor.cli import COMMANDS, main

VEHICLES = Path(__file__).parents[2] / "dbc"
ALONE = ("env",)  # what goes before a command that needs a process of its own
LONGEST_S = 180.0  # of any command here, on the busiest machine

LOG = """\
(1700000000.000000) can0 1A0#E803E80300000000
(1700000000.010000) can0 120#0000000000000000
(1700000000.020000) can0 2A0#D007000000000000
(1700000000.030000) can0 1A0#E803E80300000001
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A working directory with a good configuration, its DBC file and a good recording."""
    for suffix in (".toml", ".dbc"):
        shutil.copy(VEHICLES / f"wagon{suffix}", tmp_path)
    (tmp_path / "good.log").write_text(LOG)
    return tmp_path


def brake_monitor(folder: Path, arguments: Sequence[str], before: Sequence[str] = ()) -> tuple[int, str]:
    """Run the command; its exit code and what it wrote on standard error."""
    command = [*before, sys.executable, "-m", "brake_monitor", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LONGEST_S, check=False)
    assert "Traceback" not in done.stdout + done.stderr
    return done.returncode, done.stderr


def in_this_process(folder: Path, arguments: Sequence[str]) -> tuple[int, str]:
    """The same, where nothing depends on the process: its start takes longer than what is refused."""
    with contextlib.chdir(folder), redirect_stdout(StringIO()), redirect_stderr(StringIO()) as errors:
        try:
            code = main(arguments)
        except SystemExit as end:  # argparse's way
            code = end.code if isinstance(end.code, int) else 1
    return code, errors.getvalue()


def assert_refused(folder: Path, arguments: str, *parts: str, code: int = 2, before: Sequence[str] = ()) -> None:
    """One line that holds the parts, the exit code, and no file that was not there before."""
    files = sorted(folder.rglob("*"))
    if before or arguments.startswith("run"):  # the daemon takes over what its process logs
        got_code, errors = brake_monitor(folder, arguments.split(), before)
    else:
        got_code, errors = in_this_process(folder, arguments.split())
    lines = errors.splitlines()
    assert len(lines) == 1, errors
    assert lines[0].startswith("brake-monitor: ")
    assert all(part in lines[0] for part in parts), errors
    assert got_code == code
    assert sorted(folder.rglob("*")) == files


def edit(folder: Path, old: str, new: str) -> int:
    """Change the configuration in one place, and return its line."""
    path = folder / "wagon.toml"
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    return text[: text.index(old)].count("\n") + 1


def test_what_the_others_spoil_is_good(folder: Path) -> None:
    assert brake_monitor(folder, ["replay", "-c", "wagon.toml", "good.log", "-o", "out.csv"]) == (0, "")
    assert (folder / "out.csv").read_text().startswith("time_s,speed_mps,adhesion,")


# --- recordings ---


def write_garbage(path: Path) -> None:
    path.write_bytes(bytes(range(256)) * 20)


@pytest.mark.parametrize(
    ("name", "spoil", "parts"),
    [
        ("none.log", lambda path: None, ("none.log: cannot be read: No such file or directory",)),
        ("empty.log", Path.touch, ("empty.log: is empty",)),
        (
            "head.blf",
            lambda path: path.write_bytes(b"LOGG"),
            ("head.blf: damaged, or not a .blf file: it ends in the",),
        ),
        (
            "table.csv",
            lambda path: path.write_text("time,speed\n1.0,2.0\n"),
            ("table.csv:2: damaged, or not a .csv file: expected timestamp, arbitration_id, extended,",),
        ),
        ("garbage.log", write_garbage, ("garbage.log:1: not a line of candump's log format",)),
        ("garbage.blf", write_garbage, ("garbage.blf: damaged, or not a .blf file",)),
        ("garbage.log.gz", write_garbage, ("garbage.log.gz: cannot be read: Not a gzipped file",)),
        ("cut.log", lambda path: path.write_text(LOG[:-20] + "\n"), ("cut.log:4: not a line of candump's log format",)),
        ("folder.log", Path.mkdir, ("folder.log: cannot be read: Is a directory",)),
        ("notes.txt", Path.touch, ("notes.txt: unknown kind of log, expected one of .log, .asc",)),
    ],
)
def test_a_recording_that_is_none(
    folder: Path, name: str, spoil: Callable[[Path], object], parts: tuple[str, ...]
) -> None:
    spoil(folder / name)
    assert_refused(folder, f"replay -c wagon.toml {name} -o out.csv", *parts)


@pytest.mark.parametrize("command", ["replay", "report -o x.html"])
def test_a_recording_whose_recorder_lost_power_is_played(folder: Path, command: str) -> None:
    (folder / "cut.log").write_text(LOG[:-20])
    arguments = [*command.split(), "-c", "wagon.toml", "cut.log"]
    assert in_this_process(folder, arguments) == (0, "remark: cut.log:4: the last line is cut off: left out\n")


@pytest.mark.parametrize("command", ["replay", "report -o x.html", "check"])
def test_a_packed_recording_that_is_cut_off_is_played_up_to_there(folder: Path, command: str) -> None:
    (folder / "cut.log.gz").write_bytes(gzip.compress(LOG.encode())[:-8])
    code, told = in_this_process(folder, [*command.split(), "-c", "wagon.toml", "cut.log.gz"])
    assert code == 0
    assert told == ("" if command == "check" else "remark: cut.log.gz: is cut off: read up to there\n")


@pytest.mark.parametrize("content", [None, "[", '{"nosuch": 3}'])
def test_a_zenoh_configuration_that_is_none(folder: Path, content: str | None) -> None:
    if content is not None:
        (folder / "zenoh.json5").write_text(content)
    _, errors = brake_monitor(folder, ["watch", "--zenoh-config", "zenoh.json5"])
    fault = "cannot be read" if content is None else "not a Zenoh configuration"
    assert_refused(folder, "watch --zenoh-config zenoh.json5", f"zenoh.json5: {fault}: ")
    assert ".rs:" not in errors  # where in its source Zenoh says so


def test_a_zenoh_configuration_whose_certificates_are_elsewhere(folder: Path) -> None:
    """As where the shipped example is not started beside `pki`."""
    shutil.copy(VEHICLES.parent / "docs" / "security" / "dashboard.json5", folder / "zenoh.json5")
    sentence = "zenoh.json5: root_ca_certificate: pki/ca.pem cannot be read here: No such file or directory"
    assert_refused(folder, "watch --zenoh-config zenoh.json5", sentence)
    (folder / "pki").mkdir()
    for name in ("ca.pem", "dashboard.pem"):
        (folder / "pki" / name).touch()
    sentence = "zenoh.json5: connect_private_key: pki/dashboard.key cannot be read here: No such file or directory"
    assert_refused(folder, "dashboard --zenoh-config zenoh.json5", sentence)


def test_a_recording_that_may_not_be_read(folder: Path) -> None:
    (folder / "good.log").chmod(0)
    # root may read everything, unless it gives up its capabilities
    before = ["setpriv", "--bounding-set=-all", "--inh-caps=-all"] if os.geteuid() == 0 else []
    assert_refused(
        folder, "replay -c wagon.toml good.log", "good.log: cannot be read: Permission denied", before=before
    )


def test_a_recording_that_is_damaged_far_behind_leaves_no_table(folder: Path) -> None:
    (folder / "long.log").write_text(LOG * 2000 + "(1700000001.0) can0 1A0#0\n")
    assert_refused(folder, "replay -c wagon.toml long.log -o out.csv", "long.log:8001: not a line")


# --- configuration and DBC ---


@pytest.mark.parametrize("command", ["check -c wagon.toml", "run -c wagon.toml", "replay -c wagon.toml good.log"])
def test_every_command_checks_the_configuration(folder: Path, command: str) -> None:
    line = edit(folder, "mass_kg = 36000.0", "mass_kg = -36000.0")
    where = f"wagon.toml:{line}: vehicle.mass_kg: "
    assert_refused(folder, command, where, "expected a number greater than 0, got -36000")


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("mass_kg = 36000.0", "mass_kg = nan", "vehicle.mass_kg: expected a finite number, got nan"),
        ("mass_kg = 36000.0", "mas_kg = 36000.0", 'vehicle.mas_kg: unknown key, did you mean "mass_kg"?'),
        ("mass_kg = 36000.0", "mass_kg = ", "not valid TOML"),
        ("mass_kg = 36000.0", "mass_kg = 36000,0", "not valid TOML: expected a decimal point, not a comma"),
        ("mass_kg = 36000.0", 'mass_kg = "thirty-six', "not valid TOML: a text in quotes does not end on its line"),
        ('id = "wagon-8127"', "id = wagon-8127", "not valid TOML: expected a number, true, false, or a text in quotes"),
        ('preset = "wagon"', "preset = True", "not valid TOML: expected a number, true, false, or a text in quotes"),
    ],
)
def test_a_wrong_key_is_named_with_its_line(folder: Path, old: str, new: str, sentence: str) -> None:
    line = edit(folder, old, new)
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: {sentence}")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('preset = "wagon"', f'preset = "{"x" * 3000}"'),
        ('preset = "wagon"', f'preset = "{"wagon, " * 500}"'),
        ('signal = "v_ground"', f'signal = "{"x" * 3000}"'),
        ("mass_kg = 36000.0", f"mass_kg = 36000.0\n{'x' * 3000} = 3"),
    ],
    ids=["a word", "many words", "a name", "a key"],
)
def test_what_is_long_is_not_repeated_whole(folder: Path, old: str, new: str) -> None:
    config = folder / "wagon.toml"
    config.write_text(config.read_text().replace(old, new))
    code, error = in_this_process(folder, ["check", "-c", "wagon.toml"])
    assert code == 2
    assert 100 < len(error) < 500


def test_a_long_option_is_not_repeated_whole(folder: Path) -> None:
    code, error = in_this_process(folder, ["simulate", "wsp", "--seed", "9" * 3000 + "x"])
    assert code == 2
    assert 100 < len(error) < 500


def test_a_name_that_a_terminal_would_obey_is_told_as_it_is_written(folder: Path) -> None:
    config = folder / "wagon.toml"
    config.write_text(config.read_text().replace('message = "GNSS",', 'message = "G\\nS\\u001b[31mü",'))
    code, error = brake_monitor(folder, ["check", "-c", "wagon.toml"])
    assert code == 2
    assert r"G\nS\x1b[31mü" in error
    assert error.count("\n") == 1


def test_the_nearest_name_is_the_one_that_differs_in_its_letters_size_only(folder: Path) -> None:
    """n_a is n_A, and not the other wheelset's n_B, which is as near by its letters."""
    edit(folder, 'signal = "n_A"', 'signal = "n_a"')
    assert_refused(folder, "check -c wagon.toml", 'has no signal "n_a", did you mean "n_A"?')


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"n_B"', '"n_C"', 'signals.axle_speed[2]: message "WSP" has no signal "n_C"'),
        ('"n_B", unit = "km/h"', '"n_B", unit = "km/h", match = "pgn"',
         'signals.axle_speed[2]: message "WSP" has an 11-bit id'),
        ('"n_A", unit = "km/h", noise_std = 0.036, counter = "WSP_counter"',
         '"n_A", unit = "km/h", noise_std = 0.036, counter = "WSP_count"',
         'signals.axle_speed[1].counter: message "WSP" has no signal "WSP_count", did you mean "WSP_counter"?'),
        ('"wsp_B", counter = "WSP_counter"', '"wsp_B", counter = "valve_B"', 'signals.wsp_active[2].counter: "va'),
        ('"wsp_B", counter = "WSP_counter"', '"wsp_B", counter = "n_B"',
         'signals.wsp_active[2].counter: signal "n_B" cannot be a rolling counter: it has steps of 0.01, expected a'),
        ('signal = "sanding"', 'signal = "sanding", counter = "none"', 'signals.sanding.counter: message "San'),
        ('signal = "v_ground"', 'signal = "v_ground", qualifier = "Fix"',
         'signals.speed.qualifier: message "GNSS" has no signal "Fix", did you mean "fix"?'),
        ('signal = "v_ground"', 'signal = "v_ground", qualifier = "fix", qualifier_good = [16]',
         'signals.speed.qualifier_good: signal "fix" has 4 bits, expected raw numbers from 0 to 15'),
        ('signal = "v_ground"', 'signal = "v_ground", qualifier_good = [1]',
         "signals.speed.qualifier_good: expected the key qualifier beside it"),
    ],
)  # fmt: skip
def test_a_mapping_that_does_not_fit_is_named_with_its_line(folder: Path, old: str, new: str, sentence: str) -> None:
    line = edit(folder, old, new)
    assert_refused(folder, "replay -c wagon.toml good.log", f"wagon.toml:{line}: {sentence}")


@pytest.mark.parametrize("command", ["check", "run", "replay good.log --publish -o out.csv"])
@pytest.mark.parametrize(
    ("setting", "sentence"),
    [
        ('connect = ["127.0.0.1:7447"]', "[zenoh] connect '127.0.0.1:7447': expected <protocol>"),
        ('listen = [\n"nowhere"]', "[zenoh] listen 'nowhere': expected <protocol>"),
        ('mode = "client"', "[zenoh] connect: a client needs the endpoint of a router"),
    ],
)
def test_an_endpoint_that_is_none_is_named_with_its_line(
    folder: Path, command: str, setting: str, sentence: str
) -> None:
    line = edit(folder, "[estimator]", f"[zenoh]\n{setting}\n[estimator]")
    if "connect =" in setting or "listen =" in setting:
        line += 1 + setting.count("\n")  # where the endpoint is, and not its list or table
    assert_refused(folder, f"{command} -c wagon.toml", f"wagon.toml:{line}: {sentence}")


def test_nothing_is_published_where_the_configuration_says_so(folder: Path) -> None:
    line = edit(folder, "[estimator]", "[zenoh]\nenabled = false\n[estimator]") + 1
    arguments = "replay -c wagon.toml good.log --publish -o out.csv"
    assert_refused(folder, arguments, f"wagon.toml:{line}: zenoh.enabled: expected true where --publish is given")


def test_a_mapping_to_what_the_dbc_does_not_have(folder: Path) -> None:
    line = edit(folder, 'signal = "v_ground"', 'signal = "v_grund"')
    sentence = 'signals.speed: message "GNSS" has no signal "v_grund", did you mean "v_ground"?'
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: {sentence}")


@pytest.mark.parametrize(
    ("spoil", "parts"),
    [
        (Path.unlink, ("wagon.toml:17: can.dbc: ", "wagon.dbc: cannot be read: No such file or directory")),
        (write_garbage, ("wagon.toml:17: can.dbc: ", "wagon.dbc: not a DBC file that can be read")),
        (
            lambda path: path.write_text(path.read_text() + '\nBA_ "GenMsgILSupport" BO_ 288 1;\n'),
            ("wagon.dbc: not a DBC file that can be read: it uses 'GenMsgILSupport', which it does not define",),
        ),
        (
            lambda path: path.write_text(path.read_text().partition("BO_ 672")[0]),
            ("wagon.toml:20: signals.speed: ", 'wagon.dbc: no message is named "GNSS"'),
        ),
        (
            lambda path: path.write_text(path.read_text().partition("_A : 0|16@1+ (0.01")[0]),
            ("wagon.dbc: ",),
        ),
    ],
    ids=["none", "garbage", "an attribute that is not defined", "cut between messages", "cut in a signal"],
)
def test_a_wrong_dbc(folder: Path, spoil: Callable[[Path], object], parts: tuple[str, ...]) -> None:
    spoil(folder / "wagon.dbc")
    assert_refused(folder, "replay -c wagon.toml good.log -o out.csv", *parts)


def test_a_dbc_with_two_messages_of_one_name(folder: Path) -> None:
    text = (folder / "wagon.dbc").read_text()
    (folder / "wagon.dbc").write_text(text.replace("BO_ 673 GNSS_Position", "BO_ 673 GNSS"))
    assert_refused(folder, "check -c wagon.toml", 'wagon.toml:20: signals.speed: message "GNSS" is ambiguous')
    (folder / "wagon.dbc").write_text(f"{text}\nBO_ 1000 Other: 8 X\n\nBO_ 1001 Other: 8 X\n")
    assert in_this_process(folder, ["replay", "-c", "wagon.toml", "good.log"]) == (0, "")


def test_a_dbc_that_is_named_wrongly(folder: Path) -> None:
    edit(folder, 'dbc = ["wagon.dbc"]', 'dbc = ["wagn.dbc"]')
    sentence = 'wagn.dbc: cannot be read: No such file or directory; of DBC files did you mean "wagon.dbc"?'
    assert_refused(folder, "check -c wagon.toml", sentence)
    line = edit(folder, "[can]", "[[can]]") + 3
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: can.dbc: ", sentence)


@pytest.mark.skipif(sys.version_info >= (3, 15), reason="there its lines may be as many as one likes")
def test_a_table_in_braces_over_several_lines(folder: Path) -> None:
    line = edit(folder, 'speed = { message = "GNSS",', 'speed = {\n  message = "GNSS",')
    sentence = "not valid TOML: what stands in { } has to stand on one line"
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: {sentence}")


def test_a_wrong_dbc_of_the_second_bus(folder: Path) -> None:
    first = '[[can]]\nname = "train"\ninterface = "socketcan"\nchannel = "can1"\ndbc = ["wagon.dbc"]\n'
    line = edit(folder, "[can]", f'{first}[[can]]\nname = "wagon"') + 9
    text = (folder / "wagon.toml").read_text().replace("{ message", '{ bus = "wagon", message')
    (folder / "wagon.toml").write_text(text.replace('["wagon.dbc"]    ', '["none.dbc"]'))
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: can[2].dbc: ", "none.dbc: cannot be read")


@pytest.mark.parametrize("again", ["wagon.dbc", "./wagon.dbc"])
def test_a_dbc_that_is_listed_twice_is_read_once(folder: Path, again: str) -> None:
    edit(folder, 'dbc = ["wagon.dbc"]', f'dbc = ["wagon.dbc", "{again}"]')
    assert in_this_process(folder, ["check", "-c", "wagon.toml"]) == (0, "")


def test_what_a_terminal_would_obey_is_not_repeated(folder: Path) -> None:
    (folder / "wagon.dbc").write_bytes(b'VERSION "a"\x1b]0;title\x07\x9b2J')
    _, errors = in_this_process(folder, ["check", "-c", "wagon.toml"])
    assert errors.strip().isprintable(), errors


def test_a_speed_without_steps_and_without_noise(folder: Path) -> None:
    """No reading of a floating-point number is beyond doubt, and two at once would divide by it."""
    dbc = (folder / "wagon.dbc").read_text()
    lines = [
        line
        for line in dbc.splitlines()
        if not re.match(r" SG_ (heading|fix|satellites) |.* 672 (heading|fix|sat)", line)
    ]
    text = "\n".join(lines).replace("v_ground : 0|16@1+ (0.005,0)", "v_ground : 0|32@1- (1,0)")
    (folder / "wagon.dbc").write_text(f"{text}\nSIG_VALTYPE_ 672 v_ground : 1;\n")
    assert in_this_process(folder, ["check", "-c", "wagon.toml"])[0] == 0
    edit(folder, 'unit = "m/s", noise_std = 0.02', 'unit = "m/s", noise_std = 0.0')
    sentence = 'signals.speed: signal "v_ground": expected a noise_std of more than 0'
    assert_refused(folder, "check -c wagon.toml", sentence)


def test_an_identifier_and_a_time_that_no_frame_has(folder: Path) -> None:
    head = "timestamp,arbitration_id,extended,remote,error,dlc,data\n"
    for name, row in (("id", "1.0,0x3fffffff,1,0,0,1,AA=="), ("time", "1e300,0x120,0,0,0,1,AA==")):
        (folder / f"{name}.csv").write_text(f"{head}{row}\n")
    assert_refused(folder, "replay -c wagon.toml id.csv", "id.csv:2: ", "identifier 0x3FFFFFFF has more than 29 bits")
    assert_refused(folder, "check -c wagon.toml time.csv", "time.csv:2: ", "time stamp 1e+300")
    (folder / "long.log").write_text(f"({'9' * 310}.0) can0 120#00\n")
    assert_refused(folder, "replay -c wagon.toml long.log", "long.log:1: not a line of candump's log format")


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        ("check -c wagn.toml", 'did you mean "wagon.toml"?'),
        ("check -c WAGON.toml", 'did you mean "wagon.toml"?'),
        ("check -c wagon.toml god.log", 'did you mean "good.log"?'),
        ("replay -c wagon.toml GOOD.LOG", 'did you mean "good.log"?'),
    ],
)
def test_a_file_that_is_named_wrongly(folder: Path, arguments: str, hint: str) -> None:
    assert_refused(folder, arguments, f": cannot be read: No such file or directory, {hint}")


def test_a_file_that_nothing_is_like(folder: Path) -> None:
    _, errors = in_this_process(folder, ["check", "-c", "wagon.toml", "nosuch/none.log"])
    assert errors == "brake-monitor: nosuch/none.log: cannot be read: No such file or directory\n"


@pytest.mark.parametrize(("twice", "named"), [("mass_kg = 1.0", "mass_kg"), ("[vehicle]", "the table [vehicle]")])
def test_what_stands_twice_is_named(folder: Path, twice: str, named: str) -> None:
    line = edit(folder, "mass_kg = 36000.0", f"mass_kg = 36000.0\n{twice}") + 1
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: not valid TOML: {named} stands twice")


def test_a_letter_of_another_encoding_is_named_with_its_line(folder: Path) -> None:
    line = edit(folder, "mass_kg = 36000.0", "mass_kg = 36000.0 # Gewicht für alles")
    path = folder / "wagon.toml"
    path.write_bytes(path.read_text().encode("latin-1", errors="replace"))
    assert_refused(folder, "check -c wagon.toml", f"wagon.toml:{line}: expected a configuration in TOML")


def test_an_output_that_lacks_letters_gets_all_the_others(folder: Path) -> None:
    arguments = ["replay", "-c", "wagon.toml", "good.log"]
    command = ["env", "PYTHONIOENCODING=ascii", sys.executable, "-m", "brake_monitor", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, timeout=LONGEST_S, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b", discs 15 ?C\nno alarms\n" in done.stdout


def test_a_name_that_the_system_has_no_letters_for(folder: Path) -> None:
    edit(folder, '"wagon.dbc"', '"Zug Ü.dbc"')
    ascii_only = ["env", "PYTHONCOERCECLOCALE=0", "PYTHONUTF8=0", "LC_ALL=C"]
    assert_refused(folder, "check -c wagon.toml", "encoding (ascii) has no letters for this name", before=ascii_only)


def test_a_device_without_end_is_no_configuration(folder: Path) -> None:
    assert_refused(folder, "check -c /dev/zero", "/dev/zero: expected a configuration in TOML, this has more than")


def test_a_configuration_that_is_none(folder: Path) -> None:
    assert_refused(folder, "check -c none.toml", "none.toml: cannot be read: No such file or directory")


# --- buses, targets, options ---


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"socketcan"', '"socketcann"', 'cannot open socketcann:can0: no such interface, did you mean "socketcan"?'),
        ('"can0"', '"nothere0"', 'cannot open socketcan:nothere0: there is no network interface "nothere0"'),
    ],
)
def test_run_on_a_bus_that_is_not_there(folder: Path, old: str, new: str, sentence: str) -> None:
    edit(folder, old, new)
    assert_refused(folder, "run -c wagon.toml --log-level warning", sentence)


@pytest.mark.parametrize(
    "arguments",
    ["replay -c wagon.toml good.log -o none/out.csv", "simulate dry -c wagon.toml -o none/out.csv"],
)
def test_a_target_in_a_directory_that_is_not_there(folder: Path, arguments: str) -> None:
    assert_refused(folder, arguments, "none/out.csv: there is no directory none")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("replay -c wagon.toml good.log -o good.log", "-o good.log: this is the recording, which would be lost"),
        ("replay -c wagon.toml good.log -o sub/../good.log", "-o sub/../good.log: this is the recording"),
        ("replay -c wagon.toml good.log --wear link.log", "--wear link.log: this is the recording"),
        ("replay -c wagon.toml good.log --alarms wagon.toml", "--alarms wagon.toml: this is the configuration"),
        ("replay -c wagon.toml good.log -o wagon.dbc", "-o wagon.dbc: this is a DBC file of the configuration"),
        ("replay -c wagon.toml good.log -o x.csv --alarms {}/x.csv", "-o and --alarms cannot go to the same place"),
        ("report -c wagon.toml good.log -o good.log", "-o good.log: this is the recording"),
        ("report -c wagon.toml good.log -o wagon.toml", "-o wagon.toml: this is the configuration"),
        ("report -c wagon.toml good.log -o x --figures {}/x", "-o and --figures cannot go to the same place"),
        ("simulate dry -c wagon.toml -o x.log --truth wagon.toml", "--truth wagon.toml: this is the configuration"),
        ("simulate dry -c wagon.toml --due wagon.dbc", "--due wagon.dbc: this is a DBC file of the configuration"),
        ("simulate dry -o x.log --truth sub/../x.log", "-o and --truth cannot go to the same place"),
        ("observability -c link.svg -o link.svg", "-o link.svg: this is the configuration"),
    ],
)
def test_an_output_never_takes_the_place_of_an_input_or_another(folder: Path, arguments: str, sentence: str) -> None:
    (folder / "sub").mkdir()
    (folder / "link.log").symlink_to("good.log")
    (folder / "link.svg").symlink_to("wagon.toml")
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    assert_refused(folder, arguments.format(folder), sentence)
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


@pytest.mark.parametrize("name", ["x.db", "x.xyz", "x", "x.gz", "x.log.zip", "x.blf.gz", "x.mf4.gz"])
def test_a_kind_of_log_that_cannot_be_written(folder: Path, name: str) -> None:
    sentence = f"{name}: cannot write this kind of log, expected one of .log, .asc, "
    assert_refused(folder, f"simulate dry -o {name} --truth truth.csv", sentence)


def test_mf4_is_not_written_without_its_extra(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "absent").mkdir()
    (folder / "absent" / "asammdf.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", str(folder / "absent"))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    assert_refused(
        folder, "simulate leaf -o x.mf4", "x.mf4: writing .mf4 needs the extra 'mf4': pip install", before=ALONE
    )


def test_who_has_no_configuration_yet_is_told_of_examples(tmp_path: Path) -> None:
    code, said = in_this_process(tmp_path, ["check", "-c", "wagon.toml"])
    assert (code, said.startswith("brake-monitor: wagon.toml: cannot be read: No such file or directory; ")) == (
        2,
        True,
    )
    (folder,) = re.findall(r"example vehicles are in (.*)\n", said)
    assert in_this_process(tmp_path, ["check", "-c", f"{folder}/wagon.toml"]) == (0, "")


TO_COPY = re.compile(r"  brake-monitor (?!.*\S {2,}[a-z]).*")  # in one piece, and nothing is told beside it


@pytest.mark.parametrize("command", COMMANDS)
def test_its_help_fits_the_terminal(
    command: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([command, "--help"])
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if len(line) > 80 and not TO_COPY.fullmatch(line)] == []


def test_what_has_no_room_beside_a_name_stands_below_it(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main(["simulate", "--help"])
    text = capsys.readouterr().out
    assert (
        "  wsp                       120 km/h, three short brakings, then a stop on\n" + " " * 28 + "adhesion" in text
    )
    assert "simulate stuck -o stuck.log --due due.jsonl\n      a fault, and the alarms" in text


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("replay -c wagon.toml good.log -o .", "-o .: expected a file, this is a directory"),
        ("replay -c wagon.toml good.log --wear /", "--wear /: expected a file, this is a directory"),
        ("replay -c wagon.toml good.log -o sub", "-o sub: expected a file, this is a directory"),
        ("report -c wagon.toml good.log -o sub", "-o sub: expected a file, this is a directory"),
        ("simulate dry -o x.log --truth sub", "--truth sub: expected a file, this is a directory"),
        ("report -c wagon.toml good.log -o x --figures good.log", "--figures good.log: expected a directory"),
        ("schema -o good.log", "-o good.log: expected a directory"),
        ("validate-alarms -o good.log", "-o good.log: expected a directory"),
        ("validate -o /dev/null", "-o /dev/null: expected a directory"),
    ],
)
def test_a_folder_for_a_file_or_a_file_for_a_folder(folder: Path, arguments: str, sentence: str) -> None:
    (folder / "sub").mkdir()
    assert_refused(folder, arguments, sentence)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("replay -c wagon.toml good.log -o x.xlsx", "-o x.xlsx: expected a file name that ends in .csv or .parquet"),
        ("replay -c wagon.toml good.log -o x.csv.gz", "-o x.csv.gz: expected a file name that ends in .csv or"),
        ("report -c wagon.toml good.log -o x.pdf", "-o x.pdf: expected a file name that ends in .html or .htm"),
        ("report -c wagon.toml good.log -o x.html --format png", "--format changes nothing but the figures: say where"),
        (
            "report -c wagon.toml good.log -o -",
            "-o -: expected the name of a file, this does not go to standard output",
        ),
        ("simulate dry --truth -", "--truth -: expected the name of a file, this does not go to standard output"),
        ("simulate dry --due -", "--due -: expected the name of a file, this does not go to standard output"),
        ("simulate dry -o x.log --minutes 3", "--minutes changes nothing but 'service': 'dry' takes"),
        ("simulate dry -o x.log --speed 3", "--speed changes nothing but the sending: say on which bus with --bus"),
        ("schema alarm -o sub", "-o sub: all schemas are written there: leave out 'alarm', or -o to print it"),
    ],
)
def test_nothing_that_was_asked_for_is_passed_over(folder: Path, arguments: str, sentence: str) -> None:
    assert_refused(folder, arguments, sentence)


def test_what_the_system_refuses_is_named(folder: Path) -> None:
    sentence = "good.log/schemas: cannot be created: Not a directory"
    assert_refused(folder, "schema -o good.log/schemas", sentence, code=1, before=ALONE)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("report -c wagon.toml absent.log -o /proc/x.html", "/proc/x.html: cannot be written: No such file"),
        ("report -c wagon.toml absent.log -o x.html --figures /proc/x", "/proc/x: cannot be written: No such file"),
        (
            "report -c wagon.toml absent.log -o x.html --figures wagon.dbc/x",
            "wagon.dbc/x: cannot be written: Not a",
        ),
        ("replay -c wagon.toml absent.log -o /proc/x.csv", "/proc/x.csv: cannot be written: No such file"),
        ("replay -c wagon.toml absent.log --wear /proc/x.jsonl", "/proc/x.jsonl: cannot be written: No such file"),
        ("simulate dry --bus no:bus -o /proc/x.log", "/proc/x.log: cannot be written: No such file"),
        ("simulate dry --bus no:bus --due /proc/x.jsonl", "/proc/x.jsonl: cannot be written: No such file"),
        ("validate -o /proc --only wagon/dry/as_modelled/wagon --seeds 1", "/proc: cannot be written: No such file"),
        ("validate-alarms -o /proc --only wagon/stuck/0 --hours 0", "/proc: cannot be written: No such file"),
    ],
)
def test_where_nothing_can_be_written_no_work_begins(folder: Path, arguments: str, sentence: str) -> None:
    """Not even for root. Work would begin with the recording, or the bus, that is not there."""
    assert_refused(folder, arguments, sentence, code=1)


@pytest.mark.parametrize(
    "arguments",
    [
        "check -c wagon.toml",
        "schema alarm",
        "replay -c wagon.toml good.log -o -",
        "replay -c wagon.toml good.log --wear -",  # so little that it would wait in a buffer until the end
        "--help",
        "wear --help",
        "--version",
    ],
)
def test_a_full_disk_behind_standard_output_is_named(folder: Path, arguments: str) -> None:
    full = ("sh", "-c", 'exec "$@" > /dev/full', "sh")
    sentence = "standard output: cannot be written: No space left on device"
    assert_refused(folder, arguments, sentence, code=1, before=full)


@pytest.mark.parametrize(
    ("arguments", "code"),
    [("check -c nosuch.toml", 2), ("--nosuch", 2), ("replay -c wagon.toml back.log -o out.csv", 0)],
)
def test_what_cannot_be_told_changes_no_exit_code(folder: Path, arguments: str, code: int) -> None:
    """A refusal, that of an option, and a remark, that the time goes back."""
    recorded = (folder / "good.log").read_text()
    (folder / "back.log").write_text(recorded + recorded)
    full = ("sh", "-c", 'exec "$@" 2> /dev/full', "sh")
    assert brake_monitor(folder, arguments.split(), full) == (code, "")


def test_a_pipe_is_no_recording(folder: Path) -> None:
    """Nobody writes to it."""
    os.mkfifo(folder / "pipe.log")
    assert_refused(folder, "check -c wagon.toml pipe.log", "pipe.log: expected a recording, this is a pipe")


def test_a_disk_that_fills_while_writing(folder: Path) -> None:
    (folder / "long.log").write_text(
        "".join(f"({1700000000 + i / 100:.2f}) can0 1A0#E803E803000000{i % 16:02X}\n" for i in range(20_000))
    )
    limited = ("sh", "-c", 'ulimit -f 8 && exec "$@"', "sh")  # blocks that a file may take
    assert_refused(
        folder, "replay -c wagon.toml long.log -o out.csv", "out.csv: cannot be written", code=1, before=limited
    )


def test_a_device_that_takes_nothing(folder: Path) -> None:
    """The kernel's own full disk."""
    assert_refused(folder, "replay -c wagon.toml good.log -o /dev/full", "/dev/full: cannot be written", code=1)


OTHERS_LOG = "".join(f"(1700000000.{i:06}) can0 7{i:02X}#0011223344556677\n" for i in range(20))


def test_a_recording_of_another_vehicle(folder: Path) -> None:
    (folder / "other.log").write_text(OTHERS_LOG)
    sentence = (
        "other.log: of 20 frames none is one that wagon.toml maps; "
        "'brake-monitor check -c wagon.toml other.log' lists what it carries"
    )
    for arguments in ("replay -c wagon.toml other.log", "report -c wagon.toml other.log -o /dev/null"):
        assert_refused(folder, arguments, sentence, code=1)


@pytest.mark.parametrize("options", ["", "--smooth", "--speed 1000"])
def test_the_table_of_another_vehicle_has_no_rows(folder: Path, options: str) -> None:
    """Ten seconds of frames, far beyond every time-out."""
    lines = [f"({1700000000 + i * 0.1:.6f}) can0 7{i % 100:02}#00" for i in range(100)]
    (folder / "other.log").write_text("\n".join(lines) + "\n")
    arguments = f"replay -c wagon.toml other.log -o out.csv {options}"
    assert in_this_process(folder, arguments.split())[0] == 1
    assert len((folder / "out.csv").read_text().splitlines()) == 1


def test_rows_begin_with_the_first_value_that_is_mapped(folder: Path) -> None:
    """Three seconds in which another sender talks, then this vehicle's frames."""
    others = "".join(f"({1699999997 + i * 0.1:.6f}) can0 700#00\n" for i in range(30))
    (folder / "late.log").write_text(others + LOG)
    assert in_this_process(folder, ["replay", "-c", "wagon.toml", "late.log", "-o", "out.csv"])[0] == 0
    times_s = [float(line.split(",")[0]) for line in (folder / "out.csv").read_text().splitlines()[1:]]
    assert times_s
    assert min(times_s) >= 1700000000.0


def test_figures_without_their_extra_before_any_work(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (folder / "absent").mkdir()
    (folder / "absent" / "matplotlib.py").write_text("raise ImportError")
    monkeypatch.setenv("PYTHONPATH", str(folder / "absent"))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    arguments = "report -c wagon.toml good.log -o x.html --figures plots"
    assert_refused(folder, arguments, "--figures needs the extra 'report': pip install '.[report]'", before=ALONE)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ("replay -c wagon.toml good.log --sped 2",
         'brake-monitor replay: unknown option --sped, did you mean "--speed"? (see brake-monitor replay'),
        ("replay -c wagon.toml good.log --sped=2", 'unknown option --sped, did you mean "--speed"?'),
        ("check -c wagon.toml good.log other.log",
         "brake-monitor check: unrecognized arguments: other.log (see brake-monitor check"),
        ("wear set -c wagon.toml --wheelset 1 --thickness-mm 30 --staet .",
         'brake-monitor wear set: unknown option --staet, did you mean "--state"?'),
        ("replay -c wagon.toml good.log --speed fast", "expected a number from 0.001 on or 'max', got 'fast'"),
        ("replay -c wagon.toml good.log --speed 1e-300", "expected a number from 0.001 on or 'max', got '1e-300'"),
        ("simulate wps -o x.log", 'argument SCENARIO: invalid choice: "wps", did you mean "wsp"? (see '),
        ("simulate presure-0 -o x.log", 'invalid choice: "presure-0", did you mean "pressure-0"? (see '),
        ("simulate icy -o x.log", 'invalid choice: "icy", there is "wsp", "sanding", '),
        ("simulate dry -o x.log --vehicle bogy", 'argument --vehicle: invalid choice: "bogy", did you mean "bogie"?'),
        ("wear shwo", 'argument ACTION: invalid choice: "shwo", did you mean "show"?'),
        ("simulate dry -o x.log --seed -1", "--seed: expected a whole number from 0 on, got '-1'"),
        ("demo --seed 1.5", "--seed: expected a whole number from 0 on, got '1.5'"),
        ("report -c wagon.toml good.log --output=", "argument -o/--output: expected a path, got ''"),
        ("wear show -c wagon.toml --state=", "argument --state: expected a path, got ''"),
        ("dashboard --port 1", "unknown option --port (see"),  # an option that is not for people is near
        ("dashboard --name=", "argument --name: expected a name, got ''"),
        ("demo --port 8000", "brake-monitor demo: unknown option --port (see"),  # 8000 is no scenario
        ("replay good.log", "the following arguments are required: -c/--config"),
        ("repaly", 'argument COMMAND: invalid choice: "repaly", did you mean "replay"?'),
    ],
)  # fmt: skip
def test_options_that_are_none_are_explained(folder: Path, arguments: str, part: str) -> None:
    files = sorted(folder.rglob("*"))
    code, errors = in_this_process(folder, arguments.split())
    assert code == 2
    (sentence,) = errors.splitlines()
    assert part in sentence
    assert sentence.startswith("brake-monitor")
    assert sentence.endswith("--help)")
    assert sorted(folder.rglob("*")) == files


@pytest.mark.parametrize("closed", [">&-", ">&- 2>&-"])
@pytest.mark.parametrize(("arguments", "code"), [("check -c wagon.toml good.log", 0), ("check -c absent.toml", 2)])
def test_outputs_that_the_shell_has_closed_are_nowhere(folder: Path, arguments: str, code: int, closed: str) -> None:
    command = f"{sys.executable} -m brake_monitor {arguments} {closed}"
    done = subprocess.run(
        command, shell=True, cwd=folder, capture_output=True, text=True, timeout=LONGEST_S, check=False
    )
    assert done.returncode == code
    assert "Traceback" not in done.stderr


# --- interrupted ---


@contextmanager
def slow_replay(folder: Path, handlers: dict[signal.Signals, Any]) -> Iterator[subprocess.Popen[str]]:
    """A replay at work, begun where signals have these handlers: what is ignored here is ignored there."""
    (folder / "slow.log").write_text(LOG + LOG.replace("(17000", "(17001"))  # the second half is days later
    files = sorted(folder.rglob("*"))
    replay = ["replay", "-c", "wagon.toml", "slow.log", "--speed", "1", "-o", "out.csv"]
    command = [sys.executable, "-m", "brake_monitor", *replay]
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        process = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    with process:
        until_s = time.monotonic() + LONGEST_S
        while sorted(folder.rglob("*")) == files and time.monotonic() < until_s:
            time.sleep(0.01)  # it writes beside its target once it is at work
        yield process
    assert sorted(folder.rglob("*")) == files


@pytest.mark.parametrize(
    ("number", "code", "told"),
    [(signal.SIGINT, 130, "brake-monitor: interrupted\n"), (signal.SIGTERM, 143, ""), (signal.SIGHUP, 129, "")],
)
def test_a_signal_ends_a_replay_and_leaves_nothing(folder: Path, number: signal.Signals, code: int, told: str) -> None:
    handler = signal.default_int_handler if number is signal.SIGINT else signal.SIG_DFL
    with slow_replay(folder, {number: handler}) as process:
        process.send_signal(number)
        _, errors = process.communicate(timeout=LONGEST_S)
    assert errors == told
    assert process.returncode == code


def test_signals_that_come_together_end_it_once(folder: Path) -> None:
    """`timeout` tells the command, and then its whole group."""
    with slow_replay(folder, dict.fromkeys((signal.SIGHUP, signal.SIGTERM), signal.SIG_DFL)) as process:
        process.send_signal(signal.SIGSTOP)
        for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGCONT):
            process.send_signal(number)
        _, errors = process.communicate(timeout=LONGEST_S)
    assert errors == ""
    assert process.returncode in (129, 143)  # which is seen first is the system's affair


def test_the_end_of_a_terminal_is_ignored_where_it_was(folder: Path) -> None:
    """As with nohup."""
    with slow_replay(folder, {signal.SIGHUP: signal.SIG_IGN, signal.SIGTERM: signal.SIG_DFL}) as process:
        process.send_signal(signal.SIGHUP)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=LONGEST_S)
    assert process.returncode == 143


@pytest.mark.parametrize("module", ["can", "argparse"])
def test_ctrl_c_while_a_command_is_loaded_is_no_traceback(folder: Path, module: str) -> None:
    (folder / f"{module}.py").write_text("raise KeyboardInterrupt")  # what most of the time goes into
    assert brake_monitor(folder, ["check", "-c", "wagon.toml"]) == (130, "brake-monitor: interrupted\n")


def test_ctrl_c_when_all_is_done_changes_nothing(folder: Path) -> None:
    """The interpreter takes as long to end as to begin: another code, or a traceback, would look like a failure."""
    late = "import atexit, signal\natexit.register(lambda: print(signal.raise_signal(signal.SIGINT)))\n"
    (folder / "sitecustomize.py").write_text(late)
    found = f"PYTHONPATH={folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    assert brake_monitor(folder, ["--version"], before=["env", found]) == (0, "")


def test_an_output_that_is_a_circle_of_links(folder: Path) -> None:
    (folder / "round.csv").symlink_to("about.csv")
    (folder / "about.csv").symlink_to("round.csv")
    assert_refused(folder, "replay -c wagon.toml good.log -o round.csv", "round.csv: cannot be written", code=1)
