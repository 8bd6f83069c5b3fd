"""Which wheel speeds spike, from how their readings surprise and come back."""

from collections.abc import Sequence

import pytest

from brake_monitor.estimation.spike_watch import SpikeWatch

STEP_S = 0.02


def after(surprises: Sequence[tuple[float, bool, float]], *, from_s: float = 0.0) -> SpikeWatch:
    """A watch that has seen readings that surprise, whether they were taken, and what the next ones were off by."""
    watch = SpikeWatch()
    for k, (off_radps, taken, next_radps) in enumerate(surprises):
        time_s = from_s + 0.5 * k
        watch.note(time_s, off_radps, taken)
        assert watch.awaits
        watch.see_next(time_s + STEP_S, next_radps)
        assert not watch.awaits
    return watch


@pytest.mark.parametrize("off_radps", [-1.2, 1.2])
def test_readings_that_come_back_at_once_are_spikes(off_radps: float) -> None:
    """Taken for true, the filter is off by as much in its next step; rejected, it is not off."""
    assert after([(off_radps, True, -off_radps)] * 3).is_on(2.0)
    assert after([(off_radps, False, 0.05)] * 3).is_on(2.0)


def test_one_alone_may_be_the_rail() -> None:
    assert not after([(-1.2, True, 1.2)]).is_on(1.0)


@pytest.mark.parametrize("next_radps", [-1.2, -0.4, 0.0, 0.3])
def test_a_wheelset_that_begins_to_slide_does_not_come_back(next_radps: float) -> None:
    assert not after([(-1.2, True, next_radps)] * 10).is_on(5.1)


def test_nor_does_an_outlier_that_was_none() -> None:
    assert not after([(-1.2, False, -1.2)] * 10).is_on(5.1)


def test_a_reading_long_after_says_nothing_nor_does_one_from_before() -> None:
    watch = SpikeWatch()
    for passed_s in (1.0, -1.0):
        for _ in range(10):
            watch.note(100.0, -1.2, True)
            watch.see_next(100.0 + passed_s, 1.2)
    assert not watch.is_on(101.0)


def test_spikes_are_forgotten_and_a_clock_that_was_set_back_forgets_them() -> None:
    watch = after([(-1.2, True, 1.2)] * 5, from_s=1000.0)
    assert watch.is_on(1003.0)
    assert not watch.is_on(1060.0)
    assert not watch.is_on(500.0)
