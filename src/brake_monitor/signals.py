"""Frames → samples: what a frame says about our quantities, with capture time and quality."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import Self

import numpy as np

from brake_monitor.can_filter import CanFilter
from brake_monitor.config import Settings
from brake_monitor.dbc import BusDatabase, Presence, load_bus
from brake_monitor.frame import Frame, FrameKind
from brake_monitor.frame_block import Bools, FrameBlock, Identifier
from brake_monitor.j1939 import pgn_bits
from brake_monitor.matching import Matching
from brake_monitor.ordinary_frame import ordinary_frame
from brake_monitor.routing import Route, build_routes, doubles
from brake_monitor.samples import Channel, Quality, Quantity, Sample

__all__ = ["Channel", "DecodeCounts", "Quality", "Quantity", "Sample", "SignalDecoder"]

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
    other_width: int = 0  # unmapped, but a mapped message has this number with the other identifier width (11, 29 bits)
    unknown_multiplexer: int = 0  # the page is none that the DBC describes
    good: int = 0  # samples, from here on
    out_of_range: int = 0
    not_available: int = 0
    bad_counter: int = 0
    stale: int = 0
    lost_frames: int = 0  # by the rolling counters


class SignalDecoder:
    """Turns frames into samples. Pure once built: its only clock is the frames' own time.

    `counts` goes up as frames pass; `remarks` are doubts about the mapping, and about the DBC files where no mapped
    signal is harmed; `matchings` tell for each mapped message which frames are taken for it.
    """

    def __init__(self, settings: Settings, databases: Mapping[str, BusDatabase]) -> None:
        """`databases` holds one entry per configured bus. InputError when the mapping does not fit them."""
        self.counts = DecodeCounts()
        self.remarks = tuple(remark for database in databases.values() for remark in database.remarks)
        built = build_routes(settings, databases)
        self.remarks += (*(remark for route in built for remark in route.remarks), *doubles(settings))
        routes = tuple(_CompiledRoute(route) for route in built)
        self.matchings: tuple[Matching, ...] = tuple(route.matching for route in routes)
        self._by_id: dict[Identifier, _CompiledRoute] = {}
        self._by_pgn: dict[tuple[str, int], _CompiledRoute] = {}
        for route in routes:
            matching = route.matching
            if matching.by == "pgn":
                self._by_pgn[matching.bus, pgn_bits(matching.can_id)] = route
            else:
                self._by_id[matching.bus, matching.extended, matching.can_id] = route
        self._other_width = {(bus, not extended, can_id) for bus, extended, can_id in self._by_id}
        self._entries = tuple(entry for route in routes for entry in route.entries)
        self._next_look_s = -inf  # before it no channel can lapse
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
        route = self._by_id.get(key) or self._route_by_pgn(key)
        if route is None:
            counts.unmapped += 1
            if key in self._other_width:
                counts.other_width += 1
            return []
        counts.mapped += 1
        counter_is_good = True
        if route.counter is not None:
            counter_is_good, lost = route.counter.check(frame.time_s, frame.data)
            counts.lost_frames += lost
        if counter_is_good and route.ordinary is not None:
            samples = route.ordinary(frame.time_s, frame.data)
            if samples is not None:
                counts.good += len(samples)
                for entry in route.entries:
                    entry.good_s = frame.time_s
                return samples
        return self._signal_by_signal(route, frame, counter_is_good)

    def concerned(self, block: FrameBlock) -> Bools:
        """Which frames of a block `decode` has to see: all but the data frames that are not mapped."""
        identifiers, place = block.identifiers
        mapped = [key in self._by_id or self._route_by_pgn(key) is not None for key in identifiers]
        return np.array(mapped, dtype=np.bool_)[place] | ~block.is_data

    def pass_over(self, unmapped: Mapping[Identifier, int]) -> None:
        """Count data frames that are not mapped, given by identifier, as `decode` does of each."""
        for key, times in unmapped.items():
            self.counts.frames += times
            self.counts.unmapped += times
            if key in self._other_width:
                self.counts.other_width += times

    def expire(self, time_s: float) -> list[Sample]:
        """Return one STALE sample (value NaN) for each channel whose time-out lapsed since its last good sample.

        A channel that never had one counts from the first call. Each lapse is told once.
        """
        if time_s < self._last_time_s - _CLOCK_STEP_S:
            self._restart_timeouts()
        self._last_time_s = time_s
        if time_s < self._next_look_s:
            return []
        lapsed, self._next_look_s = [], inf
        for entry in self._entries:
            timeout_s = entry.channel.timeout_s
            if entry.good_s == -inf:
                entry.good_s = time_s
            elif entry.good_s + timeout_s <= time_s:
                entry.good_s = inf
                self.counts.stale += 1
                lapsed.append(Sample(time_s, entry.channel.quantity, entry.channel.wheelset, nan, Quality.STALE))
            # What becomes good from now on lapses a time-out after now at the soonest.
            self._next_look_s = min(self._next_look_s, min(entry.good_s, time_s) + timeout_s)
        return lapsed

    def can_filters(self, bus: str) -> list[CanFilter]:
        """Return the kernel filters that let the mapped messages of a bus through and nothing else."""
        return [matching.can_filter() for matching in self.matchings if matching.bus == bus]

    def _route_by_pgn(self, key: Identifier) -> "_CompiledRoute | None":
        bus, extended, can_id = key
        return self._by_pgn.get((bus, pgn_bits(can_id))) if extended and self._by_pgn else None

    def _restart_timeouts(self) -> None:
        for entry in self._entries:
            entry.good_s = -inf
        self._next_look_s = -inf

    def _signal_by_signal(self, route: "_CompiledRoute", frame: Frame, counter_is_good: bool) -> list[Sample]:
        """Return what is there of a frame, with its quality: signals that are missing or bad spoil no others."""
        time_s, data, counts = frame.time_s, frame.data, self.counts
        samples = []
        is_short = is_unknown_page = False
        for entry in route.entries:
            presence = entry.field.presence(data)
            raw = entry.field.raw_of(data) if presence is Presence.THERE else None
            if raw is None:
                is_short |= presence in (Presence.THERE, Presence.CUT_OFF)
                is_unknown_page |= presence is Presence.UNKNOWN_PAGE
                continue
            value, quality = entry.convert(raw)
            if entry.counter and not counter_is_good:
                quality = Quality.BAD_COUNTER
            if quality is Quality.GOOD:
                entry.good_s = time_s
            self._count(quality)
            samples.append(Sample(time_s, entry.channel.quantity, entry.channel.wheelset, value, quality))
        counts.short_frames += is_short
        counts.unknown_multiplexer += is_unknown_page
        return samples

    def _count(self, quality: Quality) -> None:
        counts = self.counts
        match quality:
            case Quality.GOOD:
                counts.good += 1
            case Quality.OUT_OF_RANGE:
                counts.out_of_range += 1
            case Quality.NOT_AVAILABLE:
                counts.not_available += 1
            case Quality.BAD_COUNTER:
                counts.bad_counter += 1


class _CompiledRoute:
    """A route as a frame takes it."""

    __slots__ = ("counter", "entries", "matching", "ordinary")

    def __init__(self, route: Route) -> None:
        self.matching = route.matching
        self.entries = route.entries
        self.counter = route.counter
        self.ordinary = ordinary_frame(route.entries, route.message.length)
