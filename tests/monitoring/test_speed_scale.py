"""The vehicle's speed in another scale than before: what tells it from wheels, lags and pauses."""

from collections.abc import Callable

import pytest

from brake_monitor.monitoring.inputs.speed_scale import SpeedScale

SPEED_MPS = 20.0


def off_s(
    told_mps: Callable[[float, float], float],
    *,
    until_s: float = 400.0,
    speed_mps: Callable[[float], float] = lambda _: SPEED_MPS,
    wheels: Callable[[float], tuple[float, float]] = lambda _: (1.0, 0.99),
    is_free: Callable[[float], bool] = lambda _: True,
) -> list[float]:
    """When the scale was another one, ten times a second.

    `told_mps` is what the vehicle's speed says, by time and true speed; `wheels` how fast each wheelset turns for it.
    """
    scale, found = SpeedScale(), []
    for k in range(round(until_s * 10)):
        time_s = k / 10
        true_mps = speed_mps(time_s)
        rolling_mps = [share * true_mps for share in wheels(time_s)]
        scale.see(time_s, told_mps(time_s, true_mps), rolling_mps, is_free=is_free(time_s))
        if scale.is_off:
            found.append(time_s)
    return found


@pytest.mark.parametrize("factor", [0.92, 0.96, 1.04, 1.3])
def test_a_radar_that_says_too_little_for_minutes_is_found_within_ten_seconds_and_believed_again(factor: float) -> None:
    found = off_s(lambda t, v: v * (factor if 100.0 <= t < 300.0 else 1.0))
    assert 104.5 < found[0] < 110.0
    assert 303.0 < found[-1] < 310.0
    assert len(found) == round((found[-1] - found[0]) * 10) + 1  # all the time


def test_so_it_is_where_a_braking_hides_the_beginning() -> None:
    found = off_s(lambda t, v: v * (0.95 if t >= 100.0 else 1.0), is_free=lambda t: not 95.0 <= t < 150.0)
    assert 150.0 < found[0] < 160.0


@pytest.mark.parametrize(
    "told_mps",
    [
        lambda t, v: v * (0.98 if t >= 100.0 else 1.0),  # satellites and curves do as much
        lambda t, v: v * (0.9 if 100.0 <= t < 104.0 else 1.0),  # for a moment
        lambda t, v: v * 0.9,  # from the beginning: a wrong radius
        lambda t, v: v * (0.9 if t >= 12.0 else 1.0),  # it was hardly known before
    ],
    ids=["two per cent", "for a moment", "always", "early"],
)
def test_of_less_nothing_is_said(told_mps: Callable[[float, float], float]) -> None:
    assert not off_s(told_mps)


def test_a_speed_that_lags_while_a_train_gathers_speed_has_no_other_scale() -> None:
    """By a second, at 0.5 m/s²: 5 per cent at 10 m/s. While it creeps on the scale is known."""
    assert not off_s(
        lambda t, v: v - 0.5 * (100.0 <= t < 140.0), speed_mps=lambda t: 10.5 + 0.5 * min(max(t - 99, 0), 40)
    )


def test_what_it_lags_between_stretches_of_steady_rolling_makes_its_scale_no_less_known() -> None:
    """By a second, as the wagon is pulled at 0.5 m/s² for 4 s of each 14; from 100 s on it says 5 per cent less."""

    def pulled_s(time_s: float) -> float:
        turns, since_s = divmod(time_s, 14.0)
        return turns * 4.0 + max(since_s - 10.0, 0.0)

    found = off_s(
        lambda t, v: (v - 0.5 * (pulled_s(t) - pulled_s(t - 1.0) if t > 1.0 else 0.0)) * (0.95 if t >= 100.0 else 1.0),
        until_s=140.0,
        speed_mps=lambda t: 10.5 + 0.5 * pulled_s(t),
    )
    assert found
    assert found[0] < 130.0


@pytest.mark.parametrize("others", [1.0, 0.97])
def test_one_wheel_speed_that_errs_says_nothing_of_the_vehicles(others: float) -> None:
    assert not off_s(lambda _, v: v, wheels=lambda t: (0.9, others) if t >= 100.0 else (1.0, 1.0))


def test_another_scale_that_lasts_for_five_minutes_of_rolling_is_the_usual_one() -> None:
    """The first one may have been wrong, as of a wagon that departs in snow."""
    found = off_s(lambda t, v: v * (0.95 if t < 60.0 else 1.0), until_s=600.0)
    assert 64.0 < found[0] < 70.0
    assert 355.0 < found[-1] < 375.0


@pytest.mark.parametrize(("pause_s", "is_off"), [(600.0, True), (4000.0, False)])
def test_wheels_may_have_been_turned_in_a_long_pause(pause_s: float, *, is_off: bool) -> None:
    """All by 5 per cent, as the wagon stood for so long."""
    found = off_s(
        lambda _, v: v,
        until_s=300.0 + pause_s,
        speed_mps=lambda t: 0.0 if 100.0 <= t < 100.0 + pause_s else SPEED_MPS,
        wheels=lambda t: (1.05, 1.05) if t >= 100.0 + pause_s else (1.0, 1.0),
    )
    assert bool(found) is is_off


def test_a_clock_that_is_set_back_is_survived() -> None:
    scale = SpeedScale()
    for k in range(4000):
        time_s = k / 10 - (50.0 if k >= 2000 else 0.0)
        scale.see(time_s, SPEED_MPS * (0.95 if k >= 2500 else 1.0), [SPEED_MPS, SPEED_MPS], is_free=True)
        assert scale.is_off is (k >= 2500 and scale.is_off)
    assert scale.is_off
