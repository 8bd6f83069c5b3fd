"""Recorded frames are given as far apart as they were captured, whatever a clock did meanwhile."""

from math import inf

import pytest

from brake_monitor.frame import Frame
from brake_monitor.host import pacing


class Clock:
    """Stands still but for what is slept."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s

    def sleep(self, wait_s: float) -> None:
        assert 0.0 < wait_s < 9e9  # more overflows
        self.now_s += wait_s


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(pacing, "time", clock)
    return clock


def given_s(clock: Clock, speed: float, *times_s: float) -> list[float]:
    """When frames of these times are given."""
    return [clock.now_s for _ in pacing.paced([Frame(time_s, "can0", 0x120, False, b"") for time_s in times_s], speed)]


def test_frames_come_as_far_apart_as_they_were(clock: Clock) -> None:
    assert given_s(clock, 1.0, 100.0, 100.5, 102.0) == pytest.approx([0.0, 0.5, 2.0])


def test_at_twice_the_speed_half_as_far(clock: Clock) -> None:
    assert given_s(clock, 2.0, 100.0, 100.5, 102.0) == pytest.approx([0.0, 0.25, 1.0])


def test_at_infinite_speed_at_once(clock: Clock) -> None:
    assert given_s(clock, inf, 100.0, 500.0, 1e9) == [0.0, 0.0, 0.0]


def test_after_a_step_back_at_once(clock: Clock) -> None:
    assert given_s(clock, 1.0, 100.0, 101.0, 50.0) == pytest.approx([0.0, 1.0, 1.0])


def test_a_clock_that_was_set_by_ages_is_no_failure(clock: Clock) -> None:
    assert len(given_s(clock, 1e-3, 100.0, 5e10)) == 2
