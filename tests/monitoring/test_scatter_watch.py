"""A speed that scatters is told where the wagon rolls, for long enough; a wheel's where not all do."""

import pytest

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.doubts.consistency import Doubt
from brake_monitor.estimation.estimate import Estimate
from brake_monitor.monitoring.creep_meter import CreepMeter
from brake_monitor.monitoring.inputs.input_judge import InputJudge
from brake_monitor.monitoring.inputs.scatter_watch import ScatterWatch
from brake_monitor.samples import InputCondition, Quantity
from brake_monitor.settings.example_vehicles import example_settings
from estimates import estimate, wheelset

ALONE, BOTH, NEITHER = (True, False), (True, True), (False, False)
VEHICLE = -1


def moments(
    start_s: float,
    end_s: float,
    scatters: tuple[bool, bool],
    *,
    speed_mps: float = 20.0,
    saturated: bool = False,
    vehicle: bool = False,
) -> list[Estimate]:
    """Ten a second; the estimator says that wheel speeds scatter where any does."""
    return [
        estimate(
            time_s=k / 10,
            speed_mps=speed_mps,
            saturated=saturated,
            wheelsets=tuple(wheelset(speed_scatters=own) for own in scatters),
            reasons=(Doubt.SCATTERED,) if any(scatters) else (),
            speed_scatters=vehicle,
        )
        for k in range(round(start_s * 10), round(end_s * 10))
    ]


def told(*parts: list[Estimate]) -> list[tuple[float, frozenset[int]]]:
    """When what is told changes, and to what."""
    watch, changes = ScatterWatch(2), [(0.0, frozenset[int]())]
    for now in (now for part in parts for now in part):
        watch.see(now)
        found = watch.wheels | ({VEHICLE} if watch.speed_scatters else set())
        if found != changes[-1][1]:
            changes.append((now.time_s, found))
    return changes[1:]


def test_it_is_told_after_ten_seconds_and_for_as_long_after_it_has_ended() -> None:
    (raised_s, who), (cleared_s, nobody) = told(moments(0.0, 15.0, ALONE), moments(15.0, 60.0, NEITHER))
    assert (who, nobody) == ({0}, set())
    assert raised_s == pytest.approx(10.0, abs=0.2)
    assert cleared_s == pytest.approx(30.0, abs=0.3)


def test_however_long_it_lasted_it_is_over_after_twenty_seconds() -> None:
    _, (cleared_s, _) = told(moments(0.0, 300.0, ALONE), moments(300.0, 400.0, NEITHER))
    assert cleared_s == pytest.approx(320.0, abs=0.3)


@pytest.mark.parametrize(("speed_mps", "is_told"), [(2.9, False), (3.1, True)])
def test_it_is_told_where_the_wagon_runs_faster_than_3_mps(speed_mps: float, is_told: bool) -> None:
    assert bool(told(moments(0.0, 15.0, ALONE, speed_mps=speed_mps))) is is_told


@pytest.mark.parametrize("wheels", [NEITHER, ALONE, BOTH])
def test_where_the_vehicles_speed_scatters_it_alone_is_told(wheels: tuple[bool, bool]) -> None:
    (raised_s, who), (cleared_s, nobody) = told(moments(0.0, 15.0, wheels, vehicle=True), moments(15.0, 60.0, NEITHER))
    assert (who, nobody) == ({VEHICLE}, set())
    assert (raised_s, cleared_s) == pytest.approx((10.0, 30.0), abs=0.3)


def test_where_all_scatter_no_sensor_is_to_blame() -> None:
    assert told(moments(0.0, 100.0, BOTH)) == []


@pytest.mark.parametrize(
    ("kind", "is_told"), [({"saturated": True}, False), ({"speed_mps": 2.0}, False), ({"speed_mps": 4.0}, True)]
)
def test_slides_and_walking_pace_show_nothing_of_sensors(kind: dict[str, float], is_told: bool) -> None:
    assert bool(told(moments(0.0, 100.0, ALONE, **kind))) is is_told  # type: ignore[arg-type]


def test_but_a_vehicle_speed_that_scatters_shows_in_slides_as_well() -> None:
    """They make wheel speeds scatter, not the vehicle's; the wheels' are left alone all the same."""
    changes = told(moments(0.0, 15.0, ALONE, vehicle=True, saturated=True))
    assert changes == [(pytest.approx(10.0, abs=0.2), {VEHICLE})]


def test_nor_do_they_end_it() -> None:
    assert len(told(moments(0.0, 15.0, ALONE), moments(15.0, 100.0, NEITHER, speed_mps=0.0))) == 1


def test_a_bridge_or_a_curve_is_over_sooner() -> None:
    parts = [
        part
        for k in range(20)
        for part in (moments(15.0 * k, 15.0 * k + 5.0, ALONE), moments(15.0 * k + 5.0, 15.0 * k + 15.0, NEITHER))
    ]
    assert told(*parts) == []


def test_seconds_of_which_nothing_is_known_do_not_count() -> None:
    assert told(moments(0.0, 5.0, ALONE), moments(50.0, 54.0, ALONE)) == []


@pytest.mark.parametrize(("tenths", "is_told"), [(8, True), (12, False)])
def test_nor_do_estimates_that_are_far_apart(tenths: int, is_told: bool) -> None:
    assert bool(told(moments(0.0, 100.0, ALONE)[::tenths])) is is_told


def test_of_one_that_is_not_told_any_more_that_is_said() -> None:
    settings, first_wheel = example_settings("wagon"), (Quantity.AXLE_SPEED, 0)
    channels = SignalDecoder.from_settings(settings).channels
    judge = InputJudge(settings, channels, CreepMeter(settings.estimator.contact_force_n))
    conditions = dict.fromkeys([channel.measurand for channel in channels], InputCondition.GOOD)

    def told_of_it(now: Estimate, changes: int) -> InputCondition:
        reports, _ = judge.judge(now, conditions.__getitem__, changes)
        return next(report.condition for report in reports if report.measurand == first_wheel)

    *_, scattered = [told_of_it(now, 1) for now in moments(0.0, 15.0, ALONE)]
    assert scattered is InputCondition.SCATTERED
    conditions[first_wheel] = InputCondition.LOST
    *_, lost = [told_of_it(now, 2) for now in moments(15.0, 16.0, NEITHER)]
    assert lost is InputCondition.LOST
