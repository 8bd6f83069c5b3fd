"""Why nothing good arrives of a signal, and how often that came to be."""

from collections import Counter
from collections.abc import Iterable

from brake_monitor.samples import Channel, InputCondition, Place, Quality, Sample

WHY = {
    Quality.OUT_OF_RANGE: InputCondition.OUT_OF_RANGE,
    Quality.NOT_AVAILABLE: InputCondition.NOT_AVAILABLE,
    Quality.BAD_COUNTER: InputCondition.BAD_COUNTER,
}
STALE = Quality.STALE
LOST = InputCondition.LOST


class Refusals:
    """Sees what is refused, and refines what the estimator says of an input."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        self._timeout_s = {channel.place: channel.timeout_s for channel in channels}
        self._longest_delay_s = max([channel.delay_s for channel in channels], default=0.0)  # estimates are as late
        self.refused: dict[Place, Sample] = {}  # the last of each that arrived, where it was not good
        self.losses: Counter[Place] = Counter()  # how often each was lost

    def refuse(self, sample: Sample) -> None:
        """Note a sample that is not good."""
        if sample.quality is not STALE:
            self.refused[sample.place] = sample
        elif self.why_lost(sample.place, sample.time_s) is LOST:
            self.losses[sample.place] += 1

    def why_lost(self, place: Place, time_s: float) -> InputCondition:
        """What is to be thought of an input that the estimator says is lost."""
        refused = self.refused.get(place)
        within_s = self._timeout_s[place] + self._longest_delay_s
        if refused is not None and abs(time_s - refused.time_s) < within_s:  # it still arrives
            return WHY[refused.quality]
        return LOST
