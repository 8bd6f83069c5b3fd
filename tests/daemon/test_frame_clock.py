"""What time it is where frames are stamped, and when somebody set that clock: with clocks that the test moves."""

import pytest

from brake_monitor.daemon import frame_clock
from brake_monitor.daemon.frame_clock import UNDERWAY_S, FrameClock

OWN_S = 1.7e9 - 3500.0  # what the clock of a bus shows that has one of its own: an hour less


class Clocks:
    """The system's clock, and one that nobody sets."""

    def __init__(self) -> None:
        self.run_s, self.ahead_s = 100.0, 1.7e9

    def monotonic(self) -> float:
        return self.run_s

    def time(self) -> float:
        return self.run_s + self.ahead_s


@pytest.fixture
def clocks(monkeypatch: pytest.MonkeyPatch) -> Clocks:
    clocks = Clocks()
    monkeypatch.setattr(frame_clock, "time", clocks)
    return clocks


class Turns:
    """A frame clock as the daemon uses it: it looks in each turn, in which a frame may come."""

    def __init__(self, clocks: Clocks) -> None:
        self.clock, self._clocks = FrameClock(), clocks

    def frame(self, time_s: float | None = None) -> float:
        """A frame comes, captured just now or then: by how much the clock was set, as it says."""
        time_s = self._clocks.time() if time_s is None else time_s
        self.clock.look()
        set_by_s = self.clock.set_by_s(time_s)
        self.clock.captured(time_s)
        self._clocks.run_s += 0.01
        return set_by_s

    def silence(self, lasting_s: float = 1.0) -> float:
        self._clocks.run_s += lasting_s
        self.clock.look()
        return self.clock.set_in_silence_by_s()


@pytest.fixture
def turns(clocks: Clocks) -> Turns:
    return Turns(clocks)


def test_time_runs_on_from_the_last_frame_behind_by_what_may_be_underway(clocks: Clocks, turns: Turns) -> None:
    turns.frame(OWN_S)
    clocks.run_s += UNDERWAY_S / 4
    assert turns.clock.now_s() == OWN_S  # never before it
    clocks.run_s += 2.0
    assert turns.clock.now_s() == pytest.approx(OWN_S + 2.01 - 0.75 * UNDERWAY_S)


def test_drift_is_no_step_however_much_it_comes_to(clocks: Clocks, turns: Turns) -> None:
    for _ in range(10):
        clocks.ahead_s += 0.2
        assert turns.frame() == turns.silence() == 0.0


@pytest.mark.parametrize("steps_s", [(10.0, 0.3), (-3600.0, -3600.0), (3.0, -7200.0)])
def test_each_step_is_told_by_itself(steps_s: tuple[float, float], clocks: Clocks, turns: Turns) -> None:
    turns.frame()
    for by_s in steps_s:
        clocks.ahead_s += by_s
        assert turns.frame() == pytest.approx(by_s)
        assert turns.frame() == 0.0


def test_steps_that_no_frame_came_between_are_told_as_one(clocks: Clocks, turns: Turns) -> None:
    turns.frame()
    for by_s in (10.0, 25.0):
        clocks.ahead_s += by_s
        turns.clock.look()
    assert turns.frame() == pytest.approx(35.0)


def test_a_step_that_was_told_in_a_silence_is_not_told_again_and_the_next_one_is(clocks: Clocks, turns: Turns) -> None:
    turns.frame()
    for by_s in (3600.0, -50.0):
        clocks.ahead_s += by_s
        assert turns.silence() == pytest.approx(by_s)
        assert turns.clock.now_s() == pytest.approx(clocks.time() - UNDERWAY_S)
        assert turns.silence() == 0.0
    clocks.ahead_s -= 20.0
    assert turns.frame() == pytest.approx(-20.0)


def test_a_frame_that_was_captured_before_a_step_does_not_tell_of_it(clocks: Clocks, turns: Turns) -> None:
    for _ in range(1000):
        turns.frame()
    captured_s = clocks.time()
    clocks.ahead_s += 2.0
    assert turns.frame(captured_s) == 0.0
    assert turns.frame() == pytest.approx(2.0)


@pytest.mark.parametrize("by_s", [-3600.0, 2.0])
def test_frames_that_were_gathered_before_a_step_do_not_find_it_taken_over(
    by_s: float, clocks: Clocks, turns: Turns
) -> None:
    """A reader lets them gather for 0.1 s: that they do not come is no silence yet."""
    turns.frame()
    clocks.run_s += 0.05
    gathered_s = clocks.time()
    clocks.ahead_s += by_s
    assert turns.silence(0.1) == 0.0
    assert turns.frame(gathered_s) == 0.0
    assert turns.frame() == pytest.approx(by_s)


def test_a_pause_of_the_bus_is_no_step(clocks: Clocks, turns: Turns) -> None:
    turns.frame()
    clocks.run_s += 3600.0
    assert turns.frame() == 0.0


def test_a_bus_with_a_clock_of_its_own_knows_of_no_step_of_the_systems(clocks: Clocks, turns: Turns) -> None:
    turns.frame(OWN_S)
    clocks.ahead_s += 60.0
    assert turns.silence() == turns.frame(OWN_S + 1.02) == turns.silence() == 0.0
    assert turns.clock.now_s() == pytest.approx(OWN_S + 2.03 - UNDERWAY_S)
