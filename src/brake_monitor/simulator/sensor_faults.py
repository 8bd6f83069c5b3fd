"""What may be wrong with sensors and buses: the bus then carries something else than the truth."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.frame import Frame, FrameKind

ERROR_FRAME_PERIOD_S = 0.02
PROTOCOL_ERROR = 0x08  # class bits of SocketCAN's error frames
BUS_OFF = 0x40
ERROR_DATA = bytes(8)


class SensorFailure(StrEnum):
    """How a sensor fails."""

    LOST = "lost"  # the message that carries it no longer comes
    ERROR_CODE = "error code"  # its control unit says so
    FROZEN = "frozen"  # repeats its last value
    STUCK = "stuck"  # says `value`
    BIASED = "biased"  # says `value` too much


@dataclass(frozen=True, slots=True)
class SensorFault:
    """One sensor fails at `from_s`."""

    quantity: str  # a key of [signals]
    place: int  # in the configured list, from 0
    failure: SensorFailure
    from_s: float
    to_s: float = math.inf
    value: float = 0.0  # SI

    def acts(self, times_s: Floats) -> Bools:
        """When the sensor fails."""
        during: Bools = (times_s >= self.from_s) & (times_s < self.to_s)
        return during

    def reading(self, times_s: Floats, sound: Floats, si: float) -> Floats:
        """What it says instead of the `sound` readings, in a unit of `si` SI units."""
        now = self.acts(times_s)
        said = sound.copy()
        if self.failure is SensorFailure.FROZEN and now.any():
            said[now] = sound[np.argmax(now)]
        elif self.failure is SensorFailure.STUCK:
            said[now] = self.value / si
        elif self.failure is SensorFailure.BIASED:
            said[now] += self.value / si
        return said


class BusFailure(StrEnum):
    """How a bus fails."""

    SILENT = "silent"  # nothing comes
    ERROR_FRAMES = "error frames"  # a bad contact: an error frame 50 times a second, and half of the frames
    OFF = "bus-off"  # the controller gives up, with one error frame, and comes back later


@dataclass(frozen=True, slots=True)
class BusFault:
    """The first bus fails from `from_s` until `to_s`."""

    failure: BusFailure
    from_s: float
    to_s: float

    def spoil(self, frames: Iterable[Frame], start_s: float) -> list[Frame]:
        """The frames that are left, with error frames among them; times count from `start_s`."""
        spoilt, bus, turn = [], "", 0
        for frame in frames:
            bus = bus or frame.bus
            if frame.bus != bus or not self.from_s <= frame.time_s - start_s < self.to_s:
                spoilt.append(frame)
                continue
            turn += 1
            if self.failure is BusFailure.ERROR_FRAMES and turn % 2:
                spoilt.append(frame)
        spoilt += self._error_frames(bus, start_s)
        spoilt.sort(key=lambda frame: frame.time_s)
        return spoilt

    def _error_frames(self, bus: str, start_s: float) -> list[Frame]:
        if self.failure is BusFailure.SILENT:
            return []
        is_off = self.failure is BusFailure.OFF
        count = 1 if is_off else round((self.to_s - self.from_s) / ERROR_FRAME_PERIOD_S)
        can_id = BUS_OFF if is_off else PROTOCOL_ERROR
        times_s = [round(start_s + self.from_s + k * ERROR_FRAME_PERIOD_S, 6) for k in range(count)]
        return [Frame(time_s, bus, can_id, False, ERROR_DATA, FrameKind.ERROR) for time_s in times_s]
