"""A wagon whose sensors are coarse and whose WSP tells nothing: its sensors' faults are still no brake's."""

from pathlib import Path

import pytest

from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.simulator.simulate import EPOCH_S, TRUTH_STEP_S, run
from brake_monitor.simulator.troubles import TROUBLES
from coarse_bogie import coarse_bogie

SECONDS = 95.0


def alarms(name: str, folder: Path) -> list[Alarm]:
    """Of the trouble's first two brakings, as they were raised."""
    trouble, settings = TROUBLES[name], coarse_bogie(folder)
    frames = run(trouble.scenario, trouble.settings(settings), 1, trouble.modifiers, row_s=TRUTH_STEP_S).frames
    pipeline = Pipeline.from_settings(settings)
    until = [frame for frame in frames if frame.time_s < EPOCH_S + SECONDS]
    return [alarm for frame in until for alarm in pipeline.step(frame).alarms]


@pytest.mark.parametrize("name", ["frozen-pressure", "pressure-stuck"])
def test_a_pressure_that_stands_is_the_sensors_fault(name: str, tmp_path: Path) -> None:
    raised = alarms(name, tmp_path)
    assert {(alarm.kind, alarm.wheelset) for alarm in raised} == {("input_implausible", 1)}


def test_a_brake_that_never_fills_is_the_brakes_fault(tmp_path: Path) -> None:
    raised = alarms("unapplied", tmp_path)
    assert {(alarm.kind, alarm.wheelset) for alarm in raised} == {("brake_not_applied", 1)}
