"""The frames of one mapped message: its counter judged, its signals read."""

from collections.abc import Sequence

from brake_monitor.arrays import Bools, Floats, Ints
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.decoding.ordinary_frame import ordinary_frame
from brake_monitor.decoding.routing import Route
from brake_monitor.decoding.signal_field import Presence
from brake_monitor.decoding.signal_table import fits_table
from brake_monitor.frame import Frame
from brake_monitor.samples import Quality, Quantity, Sample


class MessageDecoder:
    """A route as its frames take it."""

    def __init__(self, route: Route, channels: Sequence[int], counts: DecodeCounts) -> None:
        """`channels` are the places of the mapped signals among all; `counts` go up as frames are decoded."""
        self.matching = route.matching
        self.entries = route.entries
        self.channels = channels
        self.length = route.message.length  # bytes
        self.counter = route.counter
        self.tells_wheel_speeds = any(entry.channel.quantity is Quantity.AXLE_SPEED for entry in route.entries)
        self._counts = counts
        self._ordinary = ordinary_frame(route.entries, route.message.length)
        fields = [entry.field for entry in route.entries]
        fields += [condition.multiplexer for field in fields for condition in field.conditions]
        fields += [entry.qualifier.field for entry in route.entries if entry.qualifier is not None]
        fields += [route.counter.field] if route.counter is not None else []
        self.fits_tables = all(map(fits_table, fields))

    def decode(self, frame: Frame) -> list[Sample]:
        """The samples of a data frame of the message; those that are good are noted."""
        time_s, counts = frame.time_s, self._counts
        counts.frames += 1
        counts.mapped += 1
        counter_is_good = self.counter is None or self.check(frame)
        samples = self._ordinary(time_s, frame.data) if counter_is_good else None
        if samples is not None:
            counts.good += len(samples)
            for entry in self.entries:
                entry.good_s = time_s
            return samples
        found = self._signal_by_signal(frame, counter_is_good)
        for place, sample in found:
            if sample.quality is Quality.GOOD:
                self.entries[place].good_s = time_s
        return [sample for _, sample in found]

    def samples(self, frame: Frame, counter_is_good: bool) -> list[tuple[int, Sample]]:
        """The samples of a frame, each with the place of its signal among the message's; none is noted."""
        samples = self._ordinary(frame.time_s, frame.data) if counter_is_good else None
        if samples is None:
            return self._signal_by_signal(frame, counter_is_good)
        self._counts.good += len(samples)
        return list(enumerate(samples))

    def check(self, frame: Frame) -> bool:
        """Whether the rolling counter is good, if there is one."""
        if self.counter is None:
            return True
        is_good, lost = self.counter.check(frame.time_s, frame.data)
        if lost:
            self._counts.lost_frames += lost
        return is_good

    def counter_of(self, frame: Frame) -> float:
        """The raw number of the counter, which there is; -1 where the frame is too short for it."""
        raw = self.counter.field.raw_of(frame.data) if self.counter is not None else None
        return -1 if raw is None else raw

    def check_all(self, time_s: Floats, raw: Ints) -> Bools:
        """Whether the rolling counters of successive frames are good; `raw` is below 0 where a frame has none."""
        assert self.counter is not None
        are_good, lost = self.counter.check_all(time_s, raw)
        self._counts.lost_frames += lost
        return are_good

    def _signal_by_signal(self, frame: Frame, counter_is_good: bool) -> list[tuple[int, Sample]]:
        """What is there of a frame, with its quality: signals that are missing or bad spoil no others."""
        data, counts = frame.data, self._counts
        found = []
        is_short = is_unknown_page = False
        for place, entry in enumerate(self.entries):
            presence = entry.field.presence(data)
            raw = entry.field.raw_of(data) if presence is Presence.THERE else None
            is_believed = entry.qualifier is None or entry.qualifier.is_good(data)
            if raw is None or is_believed is None:
                is_short |= presence in (Presence.THERE, Presence.CUT_OFF)
                is_unknown_page |= presence is Presence.UNKNOWN_PAGE
                continue
            value, quality = entry.convert(raw)
            if entry.counter and not counter_is_good:
                quality = Quality.BAD_COUNTER
            elif entry.qualifier is not None and not is_believed:
                quality = Quality.NOT_AVAILABLE
                entry.qualifier.rejected += 1
            counts.take(quality)
            found.append((place, Sample(frame.time_s, entry.channel.quantity, entry.channel.wheelset, value, quality)))
        counts.short_frames += is_short
        counts.unknown_multiplexer += is_unknown_page
        return found
