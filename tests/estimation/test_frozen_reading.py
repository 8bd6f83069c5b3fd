"""A speed that stands still to the last bit, while what it has to follow moves."""

from collections.abc import Iterable

from brake_monitor.estimation.doubts.frozen_reading import FrozenReading

SPACING_S, NOISE_MPS, FROZEN_MPS = 0.02, 0.03, 20.0


def frozen(reading: FrozenReading, begin_s: float, references_mps: Iterable[float], value_mps: float) -> list[bool]:
    return [reading.see(begin_s + k * SPACING_S, value_mps, v, True) for k, v in enumerate(references_mps)]


def braking(from_mps: float, to_mps: float) -> list[float]:
    count = round((from_mps - to_mps) / SPACING_S)  # by 1 m/s²
    return [from_mps - k * SPACING_S for k in range(count)]


def test_what_passes_by_its_value_does_not_bring_it_to_life() -> None:
    """The wagon went on faster as the sensor froze, and brakes through the very speed that it says."""
    reading = FrozenReading(NOISE_MPS)
    away = frozen(reading, 0.0, [FROZEN_MPS + k * SPACING_S for k in range(300)], FROZEN_MPS)
    assert away[-1]
    assert all(frozen(reading, 10.0, braking(FROZEN_MPS + 6.0, FROZEN_MPS - 6.0), FROZEN_MPS))


def test_it_is_alive_as_soon_as_it_moves() -> None:
    reading = FrozenReading(NOISE_MPS)
    assert frozen(reading, 0.0, [FROZEN_MPS + k * SPACING_S for k in range(300)], FROZEN_MPS)[-1]
    assert not reading.see(6.0, FROZEN_MPS + 6.01, FROZEN_MPS + 6.0, True)


def test_what_does_not_move_is_not_frozen_though_it_stands_still() -> None:
    assert not any(frozen(FrozenReading(NOISE_MPS), 0.0, [FROZEN_MPS] * 500, FROZEN_MPS))
