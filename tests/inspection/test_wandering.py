"""A vehicle speed whose errors last is found by the wheels, while the wagon rolls."""

import numpy as np
import pytest

from brake_monitor.arrays import Bools
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.wandering import remarks_on_wandering, times_noisier
from first_hours import Floats, of_each, of_readings, speed_channel, wheel_channel

NOISE_MPS, SPACING_S = 0.03, 0.05
RADII_M, TRUE_RADII_M = (0.46, 0.46), (0.4585, 0.463)
WHEELS = [wheel_channel(0, 0.1), wheel_channel(1, 0.1)]


def errors(count: int, lasts_s: float) -> Floats:
    """One sigma is 1; of such a correlation time, 0: each by itself."""
    rng = np.random.default_rng(3)
    kept = np.exp(-SPACING_S / lasts_s) if lasts_s else 0.0
    found = np.zeros(count)
    for k in range(1, count):
        found[k] = kept * found[k - 1] + np.sqrt(1.0 - kept**2) * rng.normal()
    return found


def heard(
    lasts_s: float,
    *,
    late_s: float = 0.0,
    noise_mps: float = NOISE_MPS,
    step_mps: float = 0.005,
    wheel_noise_mps: float = 0.02,
    coasts_s: float = 150.0,
) -> FirstHour:
    """A wagon that coasts over a wavy line, and is braked for the last 20 s."""
    rng, times_s = np.random.default_rng(1), np.arange(0.0, coasts_s + 20.0, SPACING_S)

    def true_mps(at_s: Floats) -> Floats:
        return 30.0 - 0.03 * at_s + 0.4 * np.sin(at_s / 12.0) - 0.8 * np.maximum(at_s - coasts_s, 0.0)

    told_mps = np.round((true_mps(times_s - late_s) + noise_mps * errors(len(times_s), lasts_s)) / step_mps) * step_mps
    rough_mps = wheel_noise_mps * rng.normal(size=(2, len(times_s)))
    wheels = [(true_mps(times_s) + own) / radius_m for own, radius_m in zip(rough_mps, TRUE_RADII_M, strict=True)]
    return of_readings([speed_channel(noise_mps), *WHEELS], times_s, told_mps, *wheels)


@pytest.mark.parametrize("lasts_s", [0.4, 1.0])
def test_errors_that_last_count_for_as_many_readings(lasts_s: float) -> None:
    """The mean over a time much longer than T has the variance of one reading, times 2 T over that time."""
    of_long_means = (2.0 * lasts_s / SPACING_S) ** 0.5
    assert 0.55 * of_long_means < times_noisier(heard(lasts_s), RADII_M) < 1.1 * of_long_means


@pytest.mark.parametrize(
    "first_hour",
    [
        heard(0.0),
        heard(0.0, late_s=0.3),
        heard(0.0, step_mps=0.1),
        heard(0.0, noise_mps=0.005, wheel_noise_mps=0.03, coasts_s=600.0),
    ],
    ids=["in order", "late", "coarse", "rough wheels"],
)
def test_a_speed_whose_errors_do_not_last_is_left_alone(first_hour: FirstHour) -> None:
    assert times_noisier(first_hour, RADII_M) == 1.0


def test_what_rounds_a_speed_that_hardly_changes_is_no_such_error() -> None:
    """It loses 0.1 m/s in 14 s, and is told in steps of as much."""
    times_s = np.arange(0.0, 200.0, SPACING_S)
    true_mps = 25.0 - 0.007 * times_s
    wheels = [true_mps / radius_m for radius_m in TRUE_RADII_M]
    first_hour = of_readings([speed_channel(NOISE_MPS), *WHEELS], times_s, np.round(true_mps, 1), *wheels)
    assert times_noisier(first_hour, RADII_M) == 1.0


def test_wheel_speeds_that_are_lost_are_not_taken_to_stay_as_they_were() -> None:
    """The wagon coasts on, and slows down by 2.7 m/s after their unit fell silent."""
    times_s = np.arange(0.0, 150.0, SPACING_S)
    true_mps = 30.0 - 0.03 * times_s
    told_mps = true_mps + NOISE_MPS * errors(len(times_s), 0.0)
    early = times_s < 60.0
    wheels = [(times_s[early], true_mps[early] / radius_m) for radius_m in TRUE_RADII_M]
    first_hour = of_each([speed_channel(NOISE_MPS), *WHEELS], (times_s, told_mps), *wheels)
    assert times_noisier(first_hour, RADII_M) == 1.0


@pytest.mark.parametrize(("lasts_s", "is_found"), [(0.0, False), (1.0, True)], ids=["late", "late, and errs for long"])
def test_what_a_lag_makes_of_a_line_that_changes_is_no_such_error(lasts_s: float, is_found: bool) -> None:
    """The wagon coasts over a gradient of 10 ‰ and level track in turn, 9 s each; its speed is told 0.5 s late."""
    times_s, late = np.arange(0.0, 300.0, SPACING_S), round(0.5 / SPACING_S)
    lost_mps = np.cumsum(np.where(times_s % 18.0 < 9.0, 0.0, 0.1)) * SPACING_S
    told_mps = 30.0 - np.concatenate((np.zeros(late), lost_mps[:-late])) + NOISE_MPS * errors(len(times_s), lasts_s)
    wheels = [(30.0 - lost_mps) / radius_m for radius_m in TRUE_RADII_M]
    first_hour = of_readings([speed_channel(NOISE_MPS), *WHEELS], times_s, told_mps, *wheels)
    assert (times_noisier(first_hour, RADII_M) > 1.0) is is_found


def coasting(*, kept: Bools | None = None, spikes: Bools | None = None, times: int = 1) -> FirstHour:
    """A wagon whose speed errs by each reading alone, 300 s of it.

    `kept`: which readings are not lost, `spikes`: which are wrong by 3 m/s, `times`: how often each is told.
    """
    times_s = np.arange(0.0, 300.0, SPACING_S)
    true_mps = 30.0 - 0.03 * times_s
    told_mps = np.repeat((true_mps + NOISE_MPS * errors(len(times_s), 0.0))[::times], times)[: len(times_s)]
    if spikes is not None:
        told_mps = told_mps + 3.0 * spikes
    arrives = np.ones(len(times_s), dtype=np.bool_) if kept is None else kept
    wheels = [(times_s, true_mps / radius_m) for radius_m in TRUE_RADII_M]
    return of_each([speed_channel(NOISE_MPS), *WHEELS], (times_s[arrives], told_mps[arrives]), *wheels)


def test_spikes_are_no_such_errors() -> None:
    """One in 400 readings; the errors of neighbouring readings have nothing to do with it."""
    place = np.arange(round(300.0 / SPACING_S))
    assert times_noisier(coasting(spikes=place % 400 == 30), RADII_M) == 1.0


def test_nor_is_what_few_readings_do_not_average() -> None:
    """Of every other 4 s hardly any arrives, and their mean is less certain than that of the others."""
    place = np.arange(round(300.0 / SPACING_S))
    is_thin = (place * SPACING_S // 4.0) % 2.0 == 1.0
    assert times_noisier(coasting(kept=~is_thin | (place % 20 == 0)), RADII_M) == 1.0


def test_of_readings_that_are_told_again_another_remark_tells() -> None:
    """Their errors last as long as they are repeated."""
    assert times_noisier(coasting(times=8), RADII_M) == 1.0


def test_without_one_of_the_wheel_speeds_nothing_is_said() -> None:
    channels = [speed_channel(NOISE_MPS), *WHEELS]
    times_s = np.arange(0.0, 150.0, SPACING_S)
    told_mps = 30.0 + NOISE_MPS * errors(len(times_s), 1.0)
    turning = (times_s, np.full(len(times_s), 30.0 / TRUE_RADII_M[0]))
    assert times_noisier(of_each(channels, (times_s, told_mps), turning), RADII_M[:1]) > 2.0
    assert not list(remarks_on_wandering(of_each(channels, (times_s, told_mps), turning), RADII_M))


def test_a_single_wheelset_shows_it_too() -> None:
    """Of a rig; nothing tells its own errors apart."""
    assert times_noisier(heard(1.0), RADII_M[:1]) > 3.0


def test_where_it_does_not_roll_for_long_nothing_is_said() -> None:
    assert not list(remarks_on_wandering(heard(1.0, coasts_s=20.0), RADII_M))


def test_the_remark_says_what_makes_up_for_it() -> None:
    (remark,) = remarks_on_wandering(heard(1.0), RADII_M)
    assert "multiply its noise_std by " in remark
