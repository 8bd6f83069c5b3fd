"""Sensors that lag are put back to what they saw."""

from hypothesis import given
from hypothesis import strategies as st

from brake_monitor.estimation.inputs.alignment import Alignment
from brake_monitor.samples import Channel, Quality, Quantity, Sample


def channel(quantity: Quantity, delay_s: float) -> Channel:
    return Channel(quantity, 0, "can0", "M", "s", 0.01, delay_s, 1.0)


def sample(quantity: Quantity, time_s: float, quality: Quality = Quality.GOOD) -> Sample:
    return Sample(time_s, quantity, 0, time_s, quality)


def test_without_delays_nothing_waits() -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.0)])
    one = sample(Quantity.SPEED, 1.0)
    assert list(alignment.put(one)) == [one]


def test_a_lagging_speed_is_fused_where_it_belongs() -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.1), channel(Quantity.AXLE_SPEED, 0.0)])
    out = []
    for tenth in range(5):
        out += alignment.put(sample(Quantity.AXLE_SPEED, tenth / 10))
        out += alignment.put(sample(Quantity.SPEED, tenth / 10 + 0.01))
    speeds = [s for s in out if s.quantity is Quantity.SPEED]
    assert all(abs(s.time_s - (s.value - 0.1)) < 1e-12 for s in speeds)
    assert [s.time_s for s in out] == sorted(s.time_s for s in out)


@given(st.lists(st.tuples(st.sampled_from([Quantity.SPEED, Quantity.AXLE_SPEED]), st.floats(0.0, 0.1)), max_size=50))
def test_order_is_by_what_was_seen_and_nothing_is_lost(arrivals: list[tuple[Quantity, float]]) -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.15), channel(Quantity.AXLE_SPEED, 0.02)])
    time_s, out = 0.0, []
    for quantity, step_s in arrivals:
        time_s += step_s
        out += alignment.put(sample(quantity, time_s))
    out += alignment.put(sample(Quantity.SPEED, time_s + 10.0))
    assert [s.time_s for s in out] == sorted(s.time_s for s in out)
    assert len(out) == len(arrivals) + 1


def test_bad_news_does_not_wait() -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.1)])
    stale = sample(Quantity.SPEED, 2.0, Quality.STALE)
    assert list(alignment.put(stale)) == [stale]


def test_what_waits_of_a_lapsed_channel_does_not_come_after_the_news() -> None:
    """It would make the channel seem to go on, for ever: a lapse is told once."""
    alignment = Alignment([channel(Quantity.SPEED, 0.3), channel(Quantity.AXLE_SPEED, 0.0)])
    for hundredth in range(100):
        assert not alignment.put(sample(Quantity.AXLE_SPEED, hundredth / 100)) or hundredth >= 30
    stale = sample(Quantity.AXLE_SPEED, 1.0, Quality.STALE)
    assert list(alignment.put(stale)) == [stale]
    assert [s.quantity for s in alignment.put(sample(Quantity.SPEED, 2.0))] == [Quantity.SPEED]


def test_what_waits_when_the_clock_is_set_back_does_not_come_an_hour_later() -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.3), channel(Quantity.AXLE_SPEED, 0.0)])
    for tenth in range(10):
        alignment.put(sample(Quantity.AXLE_SPEED, 5000.0 + tenth / 10))
    assert not alignment.put(sample(Quantity.AXLE_SPEED, 1400.0))
    assert [one.time_s for one in alignment.ready(6000.0)] == [1400.0]


def test_a_sample_that_is_late_by_less_than_any_clock_is_set_keeps_the_others() -> None:
    alignment = Alignment([channel(Quantity.SPEED, 0.3), channel(Quantity.AXLE_SPEED, 0.0)])
    alignment.put(sample(Quantity.AXLE_SPEED, 10.0))
    assert [one.time_s for one in alignment.put(sample(Quantity.AXLE_SPEED, 8.8))] == []
    assert [one.time_s for one in alignment.ready(10.3)] == [8.8, 10.0]


def test_samples_of_one_instant_come_in_the_order_of_their_arrival() -> None:
    force, wheel = Quantity.PRESSING_FORCE, Quantity.AXLE_SPEED
    alignment = Alignment([channel(Quantity.SPEED, 0.1), channel(wheel, 0.0), channel(force, 0.0)])
    for quantity in (force, wheel, force):
        assert not alignment.put(sample(quantity, 1.0))
    assert [one.quantity for one in alignment.ready(1.1)] == [force, wheel, force]
