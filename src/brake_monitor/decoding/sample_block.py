"""Samples by the thousand, as columns: what a block of frames says about our quantities."""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from brake_monitor.arrays import Bools, Floats, Ints, indices
from brake_monitor.samples import Channel, Measurand, Quality, Quantity, Sample

_QUALITIES = tuple(Quality)


class Columns(NamedTuple):
    """Samples in any order of frames, those of one frame together and in their order."""

    frame: Ints
    channel: Ints
    value: Floats
    quality: Ints

    @classmethod
    def of(cls, samples: Sequence[tuple[int, int, float, Quality]]) -> Self:
        """Samples that are given one by one."""
        table = np.array(samples, dtype=np.float64).reshape(-1, 4)  # in which whole numbers are exact, too
        frame, channel, quality = table[:, [0, 1, 3]].astype(np.int64).T
        return cls(frame, channel, table[:, 2], quality)


class GoodSamples(NamedTuple):
    """The good samples of one channel, in order."""

    places: Ints  # among all of the block
    time_s: Floats
    value: Floats


@dataclass(frozen=True)
class SampleBlock:
    """The samples of successive frames in the order of decoding, each array with one entry per sample."""

    channels: Sequence[Channel]
    frame: Ints  # its place in the block of frames, rising
    time_s: Floats
    channel: Ints  # place in `channels`
    value: Floats  # SI
    quality: Ints  # a Quality

    @classmethod
    def of(cls, channels: Sequence[Channel], time_s: Floats, parts: Sequence[Columns]) -> Self:
        """Put samples of different frames together; `time_s` is the frames'."""
        frame, channel, value, quality = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        order = np.argsort(frame, kind="stable")
        frame = frame[order]
        return cls(channels, frame, time_s[frame], channel[order], value[order], quality[order])

    def __len__(self) -> int:
        return len(self.frame)

    @cached_property
    def first(self) -> Ints:
        """Places of the first sample of each frame that has samples; at last the number of samples."""
        begins = np.concatenate(([-1], self.frame))
        return np.append(np.flatnonzero(begins[1:] != begins[:-1]), len(self))

    @cached_property
    def frames(self) -> Ints:
        """Places of the frames that have samples."""
        return self.frame[self.first[:-1]]

    @cached_property
    def frame_times_s(self) -> Floats:
        """Times of the frames that have samples."""
        return self.time_s[self.first[:-1]]

    @cached_property
    def listed_frame_times_s(self) -> list[float]:
        """The same in a list, which is quicker to search."""
        times_s: list[float] = self.frame_times_s.tolist()
        return times_s

    @cached_property
    def samples(self) -> list[Sample]:
        """All of them, one by one."""
        return self.at(np.arange(len(self)))

    def at(self, places: Ints) -> list[Sample]:
        """The samples in these places."""
        quantities = [channel.quantity for channel in self.channels]
        wheelsets = [channel.wheelset for channel in self.channels]
        channel = self.channel[places].tolist()
        columns = (
            self.time_s[places].tolist(),
            map(quantities.__getitem__, channel),
            map(wheelsets.__getitem__, channel),
            self.value[places].tolist(),
            map(_QUALITIES.__getitem__, self.quality[places].tolist()),
        )
        return list(map(Sample._make, zip(*columns, strict=True)))

    def sample(self, place: int) -> Sample:
        """The sample in this place."""
        (sample,) = self.at(np.array([place]))
        return sample

    def good(self, quantity: Quantity, wheelset: int = 0) -> GoodSamples:
        """The good samples of a quantity; none where it is not mapped."""
        number = self._numbers.get((quantity, wheelset))
        places = np.zeros(0, dtype=np.int64) if number is None else self._good_by_channel[number]
        return GoodSamples(places, self.time_s[places], self.value[places])

    def are_good(self, begin: int, end: int) -> bool:
        """Whether the samples in these places all are."""
        return bisect_left(self._others, begin) == bisect_left(self._others, end)

    @cached_property
    def _others(self) -> list[int]:
        """The places of those that are not good."""
        others: list[int] = np.flatnonzero(~self._is_good).tolist()
        return others

    @cached_property
    def _is_good(self) -> Bools:
        is_good: Bools = self.quality == Quality.GOOD
        return is_good

    @cached_property
    def _good_by_channel(self) -> list[Ints]:
        """For each channel the places of its good samples."""
        good = np.flatnonzero(self._is_good)
        channel = self.channel[good]
        ordered = good[np.argsort(channel.astype(np.uint16), kind="stable")]  # by radix
        return np.split(ordered, np.cumsum(np.bincount(indices(channel), minlength=len(self.channels)))[:-1])

    @cached_property
    def _numbers(self) -> dict[Measurand, int]:
        return {channel.measurand: number for number, channel in enumerate(self.channels)}

    def of_frames(self, begin: int, end: int) -> list[Sample]:
        """The samples of frames `begin` up to but not including `end`, counting only frames that have samples."""
        return self.at(np.arange(*self.places(begin, end)))

    def places(self, begin: int, end: int) -> tuple[int, int]:
        """First place, and the one past the last, of the samples of those frames (see `of_frames`)."""
        return self._first[begin], self._first[end]

    @cached_property
    def _first(self) -> list[int]:
        first: list[int] = self.first.tolist()
        return first
