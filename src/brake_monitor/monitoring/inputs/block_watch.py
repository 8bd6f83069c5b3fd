"""Shows the samples of a block to what watches them: many at once where nothing happens.

That is the usual case: wheelsets turn, brakes and flags are released. Of a stretch of such samples only the last ones
leave a trace.
"""

from bisect import bisect_left
from collections.abc import Sequence
from functools import cached_property

import numpy as np

from brake_monitor.arrays import Floats, Ints
from brake_monitor.decoding.sample_block import GoodSamples, SampleBlock
from brake_monitor.monitoring.inputs.descent import ROLLS, WHOLE
from brake_monitor.monitoring.inputs.flag_watch import FlagWatch
from brake_monitor.monitoring.inputs.frozen_forces import ForceReading, FrozenForces
from brake_monitor.monitoring.inputs.vehicle_speed import VehicleSpeed
from brake_monitor.monitoring.inputs.watched_wheelset import STANDSTILL_MPS, WatchedWheelset
from brake_monitor.monitoring.inputs.wheel_watch import WheelWatch
from brake_monitor.samples import Quantity

SPEED, AXLE_SPEED, PRESSING_FORCE = Quantity.SPEED, Quantity.AXLE_SPEED, Quantity.PRESSING_FORCE
WSP_ACTIVE, WHEEL_TORQUE = Quantity.WSP_ACTIVE, Quantity.WHEEL_TORQUE


class BlockWatch:
    """Takes the good samples of one block, in order, for the watches of an `InputJudge`."""

    def __init__(self, samples: SampleBlock, forces: FrozenForces, wheels: WheelWatch, flags: FlagWatch) -> None:
        """All of them have seen every sample before the block."""
        self._frozen = forces
        speed = samples.good(SPEED)
        self._speed = _SpeedBlock(wheels.speed, speed)
        self._wheels = [
            _WheelBlock(wheel, samples.good(AXLE_SPEED, i), samples.good(PRESSING_FORCE, i), self._speed)
            for i, wheel in enumerate(wheels.wheels)
        ]
        flagged = [(flag, samples.good(WSP_ACTIVE, i)) for i, flag in flags.flags.items()]
        self._flags = [(flag, own.places.tolist(), own.value.tolist()) for flag, own in flagged]
        readings = [samples.good(PRESSING_FORCE, i) for i in forces.wheelsets]
        self._forces = _together([own.places for own in readings])
        self._pressed = _together([own.places[own.value > 0.0] for own in readings])
        self._samples = samples
        torques = [samples.good(WHEEL_TORQUE, i).places for i in range(len(self._wheels))]
        rises = self._speed.rises and all(wheel.rises for wheel in self._wheels)
        odd = [*torques, *(wheel.odd for wheel in self._wheels)] if rises else [np.arange(len(samples))]
        self._odd = _together(odd)

    def are_ordinary(self, begin: int, end: int) -> bool:
        """Whether the samples in these places may be taken together."""
        return self._samples.are_good(begin, end) and bisect_left(self._odd, begin) == bisect_left(self._odd, end)

    def pass_over(self, begin: int, end: int) -> None:
        """Take the samples in these places, which are ordinary."""
        self._speed.pass_over(begin, end)
        for wheel in self._wheels:
            wheel.pass_over(begin, end)
        for flag, places, values in self._flags:
            last = _last(places, begin, end)
            if last is not None:
                flag.see(0.0, values[last])
        if not self._frozen.all_are_zero or bisect_left(self._pressed, begin) != bisect_left(self._pressed, end):
            first, last = bisect_left(self._forces, begin), bisect_left(self._forces, end)
            for reading in self._readings_of_forces[first:last]:
                self._frozen.see(*reading)

    @cached_property
    def _readings_of_forces(self) -> list[ForceReading]:
        samples, places = self._samples, self._forces
        wheelsets = np.array([channel.wheelset for channel in samples.channels])
        columns = (wheelsets[samples.channel[places]], samples.time_s[places], samples.value[places])
        return list(zip(*(column.tolist() for column in columns), strict=True))


class _SpeedBlock:
    """The vehicle's speed in a block."""

    def __init__(self, speed: VehicleSpeed, readings: GoodSamples) -> None:
        self._speed = speed
        self._places = readings.places
        before_mps = np.nan if speed.mps is None else speed.mps
        self._mps = np.concatenate(([before_mps], np.abs(readings.value)))
        time_s = np.concatenate(([speed.time_s], readings.time_s))
        self.rises = bool((time_s[1:] >= time_s[:-1]).all())
        self._listed_places: list[int] = readings.places.tolist()
        self._times_s = readings.time_s

    def before(self, places: Ints) -> Floats:
        """What was read last before each of the places; NaN where nothing was."""
        before: Floats = self._mps[np.searchsorted(self._places, places)]
        return before

    def pass_over(self, begin: int, end: int) -> None:
        last = _last(self._listed_places, begin, end)
        if last is not None:
            self._speed.see(self._times_s.item(last), self._mps.item(last + 1))


class _WheelBlock:
    """Speed and pressing force of one wheelset in a block."""

    def __init__(self, wheel: WatchedWheelset, speeds: GoodSamples, forces: GoodSamples, vehicle: _SpeedBlock) -> None:
        self._wheel = wheel
        self._places: list[int] = speeds.places.tolist()
        self._force_places: list[int] = forces.places.tolist()
        omega_radps = np.abs(speeds.value)
        rolling_mps = omega_radps * wheel.radius_m
        vehicle_mps = vehicle.before(speeds.places)
        stands = vehicle_mps < STANDSTILL_MPS
        turns = rolling_mps > np.maximum(ROLLS * vehicle_mps, STANDSTILL_MPS)
        is_odd = ~(stands | turns)
        is_odd[1:] |= stands[1:] != stands[:-1]
        time_s = np.concatenate(([wheel.read_s], speeds.time_s))
        self.odd = speeds.places[is_odd]  # it neither turns nor stands with the wagon, or differs from before
        self.rises = bool((time_s[1:] >= time_s[:-1]).all())  # else all are looked at singly
        is_whole = rolling_mps >= WHOLE * vehicle_mps
        self._whole_places: list[int] = speeds.places[is_whole].tolist()
        self._whole_s = speeds.time_s[is_whole]
        self._stands = stands
        self._omega_radps, self._rolling_mps = omega_radps, rolling_mps
        self._times_s, self._force_times_s, self._forces_n = speeds.time_s, forces.time_s, forces.value

    def pass_over(self, begin: int, end: int) -> None:
        last = _last(self._places, begin, end)
        if last is not None:
            time_s, omega_radps = self._times_s.item(last), self._omega_radps.item(last)
            if self._stands[last]:
                self._wheel.stand_on(time_s, self._rolling_mps.item(last))
            else:
                whole = _last(self._whole_places, begin, end)
                whole_s = None if whole is None else self._whole_s.item(whole)
                self._wheel.turn_on(time_s, omega_radps, self._rolling_mps.item(last), whole_s)
        last = _last(self._force_places, begin, end)
        if last is not None:
            self._wheel.holding.see_force(self._force_times_s.item(last), self._forces_n.item(last))


def _last(places: Sequence[int], begin: int, end: int) -> int | None:
    """Which of these places is the last one among the samples from one to before another; None: there is none."""
    last = bisect_left(places, end) - 1
    return last if last >= 0 and places[last] >= begin else None


def _together(places: Sequence[Ints]) -> list[int]:
    """All these places, in order."""
    together: list[int] = np.sort(np.concatenate(places), kind="stable").tolist() if places else []
    return together
