"""Brakes at fault in a way that no sensor tells: once they are found, no estimate that errs by them is `valid`."""

from functools import cache

import numpy as np
import pytest

from brake_monitor.estimation.estimate import Status
from brake_monitor.monitoring.misled import MisledBy, qualified
from brake_monitor.processing.pipeline import Pipeline
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.plant import Modifiers
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.simulate import EPOCH_S, run
from drives import Judged
from estimates import estimate

BRAKED_ANEW_S, END_S = 50.0, 60.0
OFF = 0.02  # an error that nobody would call small


@cache
def drive(modifiers: Modifiers, restarted_s: float | None = None) -> tuple[Judged, dict[str, float]]:
    """Brake from 10 to 20 s, coast, brake again; what was told, and when each kind of alarm was raised."""
    scenario = Scenario(
        name="two brakings",
        summary="coast, brake from 10 s to 20 s, coast, brake from 50 s",
        initial_speed_mps=32.0,
        duration_s=END_S,
        demand=steps((10.0, 0.55), (20.0, 0.0), (BRAKED_ANEW_S, 0.55)),
        rail_over_time=Profile(((0.0, 0.45),)),
    )
    return played(scenario, modifiers, restarted_s)


def played(
    scenario: Scenario, modifiers: Modifiers, restarted_s: float | None = None
) -> tuple[Judged, dict[str, float]]:
    """What was told, and when each kind of alarm was raised; the daemon may be started anew meanwhile."""
    settings = example_settings("wagon")
    pipeline, recording = Pipeline.from_settings(settings), run(scenario, settings, 4, modifiers)
    outputs = []
    for frame in recording.frames:
        if restarted_s is not None and frame.time_s >= EPOCH_S + restarted_s:
            kept, restarted_s = pipeline.remembered(), None
            pipeline = Pipeline.from_settings(settings)
            pipeline.resume(kept)
        outputs.append(pipeline.step(frame))
    raised = {alarm.kind: alarm.raised_time_s - EPOCH_S for output in outputs for alarm in output.alarms}
    told = [output.estimate for output in outputs if output.estimate is not None]
    return Judged.of(recording, told), raised


def test_adhesion_is_not_valid_while_a_brake_is_known_to_drag_unseen() -> None:
    judged, raised = drive(Modifiers(brake_faults=(BrakeFault(0, stuck_force_n=20e3),)))
    told_s = raised["dragging_brake"]
    assert 20.0 < told_s < BRAKED_ANEW_S - 5.0
    before, since = judged.during(30.0, told_s), judged.during(told_s, BRAKED_ANEW_S)
    assert np.abs(since.adhesion_error).max() > 0.01  # it drags beside what the estimator knows
    assert Status.VALID in before.statuses
    assert since.statuses == {Status.CONVERGING}
    assert since.reasons == {MisledBy.DRAG}


def test_a_drag_that_was_found_misleads_also_after_a_restart() -> None:
    restarted_s = 46.0
    judged, raised = drive(Modifiers(brake_faults=(BrakeFault(0, stuck_force_n=20e3),)), restarted_s)
    assert raised["dragging_brake"] < restarted_s
    since = judged.during(restarted_s + 0.5, END_S)
    assert len(since.told) > 100
    assert Status.VALID not in since.statuses


def test_friction_is_not_valid_while_brakes_are_known_to_differ() -> None:
    judged, raised = drive(Modifiers(brake_faults=(BrakeFault(0, rigging=0.5),)))
    told_s = raised["uneven_braking"]
    assert told_s < BRAKED_ANEW_S
    braking = judged.during(BRAKED_ANEW_S + 2.0, END_S)
    assert np.abs(braking.friction_error).min() > OFF  # what one does not do is spread over both
    assert Status.VALID not in braking.friction_statuses(0) | braking.friction_statuses(1)
    assert {own.adhesion_status for e in braking.told for own in e.wheelsets} == {Status.CONVERGING}
    assert braking.statuses == {Status.VALID}  # the wagon's adhesion does not depend on who brakes
    assert np.abs(braking.adhesion_error).max() < 0.005
    assert braking.adhesion_dishonest_s() == 0.0


def test_without_such_an_alarm_estimates_are_given_out_as_they_are() -> None:
    sound = estimate()
    assert qualified(sound, frozenset()) is sound


def test_what_is_not_valid_for_other_reasons_keeps_them() -> None:
    lost = estimate(status=Status.INVALID, reasons=("speed lost",))
    doubted = qualified(lost, {MisledBy.DRAG})
    assert (doubted.status, doubted.reasons) == (Status.INVALID, ("speed lost",))
    assert [own.friction_status for own in doubted.wheelsets] == [Status.CONVERGING, Status.HELD]


@pytest.mark.parametrize(("from_s", "statuses"), [(0.0, {Status.CONVERGING}), (30.0, {Status.VALID})])
def test_friction_is_not_valid_beside_a_wheelset_that_may_have_been_locked_all_the_time(
    from_s: float, statuses: set[Status]
) -> None:
    """One whose speed drops to 0 in mid-run as no brake stops it has a sensor that is dead."""
    dead = SensorFault("axle_speed", 1, SensorFailure.STUCK, from_s, value=0.0)
    judged, raised = drive(Modifiers(sensor_faults=(dead,)))
    assert raised["input_implausible"] < from_s + 5.0
    assert judged.during(BRAKED_ANEW_S + 2.0, END_S).friction_statuses(0) == statuses


def test_a_brake_that_sticks_at_each_release_misleads_until_the_end() -> None:
    """It is found once: before the next application the wagon rolls with it already."""
    modifiers = Modifiers(brake_faults=(BrakeFault(0, stuck_force_n=9e3),))
    scenario = Scenario(
        name="three brakings",
        summary="coast, brake from 10 s to 20 s, and twice more",
        initial_speed_mps=40.0,
        duration_s=130.0,
        demand=steps((10.0, 0.4), (20.0, 0.0), (50.0, 0.4), (58.0, 0.0), (90.0, 0.4), (96.0, 0.0)),
        rail_over_time=Profile(((0.0, 0.45),)),
    )
    judged, raised = played(scenario, modifiers)
    since = judged.during(raised["dragging_brake"], 130.0)
    assert Status.VALID not in since.statuses
    assert raised["dragging_brake"] < 50.0


@cache
def braked_every_half_minute() -> tuple[Judged, dict[str, float]]:
    """Pads stick from the first release on; the wagon rolls too shortly for an alarm before it is braked anew."""
    scenario = Scenario(
        name="brakings in quick succession",
        summary="coast, brake from 12 s to 20 s, and from 41 s to 48 s",
        initial_speed_mps=40.0,
        duration_s=75.0,
        demand=steps((12.0, 0.4), (20.0, 0.0), (41.0, 0.4), (48.0, 0.0)),
        rail_over_time=Profile(((0.0, 0.45),)),
    )
    return played(scenario, Modifiers(brake_faults=(BrakeFault(0, stuck_force_n=15e3),)))


def test_a_drag_is_told_though_the_wagon_is_soon_braked_anew() -> None:
    _, raised = braked_every_half_minute()
    assert 50.0 < raised["dragging_brake"] < 72.0


def test_adhesion_is_not_valid_from_when_a_drag_is_found() -> None:
    judged, raised = braked_every_half_minute()
    until_told = judged.during(36.0, raised["dragging_brake"])
    assert until_told.statuses == {Status.CONVERGING}
    assert until_told.reasons == {MisledBy.DRAG}


def test_adhesion_is_not_valid_while_a_silent_brake_may_press_unseen() -> None:
    """A dead sensor and an isolated brake read the same, until wheelset and wagon have shown which it is."""
    dead = SensorFault("pressing_force", 1, SensorFailure.STUCK, 0.0, value=0.0)
    judged, raised = drive(Modifiers(sensor_faults=(dead,)))
    braking = judged.during(10.0, 20.0)
    assert braking.adhesion_dishonest_s() < 0.3  # so long the others take to come on, too
    assert MisledBy.SILENT in braking.reasons
    assert Status.VALID not in judged.during(11.0, raised["input_implausible"]).statuses


def test_beside_an_isolated_brake_adhesion_is_valid_as_soon_as_that_shows() -> None:
    judged, raised = drive(Modifiers(brake_faults=(BrakeFault(1, isolated=True),)))
    assert judged.during(raised["brake_not_applied"], 20.0).statuses == {Status.VALID}
    assert judged.during(BRAKED_ANEW_S, END_S).statuses == {Status.VALID}


def test_sound_brakes_that_come_on_together_are_in_no_such_doubt() -> None:
    judged, _ = drive(Modifiers())
    assert judged.during(5.0, END_S).statuses == {Status.VALID}
