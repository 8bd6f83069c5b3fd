"""The frames of one mapped message: its counter judged, its signals read, one frame after the other or many at once."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from brake_monitor.dbc import Presence
from brake_monitor.decode_counts import DecodeCounts
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock, Ints
from brake_monitor.message_columns import MessageColumns, Payloads
from brake_monitor.ordinary_frame import ordinary_frame
from brake_monitor.routing import Route
from brake_monitor.sample_block import Columns
from brake_monitor.samples import Quality, Sample


class MessageDecoder:
    """A route as its frames take it."""

    __slots__ = ("_channels", "_columns", "_counter", "_counts", "_entries", "_ordinary", "matching")

    def __init__(self, route: Route, channels: Sequence[int], counts: DecodeCounts) -> None:
        """`channels` are the places of the mapped signals among all; `counts` go up as frames are decoded."""
        self.matching = route.matching
        self._entries = route.entries
        self._channels = np.array(channels, dtype=np.int64)
        self._counter = route.counter
        self._counts = counts
        self._ordinary = ordinary_frame(route.entries, route.message.length)
        self._columns = MessageColumns.of(route)

    def decode(self, frame: Frame) -> list[Sample]:
        """The samples of a data frame of the message, all of which are noted that are good."""
        self._counts.frames += 1
        self._counts.mapped += 1
        counter_is_good = self._check(frame)
        samples = self._whole(frame, counter_is_good)
        if samples is not None:
            for entry in self._entries:
                entry.good_s = frame.time_s
            return samples
        found = self._signal_by_signal(frame, counter_is_good)
        for place, sample in found:
            if sample.quality is Quality.GOOD:
                self._entries[place].good_s = frame.time_s
        return [sample for _, sample in found]

    def decode_all(self, block: FrameBlock, frames: Ints) -> Iterator[Columns]:
        """The samples of the message's data frames in a block, which are in these places; none is noted."""
        self._counts.frames += len(frames)
        self._counts.mapped += len(frames)
        columns = self._columns
        if columns is None:
            singly = block.frames(frames)
            yield self._one_by_one(frames, singly, map(self._check, singly))
            return
        is_whole = block.length[frames] == columns.length
        whole, others = frames[is_whole], frames[~is_whole]
        payloads = Payloads(block.data(whole, columns.length))
        singly = block.frames(others) if len(others) else []
        counter_is_good = np.ones(len(frames), dtype=np.bool_)
        if self._counter is not None and columns.counter is not None:
            count = np.empty(len(frames), dtype=np.int64)
            count[is_whole] = payloads.raw(columns.counter)
            count[~is_whole] = [self._counter.count(frame.data) for frame in singly]
            counter_is_good, lost = self._counter.check_all(block.time_s[frames], count)
            self._counts.lost_frames += lost
        value, quality = columns.decode(payloads, counter_is_good[is_whole])
        self._counts.take_all(quality)
        frame, channel = np.repeat(whole, len(self._entries)), np.tile(self._channels, len(whole))
        yield Columns(frame, channel, value.ravel(), quality.ravel())
        if singly:
            yield self._one_by_one(others, singly, counter_is_good[~is_whole].tolist())

    def _check(self, frame: Frame) -> bool:
        if self._counter is None:
            return True
        is_good, lost = self._counter.check(frame.time_s, frame.data)
        self._counts.lost_frames += lost
        return is_good

    def _one_by_one(self, places: Ints, frames: Sequence[Frame], counter_is_good: Iterable[bool]) -> Columns:
        """The samples of some frames, `places` being where they are in their block."""
        found: list[tuple[int, int, float, Quality]] = []
        for place, frame, is_good in zip(places.tolist(), frames, counter_is_good, strict=True):
            samples = self._whole(frame, is_good)
            numbered = self._signal_by_signal(frame, is_good) if samples is None else enumerate(samples)
            found += [(place, entry, sample.value, sample.quality) for entry, sample in numbered]
        return Columns(
            np.array([place for place, *_ in found], dtype=np.int64),
            self._channels[np.array([entry for _, entry, *_ in found], dtype=np.int64)],
            np.array([value for *_, value, _ in found], dtype=np.float64),
            np.array([quality for *_, quality in found], dtype=np.int64),
        )

    def _whole(self, frame: Frame, counter_is_good: bool) -> list[Sample] | None:
        """The samples of an ordinary frame; None of any other."""
        if not counter_is_good or self._ordinary is None:
            return None
        samples = self._ordinary(frame.time_s, frame.data)
        if samples is not None:
            self._counts.good += len(samples)
        return samples

    def _signal_by_signal(self, frame: Frame, counter_is_good: bool) -> list[tuple[int, Sample]]:
        """What is there of a frame, with its quality: signals that are missing or bad spoil no others.

        With each sample the place of its signal among the message's mapped ones.
        """
        data, counts = frame.data, self._counts
        found = []
        is_short = is_unknown_page = False
        for place, entry in enumerate(self._entries):
            presence = entry.field.presence(data)
            raw = entry.field.raw_of(data) if presence is Presence.THERE else None
            if raw is None:
                is_short |= presence in (Presence.THERE, Presence.CUT_OFF)
                is_unknown_page |= presence is Presence.UNKNOWN_PAGE
                continue
            value, quality = entry.convert(raw)
            if entry.counter and not counter_is_good:
                quality = Quality.BAD_COUNTER
            counts.take(quality)
            found.append((place, Sample(frame.time_s, entry.channel.quantity, entry.channel.wheelset, value, quality)))
        counts.short_frames += is_short
        counts.unknown_multiplexer += is_unknown_page
        return found
