"""Samples by the thousand, as columns: what a block of frames says about our quantities."""

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from brake_monitor.frame_block import Floats, Ints
from brake_monitor.samples import Channel, Quality, Sample

_QUALITIES = tuple(Quality)


class Columns(NamedTuple):
    """Samples in any order of frames, those of one frame together and in their order."""

    frame: Ints
    channel: Ints
    value: Floats
    quality: Ints


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
    def samples(self) -> list[Sample]:
        """One by one."""
        quantities = [channel.quantity for channel in self.channels]
        wheelsets = [channel.wheelset for channel in self.channels]
        channel = self.channel.tolist()
        columns = (
            self.time_s.tolist(),
            map(quantities.__getitem__, channel),
            map(wheelsets.__getitem__, channel),
            self.value.tolist(),
            map(_QUALITIES.__getitem__, self.quality.tolist()),
        )
        return list(map(Sample._make, zip(*columns, strict=True)))

    @cached_property
    def rows(self) -> list[tuple[int, float, float]]:
        """Channel, time and value of each."""
        return list(zip(self.channel.tolist(), self.time_s.tolist(), self.value.tolist(), strict=True))

    def sample(self, place: int) -> Sample:
        """One of them."""
        number, time_s, value = self.rows[place]
        channel = self.channels[number]
        return Sample(time_s, channel.quantity, channel.wheelset, value, _QUALITIES[self.quality[place]])

    def are_good(self, begin: int, end: int) -> bool:
        """Whether the samples in these places all are."""
        return bisect_left(self._others, begin) == bisect_left(self._others, end)

    @cached_property
    def _others(self) -> list[int]:
        """The places of those that are not good."""
        others: list[int] = np.flatnonzero(self.quality != Quality.GOOD).tolist()
        return others

    def of_frames(self, begin: int, end: int) -> list[Sample]:
        """Those of the frames with samples from one number to before another."""
        return list(map(self.sample, range(*self.places(begin, end))))

    def places(self, begin: int, end: int) -> tuple[int, int]:
        """Where the samples of the frames from one number to before another begin and end."""
        return self._first[begin], self._first[end]

    @cached_property
    def _first(self) -> list[int]:
        first: list[int] = self.first.tolist()
        return first
