"""Frames → samples: what a frame says about our quantities, with capture time and quality."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import Self

from brake_monitor.can_filter import CanFilter
from brake_monitor.config import Settings
from brake_monitor.dbc import BusDatabase, Presence, load_bus
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.j1939 import pgn_bits
from brake_monitor.routing import Route, build_routes
from brake_monitor.samples import Channel, Quality, Quantity, Sample

__all__ = ["Channel", "DecodeCounts", "Quality", "Quantity", "Sample", "SignalDecoder"]

_GOOD = Quality.GOOD  # looking a member up in its enumeration is slow, and every sample needs this one
_CLOCK_STEP_S = 1.0  # a frame that is older than the last by more than this: the clock was set back


@dataclass(slots=True)
class DecodeCounts:
    """What became of the frames and of the mapped signals in them; for `check`, health and the log's last line."""

    frames: int = 0
    mapped: int = 0  # frames of a message that is mapped
    unmapped: int = 0
    error_frames: int = 0
    remote_frames: int = 0
    short_frames: int = 0  # mapped, but too short for a mapped signal
    other_width: int = 0  # unmapped, but a mapped message has this number with the other identifier width
    unknown_multiplexer: int = 0  # the page is none that the DBC describes
    good: int = 0  # samples, from here on
    out_of_range: int = 0
    not_available: int = 0
    bad_counter: int = 0
    stale: int = 0
    lost_frames: int = 0  # by the rolling counters


class SignalDecoder:
    """Turns frames into samples. Pure once built: its only clock is the frames' own time.

    `counts` goes up as frames pass; `remarks` are doubts about the DBC files that harm no mapped signal.
    """

    def __init__(self, settings: Settings, databases: Mapping[str, BusDatabase]) -> None:
        """`databases` holds one entry per configured bus. InputError when the mapping does not fit them."""
        self.counts = DecodeCounts()
        self.remarks = tuple(remark for database in databases.values() for remark in database.remarks)
        routes = build_routes(settings, databases)
        self._routes = routes
        self._by_id: dict[tuple[str, bool, int], Route] = {}
        self._by_pgn: dict[tuple[str, int], Route] = {}
        self._other_width: set[tuple[str, bool, int]] = set()
        for route in routes:
            can_id, extended = route.message.frame_id, route.message.is_extended_frame
            if route.match == "pgn":
                self._by_pgn[route.bus, pgn_bits(can_id)] = route
                continue
            self._by_id[route.bus, extended, can_id] = route
            twin = (route.bus, not extended, can_id)
            if route.match == "number":
                self._by_id[twin] = route
            else:
                self._other_width.add(twin)
        self._entries = tuple(entry for route in routes for entry in route.entries)
        self._next_deadline_s = -inf  # no channel can have lapsed before it
        self._last_time_s = -inf
        self.channels: tuple[Channel, ...] = tuple(
            sorted(
                (entry.channel for entry in self._entries),
                key=lambda channel: (list(Quantity).index(channel.quantity), channel.wheelset),
            )
        )

    @classmethod
    def from_settings(cls, settings: Settings) -> Self:
        """Read the DBC files that the settings name; InputError when one is bad or the mapping does not fit."""
        return cls(settings, {bus.name: load_bus(bus.name, bus.dbc) for bus in settings.can})

    def decode(self, frame: Frame) -> list[Sample]:
        """Return the samples of a frame; none when it is not mapped, broken or of no use, which is counted."""
        counts = self.counts
        counts.frames += 1
        if frame.kind:
            if frame.kind is FrameKind.REMOTE:
                counts.remote_frames += 1
            else:
                counts.error_frames += 1
            return []
        key = (frame.bus, frame.extended, frame.can_id)
        route = self._by_id.get(key)
        if route is None and frame.extended and self._by_pgn:
            route = self._by_pgn.get((frame.bus, pgn_bits(frame.can_id)))
        if route is None:
            counts.unmapped += 1
            if key in self._other_width:
                counts.other_width += 1
            return []
        counts.mapped += 1
        return self._samples(route, frame)

    def expire(self, time_s: float) -> list[Sample]:
        """Return one STALE sample (value NaN) for each channel whose time-out lapsed since its last good sample.

        A channel that never had one counts from the first call. Each lapse is told once.
        """
        if time_s < self._last_time_s - _CLOCK_STEP_S:
            self._restart_timeouts()
        self._last_time_s = time_s
        if time_s < self._next_deadline_s:
            return []
        lapsed, next_deadline_s = [], inf
        for entry in self._entries:
            if entry.deadline_s == -inf:
                entry.deadline_s = time_s + entry.channel.timeout_s
            elif entry.deadline_s <= time_s:
                entry.deadline_s = inf
                self.counts.stale += 1
                lapsed.append(Sample(time_s, entry.channel.quantity, entry.channel.wheelset, nan, Quality.STALE))
            next_deadline_s = min(next_deadline_s, entry.deadline_s)
        self._next_deadline_s = next_deadline_s
        return lapsed

    def can_filters(self, bus: str) -> list[CanFilter]:
        """Return the kernel filters that let the mapped messages of a bus through and nothing else."""
        return [filter_ for route in self._routes if route.bus == bus for filter_ in route.can_filters()]

    def _restart_timeouts(self) -> None:
        for entry in self._entries:
            entry.deadline_s = -inf
        self._next_deadline_s = -inf

    def _samples(self, route: Route, frame: Frame) -> list[Sample]:
        time_s, data, counts = frame.time_s, frame.data, self.counts
        counter_is_good = True
        if route.counter is not None:
            counter_is_good, lost = route.counter.check(time_s, data)
            counts.lost_frames += lost
        samples = []
        is_short = is_unknown_page = False
        for entry in route.entries:
            field, channel = entry.field, entry.channel
            if field.conditions:
                presence = field.presence(data)
                if presence is not Presence.THERE:
                    is_short |= presence is Presence.CUT_OFF
                    is_unknown_page |= presence is Presence.UNKNOWN_PAGE
                    continue
            raw = field.raw_of(data)
            if raw is None:
                is_short = True
                continue
            value, quality = entry.convert(raw)
            if entry.is_counted and not counter_is_good:
                quality = Quality.BAD_COUNTER
            if quality is _GOOD:
                counts.good += 1
                entry.deadline_s = deadline_s = time_s + channel.timeout_s
                self._next_deadline_s = min(self._next_deadline_s, deadline_s)
            else:
                self._count_bad(quality)
            samples.append(Sample(time_s, channel.quantity, channel.wheelset, value, quality))
        counts.short_frames += is_short
        counts.unknown_multiplexer += is_unknown_page
        return samples

    def _count_bad(self, quality: Quality) -> None:
        counts = self.counts
        match quality:
            case Quality.OUT_OF_RANGE:
                counts.out_of_range += 1
            case Quality.NOT_AVAILABLE:
                counts.not_available += 1
            case Quality.BAD_COUNTER:
                counts.bad_counter += 1
