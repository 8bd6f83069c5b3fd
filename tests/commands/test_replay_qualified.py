"""A qualifier that drops in the middle of a braking: what is published is what would be of a sender without a value."""

import csv
import json
from pathlib import Path

import pytest

from brake_monitor.bus.candump_log import line_of
from brake_monitor.cli import main
from brake_monitor.frame import Frame
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, drive

BCU = 0x120
FROM_S, TO_S = 7.0, 10.0  # it brakes from 5 to 13 s
TIMEOUT_S = 0.05  # five cycles of 10 ms
QUALIFIED = 'signal = "p_A", qualifier = "BCU_state", qualifier_good = [0, 1]'
WRONG_BAR, NO_VALUE = bytes.fromhex("07D0"), bytes.fromhex("FFFF")  # 4 bar, and what the DBC calls not available


def is_doubted(frame: Frame) -> bool:
    return frame.can_id == BCU and FROM_S <= frame.time_s - EPOCH_S < TO_S


def failing(frame: Frame) -> Frame:
    """Its sender goes on with a pressure that might be one, and says by its state (bits 4 to 7) that it is none."""
    data = frame.data
    return frame._replace(data=WRONG_BAR + data[2:7] + bytes([data[7] | 0x40])) if is_doubted(frame) else frame


def without_value(frame: Frame) -> Frame:
    return frame._replace(data=NO_VALUE + frame.data[2:]) if is_doubted(frame) else frame


class Replayed:
    """What `replay` writes of frames."""

    def __init__(self, folder: Path, frames: list[Frame], old: str = "", new: str = "") -> None:
        folder.mkdir()
        example = example_config("wagon")
        text = example.read_text().replace('"wagon.dbc"', json.dumps(str(example.with_suffix(".dbc"))))
        (folder / "wagon.toml").write_text(text.replace(old, new))
        (folder / "x.log").write_text("".join(map(line_of, frames)))
        table, alarms = folder / "out.csv", folder / "out.jsonl"
        places = map(str, (folder / "wagon.toml", folder / "x.log", "-o", table, "--alarms", alarms))
        assert main(["replay", "-c", *places]) == 0
        self.table, self.alarms = table.read_text(), alarms.read_text()

    def rows(self, from_s: float, to_s: float) -> list[dict[str, str]]:
        rows = csv.DictReader(self.table.splitlines())
        return [row for row in rows if from_s <= float(row["time_s"]) - EPOCH_S < to_s]


@pytest.fixture(scope="module")
def qualified(tmp_path_factory: pytest.TempPathFactory) -> Replayed:
    frames = [failing(frame) for frame in drive(DRY).frames]
    return Replayed(tmp_path_factory.mktemp("replay") / "qualified", frames, 'signal = "p_A"', QUALIFIED)


def test_the_same_is_told_as_of_a_sender_that_says_that_it_has_no_value(qualified: Replayed, tmp_path: Path) -> None:
    told = Replayed(tmp_path / "told", [without_value(frame) for frame in drive(DRY).frames])
    assert qualified.table == told.table
    assert qualified.alarms == told.alarms


def test_meanwhile_nothing_is_valid_and_the_reason_is_told(qualified: Replayed) -> None:
    lost = qualified.rows(FROM_S + 2 * TIMEOUT_S, TO_S)
    assert len(lost) > 20
    assert {row["status"] for row in lost} == {row["friction_1_status"] for row in lost} == {"invalid"}
    assert all("pressing_force 1 lost" in row["reasons"] for row in lost)
    assert {float(row["pressing_force_1_n"]) < 60e3 for row in qualified.rows(0.0, 27.0)} == {True}  # 4 bar: 70 kN
    (alarm,) = map(json.loads, qualified.alarms.splitlines())
    assert (alarm["kind"], alarm["wheelset"]) == ("input_implausible", 1)
    assert (alarm["evidence"]["signals"], alarm["evidence"]["conditions"]) == ("BCU.p_A", "not available")
    assert FROM_S < alarm["raised_time_s"] - EPOCH_S < alarm["cleared_time_s"] - EPOCH_S


def test_before_it_is_valid_and_afterwards_it_is_again(qualified: Replayed) -> None:
    assert {row["status"] for row in qualified.rows(FROM_S - 0.5, FROM_S)} == {"valid"}
    assert {row["status"] for row in qualified.rows(25.0, 27.0)} == {"valid"}


def test_without_the_qualifier_the_pressure_would_be_believed(tmp_path: Path) -> None:
    plain = Replayed(tmp_path / "plain", [failing(frame) for frame in drive(DRY).frames])
    assert max(float(row["pressing_force_1_n"]) for row in plain.rows(FROM_S, TO_S)) > 65e3
