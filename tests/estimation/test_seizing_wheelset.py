"""A bearing that seizes inside a train, which goes on as before: a rail turns what slides, and does not stop it."""

from math import exp

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.doubts.seizing import Seizing
from brake_monitor.estimation.estimate import Status
from brake_monitor.simulator.simulate import EPOCH_S
from drives import DRY, drive, play
from faults import signal_changed

SEIZED_WITHIN_S, LASTS_S = 0.3, 1.2  # its torque rises, and goes
STEP_S = 1e-4
RAIL, RELAXES_AT = 0.2, 0.004  # adhesion of a dry rail, and by which slip it has given nearly two thirds of it
ASKED = 0.06  # adhesion that the brake asks for, where it brakes
TOLD_WITHIN_S = 0.25  # after a tenth of slip
GOOD_AFTER_S = 4.0  # it rolls after half a second or so, and the doubt lasts for three


def wheel_speeds(from_s: float, *, braked: bool) -> tuple[np.ndarray, np.ndarray, float]:
    """Times, and the circumferential speed of a wheelset of the example wagon; when it has a tenth of slip.

    J d(omega)/dt = mu L r_W - T.
    """
    recording = drive(DRY)
    vehicle, trace = recording.settings.vehicle, recording.trace
    per_adhesion_mps2 = vehicle.mass_kg * 9.81 / 2 * vehicle.wheel_radius_m[0] ** 2 / vehicle.wheelset_inertia_kgm2[0]
    times_s = np.arange(from_s - 1.0, from_s + LASTS_S + 2.0, STEP_S)
    vehicle_mps = np.interp(times_s, np.arange(len(trace.values)) * trace.step_s, trace.wagon("speed_mps"))
    wheel_mps, speed_mps = np.empty_like(times_s), vehicle_mps[0]
    for k, (time_s, v_mps) in enumerate(zip(times_s.tolist(), vehicle_mps.tolist(), strict=True)):
        wheel_mps[k] = speed_mps
        seized = min((time_s - from_s) / SEIZED_WITHIN_S, 1.0) if from_s <= time_s < from_s + LASTS_S else 0.0
        slip = 1.0 - speed_mps / v_mps
        adhesion = RAIL * (1.0 - exp(-abs(slip) / RELAXES_AT)) * np.sign(slip)
        stopped = 1.5 * RAIL * seized + ASKED * braked
        speed_mps = max(speed_mps + (adhesion - stopped) * per_adhesion_mps2 * STEP_S, 0.0)
    return times_s, wheel_mps, float(times_s[np.argmax(wheel_mps < 0.9 * vehicle_mps)])


@pytest.mark.parametrize(("from_s", "braked"), [(13.5, False), (8.0, True)])
def test_nothing_is_valid_while_a_wheelset_seizes_and_everything_is_soon_afterwards(
    from_s: float, *, braked: bool
) -> None:
    """The train hides it: by the wagon's speed nothing retards."""
    recording = drive(DRY)
    times_s, wheel_mps, slides_s = wheel_speeds(from_s, braked=braked)
    seized = signal_changed(
        "wheel speed", lambda time_s, _: 3.6 * np.interp(time_s, times_s, wheel_mps), times_s[0], times_s[-1]
    )
    train = replace(recording.settings, estimator=replace(recording.settings.estimator, preset="train"))
    found = [(e.time_s - EPOCH_S, e) for e in play(train, seized(recording.frames))]
    during = [e for time_s, e in found if slides_s + TOLD_WITHIN_S <= time_s < from_s + LASTS_S]
    assert len(during) > 5
    assert {e.status for e in during} <= {Status.CONVERGING, Status.INVALID}
    assert all(Doubt.SEIZES in e.reasons for e in during if e.status is Status.CONVERGING)
    assert not any(wheel.friction_status is Status.VALID for e in during for wheel in e.wheelsets)
    good_s = from_s + LASTS_S + GOOD_AFTER_S
    assert {e.status for time_s, e in found if good_s <= time_s < good_s + 1.0} == {Status.VALID}


@pytest.mark.parametrize("slides", [False, True])
def test_one_that_rolls_or_is_turned_by_its_rail_does_not_seize(slides: bool) -> None:
    seizing, slip, adhesion = Seizing(), 0.3 * slides, 0.05 if slides else -0.05
    assert not any(seizing.see(0.01 * k, slip, adhesion, 0.001) for k in range(100))


def test_what_lasts_for_two_readings_or_lies_within_what_is_not_known_is_no_seizing() -> None:
    seizing = Seizing()
    assert not any(seizing.see(0.02 * k, 0.3, -0.1 if k % 5 < 2 else 0.05, 0.001) for k in range(100))
    assert not any(seizing.see(3.0 + 0.02 * k, 0.3, -0.1, 0.03) for k in range(100))


def test_one_that_has_rolled_has_to_seize_anew() -> None:
    seizing = Seizing()
    assert any(seizing.see(0.02 * k, 0.3, -0.1, 0.001) for k in range(10))
    seizing.rolls()
    assert not seizing.is_on
    assert not seizing.see(10.0, 0.3, -0.1, 0.001)
