"""Which wheel speeds spike, from how their readings surprise and come back."""

from collections.abc import Sequence

import pytest

from brake_monitor.estimation.doubts.spike_watch import SpikeWatch

STEP_S = 0.02
OMEGA_RADPS = 60.0  # without what surprises


def after(
    surprises: Sequence[tuple[float, bool, float]], *, from_s: float = 0.0, to_radps: float = OMEGA_RADPS
) -> SpikeWatch:
    """A watch that has seen readings that surprise, whether they were taken, and what the next ones were off by.

    The next ones are at `to_radps`.
    """
    watch = SpikeWatch()
    for k, (off_radps, taken, next_radps) in enumerate(surprises):
        time_s = from_s + 0.5 * k
        watch.note(time_s, OMEGA_RADPS + off_radps, off_radps, taken)
        assert watch.awaits
        was_spike = watch.see_next(time_s + STEP_S, to_radps, next_radps)
        assert not (was_spike and not taken)
        assert not watch.awaits
    return watch


@pytest.mark.parametrize("off_radps", [-1.2, 1.2])
def test_readings_that_come_back_at_once_are_spikes(off_radps: float) -> None:
    """Taken for true, the filter is off by as much in its next step, and by twice as much if it goes on; else not."""
    assert after([(off_radps, True, -off_radps)] * 3).is_on(2.0)
    assert after([(off_radps, True, -2.0 * off_radps)] * 3).is_on(2.0)
    assert after([(off_radps, False, 0.05)] * 3).is_on(2.0)


@pytest.mark.parametrize(
    ("taken", "next_radps", "was_spike"), [(True, -2.4, True), (True, 0.0, False), (False, 0.0, False)]
)
def test_a_spike_that_was_taken_for_true_is_told_by_the_next_reading(
    taken: bool, next_radps: float, was_spike: bool
) -> None:
    watch = SpikeWatch()
    watch.note(1.0, OMEGA_RADPS + 1.2, 1.2, taken)
    assert watch.see_next(1.0 + STEP_S, OMEGA_RADPS, next_radps) is was_spike


def test_a_next_reading_that_is_off_by_more_than_a_spike_leaves_shows_something_else() -> None:
    """Taken for true, a spike leaves twice itself at the most; held back, it leaves the prediction what it was."""
    assert not after([(1.2, True, -3.6)] * 3).is_on(2.0)
    assert not after([(1.2, False, -0.9)] * 3).is_on(2.0)


def test_one_alone_may_be_the_rail() -> None:
    assert not after([(-1.2, True, 1.2)]).is_on(1.0)


@pytest.mark.parametrize("next_radps", [-1.2, -0.4, 0.0, 0.3])
def test_a_wheelset_that_begins_to_slide_does_not_come_back(next_radps: float) -> None:
    assert not after([(-1.2, True, next_radps)] * 10).is_on(5.1)


def test_nor_does_one_that_finds_hold_and_rolls() -> None:
    """It is far below what its pull foretold, as a spike's next reading is, but above the one that surprised."""
    assert not after([(1.6, True, -1.4)] * 10, to_radps=OMEGA_RADPS + 2.7).is_on(5.1)


def test_nor_does_an_outlier_that_was_none() -> None:
    assert not after([(-1.2, False, -1.2)] * 10).is_on(5.1)


def test_a_reading_long_after_says_nothing_nor_does_one_from_before() -> None:
    watch = SpikeWatch()
    for passed_s in (1.0, -1.0):
        for _ in range(10):
            watch.note(100.0, OMEGA_RADPS - 1.2, -1.2, True)
            watch.see_next(100.0 + passed_s, OMEGA_RADPS, 1.2)
    assert not watch.is_on(101.0)


def test_spikes_are_forgotten_and_a_clock_that_was_set_back_forgets_them() -> None:
    watch = after([(-1.2, True, 1.2)] * 5, from_s=1000.0)
    assert watch.is_on(1003.0)
    assert not watch.is_on(1060.0)
    assert not watch.is_on(500.0)
