"""Why nothing good arrives of a signal, and how often that came to be."""

from collections import Counter
from collections.abc import Iterable

from brake_monitor.samples import Channel, InputCondition, Measurand, Quality, Quantity, Sample

WHY = {
    Quality.OUT_OF_RANGE: InputCondition.OUT_OF_RANGE,
    Quality.NOT_AVAILABLE: InputCondition.NOT_AVAILABLE,
    Quality.BAD_COUNTER: InputCondition.BAD_COUNTER,
}
CUT_OUT = {Quantity.SPEED, Quantity.AXLE_SPEED}  # these are not available while the wagon is slow, again and again
STALE = Quality.STALE
LOST = InputCondition.LOST


class Refusals:
    """Sees what is refused, and refines what the estimator says of an input."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        self._timeout_s = {channel.measurand: channel.timeout_s for channel in channels}
        self._longest_delay_s = max([channel.delay_s for channel in channels], default=0.0)  # estimates are as late
        self.refused: dict[Measurand, Sample] = {}  # the last of each that arrived, where it was not good
        self.losses: Counter[Measurand] = Counter()  # how often each was lost

    def refuse(self, sample: Sample) -> None:
        """Note a sample that is not good."""
        if sample.quality is not STALE:
            self.refused[sample.measurand] = sample
        elif sample.quantity not in CUT_OUT or self.why_lost(sample.measurand, sample.time_s) is LOST:
            self.losses[sample.measurand] += 1

    def why_lost(self, measurand: Measurand, time_s: float) -> InputCondition:
        """What is to be thought of an input that the estimator says is lost."""
        refused = self.refused.get(measurand)
        within_s = self._timeout_s[measurand] + self._longest_delay_s
        if refused is not None and abs(time_s - refused.time_s) < within_s:  # it still arrives
            return WHY[refused.quality]
        return LOST
