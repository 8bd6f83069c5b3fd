"""A deceleration that nothing explained leaves friction in doubt until the release, or until slides tell of it."""

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Status
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from drives import Judged, drive, play
from faults import carries, in_order, within

LATE_FROM_S, LATE_TO_S, LATER_S = 8.5, 10.0, 0.2
SLIDES_TO_S, END_S = 34.0, 40.0
LONG_SLIDE = Scenario(
    name="a long slide",
    summary="coast, brake from 5 s until the end, slide from 6 to 34 s",
    initial_speed_mps=50.0,
    duration_s=END_S,
    demand=steps((5.0, 1.0)),
    rail_over_time=Profile(((5.0, 0.3), (6.0, 0.07), (SLIDES_TO_S, 0.07), (35.0, 0.3))),
)
WEAK = Modifiers(brake_faults=(BrakeFault(friction=Profile(((0.0, 0.88),))),))  # it never comes near nominal friction


def test_friction_that_slides_have_told_of_is_believed_though_it_is_not_what_was_known() -> None:
    recording = drive(LONG_SLIDE, WEAK)
    frames = [
        frame._replace(time_s=frame.time_s + LATER_S)
        if carries(frame, "GNSS") and within(frame, LATE_FROM_S, LATE_TO_S)
        else frame
        for frame in recording.frames
    ]
    judged = Judged.of(recording, play(recording.settings, in_order(frames)))
    assert Doubt.UNEXPLAINED in judged.during(LATE_FROM_S, LATE_TO_S + 1.0).reasons
    for began_s, ended_s in ((LATE_TO_S + 8.0, SLIDES_TO_S), (35.0, END_S - 0.5)):
        later = judged.during(began_s, ended_s)
        assert all(e.status is Status.VALID for e in later.told)
        assert abs(later.adhesion_error).max() < 0.01
        assert later.worst_friction() < 0.045
