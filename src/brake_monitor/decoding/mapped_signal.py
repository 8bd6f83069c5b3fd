"""One mapped signal: what becomes of the raw number in a frame, and when it last was good."""

from dataclasses import dataclass
from math import inf, isfinite, isnan

from brake_monitor.decoding.qualifier import Qualifier
from brake_monitor.decoding.signal_field import SignalField
from brake_monitor.samples import FLAGS, Channel, Quality


@dataclass(slots=True)
class MappedSignal:
    """One mapped signal on its way from raw number to sample."""

    channel: Channel
    field: SignalField
    gain: float  # SI value = physical * gain + bias, then clamped; physical is the DBC's
    bias: float
    minimum: float  # clamps, SI
    maximum: float
    no_data_from: float  # J1939: raw numbers from here on are no measurement; NaN, which none reaches, elsewhere
    counter: str  # its message's rolling counter, which must be good; "" for none
    qualifier: Qualifier | None = None
    good_s: float = -inf  # when it last was good; inf once it was told that this is too long ago

    @property
    def is_flag(self) -> bool:
        """Whether it is 0 or 1; by any other value senders say that they do not know."""
        return self.channel.quantity in FLAGS

    def convert(self, raw: float) -> tuple[float, Quality]:
        """Return the SI value and what is to be thought of it."""
        field = self.field
        physical = raw * field.scale + addend(field.offset)
        value = physical * self.gain + addend(self.bias)
        is_neither = self.is_flag and value not in (0.0, 1.0)  # a clamp would make one of it
        if value < self.minimum:
            value = self.minimum
        elif value > self.maximum:
            value = self.maximum
        if raw >= self.no_data_from or raw in field.not_available or isnan(raw):
            return value, Quality.NOT_AVAILABLE
        if field.minimum <= physical <= field.maximum and isfinite(physical) and not is_neither:
            return value, Quality.GOOD
        return value, Quality.OUT_OF_RANGE


def addend(number: float) -> float:
    """What to add for an offset: for 0 it is -0, which changes no number; adding 0 would make 0 of -0."""
    return number or -0.0
