"""Rules on brakes where motors brake as well: sound brakes are not accused, and what is wrong is still found."""

import struct

from brake_monitor.frame import Frame
from brake_monitor.simulator.brake_faults import BrakeFault
from brake_monitor.simulator.scenarios import Scenario, steps
from motor_drives import BRAKINGS, DRY, SLIPPERY, TORQUE_ID, alarms, recording

EARLY_FADE_MPS = 40.0  # wholly gone at half of it: pads brake alone below


def test_sound_brakes_are_not_accused_where_motors_brake_two_of_four_wheelsets() -> None:
    assert not alarms(recording(BRAKINGS))


def test_nor_where_the_torque_is_told_too_high() -> None:
    assert not alarms(recording(BRAKINGS), _ten_per_cent_more)


def _ten_per_cent_more(frame: Frame) -> Frame:
    if frame.can_id != TORQUE_ID:
        return frame
    return frame._replace(data=struct.pack("<4h", *(round(1.1 * raw) for raw in struct.unpack("<4h", frame.data))))


def test_nor_where_the_torque_has_never_come() -> None:
    found = alarms(recording(BRAKINGS), lambda frame: None if frame.can_id == TORQUE_ID else frame)
    assert {kind for kind, _ in found} == {"input_lost"}


def test_slides_under_motors_tell_of_the_rail_and_not_of_the_brakes() -> None:
    kinds = {kind for kind, _ in alarms(recording(SLIPPERY))}
    assert "low_adhesion" in kinds
    assert kinds <= {"low_adhesion", "slide"}


def test_a_brake_that_does_nothing_is_found_as_pads_brake_alone() -> None:
    drive = recording(BRAKINGS, fade_mps=EARLY_FADE_MPS, faults=(BrakeFault(0, isolated=True),))
    assert alarms(drive) == {("brake_not_applied", 1)}


def test_a_brake_that_drags_unseen_after_motors_have_braked_is_found() -> None:
    released = Scenario("r", "a braking", 33.0, 46.0, steps((8.0, 0.8), (16.0, 0.0)), DRY)
    drive = recording(released, faults=(BrakeFault(2, stuck_force_n=10e3),))
    assert alarms(drive) == {("dragging_brake", 3)}
