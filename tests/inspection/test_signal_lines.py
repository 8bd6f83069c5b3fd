"""How the values of a signal lie in the recording, and what they were."""

from types import SimpleNamespace

import numpy as np
import pytest

from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.inspection.traffic import Found, SignalLine, Traffic
from brake_monitor.samples import Quality
from first_hours import Floats, good_samples, speed_channel, wheel_channel

SPEED, WHEEL = CHANNELS = [speed_channel(0.02), wheel_channel(0, 0.02)]  # both time out after 0.5 s
TENTHS_S = np.arange(0.0, 20.0, 0.1)


@pytest.mark.parametrize(
    ("values", "size"),
    [([1.0, 2.0, -7.0, -8.0, -6.0, 99.0, 1.0], 6.0), ([0.0, 0.0, 0.0, 3.0, 4.0, 5.0, 0.0], 3.0), ([3.0, 9.0], 0.0)],
)
def test_the_greatest_value_is_one_that_three_in_a_row_reach(values: list[float], size: float) -> None:
    noted = Found()
    noted.see(np.arange(float(len(values))), np.array(values), np.full(len(values), Quality.GOOD))
    assert noted.size == size
    assert noted.is_kept is (size > 0.0)


def lines(speed_s: Floats, speeds_mps: Floats, begin_s: float = 0.0, end_s: float = 20.0) -> dict[str, SignalLine]:
    """Of a recording from `begin_s` to `end_s`, in which the speed is told at these times, and no wheel speed."""
    traffic = Traffic(CHANNELS)
    bounds = [Frame(time_s, "can0", 0x7FF, False, b"") for time_s in (begin_s, end_s)]
    nothing = np.zeros(0)
    traffic.see_block(FrameBlock.of(bounds), good_samples(CHANNELS, 0, nothing, nothing))
    if len(speed_s):
        frames = [Frame(time_s, "can0", 0x100, False, bytes(8)) for time_s in speed_s.tolist()]
        traffic.see_block(FrameBlock.of(frames), good_samples(CHANNELS, 0, speed_s, speeds_mps))
    assert traffic.duration_s == end_s - begin_s
    told = traffic.lines(SimpleNamespace(channels=CHANNELS))  # type: ignore[arg-type]
    return {line.channel.name: line for line in told}


def test_a_signal_that_is_there_all_the_time() -> None:
    line = lines(TENTHS_S, np.linspace(-2.0, 25.0, len(TENTHS_S)))[SPEED.name]
    assert (line.values, line.period_s) == (200, pytest.approx(0.1))
    assert (line.least, line.greatest, line.not_good) == (-2.0, 25.0, {})
    assert line.longest_gap_s == pytest.approx(0.1)
    assert (line.present_only_s, line.presence, line.is_late) == (None, "", False)


@pytest.mark.parametrize(
    ("first_s", "last_s", "longest_s", "presence"),
    [
        (5.0, 10.0, 10.0, "from 5 to 10 s"),
        (0.0, 12.0, 8.0, "from 0 to 12 s"),
        (3.0, 20.0, 3.0, "from 3 to 20 s"),
        (0.8, 20.0, 0.8, ""),  # late, and not missing
        (0.4, 19.7, 0.4, ""),
    ],
)
def test_a_signal_that_is_missing_at_an_end(first_s: float, last_s: float, longest_s: float, presence: str) -> None:
    """The recording begins at 100 s; its times are told from there."""
    times_s = 100.0 + np.append(np.arange(first_s, last_s, 0.1), last_s)
    line = lines(times_s, np.zeros(len(times_s)), 100.0, 120.0)[SPEED.name]
    assert line.longest_gap_s == pytest.approx(longest_s)
    assert line.is_late is (longest_s > 0.5)
    assert line.presence == presence


def test_a_signal_that_falls_silent_in_between_is_late() -> None:
    times_s = np.delete(TENTHS_S, slice(50, 70))
    line = lines(times_s, np.zeros(len(times_s)))[SPEED.name]
    assert line.longest_gap_s == pytest.approx(2.1)
    assert (line.present_only_s, line.is_late) == (None, True)


def test_of_a_signal_that_never_came_and_of_one_that_came_once() -> None:
    told = lines(np.array([4.0]), np.array([12.0]))
    never, once = told[WHEEL.name], told[SPEED.name]
    assert (never.values, never.period_s, never.longest_gap_s, never.least, never.greatest) == (0, *[None] * 4)
    assert (never.is_late, never.presence) == (True, "")
    assert (once.values, once.period_s, once.longest_gap_s) == (1, None, 16.0)
    assert (once.least, once.greatest, once.presence) == (12.0, 12.0, "from 4 to 4 s")
