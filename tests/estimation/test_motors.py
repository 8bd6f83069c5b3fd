"""Motors beside the pads: what they do is known, and not taken for the pads'; nor is what they are not known to do."""

from collections.abc import Iterator

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.frame import Frame
from brake_monitor.simulator.journey import Act, Leg, LegJourney
from brake_monitor.simulator.scenarios import Scenario
from brake_monitor.simulator.simulate import Recording
from motor_drives import (
    BRAKINGS,
    DRY,
    SLIPPERY,
    TORQUE_ID,
    as_it_came,
    during,
    played,
    recording,
    scaled,
    since_start_s,
    truth,
)

VALID = Status.VALID
MOTORS_FADE_S = 42.0  # in the second one of `BRAKINGS`


def frictions(drive: Recording, found: list[Estimate]) -> Iterator[tuple[float, float]]:
    """Error and deviation of each that is valid."""
    for now in found:
        for own, true in zip(now.wheelsets, truth(drive, now, "friction"), strict=True):
            if own.friction_status is VALID:
                yield own.friction - float(true), own.friction_std


def adhesion_error(drive: Recording, now: Estimate) -> float:
    """`adhesion` is braking positive whichever way the wagon goes."""
    row_speed_mps = truth_speed_mps(drive, now)
    creep_n = truth(drive, now, "creep_force_n").sum() * (1.0 if row_speed_mps >= 0.0 else -1.0)
    return now.adhesion - float(creep_n / truth(drive, now, "load_n").sum())


def truth_speed_mps(drive: Recording, now: Estimate) -> float:
    return float(drive.trace.wagon("speed_mps")[round((now.time_s - drive.frames[0].time_s) / 0.01)])


def test_friction_and_adhesion_hold_while_motors_hand_over_to_pads() -> None:
    drive = recording(BRAKINGS)
    found = during(played(drive), 25.0, 60.0)
    errors = list(frictions(drive, found))
    assert len(errors) > 100
    assert np.mean([abs(error) < 3.0 * std for error, std in errors]) > 0.97
    assert max(abs(adhesion_error(drive, now)) for now in found if now.status is VALID) < 0.008


def test_wheelsets_without_a_motor_need_no_signal_that_says_so() -> None:
    drive = recording(BRAKINGS)
    signals = drive.settings.signals
    torques = (*signals.wheel_torque[:2], "none", "none")
    settings = replace(drive.settings, signals=replace(signals, wheel_torque=torques))
    found = during(played(drive, settings=settings), 25.0, 60.0)
    errors = list(frictions(drive, found))
    assert len(errors) > 100
    assert np.mean([abs(error) < 3.0 * std for error, std in errors]) > 0.97
    assert max(abs(adhesion_error(drive, now)) for now in found if now.status is VALID) < 0.008
    assert all(own.motor_force_n == 0.0 for now in found for own in now.wheelsets[2:])
    assert max(own.motor_force_n or 0.0 for now in found for own in now.wheelsets[:2]) > 1000.0


@pytest.mark.parametrize("told", [0.96, 1.04])
def test_a_torque_that_is_told_a_little_wrong_leaves_adhesion_in_its_interval(told: float) -> None:
    drive = recording(BRAKINGS, (0, 1, 2, 3))

    found = [now for now in during(played(drive, scaled(told)), 25.0, MOTORS_FADE_S) if now.status is VALID]
    inside = [abs(adhesion_error(drive, now)) < 1.96 * now.adhesion_std for now in found]
    assert len(inside) > 100
    assert np.mean(inside) > 0.95


@pytest.mark.parametrize("told", [0.92, 1.08])
def test_by_how_much_torques_are_told_wrong_is_learned_and_not_taken_for_the_pads(told: float) -> None:
    drive = recording(BRAKINGS, (0, 1, 2, 3))
    found = during(played(drive, scaled(told)), 28.0, 60.0)
    errors = [adhesion_error(drive, now) for now in found if now.status is VALID]
    assert len(errors) > 100
    assert np.sqrt(np.mean(np.square(errors))) < 0.002
    pads = list(frictions(drive, during(found, MOTORS_FADE_S + 2.0, 60.0)))
    assert len(pads) > 100
    assert np.sqrt(np.mean([error * error for error, _ in pads])) < 0.02
    assert np.mean([abs(error) < 1.96 * std for error, std in pads]) > 0.95


def test_who_drives_backwards_uses_the_rail_the_other_way() -> None:
    legs = (
        Leg(Act.STAND, lasts_s=4.0, demand=0.3),
        Leg(Act.PULL, 7.0, pull_mps2=0.5),
        Leg(Act.COAST, lasts_s=3.0),
        Leg(Act.STAND, lasts_s=20.0, demand=0.6),
    )
    back = LegJourney(legs, 1e3, frozenset({1}))
    drive = recording(Scenario("back", "", 0.0, 40.0, back, DRY))
    found = [now for now in during(played(drive), 9.0, 40.0) if now.status is VALID]
    assert np.min(drive.trace.wagon("speed_mps")) < -6.0
    assert min(now.adhesion for now in found) < -0.03
    assert max(now.adhesion for now in found) > 0.03
    errors = [abs(adhesion_error(drive, now)) / now.adhesion_std for now in found]
    assert np.mean([error < 3.0 for error in errors]) > 0.97


def test_a_torque_that_was_never_told_lets_no_friction_show() -> None:
    found = during(played(recording(BRAKINGS), _without_torque), 5.0, 60.0)
    assert not [now for now in found for own in now.wheelsets if own.friction_status is VALID]
    assert all(own.motor_force_n is None for own in found[0].wheelsets)


def _without_torque(frame: Frame) -> Frame | None:
    return None if frame.can_id == TORQUE_ID else frame


def test_a_torque_that_is_lost_at_rest_may_act_unseen() -> None:
    """It was 0 as it was lost: the motor, which acted before, may act again."""
    drive = recording(BRAKINGS, (0, 1, 2, 3))
    found = during(played(drive, _lost_at_rest), 25.0, 60.0)
    assert not [now for now in found for own in now.wheelsets if own.friction_status is VALID]
    assert found
    assert not [now for now in found if now.status is VALID]


def _lost_at_rest(frame: Frame) -> Frame | None:
    return None if frame.can_id == TORQUE_ID and since_start_s(frame) > 20.0 else frame


def test_a_torque_that_comes_late_is_out_of_step_in_slides() -> None:
    drive = recording(SLIPPERY, (0, 1, 2, 3))
    in_step, late = (during(played(drive, change), 18.0, 32.0) for change in (as_it_came, _late))
    assert not any(Doubt.OUT_OF_STEP in now.reasons for now in in_step)
    assert np.mean([Doubt.OUT_OF_STEP in now.reasons for now in late]) > 0.7


def _late(frame: Frame) -> Frame:
    return frame._replace(time_s=frame.time_s + 0.1) if frame.can_id == TORQUE_ID else frame


def test_slides_under_motors_do_not_make_a_pressing_force_of_0_stand_still() -> None:
    found = during(played(recording(SLIPPERY, (0, 1, 2, 3))), 14.0, 32.0)
    assert any(now.saturated for now in found)
    assert not any(Doubt.STILL in now.reasons for now in found)
    assert all(own.renewed_slides == 0 for now in found for own in now.wheelsets)
