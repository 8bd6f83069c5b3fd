"""When a slide is over, and how often slide protection acted in it."""

from functools import cache

from brake_monitor.config_file import load_settings
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.pipeline import Pipeline
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario
from brake_monitor.simulator.simulate import EPOCH_S, Recording
from brake_monitor.simulator.simulate import run as simulate
from brake_monitor.vehicle_files import example_config

STOPPED = Scenario(
    name="stop on leaves",
    summary="coast, full brake on a slippery rail until it stands, and stand",
    initial_speed_mps=10.0,
    duration_s=60.0,
    demand=Profile(((0.0, 0.0),)),
    rail_over_time=Profile(((3.0, 0.3), (4.0, 0.06))),
    journey=LegJourney((Leg(Act.COAST, lasts_s=5.0), Leg(Act.STAND, lasts_s=30.0, demand=1.0)), 500.0),
)
CLEAR_S = 2.0  # of the rule, and of low speed before


@cache
def locked_stop() -> Recording:
    return simulate(STOPPED, load_settings(example_config("wagon")), 3, Modifiers(slide_protection=False))


def last_of(recording: Recording, kind: str) -> dict[int | None, Alarm]:
    """The last state of each alarm of a kind, by wheelset."""
    pipeline = Pipeline.from_settings(recording.settings)
    given = [alarm for frame in recording.frames for alarm in pipeline.step(frame).alarms if alarm.kind == kind]
    return {alarm.wheelset: alarm for alarm in given}


def test_a_slide_with_locked_wheelsets_ends_where_the_wagon_stands() -> None:
    """Its wheelsets do not turn before the wagon does, perhaps hours later."""
    recording = locked_stop()
    speed_mps = recording.trace.wagon("speed_mps")
    stood_s = next(k for k, speed in enumerate(speed_mps) if k * recording.trace.step_s > 5.0 and speed < 0.02)
    stood_s *= recording.trace.step_s
    slides = last_of(recording, "slide")
    assert set(slides) == {1, 2}
    for slide in slides.values():
        assert slide.cleared_time_s is not None
        assert abs(slide.cleared_time_s - EPOCH_S - stood_s - CLEAR_S) < 1.0
        assert slide.evidence["speed_end_mps"] < 1.5  # walking pace, below which wheel-speed sensors cut out
