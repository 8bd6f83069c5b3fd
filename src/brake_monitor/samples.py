"""What a sample is: one value of one quantity in SI units, with capture time and quality."""

from dataclasses import dataclass
from enum import IntEnum, StrEnum
from typing import NamedTuple


class Quality(IntEnum):
    """Whether a sample may be believed; only GOOD samples are fused."""

    GOOD = 0
    STALE = 1  # nothing arrived within the time-out
    OUT_OF_RANGE = 2  # outside the DBC's own [min|max], or a flag that is neither 0 nor 1
    NOT_AVAILABLE = 3  # the sender says so (J1939 error / not-available codes, value table, qualifier)
    BAD_COUNTER = 4  # the message's rolling counter did not advance as it must


class InputCondition(StrEnum):
    """What is known of a mapped signal as a whole, beyond the quality of its single samples."""

    GOOD = "good"
    AWAITED = "awaited"  # not seen yet
    LOST = "lost"  # nothing good arrives any more
    FROZEN = "frozen"  # repeats itself while everything else moves
    REPEATED = "repeated"  # stands still, with all other speeds, to the last bit while the wagon rolls: a gateway does
    IMPOSSIBLE = "impossible"  # says what no vehicle does
    OUT_OF_RANGE = "out of range"  # what arrives is outside its range, and has been for the time-out
    NOT_AVAILABLE = "not available"  # its sender says so, and has for the time-out
    BAD_COUNTER = "bad counter"  # its sender repeats itself, and has for the time-out
    SCATTERED = "scattered"  # goes to and fro far beyond its noise
    CONTRADICTED = "contradicted"  # believable by itself, but not beside the others


class Quantity(StrEnum):
    """What we measure, named as in the configuration's [signals]."""

    SPEED = "speed"  # m/s
    AXLE_SPEED = "axle_speed"  # rad/s
    PRESSING_FORCE = "pressing_force"  # N
    WSP_ACTIVE = "wsp_active"  # 0 or 1
    SANDING = "sanding"  # 0 or 1
    LOAD_FORCE = "load_force"  # N
    GRADIENT = "gradient"  # rise over run
    WHEEL_TORQUE = "wheel_torque"  # N m
    LATITUDE = "latitude"  # degrees
    LONGITUDE = "longitude"  # degrees


Measurand = tuple[Quantity, int]  # which quantity of which wheelset, from 0; what the vehicle has once is at 0


MEASURED = (Quantity.AXLE_SPEED, Quantity.SPEED)  # fused, y of (15); all other quantities are inputs
ESSENTIAL = (*MEASURED, Quantity.PRESSING_FORCE)  # without these no estimate is valid
FLAGS = frozenset({Quantity.WSP_ACTIVE, Quantity.SANDING})


class Sample(NamedTuple):
    """One value of one quantity in SI units at its capture time."""

    time_s: float
    quantity: Quantity
    wheelset: int  # place in the configured list, from 0; 0 for a quantity of the whole wagon
    value: float
    quality: Quality

    @property
    def measurand(self) -> Measurand:
        """Which quantity of which wheelset it is."""
        return self.quantity, self.wheelset


@dataclass(frozen=True, slots=True)
class Channel:
    """What is known of one mapped signal before any frame arrives."""

    quantity: Quantity
    wheelset: int  # as in Sample
    bus: str
    message: str
    signal: str
    noise_std: float  # SI; the configured sigma and the quantisation LSB/sqrt(12), combined
    delay_s: float
    timeout_s: float

    @property
    def measurand(self) -> Measurand:
        """Which quantity of which wheelset it is."""
        return self.quantity, self.wheelset

    @property
    def name(self) -> str:
        """For people, who count wheelsets from 1: `axle_speed 2`."""
        return f"{self.quantity} {self.wheelset + 1}"

    @property
    def source(self) -> str:
        """Where the DBC has it: `<message>.<signal>`."""
        return f"{self.message}.{self.signal}"
