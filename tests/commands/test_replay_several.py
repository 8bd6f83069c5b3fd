"""Several recordings at one go: what one by one would have given, and nothing that would be lost."""

import gzip
import shutil
from pathlib import Path

import pytest

from brake_monitor.cli import main
from brake_monitor.errors import brief
from brake_monitor.settings.example_vehicles import example_config

GOLDEN = Path(__file__).parents[1] / "golden" / "slide.log.gz"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three recordings: a slide whole and packed, its first half, and one that is damaged in the middle."""
    folder = tmp_path_factory.mktemp("recordings")
    shutil.copy(GOLDEN, folder / "monday.log.gz")
    lines = gzip.decompress(GOLDEN.read_bytes()).splitlines(keepends=True)
    (folder / "tuesday.half.log").write_bytes(b"".join(lines[: len(lines) // 2]))
    (folder / "damaged.log").write_bytes(b"".join(lines[:2000]) + b"(12) nonsense\n" + b"".join(lines[2000:]))
    return folder


def replay(*arguments: object) -> int:
    return main(["replay", "-c", str(example_config("wagon")), *map(str, arguments)])


@pytest.mark.parametrize("jobs", [1, 2])
def test_they_give_what_each_gives_alone(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], jobs: int
) -> None:
    logs = {"monday": folder / "monday.log.gz", "tuesday.half": folder / "tuesday.half.log"}
    summaries = []
    for name, log in logs.items():
        outputs = ("-o", tmp_path / f"{name}.csv", "--alarms", tmp_path / f"{name}.jsonl", "--wear", tmp_path / "wear")
        assert replay(log, *outputs) == 0
        summaries.append(f"{log}\n{capsys.readouterr().out}")
    together = tmp_path / "together"
    together.mkdir()
    outputs = ("-o", together / "*.csv", "--alarms", together / "*.jsonl")
    assert replay(*logs.values(), *outputs, "--jobs", jobs) == 0
    assert capsys.readouterr().out == "\n".join(summaries)
    for name in logs:
        for suffix in (".csv", ".jsonl"):
            assert (together / f"{name}{suffix}").read_bytes() == (tmp_path / f"{name}{suffix}").read_bytes()
    assert len(list(together.iterdir())) == 4


def test_one_that_is_given_twice_is_refused(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = folder / "tuesday.half.log"
    assert replay(log, log, "-o", tmp_path / "*.csv") == 2
    assert f"{log}: this recording is given 2 times" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_a_damaged_one_keeps_no_other_from_being_played(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = (folder / "damaged.log", folder / "tuesday.half.log")
    assert replay(*logs, "-o", tmp_path / "*.csv", "--jobs", 2) == 2
    said = capsys.readouterr()
    assert f"{logs[0]}\nnot played" in said.out
    assert "wheelset 2: friction" in said.out.partition(str(logs[1]))[2]
    assert said.err.count("\n") == 1
    assert f"{logs[0]}:2001: not a line of candump's log format" in said.err
    assert [path.name for path in tmp_path.iterdir()] == ["tuesday.half.csv"]


def test_nor_does_one_that_cannot_be_asked_for(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = (folder / f"{'x' * 300}.log", folder / "tuesday.half.log")
    assert replay(*logs, "--jobs", 1) == 2
    said = capsys.readouterr()
    assert "wheelset 2: friction" in said.out.partition(str(logs[1]))[2]
    assert said.err == brief(f"brake-monitor: {logs[0]}: cannot be read: File name too long\n")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("-o one.csv", "-o one.csv: what comes of several recordings cannot all go there"),
        ("--alarms -", "--alarms -: what comes of several recordings cannot all go there"),
        ("--wear */wear", "cannot all go there"),
        ("--publish", "--publish and --speed are for one recording"),
        ("--speed 1", "--publish and --speed are for one recording"),
    ],
)
def test_what_is_refused_of_several(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: str, sentence: str
) -> None:
    assert replay(folder / "monday.log.gz", folder / "tuesday.half.log", *arguments.split()) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("pattern", ["*.csv", "one.csv"])
def test_two_of_one_name_are_named(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], pattern: str
) -> None:
    twin = tmp_path / "monday.log"
    twin.write_bytes((folder / "tuesday.half.log").read_bytes())
    assert replay(folder / "monday.log.gz", twin, "-o", tmp_path / pattern) == 2
    told = capsys.readouterr().err
    assert f"{folder / 'monday.log.gz'} and {twin} are both named monday" in told
    assert "write a '*'" not in told


def test_a_configuration_that_is_none_is_told_once(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "wagon.toml"
    config.write_text(example_config("wagon").read_text().replace("mass_kg", "mas_kg"))
    assert main(["replay", "-c", str(config), *map(str, folder.glob("*.log"))]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("vehicle.mas_kg: unknown key") == 1


def test_no_output_takes_the_place_of_another_recording(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table of estimates and a recording in python-can's CSV may have the same name."""
    table = folder / "monday.csv"
    table.write_text("timestamp,arbitration_id,extended,remote,error,dlc,data\n0.0,0x1,0,0,0,1,AA==\n")
    before = table.read_bytes()
    assert replay(folder / "monday.log.gz", table, "-o", folder / "*.csv") == 2
    assert "this is one of the recordings, which would be lost" in capsys.readouterr().err
    assert table.read_bytes() == before
