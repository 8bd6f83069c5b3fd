"""The campaign counts rightly: in time, late, missed, open from before, false; and runs from end to end."""

from pathlib import Path

import pytest

from brake_monitor.alarm_campaign.drives import Drive, chosen, service_drives, trouble_drives
from brake_monitor.alarm_campaign.outcome import Answer, FalseAlarm, Outcome, compare
from brake_monitor.alarm_campaign.tables import by_drive, failures, markdown
from brake_monitor.cli import main
from brake_monitor.commands import validate_alarms
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.processing import playing
from brake_monitor.simulator.due.alarm import DELAY_S, Due
from brake_monitor.simulator.ordinary_service import SERVICE
from brake_monitor.simulator.simulate import EPOCH_S
from brake_monitor.simulator.troubles import TROUBLES

DRIVE = Drive("wagon", "stuck", 0)
STATED_S = DELAY_S["dragging_brake"]


def dragging(from_s: float = 20.0, until_s: float = 90.0, *, must: bool = True) -> Due:
    by_s = EPOCH_S + from_s + STATED_S if must else None
    return Due("dragging_brake", 1, EPOCH_S + from_s, by_s, EPOCH_S + until_s, "presses")


def alarm(raised_s: float, wheelset: int | None = 1, cleared_s: float | None = None) -> Alarm:
    return Alarm(
        id=f"dragging_brake-{wheelset}-{raised_s}",
        kind="dragging_brake",
        wheelset=wheelset,
        severity=Severity.WARNING,
        raised_time_s=EPOCH_S + raised_s,
        updated_time_s=EPOCH_S + raised_s,
        acknowledged_time_s=None,
        cleared_time_s=None if cleared_s is None else EPOCH_S + cleared_s,
        message="It drags.",
        evidence={},
    )


def outcome(due: list[Due], raised: list[Alarm]) -> Outcome:
    return compare(DRIVE, 100.0, due, raised)


@pytest.mark.parametrize(
    ("raised_s", "delay_s", "is_in_time"),
    [(25.0, 5.0, True), (20.0 + STATED_S, STATED_S, True), (21.0 + STATED_S, STATED_S + 1.0, False)],
)
def test_the_delay_counts_from_when_the_condition_qualifies(raised_s: float, delay_s: float, is_in_time: bool) -> None:
    (answer,) = outcome([dragging()], [alarm(raised_s)]).answers
    assert answer.delay_s == pytest.approx(delay_s, abs=0.01)
    assert answer.is_in_time is is_in_time


def test_what_never_comes_is_missed_also_when_another_wheelset_is_named() -> None:
    found = outcome([dragging()], [alarm(25.0, wheelset=2)])
    assert (found.answers[0].delay_s, found.answers[0].is_in_time) == (None, False)
    assert [(one.kind, one.wheelset) for one in found.false_alarms] == [("dragging_brake", 2)]


def test_an_alarm_that_is_still_open_need_not_be_raised_again() -> None:
    again = [dragging(), dragging(120.0, 150.0)]
    answers = outcome(again, [alarm(25.0)]).answers
    assert [answer.is_in_time for answer in answers] == [True, True]
    assert answers[1].delay_s is None
    assert outcome(again, [alarm(25.0, cleared_s=121.0)]).answers == answers  # cleared while it was due again
    answers = outcome(again, [alarm(25.0, cleared_s=100.0)]).answers
    assert [answer.is_in_time for answer in answers] == [True, False]


def test_what_may_come_is_neither_missed_nor_false() -> None:
    may = [dragging(must=False)]
    assert outcome(may, []) == Outcome(DRIVE, 100.0 / 3600.0, (), ())
    assert outcome(may, [alarm(50.0)]).false_alarms == ()


@pytest.mark.parametrize("raised_s", [5.0, 95.0])
def test_before_and_after_its_condition_an_alarm_is_false(raised_s: float) -> None:
    assert len(outcome([dragging()], [alarm(raised_s)]).false_alarms) == 1


def test_the_tables_count_by_kind_and_by_drive_and_every_failure_is_told() -> None:
    answers = (
        Answer("dragging_brake", 1, 20.0, 4.0, True, "presses"),
        Answer("dragging_brake", 1, 60.0, 40.0, False, "presses"),
        Answer("dragging_brake", 1, 90.0, None, False, "presses"),
        Answer("dragging_brake", 1, 95.0, None, True, "presses"),
    )
    service = Outcome(Drive("bogie", SERVICE, 7), 0.5, (), (FalseAlarm("slide", 2, 99.0, "It slides."),))
    found = [Outcome(DRIVE, 0.1, answers, ()), service]
    assert "| `dragging_brake` | 4 | 1 | 1 | 1 | 1 | 22.0 / 40.0 s | 30 s | 0 |" in markdown(found)
    assert "0.5 hours, false alarms: 1 `slide`" in markdown(found)
    assert "| stuck, wagon | 4 | 1 | 1 | 1 | 1 |" in by_drive(found)
    told = list(failures(found))
    assert len(told) == 3
    assert told[0].startswith("bogie/service/7: slide 2 at 99.0 s: false")


def test_the_hours_are_whole_and_every_trouble_is_driven_by_every_vehicle_that_can_have_it() -> None:
    assert sum(drive.expected_s for drive in service_drives(10.0)) == 36000.0
    assert DRIVE.expected_s == TROUBLES["stuck"].scenario.duration_s
    paths = {drive.path for drive in trouble_drives(2)}
    assert {"single/locked/1", "wagon/stuck/0", "bogie/uneven/1"} <= paths
    assert "single/uneven/0" not in paths
    assert [d.path for d in chosen(trouble_drives(3), ["*/stuck/1"])] == ["wagon/stuck/1", "bogie/stuck/1"]


def test_low_adhesion_is_told_in_time_and_an_interrupted_campaign_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(playing, "have_made", pytest.fail)  # machine code takes longer than the one drive
    command = ["validate-alarms", "-o", str(tmp_path), "--hours", "0", "--jobs", "1", "--seeds", "1"]
    main([*command, "--only", "single/leaf/0"])
    first = (tmp_path / "outcomes.jsonl").read_bytes()
    (line,) = [text for text in (tmp_path / "alarms.md").read_text().splitlines() if "`low_adhesion`" in text]
    assert line.startswith("| `low_adhesion` | 1 | 1 | 0 | 0 | 0 |")
    main([*command, "--only", "single/leaf/0", "--resume"])
    assert (tmp_path / "outcomes.jsonl").read_bytes() == first


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A campaign of three drives, which has been run."""
    monkeypatch.setattr(validate_alarms, "judge", lambda drive, **_: Outcome(drive, 0.1, (), ()))
    drives = ["--hours", "0", "--jobs", "1", "--only", "single/leaf/*", "--seeds", "3"]
    command = ["validate-alarms", "-o", str(tmp_path), *drives]
    assert main(command) == 0
    return command


def test_what_was_driven_after_a_line_that_was_cut_short_is_not_driven_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    noted = tmp_path / "outcomes.jsonl"
    whole = noted.read_bytes()
    for cut in (1, 5):  # the end of its line alone, and more
        noted.write_bytes(whole[:-cut])
        for to_do in ("1 drive", "0 drives"):
            capsys.readouterr()
            assert main([*command, "--resume"]) == 0
            assert capsys.readouterr().out.startswith(f"{to_do}, ")
        assert noted.read_bytes() == whole


def test_a_line_that_is_none_costs_no_outcome_behind_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: list[str]
) -> None:
    noted = tmp_path / "outcomes.jsonl"
    first, *others = noted.read_bytes().splitlines(keepends=True)
    noted.write_bytes(first[:9] + b"".join(others))
    capsys.readouterr()
    assert main([*command, "--resume"]) == 0
    assert capsys.readouterr().out.startswith("2 drives, ")  # the second shares the line of the first


def test_a_disk_that_is_full_is_told_with_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(validate_alarms, "judge", lambda drive, **_: Outcome(drive, 0.1, (), ()))
    (tmp_path / "outcomes.jsonl").symlink_to("/dev/full")
    assert main(["validate-alarms", "-o", str(tmp_path), "--jobs", "1", "--only", "single/leaf/0"]) == 1
    told = f"brake-monitor: {tmp_path / 'outcomes.jsonl'}: cannot be written: No space left on device\n"
    assert capsys.readouterr().err == told


def test_without_a_pattern_all_is_driven(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(validate_alarms, "judge", lambda drive, **_: Outcome(drive, 0.1, (), ()))
    assert main(["validate-alarms", "-o", str(tmp_path), "--hours", "1", "--seeds", "1", "--jobs", "1"]) == 0
    drives = len(trouble_drives(1)) + len(service_drives(1.0))
    assert capsys.readouterr().out.startswith(f"{drives} drives, ")


def test_nothing_to_drive_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["validate-alarms", "-o", str(tmp_path), "--only", "no/such/drive"]) == 2
    assert "nothing is left to drive" in capsys.readouterr().err
