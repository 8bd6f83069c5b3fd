"""What readings taught while they were in doubt is in doubt when they no longer are, once."""

import pytest

from brake_monitor.estimation.doubts.consistency import (
    DEAD,
    DOUBT_S,
    LARGEST_NIS,
    LASTS_S,
    OUT_OF_STEP,
    REPEATED,
    SEIZES,
    STILL,
    TAUGHT_S,
    Consistency,
    WheelChecks,
)

SPACING_S = 0.02
END_S = 40.0


def ended(scatters_s: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """When doubts ended, and how much was wrong then, of a wheelset whose speeds scatter in these spans."""
    consistency, wheel, found = Consistency(), WheelChecks(), []
    for k in range(round(END_S / SPACING_S)):
        time_s = k * SPACING_S
        scatters = any(begin_s <= time_s < end_s for begin_s, end_s in scatters_s)
        consistency.see_wheel(time_s, wheel, LARGEST_NIS if scatters else 0.5, 40.0, 0.0)
        if wrong := consistency.taught_wrongly(time_s):
            consistency.deal_with_doubts(time_s)
            found.append((time_s, wrong))
    return found


def test_nothing_is_wrong_where_nothing_was_in_doubt() -> None:
    assert ended([]) == []


def test_all_is_in_doubt_once_after_wheel_speeds_have_scattered_for_long() -> None:
    ((end_s, wrong),) = ended([(10.0, 20.0)])
    assert wrong == 1.0
    assert end_s > 20.0 + DOUBT_S


@pytest.mark.parametrize("doubt", [OUT_OF_STEP, STILL, REPEATED, DEAD, SEIZES])
def test_all_is_in_doubt_once_after_readings_were_late_or_stood_still(doubt: int) -> None:
    consistency = Consistency()
    consistency.raised_s[doubt] = 10.0
    end_s = 10.0 + LASTS_S[doubt]
    assert consistency.taught_wrongly(end_s - SPACING_S) == 0.0
    assert consistency.taught_wrongly(end_s + SPACING_S) == 1.0
    consistency.deal_with_doubts(end_s + SPACING_S)
    assert consistency.taught_wrongly(end_s + 2.0 * SPACING_S) == 0.0


def test_who_scatters_for_a_moment_teaches_little() -> None:
    ((_, wrong),) = ended([(10.0, 10.5)])
    assert 0.0 < wrong < 0.5


def test_who_scatters_again_before_the_doubt_ends_has_scattered_all_the_time() -> None:
    found = ended([(10.0, 11.0), (12.0, 13.0), (14.0, 15.0)])
    assert [wrong for _, wrong in found] == [1.0]
    assert found[0][0] - 10.0 > TAUGHT_S


@pytest.mark.parametrize("by_s", [0.5, 600.0])
def test_a_clock_that_is_set_back_changes_nothing(by_s: float) -> None:
    consistency, wheel = Consistency(), WheelChecks()
    for k in range(500):
        consistency.see_wheel(1000.0 + k * SPACING_S, wheel, LARGEST_NIS, 40.0, 0.0)
    consistency.set_back(by_s)
    end_s = 1010.0 - by_s
    assert consistency.taught_wrongly(end_s + DOUBT_S - 0.5) == 0.0
    assert consistency.taught_wrongly(end_s + DOUBT_S) == 1.0
