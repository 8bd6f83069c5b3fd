"""A count as it was a while ago."""

from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.monitoring.rules.earlier_count import EarlierCount

SPAN_S = 3.0
STEPS_S = st.sampled_from([0.0, 0.1, 0.5, 1.0, 2.9, 3.0, 5.0])


@given(st.lists(st.tuples(STEPS_S, st.integers(0, 2))))
def test_it_is_the_count_at_the_first_observation_within_the_span(steps: list[tuple[float, int]]) -> None:
    earlier, seen = EarlierCount[int](SPAN_S), []
    time_s, count = 0.0, 0
    for step_s, more in steps:
        time_s, count = time_s + step_s, count + more
        seen.append((time_s, count))
        assert earlier.see(time_s, count) == next(then for then_s, then in seen if time_s - then_s <= SPAN_S)


def test_what_is_ahead_of_a_clock_that_was_set_back_is_not_told() -> None:
    earlier = EarlierCount[int](SPAN_S)
    earlier.see(10.0, 0)
    assert earlier.see(11.0, 4) == 0
    assert earlier.see(5.0, 4) == 4
