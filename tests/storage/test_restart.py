"""The real daemon, killed in the middle of a braking and started again, ends as one that was never interrupted."""

import signal
from itertools import pairwise
from pathlib import Path

import pytest

from brake_monitor.bus.can_log import open_log
from brake_monitor.bus.candump_log import parse_line
from brake_monitor.cli import main
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.config_file import load_settings
from brake_monitor.simulator.simulate import EPOCH_S
from interrupted_daemon import PATIENCE_S, daemon, kept, kept_until_s, prepare, wait_until
from program import until

KILLED_S = (60.0, 75.0)  # in the long slide
STANDS_S = 111.0  # the low adhesion is over and the last brake application ends: the last that is kept
LONG_BEFORE_S = 50.0  # of alarms that were raised until then the evidence is whole before the first kill
AFTER_S = 1.0  # what is whole holds more than that of what came after
END_S = 113.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("restart")
    prepare(folder, "enabled = false", END_S)
    return folder


def uninterrupted(folder: Path) -> tuple[Pipeline, dict[str, Alarm], float]:
    """The pipeline at the end, its alarms, and the most energy that one wheelset's brake took within a second."""
    settings = load_settings(folder / "wagon.toml")
    pipeline, alarms = Pipeline.from_settings(settings), {}
    energy_j = []
    for frame in open_log(folder / "wsp.log", settings.can):
        outputs = pipeline.step(frame)
        alarms |= {alarm.id: alarm for alarm in outputs.alarms}
        if outputs.estimate is not None:
            energy_j.append(max(unit.pads.since_fitted.energy_j for unit in pipeline.brake_book.brakes.units))
    per_second = round(settings.output.rate_hz)
    greatest_j = max(b - a for a, b in zip(energy_j, energy_j[per_second:], strict=False))
    return pipeline, alarms, greatest_j


def early_alarms(folder: Path) -> list[Alarm]:
    """Those of long before the first kill."""
    return [alarm for alarm in kept(folder)[1] if alarm.raised_time_s < EPOCH_S + LONG_BEFORE_S]


def evidence(folder: Path, alarm: Alarm) -> Path:
    return folder / "state" / "evidence" / f"{alarm.id}.log"


def is_whole(log: Path, alarm: Alarm) -> bool:
    if not log.exists():
        return False
    *_, last = log.read_text().splitlines()
    return parse_line(last).time_s >= alarm.raised_time_s + AFTER_S


def test_killed_twice_while_braking_it_ends_as_if_nothing_had_happened(folder: Path) -> None:
    reference, reference_alarms, second_j = uninterrupted(folder)
    from_s = 0.0
    for killed_s in KILLED_S:
        with daemon(folder, from_s) as child:
            wait_until(child, folder, EPOCH_S + killed_s)
            until(lambda: all(is_whole(evidence(folder, alarm), alarm) for alarm in early_alarms(folder)))
            child.send_signal(signal.SIGKILL)
            assert child.wait(PATIENCE_S) == -signal.SIGKILL
        from_s = kept_until_s(folder) + 0.001  # what is kept is not played again
    with daemon(folder, from_s) as child:
        wait_until(child, folder, EPOCH_S + STANDS_S)
        child.send_signal(signal.SIGTERM)
        assert child.wait(PATIENCE_S) == 0
    brakes, alarms = kept(folder)
    assert brakes is not None
    for unit, expected in zip(brakes.units, reference.brake_book.brakes.units, strict=True):
        lost_j = expected.pads.since_fitted.energy_j - unit.pads.since_fitted.energy_j
        assert abs(lost_j) <= second_j * len(KILLED_S)
        assert unit.pads.since_fitted.energy_j > 5.0 * second_j
    (low,) = (alarm for alarm in alarms if alarm.kind == "low_adhesion")
    (expected_low,) = (alarm for alarm in reference_alarms.values() if alarm.kind == "low_adhesion")
    assert abs(low.raised_time_s - expected_low.raised_time_s) < 0.3
    assert low.cleared_time_s is not None
    assert expected_low.cleared_time_s is not None
    assert abs(low.cleared_time_s - expected_low.cleared_time_s) < 3.0
    for alarm, later in pairwise(sorted(alarms, key=lambda a: (a.kind, a.wheelset or 0, a.raised_time_s))):
        if (alarm.kind, alarm.wheelset) == (later.kind, later.wheelset):  # none was raised while it was open
            assert alarm.cleared_time_s is not None
            assert alarm.cleared_time_s < later.raised_time_s


def test_the_evidence_of_each_alarm_replays_to_it(folder: Path, tmp_path: Path) -> None:
    """After the test above: evidence outlives the kill."""
    alarms = early_alarms(folder)
    assert {alarm.kind for alarm in alarms} == {"low_adhesion", "slide"}
    for alarm in alarms:
        log = evidence(folder, alarm)
        assert is_whole(log, alarm)
        out = tmp_path / "alarms.jsonl"
        assert main(["replay", "-c", str(folder / "wagon.toml"), str(log), "--alarms", str(out)]) == 0
        found = [line for line in out.read_text().splitlines() if f'"{alarm.kind}"' in line]
        assert any(f'"wheelset":{alarm.wheelset or "null"}' in line.replace(" ", "") for line in found), (alarm, found)
        table = log.with_suffix(".csv").read_text().splitlines()
        assert table[0].startswith("time_s,speed_mps,adhesion,")
        assert float(table[1].split(",")[0]) < alarm.raised_time_s <= float(table[-1].split(",")[0]) + 0.2
