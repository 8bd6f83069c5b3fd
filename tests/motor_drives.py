"""Drives of the simulated railcar, whose motors brake before its pads do."""

from collections.abc import Callable
from functools import cache

import numpy as np

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.frame import Frame
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.physics.motors import Motors
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.simulate import EPOCH_S, Recording, run

ROW_S = 0.01
TORQUE_ID = 304  # of the message with all torques
DRY = Profile(((0.0, 0.45),))
BRAKINGS = Scenario("b", "a braking and a stop", 26.0, 55.0, steps((8.0, 0.5), (14.0, 0.0), (24.0, 0.8)), DRY)
SLIPPERY = Scenario(
    "s", "a braking on good rail, then one with slides", 26.0, 32.0, steps((6.0, 0.5), (10.0, 0.0), (14.0, 0.8)),
    Profile(((12.0, 0.45), (13.0, 0.05))),
)  # fmt: skip


@cache
def recording(
    scenario: Scenario, driven: tuple[int, ...] = (0, 1), fade_mps: float = 8.0, faults: tuple[BrakeFault, ...] = ()
) -> Recording:
    """Simulated once for all tests; wheelsets from 0."""
    modifiers = Modifiers(motors=Motors(frozenset(driven), fade_mps) if driven else None, brake_faults=faults)
    return run(scenario, example_settings("railcar"), 4, modifiers, row_s=ROW_S)


Change = Callable[[Frame], Frame | None]


def as_it_came(frame: Frame) -> Frame:
    """No change."""
    return frame


def played(drive: Recording, change: Change = as_it_came, settings: Settings | None = None) -> list[Estimate]:
    """What is estimated of it, frames being changed or, as None, lost."""
    outputs = _outputs(drive, change, settings or drive.settings)
    return [output.estimate for output in outputs if output.estimate is not None]


def scaled(told: float) -> Callable[[Frame], Frame]:
    """Torques are told as so much of what they are."""

    def scale(frame: Frame) -> Frame:
        if frame.can_id != TORQUE_ID:
            return frame
        torques_nm = np.frombuffer(frame.data, "<i2")
        return frame._replace(data=np.rint(told * torques_nm).astype("<i2").tobytes())

    return scale


def alarms(drive: Recording, change: Change = as_it_came) -> set[tuple[str, int | None]]:
    """What is raised, and of which wheelset (from 1)."""
    return {
        (alarm.kind, alarm.wheelset) for output in _outputs(drive, change, drive.settings) for alarm in output.alarms
    }


def _outputs(drive: Recording, change: Change, settings: Settings) -> list[Outputs]:
    pipeline = Pipeline.from_settings(settings)
    frames = sorted((new for frame in drive.frames if (new := change(frame))), key=lambda frame: frame.time_s)
    return [pipeline.step(frame) for frame in frames]


def since_start_s(frame: Frame) -> float:
    """Of the drive."""
    return frame.time_s - EPOCH_S


def during(found: list[Estimate], from_s: float, to_s: float) -> list[Estimate]:
    """Those in this span of the drive."""
    return [now for now in found if from_s <= now.time_s - EPOCH_S < to_s]


def truth(drive: Recording, now: Estimate, name: str) -> np.ndarray:
    """A column of the trace as of an estimate, one value per wheelset."""
    row = round((now.time_s - EPOCH_S) / ROW_S)
    return np.array([drive.trace.wheelset(i, name)[row] for i in range(drive.trace.wheelset_count)])
