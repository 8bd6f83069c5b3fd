"""A gateway that tells what it was told last, when nothing reaches it any more: all speeds agree, and are wrong."""

import numpy as np
import pytest

from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.doubts.still_speeds import MANY_TIMES, STILL_S, TURNS_SEEN, StillSpeeds
from brake_monitor.estimation.estimate import Status
from drives import DRY, Judged, drive, play
from faults import repeating_gateway, silence

PERIOD_S = 0.01


@pytest.mark.parametrize(
    ("from_s", "status", "reason"),
    [(14.0, Status.INVALID, "pressing_force 1 frozen"), (16.5, Status.CONVERGING, Doubt.REPEATED)],
    ids=["with air left", "released"],
)
def test_what_a_gateway_tells_again_and_again_is_not_valid_for_long(from_s: float, status: Status, reason: str) -> None:
    """The brake is put on meanwhile, of which nothing tells. Air that is left of the last braking trembles, too."""
    recording = drive(DRY)
    seen = Judged.of(recording, play(recording.settings, repeating_gateway(from_s, 23.0)(recording.frames)))
    seen.assert_sound()
    seen.assert_honest()
    during = seen.during(from_s + 1.5, 23.0)
    assert during.statuses == {status}
    assert all(reason in estimate.reasons for estimate in during.told)
    assert Doubt.REPEATED not in seen.during(1.0, from_s).reasons


def test_a_gap_is_no_time_in_which_speeds_stood_still() -> None:
    """What is told first after it may by chance be what was told last before it."""
    recording = drive(DRY)
    frames = repeating_gateway(13.9, 15.6)(recording.frames)
    seen = Judged.of(recording, play(recording.settings, silence(14.0, 15.5)(frames)))
    assert Doubt.REPEATED not in seen.reasons


def still_after_s(speeds: StillSpeeds, from_s: float, to_s: float) -> float | None:
    """After how long standing still is in doubt, of speeds that move for the last time at `from_s`; None: never."""
    speeds.moved_s = from_s
    for time_s in np.arange(from_s, to_s, PERIOD_S):
        if speeds.are_dead(time_s):
            return float(time_s - from_s)
    return None


def turning(every_s: float, turns: int = TURNS_SEEN + 1) -> StillSpeeds:
    """What is known of speeds that turn back so often."""
    speeds = StillSpeeds()
    for k in range(turns):
        speeds.see_turn(k * every_s, -1.0)
    return speeds


@pytest.mark.parametrize(("every_s", "doubted_s"), [(0.02, STILL_S), (0.05, STILL_S), (0.3, 0.3 * MANY_TIMES)])
def test_the_noisier_sensors_are_the_sooner_they_are_doubted(every_s: float, doubted_s: float) -> None:
    """What hardly ever went to and fro may as well stand still."""
    assert still_after_s(turning(every_s), 100.0, 200.0) == pytest.approx(doubted_s, abs=3 * PERIOD_S)


def test_coarse_sensors_without_noise_are_never_doubted() -> None:
    """They stand still until the wagon has lost a step of theirs; then all of them go on the same way."""
    assert still_after_s(turning(15.0, turns=20), 300.0, 1300.0) is None


def test_sensors_that_stand_still_between_two_of_their_steps_are_doubted_once() -> None:
    """Their noise shows only as the speed passes from one step to the next."""
    speeds = turning(0.02)
    assert still_after_s(speeds, 8.0, 20.0) == pytest.approx(STILL_S, abs=3 * PERIOD_S)
    for time_s in (20.0, 20.02):  # to the next step, and to and fro there
        speeds.see_turn(time_s, -1.0)
    assert still_after_s(speeds, 28.0, 40.0) is None


def test_a_brake_teaches_nothing_of_noise() -> None:
    """As a wagon loses speed quickly, readings of it hardly ever turn back."""
    speeds = turning(0.02)
    speeds.see_turn(60.0, coasts_since_s=59.0)
    assert still_after_s(speeds, 100.0, 110.0) == pytest.approx(STILL_S, abs=3 * PERIOD_S)


def test_a_stop_teaches_nothing_of_noise() -> None:
    speeds = turning(0.02)
    speeds.begin(60.0)
    speeds.see_turn(60.5, coasts_since_s=-1.0)
    assert still_after_s(speeds, 100.0, 110.0) == pytest.approx(STILL_S, abs=3 * PERIOD_S)


def test_a_clock_that_is_set_back_begins_anew() -> None:
    """Else what was told before it would count."""
    speeds = turning(0.02)
    speeds.moved_s = 110.0
    assert not speeds.are_dead(10.0)
    assert still_after_s(speeds, 10.01, 12.0) == pytest.approx(STILL_S, abs=3 * PERIOD_S)
