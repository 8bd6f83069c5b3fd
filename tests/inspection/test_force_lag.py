"""A pressing force or a wheel speed that comes late is found by what slides show, on drives of the simulator."""

import pytest
from msgspec.structs import replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.force_lag import obeyed_forces
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from first_hours import driven, of_samples, samples_of

FORCES, WHEELS = "pressing_force", "axle_speed"


def settings_of(vehicle: str, late: str = FORCES, delay_s: float = 0.0) -> Settings:
    settings = example_settings(vehicle)
    signals = tuple([replace(signal, delay_s=delay_s) for signal in getattr(settings.signals, late)])
    return replace(settings, signals=replace(settings.signals, **{late: signals}))


def lags_found_s(
    vehicle: str, scenario: str, *, late: str = FORCES, lag_s: float = 0.0, told_s: float = 0.0
) -> list[float | None]:
    """What is found of sensors that lag, where the configuration tells of so much."""
    frames = driven(scenario, vehicle, settings_of(vehicle, late, lag_s))
    settings = settings_of(vehicle, late, told_s)
    obeyed = obeyed_forces(of_samples(samples_of(frames, settings)), settings.vehicle.wheel_radius_m)
    assert all(one is None or one.place == own for own, one in enumerate(obeyed))
    return [one and (one.lag_s or None) for one in obeyed]


@pytest.mark.parametrize("scenario", ["leaf", "wsp", "sanding"])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
@pytest.mark.parametrize("lag_s", [0.03, 0.05, 0.1])
def test_forces_that_come_late_are_found_with_their_lag(vehicle: str, scenario: str, lag_s: float) -> None:
    """A rail that gives way with slip makes a force look up to 0.016 s earlier."""
    told = [lag_s for lag_s in lags_found_s(vehicle, scenario, lag_s=lag_s) if lag_s is not None]
    assert told
    assert told == pytest.approx([lag_s] * len(told), abs=0.016)


@pytest.mark.parametrize("scenario", ["leaf", "wsp"])
@pytest.mark.parametrize("lag_s", [0.3, 0.5, 0.9])
def test_forces_that_come_far_too_late_are_found(scenario: str, lag_s: float) -> None:
    """As through a gateway that gathers them."""
    told = [lag_s for lag_s in lags_found_s("wagon", scenario, lag_s=lag_s) if lag_s is not None]
    assert told
    assert told == pytest.approx([lag_s] * len(told), abs=0.016)


def test_a_delay_that_is_none_is_found() -> None:
    told = lags_found_s("wagon", "leaf", told_s=0.5)
    assert [lag_s and round(lag_s, 1) for lag_s in told] == [-0.5, -0.5]


@pytest.mark.parametrize("lag_s", [0.03, 0.05])
def test_wheel_speeds_that_come_late_are_forces_that_come_early(lag_s: float) -> None:
    told = [one for one in lags_found_s("wagon", "leaf", late=WHEELS, lag_s=lag_s) if one is not None]
    assert told == pytest.approx([-lag_s] * len(told), abs=0.016)
    assert told


@pytest.mark.parametrize("scenario", ["dry", "leaf", "wsp", "sanding"])
@pytest.mark.parametrize("vehicle", ["rig", "wagon", "bogie"])
def test_what_comes_in_time_is_in_no_doubt(vehicle: str, scenario: str) -> None:
    assert not any(lags_found_s(vehicle, scenario))


@pytest.mark.parametrize("scenario", ["leaf", "wsp", "sanding"])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
@pytest.mark.parametrize("exchanged", [FORCES, WHEELS])
def test_two_wheelsets_that_are_taken_for_each_other_are_found(vehicle: str, scenario: str, exchanged: str) -> None:
    """In step with each other's: what looked like a lag of 0.04 s is none."""
    settings = settings_of(vehicle)
    first, second, *others = getattr(settings.signals, exchanged)
    signals = replace(settings.signals, **{exchanged: (second, first, *others)})
    samples = samples_of(driven(scenario, vehicle, settings), replace(settings, signals=signals))
    obeyed = obeyed_forces(of_samples(samples), settings.vehicle.wheel_radius_m)
    told = {own: (one.place, one.lag_s) for own, one in enumerate(obeyed) if one}
    assert told == {own: ((1, 0, 2, 3)[own], 0.0) for own in told}
    assert {0, 1} <= set(told)


def test_a_lag_that_is_configured_is_none() -> None:
    assert not any(lags_found_s("wagon", "leaf", lag_s=0.05, told_s=0.05))


def test_who_never_slides_shows_no_lag() -> None:
    assert not any(lags_found_s("wagon", "dry", lag_s=0.05))


def test_nothing_is_found_where_nothing_was_said() -> None:
    settings = settings_of("wagon")
    first_hour = FirstHour(SignalDecoder.from_settings(settings).channels)
    assert obeyed_forces(first_hour, settings.vehicle.wheel_radius_m) == [None, None]
