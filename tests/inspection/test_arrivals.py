"""When the values of a signal came."""

import numpy as np
import pytest

from brake_monitor.inspection import arrivals
from brake_monitor.inspection.arrivals import Arrivals
from first_hours import Floats

TENTHS_S = np.arange(0.0, 20.0, 0.1)
BUNCHES_S = (np.arange(0.0, 20.0, 0.1)[:, np.newaxis] + [0.0, 0.001, 0.002]).ravel()
PULSE_S = (np.arange(0.0, 40.0, 4.0)[:, np.newaxis] + [*np.arange(0.0, 1.3, 0.1), 2.2, 3.2]).ravel()


def seen(*blocks_s: Floats) -> Arrivals:
    noted = Arrivals()
    for times_s in blocks_s:
        noted.see(times_s)
    return noted


@pytest.mark.parametrize(
    ("times_s", "period_s", "is_bunched", "comes_on_change"),
    [
        (TENTHS_S, 0.1, False, False),
        (TENTHS_S[::-1], 0.1, False, False),  # a recording that runs backwards
        (BUNCHES_S, 0.098, True, False),
        (PULSE_S, 1.0, True, True),  # ten times a second while there is something to tell, else a sign of life
        (np.array([0.0, 100.0, 200.0]), 1.0, False, False),  # nothing is to be told of so seldom a sender
        (np.array([7.0]), 0.0, False, False),
    ],
    ids=["steady", "backwards", "in bunches", "on change", "seldom", "once"],
)
def test_how_values_come(times_s: Floats, period_s: float, is_bunched: bool, comes_on_change: bool) -> None:
    noted = seen(times_s)
    assert noted.period_s == pytest.approx(period_s)
    assert (noted.is_bunched, noted.comes_on_change) == (is_bunched, comes_on_change)


def test_gaps_of_a_recording_that_runs_backwards_come_from_its_end() -> None:
    assert list(seen(np.array([9.0, 4.0, 1.0, 0.0])).gaps_s) == [1.0, 3.0, 5.0]


@pytest.mark.parametrize("direction", [1, -1], ids=["ahead", "backwards"])
@pytest.mark.parametrize("cut", [1, 2, 99, 100])
def test_the_longest_gap_counts_wherever_it_lies(cut: int, direction: int) -> None:
    """As two blocks of a recording, of which one may end in the gap."""
    times_s = np.concatenate((TENTHS_S[:100], TENTHS_S[100:] + 7.0))[::direction]
    noted = seen(times_s[:cut], times_s[cut:])
    assert noted.longest_gap_s == pytest.approx(7.1)
    assert (noted.count, noted.begun_s, noted.ended_s) == (200, times_s.min(), times_s.max())


def test_of_a_long_recording_the_first_values_are_kept_and_all_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    """What it needs does not grow: later ones come three times as seldom, and one is missing for nine seconds."""
    monkeypatch.setattr(arrivals, "MOST_KEPT", 150)
    later_s = 20.0 + np.arange(0.0, 300.0, 0.3)
    noted = seen(TENTHS_S[:100], TENTHS_S[100:], later_s, later_s + 309.0)
    assert list(noted.times_s) == list(TENTHS_S[:150])
    assert not noted.all_kept
    assert noted.period_s == pytest.approx(0.1)
    assert noted.longest_gap_s == pytest.approx(9.3)
    assert (noted.count, noted.begun_s, noted.ended_s) == (2200, 0.0, later_s[-1] + 309.0)
