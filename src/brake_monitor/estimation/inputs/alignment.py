"""Samples of sensors that lag, in the order of the instants that they tell of, not of their arrival."""

from collections.abc import Iterable, Sequence
from heapq import heapify, heappop, heappush

from brake_monitor.frame import CLOCK_STEP_S
from brake_monitor.samples import Channel, Quality, Sample


class Alignment:
    """Takes each channel's delay off its samples' times and waits for the slowest; no delay, no waiting."""

    def __init__(self, channels: Iterable[Channel]) -> None:
        self._delay_s = {channel.measurand: channel.delay_s for channel in channels}
        self._longest_s = max(self._delay_s.values(), default=0.0)
        self._waiting: list[tuple[float, int, Sample]] = []
        self._count = 0  # keeps samples of equal time in the order of their arrival

    @property
    def waits(self) -> bool:
        """Whether samples have to wait at all."""
        return self._longest_s > 0.0

    def put(self, sample: Sample) -> Sequence[Sample]:
        """Take a sample as captured; give the samples that no later arrival can precede, oldest first."""
        if sample.quality is Quality.STALE:
            self._drop(sample)
            return (sample,)
        seen_s = sample.time_s - self._delay_s[sample.quantity, sample.wheelset]
        if self._waiting and seen_s < self._waiting[0][0] - self._longest_s - CLOCK_STEP_S:
            self._waiting.clear()  # they would wait until the clock has caught up, and say nothing by then
        heappush(self._waiting, (seen_s, self._count, sample._replace(time_s=seen_s)))
        self._count += 1
        return self.ready(sample.time_s)

    def ready(self, time_s: float) -> Sequence[Sample]:
        """The waiting samples that no arrival after this time can precede, oldest first."""
        ready = []
        while self._waiting and self._waiting[0][0] <= self.whole_until_s(time_s):
            ready.append(heappop(self._waiting)[2])
        return ready

    def whole_until_s(self, time_s: float) -> float:
        """The instant up to which, at this time, the samples of all sensors have arrived."""
        return time_s - self._longest_s

    def take_over(self) -> list[Sample]:
        """The waiting samples, oldest first, by the times that they tell of; none of them waits here any more."""
        return [heappop(self._waiting)[2] for _ in range(len(self._waiting))]

    def give_back(self, waiting: Iterable[Sample]) -> None:
        """Let samples wait, given as `take_over` gives them."""
        self._waiting = [(sample.time_s, place, sample) for place, sample in enumerate(waiting)]
        self._count = len(self._waiting)

    def _drop(self, lapsed: Sample) -> None:
        """Drop the waiting samples of a channel that has lapsed: they would make it seem to go on."""
        self._waiting = [waiting for waiting in self._waiting if waiting[2].measurand != lapsed.measurand]
        heapify(self._waiting)
