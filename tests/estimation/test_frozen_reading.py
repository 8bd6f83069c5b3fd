"""A speed that stands still to the last bit, while what it has to follow moves."""

from collections.abc import Callable, Iterable
from itertools import count

import pytest

from brake_monitor.estimation.doubts.frozen_reading import FrozenReading
from test_doubted_friction import braking

SPACING_S, NOISE_MPS, FROZEN_MPS = 0.02, 0.03, 20.0


def frozen(reading: FrozenReading, begin_s: float, references_mps: Iterable[float], value_mps: float) -> list[bool]:
    return [reading.see(begin_s + k * SPACING_S, value_mps, v, True) for k, v in enumerate(references_mps)]


def slower(from_mps: float, to_mps: float) -> list[float]:
    count = round((from_mps - to_mps) / SPACING_S)  # by 1 m/s²
    return [from_mps - k * SPACING_S for k in range(count)]


def test_what_passes_by_its_value_does_not_bring_it_to_life() -> None:
    """The wagon went on faster as the sensor froze, and brakes through the very speed that it says."""
    reading = FrozenReading(NOISE_MPS)
    away = frozen(reading, 0.0, [FROZEN_MPS + k * SPACING_S for k in range(300)], FROZEN_MPS)
    assert away[-1]
    assert all(frozen(reading, 10.0, slower(FROZEN_MPS + 6.0, FROZEN_MPS - 6.0), FROZEN_MPS))


def test_it_is_alive_as_soon_as_it_moves() -> None:
    reading = FrozenReading(NOISE_MPS)
    assert frozen(reading, 0.0, [FROZEN_MPS + k * SPACING_S for k in range(300)], FROZEN_MPS)[-1]
    assert not reading.see(6.0, FROZEN_MPS + 6.01, FROZEN_MPS + 6.0, True)


def test_what_does_not_move_is_not_frozen_though_it_stands_still() -> None:
    assert not any(frozen(FrozenReading(NOISE_MPS), 0.0, [FROZEN_MPS] * 500, FROZEN_MPS))


def alive(k: int) -> float:
    """A radar's noise: no two readings in a row are the same."""
    return (0.02, -0.03, 0.01, -0.01, 0.03, -0.02)[k % 6]


def after_ten_seconds(of_reading: Callable[[int], float], decelerates_mps2: float = 1.0) -> list[bool]:
    """Whether a speed is frozen that has told the truth so, while the wagon braked from 30 m/s, and then hangs."""
    reading, spacing_s, told = FrozenReading(NOISE_MPS), 0.05, []
    hangs = of_reading(200)
    for k in range(240):
        speed_mps = 30.0 - 10.0 * min(k / 200, 1.0) - decelerates_mps2 * max(k - 200, 0) * spacing_s
        told.append(reading.see(k * spacing_s, hangs if k >= 200 else of_reading(k), speed_mps, True, True))
    assert not any(told[:201])
    return told[201:]


def test_a_speed_that_has_never_repeated_itself_is_frozen_within_a_third_of_a_second() -> None:
    told = after_ten_seconds(lambda k: 30.0 - 0.05 * k + alive(k))
    assert not any(told[:2])
    assert all(told[5:])


@pytest.mark.parametrize("readings_a_fix", [4, 20], ids=["five fixes a second", "one fix a second"])
def test_a_receiver_that_repeats_its_last_fix_may_go_on_with_it_for_a_second(readings_a_fix: int) -> None:
    told = after_ten_seconds(lambda k: 30.0 - 0.05 * (k // readings_a_fix * readings_a_fix))
    assert not any(told[:18])
    assert all(told[-10:])


def test_a_speed_that_has_just_begun_has_no_habit_yet() -> None:
    reading = FrozenReading(NOISE_MPS)
    told = [reading.see(k * 0.05, FROZEN_MPS, FROZEN_MPS - 0.05 * k, True, True) for k in range(40)]
    assert not any(told[:19])
    assert told[-1]


def test_what_hangs_while_the_speed_is_steady_is_not_frozen() -> None:
    assert not any(after_ten_seconds(lambda k: 30.0 - 0.05 * k + alive(k), decelerates_mps2=0.0))


def test_a_second_of_hanging_leaves_the_habit_as_it_was() -> None:
    """Each time it is found out as soon: what a frozen sensor repeats is none of its habits."""
    reading, k = FrozenReading(NOISE_MPS), count()
    found_after = []
    for _ in range(5):
        for i in k:
            reading.see(i * 0.05, 60.0 - 0.05 * i + alive(i), 60.0 - 0.05 * i, True, True)
            if i % 100 == 99:
                break
        hangs = reading.see((i := next(k)) * 0.05, 60.0 - 0.05 * i, 60.0 - 0.05 * i, True, True)
        assert not hangs
        value_mps = 60.0 - 0.05 * i
        told = [reading.see(j * 0.05, value_mps, 60.0 - 0.05 * j, True, True) for j in range(i + 1, i + 20)]
        found_after.append(told.index(True))
        for _ in told:
            next(k)
    assert len(set(found_after)) == 1


def test_a_radar_that_holds_its_last_value_at_a_standstill_is_not_frozen() -> None:
    """Below about 1 km/h radars do, while wheelsets come to rest: by far more than their noise."""
    core = braking(2).core
    speed, radius_m = core.wheelset_count, core.wheels[0].radius.radius_m
    found = []
    for k in range(200):
        rims_mps = max(0.6 - 0.006 * k, 0.0)
        core.filter.x[:2] = [rims_mps / radius_m] * 2
        found.append(core.see_repeats(speed, core.now.time_s + 0.02 * k, 0.3))
    assert found == [False] * 200
