"""Frames of two buses come as their threads happen to run, and go on in the order of their capture."""

import pytest

from brake_monitor.daemon.capture_order import MOST_HELD, PATIENCE_S, CaptureOrder
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


@pytest.mark.parametrize("new_s", [1400.0, 4999.4])
def test_a_clock_that_is_set_back_holds_nothing_up(new_s: float) -> None:
    order = order_of(2, ("a", 5000.0), ("b", 5000.1), ("a", 5000.2), ("a", new_s), ("b", new_s + 0.1))
    assert taken(order) == [("a", 5000.0), ("b", 5000.1), ("a", 5000.2), ("a", new_s)]
    assert taken(order, PATIENCE_S) == [("b", new_s + 0.1)]


def test_a_bus_that_was_last_heard_before_the_clock_was_set_back_is_not_ahead(caplog: pytest.LogCaptureFixture) -> None:
    order = order_of(3, ("c", 5000.0), ("a", 5000.1), ("b", 5000.1))
    for now_s, bus in ((0.01, "a"), (0.01, "b"), (0.02, "a")):
        order.put(frame(bus, 1400.0 + now_s), now_s)
    order.take(0.02)
    assert order.held == 1
    assert taken(order, 1.0) == [("a", 1400.02)]  # as after a pause of the program
    assert caplog.messages == []


def test_a_bus_that_is_far_behind_does_not_make_the_other_pile_up() -> None:
    order = order_of(2, ("b", 0.0), *(("a", 1.0 + number) for number in range(MOST_HELD)))
    order.put(frame("b", 0.5), now_s=0.0)
    assert len(taken(order)) >= MOST_HELD


def played(order: CaptureOrder, arrivals: list[tuple[float, str, float]]) -> list[tuple[str, float]]:
    """What comes out of frames that arrive when, from where, stamped how; looked for with each."""
    found = []
    for now_s, bus, time_s in sorted(arrivals):
        order.put(frame(bus, time_s), now_s)
        found += taken(order, now_s)
    return found


def steady(bus: str, begin_s: float, end_s: float, every_s: float, ahead_s: float) -> list[tuple[float, str, float]]:
    count = round((end_s - begin_s) / every_s)
    return [(begin_s + k * every_s, bus, begin_s + k * every_s + ahead_s) for k in range(count)]


def test_buses_whose_clocks_differ_wait_for_each_other_no_longer(caplog: pytest.LogCaptureFixture) -> None:
    order = CaptureOrder(2)
    out = played(order, steady("a", 0.0, 10.0, 0.01, 0.0) + steady("b", 0.0, 10.0, 0.01, -1000.0))
    assert [bus for bus, _ in out].count("a") == [bus for bus, _ in out].count("b") == 1000
    (line,) = caplog.messages
    assert "bus b are 1000.0 s behind those of bus a" in line
    played(order, steady("a", 10.0, 11.0, 0.01, 0.0) + steady("b", 10.0, 11.0, 0.01, -0.105))  # it was set right
    assert {bus for bus, _ in taken(order, 11.0 + PATIENCE_S)} == {"a"}  # and is waited for again


def test_buses_whose_clocks_are_about_as_far_apart_as_is_borne_are_told_of_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    order = CaptureOrder(2)
    for begin_s, apart_s in ((0.0, 0.6), (2.0, 0.4), (4.0, 0.6), (6.0, 0.4)):
        played(
            order,
            [*steady("a", begin_s, begin_s + 2.0, 0.01, 0.0), *steady("b", begin_s, begin_s + 2.0, 0.01, apart_s)],
        )
    assert len(caplog.messages) == 1


def test_a_slow_bus_whose_clock_is_ahead_is_told_of_once(caplog: pytest.LogCaptureFixture) -> None:
    order = CaptureOrder(2)
    out = played(order, steady("a", 0.0, 30.0, 0.01, 0.0) + steady("b", 0.0, 30.0, 3.0, 2.0))
    (line,) = caplog.messages
    assert "bus a are 2.0 s behind those of bus b" in line
    assert [bus for bus, _ in out].count("b") == 10


def test_a_bus_that_is_silent_is_not_taken_for_one_whose_clock_is_behind(caplog: pytest.LogCaptureFixture) -> None:
    order = CaptureOrder(3)
    silent = [(0.0, "c", 0.0)]
    played(order, silent + steady("a", 0.0, 20.0, 0.01, 0.0) + steady("b", 0.0, 20.0, 0.01, -2.0))
    (line,) = caplog.messages
    assert "bus b are 2.0 s behind those of bus" in line
    out = played(order, steady("a", 20.0, 25.0, 0.01, 0.0) + steady("b", 20.0, 25.0, 0.01, -0.005))[10:]
    assert [time_s for _, time_s in out] == sorted(time_s for _, time_s in out)


def test_a_pause_of_the_program_is_no_difference_of_clocks(caplog: pytest.LogCaptureFixture) -> None:
    """Stopped, or starved: what came meanwhile comes all at once."""
    order = CaptureOrder(2)
    order.put(frame("a", 0.0), 0.0)
    order.put(frame("a", 0.005), 0.0)
    order.put(frame("b", 0.0), 0.0)
    out = taken(order, 0.0)
    for bus, offset_s in (("a", 0.01), ("b", 0.015)):
        for k in range(300):
            order.put(frame(bus, offset_s + k / 100), 3.0)
    out += taken(order, 3.0) + taken(order, 3.0 + 2 * PATIENCE_S)
    assert len(out) == 603
    assert [time_s for _, time_s in out] == sorted(time_s for _, time_s in out)
    assert caplog.messages == []


def test_a_thread_that_was_starved_is_no_difference_of_clocks(caplog: pytest.LogCaptureFixture) -> None:
    """What its bus gave meanwhile comes 0.7 s late; the other bus was read all the time."""
    order = CaptureOrder(2)
    order.put(frame("a", 0.1), 0.8)
    order.put(frame("b", 0.8), 0.8)
    out = taken(order, 0.8)
    order.put(frame("a", 0.79), 0.81)
    order.put(frame("b", 0.81), 0.81)
    out += taken(order, 0.81) + taken(order, 0.81 + 2 * PATIENCE_S)
    assert out == [("a", 0.1), ("a", 0.79), ("b", 0.8), ("b", 0.81)]
    assert caplog.messages == []
