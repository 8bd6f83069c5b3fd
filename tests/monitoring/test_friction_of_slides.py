"""Of a stop on a slippery rail friction is known, though nobody knows what the line did meanwhile."""

from dataclasses import replace

import numpy as np
import pytest

from brake_monitor.monitoring.brake_units.application_record import ApplicationRecord
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.simulator.scenarios import SCENARIOS, Profile, Track
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from drives import drive

STRAIGHT = Profile(((0.0, 0.0),))
SLIDES_M = 1430.0  # from the beginning on, where slide protection has worked for some seconds
TELLS = 0.04  # a third of what a stop to standstill without slides leaves open


def last_application(recording: Recording) -> ApplicationRecord:
    pipeline = Pipeline.from_settings(recording.settings)
    ended = [application for frame in recording.frames for application in pipeline.step(frame).applications]
    return ended[-1]


def true_friction(recording: Recording, stop: ApplicationRecord, i: int) -> float:
    """Its mean over the pads' energy, between the times of the record."""
    trace = recording.trace
    time_s = np.arange(len(trace.values)) * trace.step_s
    during = (time_s >= stop.start_time_s - EPOCH_S) & (time_s <= stop.end_time_s - EPOCH_S)
    friction, force_n, omega = (trace.wheelset(i, n)[during] for n in ("friction", "pressing_force_n", "omega_radps"))
    return float(np.average(friction, weights=friction * force_n * omega))


@pytest.mark.parametrize("rise", [0.01, -0.01])
def test_friction_of_a_stop_with_slide_protection_is_told_though_the_gradient_changed(rise: float) -> None:
    line = Track(Profile(((0.0, 0.0), (SLIDES_M, 0.0), (SLIDES_M + 20.0, rise))), STRAIGHT)
    recording = drive(replace(SCENARIOS["wsp"], track=line))
    stop = last_application(recording)
    assert stop.end_speed_mps < 1.0
    for i, own in enumerate(stop.wheelsets):
        assert own.wsp_actions > 20
        assert own.friction is not None
        assert own.friction_std is not None
        assert own.friction_std < TELLS
        assert abs(own.friction - true_friction(recording, stop, i)) < 2.0 * own.friction_std
