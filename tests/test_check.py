"""`check` shows which frames were taken for what, so that a wrong guess cannot be missed."""

import shutil
from pathlib import Path

import pytest

from brake_monitor.cli import main

VEHICLES = Path(__file__).parent.parent / "dbc"
DATA = Path(__file__).parent / "data"


def check(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, list[str]]:
    """The exit code and the lines that were printed, with single spaces."""
    code = main(["check", "-c", *map(str, arguments)])
    return code, [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]


def recording(tmp_path: Path, *frames: str) -> Path:
    path = tmp_path / "x.log"
    path.write_text("".join(f"({number}.0) can0 {frame}\n" for number, frame in enumerate(frames)))
    return path


def test_each_message_is_shown_with_the_frames_that_are_taken_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, VEHICLES / "bogie.toml")
    assert code == 0
    assert 'WheelSpeeds PGN FF20, J1939: its VFrameFormat is "J1939PG"' in lines
    assert "BrakeLead id 08FF3021, J1939, but BrakeTrail has the same PGN" in lines
    _, lines = check(capsys, VEHICLES / "wagon.toml")
    assert "WSP id 1A0" in lines
    assert "Sander id 18FF5030" in lines


def test_several_senders_under_one_pgn_are_remarked(capsys: pytest.CaptureFixture[str]) -> None:
    code, lines = check(capsys, DATA / "mini_j1939.toml", DATA / "mini_j1939.log")
    assert code == 0
    assert any(line.startswith("remark: VehicleSpeed came under 2 ids") for line in lines)
    assert any("0CFF0421, 18FF0400" in line for line in lines)


def test_a_pgn_that_came_from_another_sender_than_the_id_says_is_remarked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, lines = check(capsys, VEHICLES / "wagon.toml", recording(tmp_path, "0CFF5031#00000000"))
    assert any(line.startswith("remark: Sander never came, but its PGN did, under 0CFF5031") for line in lines)


def test_a_number_of_the_other_width_is_remarked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, lines = check(capsys, VEHICLES / "wagon.toml", recording(tmp_path, "000001A0#00", "2A0#00", "18FF0000#00"))
    (remark,) = (line for line in lines if line.startswith("remark: "))
    assert "000001A0 is on the bus and not mapped, while the DBC gives WSP this number with 11 bits" in remark


def test_a_recorder_that_pads_its_ids_needs_no_configuration(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("wagon.toml", "wagon.dbc"):
        shutil.copy(VEHICLES / name, tmp_path)
    log = recording(tmp_path, "000001A0#E803E80300000000", "00000120#0000000000000000", "000002A0#D007000000000000")
    code, lines = check(capsys, tmp_path / "wagon.toml", log)
    assert code == 0
    assert f"remark: {log}: every id has eight digits and none is above 7FF: taken for 11-bit ids" in lines


def test_an_endpoint_that_zenoh_would_not_understand_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wagon = (VEHICLES / "wagon.toml").read_text().replace('"wagon.dbc"', f'"{VEHICLES / "wagon.dbc"}"')
    (tmp_path / "wagon.toml").write_text(wagon + '\n[zenoh]\nconnect = ["router:7447"]\n')
    assert main(["check", "-c", str(tmp_path / "wagon.toml")]) == 2
    assert "[zenoh] connect 'router:7447': expected <protocol>/<host>:<port>" in capsys.readouterr().err


def test_what_zenoh_would_not_take_behind_an_address_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    wagon = (VEHICLES / "wagon.toml").read_text().replace('"wagon.dbc"', f'"{VEHICLES / "wagon.dbc"}"')
    (tmp_path / "wagon.toml").write_text(wagon + '\n[zenoh]\nconnect = ["tcp/router:7447?;#key=secret"]\n')
    assert main(["check", "-c", str(tmp_path / "wagon.toml")]) == 2
    told = capsys.readouterr().err
    assert "[zenoh] connect 'tcp/router:7447': expected ?<name>=<value>" in told
    assert "secret" not in told
