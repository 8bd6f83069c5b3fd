"""What a recording carries: mapped signals with their rates, gaps and qualities, and what is not mapped."""

from collections import Counter, defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from math import inf

import numpy as np
from msgspec import Struct

from brake_monitor.arrays import Floats, Ints, indices
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.frame_block import FrameBlock, Identifier
from brake_monitor.inspection.arrivals import Arrivals
from brake_monitor.inspection.first_hour import FirstHour
from brake_monitor.samples import Channel, Measurand, Quality

LEAST_ABSENT_S = 1.0  # a signal that is missing for longer at either end of a recording is called missing there


@dataclass
class Found:
    """What one channel showed in a recording; `kept_*` without what fewer than three good values in a row had."""

    arrivals: Arrivals = field(default_factory=Arrivals)
    can_ids: set[int] = field(default_factory=set)
    least: float = inf
    greatest: float = -inf
    kept_least: float = inf
    kept_greatest: float = -inf
    good: int = 0
    _last: list[float] = field(default_factory=list)  # two good values
    bad: Counter[Quality] = field(default_factory=Counter)

    @property
    def size(self) -> float:
        """The greatest that was kept, whatever its sign; 0 without any."""
        return max(abs(self.kept_least), abs(self.kept_greatest)) if self.is_kept else 0.0

    @property
    def is_kept(self) -> bool:
        """Whether there are more than single values."""
        return self.kept_least < inf

    def see(self, time_s: Floats, value: Floats, quality: Ints) -> None:
        """Take successive samples, but for their identifiers."""
        self.arrivals.see(time_s)
        times = np.bincount(indices(quality)).tolist()
        self.bad.update({Quality(place): count for place, count in enumerate(times) if place and count})
        good = value[quality == Quality.GOOD]
        if len(good):
            self.good += len(good)
            self.least = min(self.least, float(good[good.argmin()]))  # the first of equal ones: 0 and -0 are equal
            self.greatest = max(self.greatest, float(good[good.argmax()]))
            self._keep(np.concatenate((self._last, good)))

    def _keep(self, good: Floats) -> None:
        self._last = good[-2:].tolist()
        if len(good) > 2:
            three = good[:-2], good[1:-1], good[2:]
            self.kept_least = min(self.kept_least, float(np.maximum.reduce(three).min()))
            self.kept_greatest = max(self.kept_greatest, float(np.minimum.reduce(three).max()))


class SignalLine(Struct, frozen=True):
    """One mapped signal in short; None where too little came to tell."""

    channel: Channel
    values: int
    period_s: float | None  # median of the first values
    longest_gap_s: float | None  # between values, or from the recording's beginning to the first, the last to its end
    present_only_s: tuple[float, float] | None  # the first and the last, where it is missing for long before or after
    least: float | None  # of the good values
    greatest: float | None
    not_good: dict[str, int]  # by quality

    @property
    def is_late(self) -> bool:
        """Whether an estimator had to do without it for a time."""
        return self.longest_gap_s is None or self.longest_gap_s > self.channel.timeout_s

    @property
    def presence(self) -> str:
        """`from 376 to 387 s`; empty where the signal is there in all of the recording."""
        return "" if self.present_only_s is None else "from {:.0f} to {:.0f} s".format(*self.present_only_s)


class Traffic:
    """What a recording carries."""

    def __init__(self, channels: Sequence[Channel]) -> None:
        self.first_hour = FirstHour(channels)
        self.found: defaultdict[Measurand, Found] = defaultdict(Found)
        self.unmapped: Counter[Identifier] = Counter()  # of data frames
        self._first_s = inf
        self._last_s = -inf

    @property
    def duration_s(self) -> float:
        """From the first frame to the last; 0 without any."""
        return max(self._last_s - self._first_s, 0.0)

    def see_block(self, block: FrameBlock, samples: SampleBlock) -> None:
        """Take a block of frames and what was decoded from it."""
        self._first_s = min(self._first_s, float(block.time_s.min()))
        self._last_s = max(self._last_s, float(block.time_s.max()))
        self.first_hour.see(samples)
        by_channel = [self.found[channel.measurand] for channel in samples.channels]
        for number, found in enumerate(by_channel):
            own = np.flatnonzero(samples.channel == number)
            if len(own):
                found.see(samples.time_s[own], samples.value[own], samples.quality[own])
        named, place = block.identifiers
        pairs = np.bincount(indices(samples.channel * len(named) + place[samples.frame]))
        for pair in np.flatnonzero(pairs).tolist():
            number, which = divmod(pair, len(named))
            by_channel[number].can_ids.add(named[which][-1])
        has_none = block.is_data.copy()
        has_none[samples.frames] = False
        self.unmapped.update(block.identified(has_none))

    def lines(self, decoder: SignalDecoder) -> Iterator[SignalLine]:
        """Rates, ranges and qualities of what is mapped."""
        for channel in decoder.channels:
            yield self._line(channel, self.found[channel.measurand])

    def _line(self, channel: Channel, found: Found) -> SignalLine:
        arrivals, longest_s, present_only_s = found.arrivals, None, None
        if arrivals.count:
            outside_s = max(arrivals.begun_s - self._first_s, self._last_s - arrivals.ended_s)
            longest_s = max(arrivals.longest_gap_s, outside_s)
            if outside_s > max(channel.timeout_s, LEAST_ABSENT_S):
                present_only_s = (arrivals.begun_s - self._first_s, arrivals.ended_s - self._first_s)
        return SignalLine(
            channel,
            arrivals.count,
            float(np.median(arrivals.gaps_s)) if arrivals.count > 1 else None,
            longest_s,
            present_only_s,
            found.least if found.good else None,
            found.greatest if found.good else None,
            {quality.name.lower(): count for quality, count in sorted(found.bad.items())},
        )
