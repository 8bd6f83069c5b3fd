"""First hours of recordings: of readings made by hand, and of drives of the simulator."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.processing.whole_recording import all_samples
from brake_monitor.samples import Channel, Quality, Quantity
from brake_monitor.settings.config import Settings
from brake_monitor.settings.example_vehicles import example_settings
from brake_monitor.simulator.simulate import Recording
from brake_monitor.simulator.simulate import run as simulate

Floats = NDArray[np.float64]


def speed_channel(noise_mps: float) -> Channel:
    return Channel(Quantity.SPEED, 0, "can0", "GNSS", "v", noise_mps, 0.0, 0.5)


def wheel_channel(place: int, noise_radps: float) -> Channel:
    return Channel(Quantity.AXLE_SPEED, place, "can0", "WSP", f"n_{place + 1}", noise_radps, 0.0, 0.5)


def of_readings(channels: Sequence[Channel], times_s: Floats, *values: Floats) -> FirstHour:
    """Of good readings at these times, a row of values for each channel."""
    return of_each(channels, *((times_s, row) for row in values))


def of_each(channels: Sequence[Channel], *told: tuple[Floats, Floats]) -> FirstHour:
    """Of good readings: when each channel was told, and what."""
    first_hour = FirstHour(channels)
    for number, (times_s, values) in enumerate(told):
        first_hour.see(good_samples(channels, number, times_s, values))
    return first_hour


def good_samples(channels: Sequence[Channel], number: int, times_s: Floats, values: Floats) -> SampleBlock:
    """Of one of the channels."""
    places, good = np.arange(len(times_s)), np.full(len(times_s), Quality.GOOD)
    return SampleBlock(channels, places, times_s, np.full_like(places, number), values, good)


@cache
def moved(scenario: str, vehicle: str) -> Recording:
    """A drive of an example vehicle; how late its sensors tell of it changes nothing of it."""
    return simulate(scenario, example_settings(vehicle), seed=3)


@cache
def driven(scenario: str, vehicle: str, settings: Settings) -> list[Frame]:
    """What the bus carries on a drive whose sensors are as late as `settings` of the vehicle say."""
    return replace(moved(scenario, vehicle), settings=settings).frames


def samples_of(frames: list[Frame], settings: Settings) -> SampleBlock:
    return all_samples(SignalDecoder.from_settings(settings), [FrameBlock.of(frames)])


def of_samples(samples: SampleBlock) -> FirstHour:
    first_hour = FirstHour(samples.channels)
    first_hour.see(samples)
    return first_hour
