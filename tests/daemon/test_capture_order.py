"""Frames of two buses come as their threads happen to run, and go on in the order of their capture."""

import pytest

from brake_monitor.daemon.capture_order import LONGEST_HELD_S, MOST_HELD, PATIENCE_S, CaptureOrder
from brake_monitor.frame import Frame


def frame(bus: str, time_s: float) -> Frame:
    return Frame(time_s, bus, 0x100, False, b"")


def order_of(buses: int, *arrivals: tuple[str, float]) -> CaptureOrder:
    order = CaptureOrder(buses)
    for bus, time_s in arrivals:
        order.put(frame(bus, time_s), now_s=0.0)
    return order


def taken(order: CaptureOrder, now_s: float = 0.0) -> list[tuple[str, float]]:
    return [(frame.bus, frame.time_s) for frame in order.take(now_s)]


def test_of_one_bus_nothing_is_held() -> None:
    assert taken(order_of(1, ("a", 2.0), ("a", 1.0))) == [("a", 2.0), ("a", 1.0)]


def test_a_frame_waits_until_the_other_bus_has_come_as_far() -> None:
    order = order_of(2, ("a", 1.0), ("a", 2.0), ("a", 3.0), ("b", 1.5))
    assert taken(order) == [("a", 1.0), ("b", 1.5)]
    order.put(frame("b", 2.5), now_s=0.01)
    assert taken(order, 0.01) == [("a", 2.0), ("b", 2.5)]


def test_a_bus_that_gives_nothing_is_not_waited_for() -> None:
    order = order_of(2, ("b", 1.0), ("a", 1.1))
    assert taken(order) == [("b", 1.0)]
    order.put(frame("a", 1.2), now_s=PATIENCE_S)
    assert taken(order, PATIENCE_S) == [("a", 1.1), ("a", 1.2)]


def test_when_all_are_silent_nothing_is_left_behind() -> None:
    order = order_of(2, ("a", 1.0), ("b", 1.2), ("a", 1.3))
    assert taken(order) == [("a", 1.0), ("b", 1.2)]
    assert order.wait_s(0.1) < PATIENCE_S
    assert taken(order, PATIENCE_S) == [("a", 1.3)]
    assert order.wait_s(0.1) == 0.1


def test_a_clock_that_is_set_back_holds_nothing_up() -> None:
    order = order_of(2, ("a", 5000.0), ("b", 5000.1), ("a", 5000.2), ("a", 1400.0), ("b", 1400.1))
    assert taken(order) == [("a", 5000.0), ("b", 5000.1), ("a", 5000.2), ("a", 1400.0)]
    assert taken(order, PATIENCE_S) == [("b", 1400.1)]


def test_a_bus_that_is_far_behind_does_not_make_the_other_pile_up() -> None:
    order = order_of(2, ("b", 0.0), *(("a", 1.0 + number) for number in range(MOST_HELD)))
    order.put(frame("b", 0.5), now_s=0.0)
    assert len(taken(order)) >= MOST_HELD


def alternating(order: CaptureOrder, begin_s: float, end_s: float, behind_s: float) -> list[str]:
    """The buses in the order in which their frames come out, put in by turns; that of b is behind."""
    buses = []
    for k in range(round(begin_s * 100), round(end_s * 100)):
        now_s = k / 100
        order.put(frame("a", 1.7e9 + now_s), now_s)
        order.put(frame("b", 1.7e9 + now_s - behind_s), now_s)
        buses += [bus for bus, _ in taken(order, now_s)]
    return buses


def test_buses_whose_clocks_differ_wait_for_each_other_no_longer_than_a_second(
    caplog: pytest.LogCaptureFixture,
) -> None:
    order = CaptureOrder(2)
    first = alternating(order, 0.0, 10.0, behind_s=1000.0)
    assert first.count("a") == first.count("b")
    assert order.held == 0
    (line,) = caplog.messages
    assert "bus b are 1000.0 s behind those of bus a" in line
    alternating(order, 10.0, 11.0, behind_s=0.1)  # it was set right
    assert taken(order, 11.0) == []
    assert [bus for bus, _ in taken(order, 11.0 + PATIENCE_S)] == 10 * ["a"]  # waited for b again


def test_a_thread_that_is_late_for_less_loses_no_order() -> None:
    order = CaptureOrder(2)
    for k in range(90):
        order.put(frame("a", k / 100), 0.0)
    order.put(frame("b", 0.0), 0.9 * LONGEST_HELD_S)
    out = taken(order, 0.9 * LONGEST_HELD_S)
    order.put(frame("b", 0.9), 0.95 * LONGEST_HELD_S)
    out += taken(order, 0.95 * LONGEST_HELD_S)
    assert [time_s for _, time_s in out] == sorted(time_s for _, time_s in out)
    assert len(out) == 92
