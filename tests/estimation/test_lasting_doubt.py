"""A doubt that lasts as long as the brake is on leaves the line no more in doubt than lines differ."""

import pytest

from brake_monitor.estimation.core.new_core import UNEXPLAINED_SIGMAS
from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.model.tuning import WAGON
from brake_monitor.simulator.scenarios import Profile, Scenario, steps
from drives import Judged, drive, play
from faults import in_order, lagging, within

RELEASED_S, END_S = 12.0, 50.0
TWICE = Scenario(
    name="a short braking and a long one",
    summary="coast, brake from 4 to 9 s, coast, brake from 14 s until the end; nothing slides",
    initial_speed_mps=38.0,
    duration_s=END_S,
    demand=steps((4.0, 0.6), (9.0, 0.0), (14.0, 0.5)),
    rail_over_time=Profile(((0.0, 0.45),)),
)
LATER_S = 0.25  # by which the vehicle's speed comes from then on: the lag strays from what the first braking has taught
LARGEST_MPS2 = UNEXPLAINED_SIGMAS * WAGON.deceleration_std
ONE_READING_MPS2 = 0.01  # the last one that adds to a doubt may do so beyond it


@pytest.fixture(scope="module")
def doubted() -> Judged:
    recording = drive(TWICE)
    frames = list(recording.frames)
    in_time = [frame for frame in frames if within(frame, 0.0, RELEASED_S)]
    late = [frame for frame in lagging("GNSS", LATER_S)(frames) if within(frame, RELEASED_S, END_S)]
    return Judged.of(recording, play(recording.settings, in_order(in_time + late))).during(RELEASED_S, END_S)


def test_the_speed_is_in_doubt_to_the_end(doubted: Judged) -> None:
    assert all(e.status.value == "converging" for e in doubted.during(20.0, END_S).told)


def test_why_adhesion_is_uncertain_is_told_with_it(doubted: Judged) -> None:
    uncertain = [e.reasons for e in doubted.during(20.0, END_S).told if "adhesion uncertain" in e.reasons]
    assert uncertain
    assert all(Doubt.BIASED in reasons for reasons in uncertain)


def test_what_is_in_doubt_is_no_more_than_lines_differ(doubted: Judged) -> None:
    widest_mps2 = max(e.deceleration_std_mps2 for e in doubted.told)
    assert widest_mps2 > 0.5 * LARGEST_MPS2
    assert widest_mps2 < LARGEST_MPS2 + ONE_READING_MPS2


def test_what_is_estimated_meanwhile_stays_near_the_truth(doubted: Judged) -> None:
    assert abs(doubted.adhesion_error).max() < 0.01
    assert doubted.worst_friction() < 0.05
