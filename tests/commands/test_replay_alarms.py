"""`replay --alarms`: one object per alarm, in the order of raising, on the recording's own time base."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from brake_monitor.cli import main
from brake_monitor.settings.example_vehicles import example_config

LOG = Path(__file__).parents[1] / "golden" / "slide.log.gz"
CONFIG = str(example_config("wagon"))
AGREED = ["kind", "wheelset", "severity", "raised_time_s", "cleared_time_s", "message"]
FROM_S, TO_S = 1_700_000_037.0, 1_700_000_052.0


def test_one_object_per_alarm_with_the_agreed_keys_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "alarms.jsonl"
    assert main(["replay", "-c", CONFIG, str(LOG), "--alarms", str(out)]) == 0
    found = [json.loads(line) for line in out.read_text().splitlines()]
    assert all(list(alarm)[: len(AGREED)] == AGREED for alarm in found)
    assert "low_adhesion" in {alarm["kind"] for alarm in found}
    assert len({alarm["id"] for alarm in found}) == len(found)
    raised = [alarm["raised_time_s"] for alarm in found]
    assert raised == sorted(raised)
    assert all(FROM_S <= time_s <= TO_S for time_s in raised)
    assert any(alarm["cleared_time_s"] is None for alarm in found)  # it ends in the slide
    said = capsys.readouterr().out
    assert all(alarm["message"] in said for alarm in found)


def test_to_stdout_the_summary_gives_way(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", "-c", CONFIG, str(LOG), "--alarms", "-"]) == 0
    out, err = capsys.readouterr()
    assert all(json.loads(line)["kind"] for line in out.splitlines())
    assert "wagon-8127" in err


@pytest.mark.parametrize("name", ["-", "/dev/stdout"])
def test_into_a_file_that_is_standard_output_the_table_goes_alone(tmp_path: Path, name: str) -> None:
    with (tmp_path / "out.jsonl").open("w") as out:
        command = [sys.executable, "-m", "brake_monitor", "replay", "-c", CONFIG, LOG, "--wear", name]
        said = subprocess.run(command, stdout=out, stderr=subprocess.PIPE, text=True, check=True).stderr
    lines = (tmp_path / "out.jsonl").read_text().splitlines()
    assert [json.loads(line)["wheelset"] for line in lines] == [1, 2]
    assert "wagon-8127" in said


def test_estimates_and_alarms_do_not_go_to_one_place(capsys: pytest.CaptureFixture[str]) -> None:
    for other in ("-", "/dev/stdout"):
        assert main(["replay", "-c", CONFIG, str(LOG), "-o", "-", "--alarms", other]) == 2
        assert "cannot go to the same place" in capsys.readouterr().err


def test_wear_is_one_object_per_wheelset_and_a_line_of_the_summary(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "wear.jsonl"
    assert main(["replay", "-c", CONFIG, str(LOG), "--wear", str(out)]) == 0
    found = [json.loads(line) for line in out.read_text().splitlines()]
    assert [one["wheelset"] for one in found] == [1, 2]
    for one in found:
        worn_mm = 0.2 * one["pad_energy_j"] / 1e6 / 4 / 400.0 * 10.0  # 0.2 cm³/MJ, 4 pads of 400 cm²
        assert one["pad_energy_j"] > 0.0
        assert one["thickness_mm"] == pytest.approx(35.0 - worn_mm)
        assert one["thickness_low_mm"] < one["thickness_mm"] < one["thickness_high_mm"]
        assert one["sliding_distance_m"] > 0.0
    said = capsys.readouterr().out
    assert "wheelset 2:" in said
    assert "MJ of braking" in said


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[alarms.slide]\nflat_likely_m = -1.0\n", "alarms.slide.flat_likely_m"),
        ("[alarms.bus_fault]\nerror_frames = 0\n", "alarms.bus_fault.error_frames"),
        ("[alarms.wheelset_not_rotating]\nlatch = true\n", "latch"),
        ("[alarms.slides]\nenabled = false\n", "slides"),
    ],
)
def test_a_wrong_threshold_is_one_sentence(
    text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config = tmp_path / "wagon.toml"
    dbc = Path(CONFIG).with_suffix(".dbc")
    config.write_text(Path(CONFIG).read_text().replace('"wagon.dbc"', f'"{dbc}"') + "\n" + text)
    assert main(["check", "-c", str(config)]) == 2
    err = capsys.readouterr().err
    assert said in err
    assert len(err.strip().splitlines()) == 1
