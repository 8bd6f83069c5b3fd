"""What a sample is: one value in SI units, with capture time and quality, of one of the quantities that there are."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum, StrEnum
from math import inf, pi
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
    """What we measure, named as in the configuration's [signals]; `TRAITS` says what is known of each."""

    SPEED = "speed"
    AXLE_SPEED = "axle_speed"
    PRESSING_FORCE = "pressing_force"
    WSP_ACTIVE = "wsp_active"
    SANDING = "sanding"
    LOAD_FORCE = "load_force"
    GRADIENT = "gradient"
    WHEEL_TORQUE = "wheel_torque"
    LATITUDE = "latitude"
    LONGITUDE = "longitude"


class Traits(NamedTuple):
    """What is known of a quantity on any vehicle."""

    called: str  # in sentences for people
    units: Mapping[str, float]  # in which it may be configured, and their factors to that of samples; first the default
    noise_std: float = 0.0  # in that of samples, where the mapping gives none: what such a sensor is usually worth
    largest: float = inf  # ... absolute: nothing on rails exceeds it. Keeps a sensor's nonsense out of the arithmetic
    per_wheelset: bool = False  # its list has an entry for each; that of WSP flags may have one for all
    timeout_s: float = 1.0  # how long a value is used where neither the mapping nor the DBC's cycle time says so


_SLOW_S = 5.0
_FLAG = {"": 1.0}  # 0 or 1
_NEWTONS = {"N": 1.0, "kN": 1e3}
_DEGREES = {"deg": 1.0, "°": 1.0}  # the only unit of samples that is none of SI: places are read in degrees
_KMH = 1.0 / 3.6

TRAITS: Mapping[str, Traits] = {  # of each `Quantity`
    Quantity.SPEED: Traits("the vehicle speed", {"m/s": 1.0, "km/h": _KMH}, 0.05, 200.0),
    Quantity.AXLE_SPEED: Traits(
        "the wheel speed",
        {"rad/s": 1.0, "rpm": 2.0 * pi / 60.0, "m/s": 1.0, "km/h": _KMH},  # see `si_factor`
        0.1,
        1000.0,
        per_wheelset=True,
    ),
    Quantity.PRESSING_FORCE: Traits("the pressing force", _NEWTONS, 500.0, 1e6, per_wheelset=True),
    Quantity.WSP_ACTIVE: Traits("the state of the wheel-slide protection", _FLAG, per_wheelset=True),
    Quantity.SANDING: Traits("sanding", _FLAG),
    Quantity.LOAD_FORCE: Traits("the load", _NEWTONS, 2000.0, 5e6, timeout_s=_SLOW_S),
    Quantity.GRADIENT: Traits(
        "the gradient",
        {"m/m": 1.0, "%": 1e-2, "‰": 1e-3, "permille": 1e-3},  # rise over run
        0.002,
        0.5,
        timeout_s=_SLOW_S,
    ),
    Quantity.WHEEL_TORQUE: Traits(
        "the wheel torque", {"N m": 1.0, "Nm": 1.0, "kN m": 1e3, "kNm": 1e3}, 100.0, 1e6, per_wheelset=True
    ),
    Quantity.LATITUDE: Traits("the latitude", _DEGREES, 5e-5, timeout_s=_SLOW_S),  # about 5 m
    Quantity.LONGITUDE: Traits("the longitude", _DEGREES, 5e-5, timeout_s=_SLOW_S),
}

Measurand = tuple[Quantity, int]  # which quantity of which wheelset, from 0; what the vehicle has once is at 0

MEASURED = (Quantity.AXLE_SPEED, Quantity.SPEED)  # fused, y of (15); all other quantities are inputs
ESSENTIAL = (*MEASURED, Quantity.PRESSING_FORCE)  # without these no estimate is valid
FLAGS = frozenset(quantity for quantity in Quantity if TRAITS[quantity].units is _FLAG)


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
