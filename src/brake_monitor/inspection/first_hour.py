"""The readings of a recording's first hour, by what they measure: to find out which of them come late."""

from array import array
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.samples import MEASURED, Channel, Quantity

LONGEST_S = 3600.0
LEAST_MPS = 3.0  # slower than this, speeds say too little of lags, slides and noise
SLOWING_S = 3.0
CHANGE_SPAN_S = 0.5  # to both sides, by which it is told how fast a speed changes
SPIKES = 2  # so many readings in a row may be wrong
KEPT = (*MEASURED, Quantity.PRESSING_FORCE)


class Readings(NamedTuple):
    """What a sensor said, and when that was measured."""

    times_s: Floats
    values: Floats

    def at(self, times_s: Floats) -> Floats:
        """What it would have said then."""
        return np.interp(times_s, self.times_s, self.values)

    def apart_s(self, times_s: Floats) -> Floats:
        """How far from then its nearest reading is."""
        later = np.clip(np.searchsorted(self.times_s, times_s), 1, len(self.times_s) - 1)
        apart: Floats = np.minimum(np.abs(times_s - self.times_s[later - 1]), np.abs(self.times_s[later] - times_s))
        return apart


def change_per_s(values: Callable[[Floats], Floats], times_s: Floats) -> Floats:
    """How fast values, which are told at any time, change at these."""
    return (values(times_s + CHANGE_SPAN_S) - values(times_s - CHANGE_SPAN_S)) / (2.0 * CHANGE_SPAN_S)


class FirstHour:
    """Keeps what good readings of speeds, axle speeds and pressing forces say, and when they were measured."""

    def __init__(self, channels: Sequence[Channel]) -> None:
        self._delay_s = {channel.measurand: channel.delay_s for channel in channels}
        self._noise_std = {channel.measurand: channel.noise_std for channel in channels}
        self._timeout_s = {channel.measurand: channel.timeout_s for channel in channels}
        self.speeds = {  # of the vehicle's and the wheelsets', by the names that remarks give them
            "speed" if channel.quantity is Quantity.SPEED else channel.name: channel.measurand
            for channel in channels
            if channel.quantity in MEASURED
        }
        measurands = [measurand for measurand in self._delay_s if measurand[0] in KEPT]
        self._times_s = {measurand: array("d") for measurand in measurands}
        self._values = {measurand: array("d") for measurand in measurands}
        self._begun_s: float | None = None

    def see(self, samples: SampleBlock) -> None:
        """Take successive samples."""
        if not len(samples.time_s):
            return
        if self._begun_s is None:
            self._begun_s = float(samples.time_s[0])
        if float(samples.time_s[0]) - self._begun_s > LONGEST_S:
            return
        for measurand, times_s in self._times_s.items():
            _, time_s, value = samples.good(*measurand)
            kept = time_s - self._begun_s <= LONGEST_S  # a clock that is set ahead leaves it amid a block
            times_s.frombytes((time_s[kept] - self._delay_s[measurand]).tobytes())
            self._values[measurand].frombytes(value[kept].tobytes())

    def readings(self, quantity: Quantity, wheelset: int = 0) -> Readings | None:
        """None when there are not two, or the clock was set."""
        times_s = np.frombuffer(self._times_s[quantity, wheelset])
        if len(times_s) < 2 or (np.diff(times_s) < 0.0).any():
            return None
        return Readings(times_s, np.frombuffer(self._values[quantity, wheelset]))

    def delay_s(self, quantity: Quantity, wheelset: int = 0) -> float:
        """Its configured delay, which has been taken off the times of its readings."""
        return self._delay_s[quantity, wheelset]

    def noise_std(self, quantity: Quantity, wheelset: int = 0) -> float:
        """One sigma of its readings as configured, with what their steps add, SI."""
        return self._noise_std[quantity, wheelset]

    def hardest_slowing(self) -> tuple[float, float]:
        """The vehicle's greatest deceleration over SLOWING_S, m/s², and from when on; 0 when nothing tells."""
        told = self.readings(Quantity.SPEED)
        if told is None:
            return 0.0, 0.0
        times_s, speed = told.times_s, told._replace(values=np.abs(told.values))
        begins = times_s + SLOWING_S <= times_s[-1]
        slowing_mps2 = (speed.values[begins] - speed.at(times_s[begins] + SLOWING_S)) / SLOWING_S
        if len(slowing_mps2) <= SPIKES:
            return 0.0, 0.0
        hardest = int(np.argsort(slowing_mps2)[-SPIKES - 1])
        return max(float(slowing_mps2[hardest]), 0.0), float(times_s[hardest])

    def greatest_force_n(self, wheelset: int, begin_s: float) -> float | None:
        """What the brake of a wheelset presses with at most within SLOWING_S; None when nothing tells."""
        told = self.readings(Quantity.PRESSING_FORCE, wheelset)
        if told is None:
            return None
        times_s, forces_n = told
        first, end = np.searchsorted(times_s, (begin_s, begin_s + SLOWING_S), side="right")
        meanwhile = forces_n[max(first - 1, 0) : end]  # what was told last before is so still
        return max(float(meanwhile.max()), 0.0) if len(meanwhile) else None

    def speeds_mps(self, wheel_radius_m: Sequence[float]) -> list[Readings] | None:
        """The vehicle's and the wheels' circumferential speeds; None when any is missing."""
        scales = {(Quantity.SPEED, 0): 1.0}
        scales |= {(Quantity.AXLE_SPEED, i): radius_m for i, radius_m in enumerate(wheel_radius_m)}
        every = [(self.readings(*measurand), scale) for measurand, scale in scales.items()]
        told = [Readings(one.times_s, np.abs(one.values) * scale) for one, scale in every if one is not None]
        return told if len(told) == len(every) else None

    def speeds_told_together_mps(self, wheel_radius_m: Sequence[float]) -> list[Readings] | None:
        """The same, the vehicle's only while every wheel speed was told: one that is lost does not stay as it was."""
        speeds = self.speeds_mps(wheel_radius_m)
        if speeds is None:
            return None
        (times_s, speed_mps), *wheels = speeds
        apart_s = np.array([wheel.apart_s(times_s) for wheel in wheels])
        timeouts_s = np.array([self._timeout_s[Quantity.AXLE_SPEED, i] for i in range(len(wheels))])
        together = (apart_s <= timeouts_s[:, np.newaxis]).all(axis=0)
        if np.count_nonzero(together) < 2:
            return None
        return [Readings(times_s[together], speed_mps[together]), *wheels]
