"""What is at hand is what arrived, bounded, and small."""

import tracemalloc
from collections.abc import Callable, Sequence
from math import inf, nan

import pytest

from brake_monitor.estimation.estimate import Estimate
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.processing.at_hand import ENTRIES_IN_BLOCK, AtHand, entry_count
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import run as simulate
from drives import DRY, SLIDE, drive, play
from estimates import estimate

FRAMES = [
    Frame(1700000000.123456, "can0", 0x7FF, False, b""),
    Frame(1700000000.5, "can0", 0x7FF, True, b"\x00" * 8),
    Frame(1700000001.0, "front", 0x1FFFFFFF, True, bytes(range(64))),
    Frame(1700000001.0, "front", 0x1, False, b"", FrameKind.REMOTE),
    Frame(1700000002.0, "front", 0x80, True, b"\x00" * 8, FrameKind.ERROR),
]


def at_hand(times_s: Sequence[float], most: int = 10**6) -> AtHand[Frame]:
    """One frame at each of the times, as they arrived."""
    kept = AtHand(Frame, most)
    for time_s in times_s:
        kept.add([Frame(float(time_s), "can0", 0x123, False, b"\x01")])
    return kept


def times_s(kept: AtHand[Frame], begin_s: float = -inf, end_s: float = inf) -> list[float]:
    return [frame.time_s for frame in kept.between(begin_s, end_s)]


def test_frames_of_any_kind_come_back_as_they_were() -> None:
    kept = AtHand(Frame, 10**6)
    kept.add(FRAMES * 100)
    back = list(kept.between(-inf, inf))
    assert back == FRAMES * 100
    assert {type(frame.kind) for frame in back} == {FrameKind}


@pytest.mark.parametrize("vehicle", ["wagon", "railcar", "bogie"])
def test_estimates_come_back_to_the_last_bit(vehicle: str) -> None:
    settings = example_settings(vehicle)
    given = play(settings, list(simulate(SLIDE, settings, seed=5).frames))
    assert len(given) > 200
    kept = AtHand(Estimate, 10**6)
    kept.add(given)
    assert list(kept.between(-inf, inf)) == given


@pytest.mark.parametrize("value", [inf, -inf, nan, 5e-324, -0.0])
def test_what_is_no_ordinary_number_comes_back(value: float) -> None:
    kept = AtHand(Estimate, 10)
    kept.add([estimate(nis=value)])
    (back,) = kept.between(-inf, inf)
    assert repr(back.nis) == repr(value)


def test_both_ends_of_a_span_are_in_it() -> None:
    assert times_s(at_hand(range(300)), 100.0, 200.0) == list(range(100, 201))


def test_the_newest_of_a_span_come_oldest_first() -> None:
    span = at_hand(range(300)).between(10.0, 200.0)
    assert [frame.time_s for frame in span.newest(100)] == list(range(101, 201))
    assert [frame.time_s for frame in span.newest(1000)] == list(range(10, 201))


def test_asking_again_and_again_changes_nothing() -> None:
    kept = at_hand([])
    for time_s in range(300):
        kept.add([Frame(float(time_s), "can0", 0x123, False, b"")])
        assert times_s(kept)[-1] == time_s
    assert times_s(kept) == list(range(300))


@pytest.mark.parametrize("most", [1, ENTRIES_IN_BLOCK, 1000])
def test_as_many_as_wanted_are_kept_and_no_more_than_a_block_besides(most: int) -> None:
    found = times_s(at_hand(range(5000), most))
    assert found == list(range(5000 - len(found), 5000))
    assert most <= len(found) < most + ENTRIES_IN_BLOCK


def test_what_is_too_old_goes() -> None:
    kept = at_hand(range(1000))
    kept.forget_before(500.0)
    assert 500 - ENTRIES_IN_BLOCK < times_s(kept)[0] <= 500
    assert times_s(kept)[-1] == 999


def test_after_a_clock_was_set_only_what_is_near_stays_wherever_it_stands() -> None:
    kept = at_hand([*range(5000, 5200), *range(100)])
    kept.keep_near(99.0, 20.0)
    assert times_s(kept) == list(range(80, 100))


def test_what_two_spans_share_is_in_memory_once() -> None:
    kept = at_hand(range(10 * ENTRIES_IN_BLOCK))
    spans = [kept.between(0.0, inf), kept.between(0.0, inf)]
    assert entry_count(spans) == entry_count(spans[:1]) == 10 * ENTRIES_IN_BLOCK


def held_bytes(make: Callable[[], object]) -> int:
    """What is left in memory of all that was made."""
    tracemalloc.start()
    try:
        kept = make()
        size = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert kept
    return size


def test_five_minutes_of_estimates_and_of_frames_take_little_memory() -> None:
    """One by one these are 1.0 to 1.6 kB and some 200 bytes each; as arrays frames were 53."""
    frames = list(drive(DRY).frames)
    given = play(example_settings("wagon"), frames)
    for kind, entries, most_bytes in ((Estimate, given, 300), (Frame, frames, 25)):

        def keep(kind: type = kind, entries: list[Estimate] | list[Frame] = entries) -> object:
            kept: AtHand[Estimate] | AtHand[Frame] = AtHand(kind, 10**6)
            kept.add(entries)
            return kept.between(-inf, inf)

        assert held_bytes(keep) < most_bytes * len(entries)
