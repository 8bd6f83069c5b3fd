"""A pressing force or a wheel speed that comes late is found by what slides show, on drives of the simulator."""

import numpy as np
import pytest
from msgspec.structs import replace

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.inspection.force_lag import obeyed_forces
from brake_monitor.samples import Channel, Quality, Quantity
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from first_hours import driven, of_samples, samples_of, speed_channel, wheel_channel

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
@pytest.mark.parametrize("lag_s", [0.03, 0.1])
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


@pytest.mark.parametrize("begin_s", range(45, 55))
def test_some_readings_of_a_slide_tell_nothing(begin_s: int) -> None:
    """As in a recording of some lines, or of a wheel speed that is hardly ever good."""
    settings = settings_of("wagon")
    frames = driven("wsp", "wagon", settings)
    some = [frame for frame in frames if 0.0 <= frame.time_s - frames[0].time_s - begin_s < 0.3]
    obeyed = obeyed_forces(of_samples(samples_of(some, settings)), settings.vehicle.wheel_radius_m)
    assert obeyed == [None, None]


def test_nothing_is_found_where_nothing_was_said() -> None:
    settings = settings_of("wagon")
    first_hour = FirstHour(SignalDecoder.from_settings(settings).channels)
    assert obeyed_forces(first_hour, settings.vehicle.wheel_radius_m) == [None, None]


def chopped(seed: int) -> FirstHour:
    """A wheelset that slides on an uneven rail, while its protection vents and fills eight times a second."""
    rng = np.random.default_rng(seed)
    at_s = np.arange(0.0, 30.0, 0.01)
    strokes = np.repeat(rng.normal(1.0, 0.02, len(at_s) // 12), 12)
    force_n = 20e3 + 8e3 * strokes * np.sin(2.0 * np.pi * at_s / 0.12)
    wanders = np.convolve(rng.normal(size=len(at_s) + 24), np.hanning(25) / np.sqrt(9.0), "valid")
    spin_radps2 = (0.35 * 0.25 * (20e3 - force_n) + 250.0 * wanders) / 120.0
    omega_radps = 38.0 + np.cumsum(spin_radps2) * 0.01
    omega_radps += 38.0 - np.convolve(np.pad(omega_radps, 100, "edge"), np.ones(201) / 201.0, "valid")
    channels = (
        speed_channel(0.02),
        wheel_channel(0, 0.02),
        Channel(Quantity.PRESSING_FORCE, 0, "can0", "BCU", "p", 100.0, 0.0, 0.5),
    )
    first_hour = FirstHour(channels)
    told = ((0, 5, np.full_like(at_s, 20.0)), (1, 2, omega_radps + rng.normal(0.0, 0.02, len(at_s))), (2, 1, force_n))
    for number, every, values in told:
        times_s = at_s[::every]
        where = np.arange(len(times_s))
        good = np.full(len(where), Quality.GOOD)
        first_hour.see(SampleBlock(channels, where, times_s, np.full_like(where, number), values[::every], good))
    return first_hour


@pytest.mark.parametrize("seed", range(10))
def test_a_protection_that_chops_regularly_shows_no_lag_of_one_stroke(seed: int) -> None:
    """What it does now is what it did a stroke ago, which lies at the end of the lags that are looked for."""
    (obeyed,) = obeyed_forces(chopped(seed), [0.45])
    assert obeyed is None or obeyed.lag_s == 0.0
