"""A vehicle speed that comes late is found by when the wheels changed their speed, on drives of the simulator."""

import dataclasses

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.speed_lag import speed_lag_s
from brake_monitor.samples import Quantity
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from first_hours import driven, of_samples, samples_of

ABOUT_S = 0.11  # creep looks like a tenth of a second


def settings_of(vehicle: str, delay_s: float) -> Settings:
    settings = example_settings(vehicle)
    speed = replace(settings.signals.speed, delay_s=delay_s)
    return replace(settings, signals=replace(settings.signals, speed=speed))


def found_s(vehicle: str, scenario: str, *, lag_s: float, told_s: float = 0.0) -> float | None:
    """What is found of a sensor that lags, where the configuration tells of so much."""
    settings = settings_of(vehicle, told_s)
    samples = samples_of(driven(scenario, vehicle, settings_of(vehicle, lag_s)), settings)
    return speed_lag_s(of_samples(samples), settings.vehicle.wheel_radius_m)


@pytest.mark.parametrize("lag_s", [0.25, 0.5, 1.5, 2.6])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_a_speed_that_lags_is_found_with_its_lag(vehicle: str, lag_s: float) -> None:
    assert found_s(vehicle, "dry", lag_s=lag_s) == pytest.approx(lag_s, abs=max(ABOUT_S, 0.1 * lag_s))


def test_a_lag_beyond_what_is_looked_for_is_not_told_as_another() -> None:
    assert found_s("wagon", "dry", lag_s=6.0) is None


def test_a_lag_that_is_configured_is_none() -> None:
    assert found_s("wagon", "dry", lag_s=0.5, told_s=0.5) is None
    assert found_s("wagon", "dry", lag_s=0.5, told_s=0.2) == pytest.approx(0.3, abs=ABOUT_S)


@pytest.mark.parametrize(("lag_s", "told_s"), [(0.0, 0.3), (0.0, 0.5), (0.0, 2.0), (0.3, 0.8)])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_a_speed_that_is_said_to_lag_more_than_it_does_comes_early(vehicle: str, lag_s: float, told_s: float) -> None:
    early_s = told_s - lag_s
    found = found_s(vehicle, "dry", lag_s=lag_s, told_s=told_s)
    assert found == pytest.approx(-early_s, abs=max(ABOUT_S, 0.1 * early_s))


@pytest.mark.parametrize("scenario", ["wsp", "sanding", "leaf"])
@pytest.mark.parametrize("vehicle", ["wagon", "bogie"])
def test_slides_are_not_taken_for_a_speed_that_comes_early(vehicle: str, scenario: str) -> None:
    """Where it lags as it is said to."""
    assert found_s(vehicle, scenario, lag_s=0.5, told_s=0.5) is None


@pytest.mark.parametrize("scenario", ["dry", "wsp", "sanding", "leaf"])
@pytest.mark.parametrize("vehicle", ["rig", "wagon", "bogie"])
def test_neither_creep_nor_slides_are_taken_for_a_lag(vehicle: str, scenario: str) -> None:
    assert found_s(vehicle, scenario, lag_s=0.0) is None


def test_nothing_is_found_where_nothing_was_said() -> None:
    settings = settings_of("wagon", 0.0)
    first_hour = FirstHour(SignalDecoder.from_settings(settings).channels)
    assert speed_lag_s(first_hour, settings.vehicle.wheel_radius_m) is None


def test_a_clock_that_was_set_tells_nothing() -> None:
    settings = settings_of("wagon", 0.0)
    frames = driven("dry", "wagon", settings_of("wagon", 0.5))
    half = len(frames) // 2
    back = [*frames[:half], *(frame._replace(time_s=frame.time_s - 500.0) for frame in frames[half:])]
    assert speed_lag_s(of_samples(samples_of(back, settings)), settings.vehicle.wheel_radius_m) is None


def test_wheel_speeds_that_say_nothing_but_0_tell_nothing() -> None:
    settings = settings_of("rig", 0.0)
    samples = samples_of(driven("dry", "rig", settings), settings)
    dead = [samples.channels[number].quantity is Quantity.AXLE_SPEED for number in samples.channel.tolist()]
    heard = of_samples(dataclasses.replace(samples, value=np.where(dead, 0.0, samples.value)))
    assert speed_lag_s(heard, settings.vehicle.wheel_radius_m) is None
