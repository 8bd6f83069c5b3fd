"""Frames → samples: what a frame says about our quantities, with capture time and quality."""

from collections.abc import Iterable, Mapping
from typing import Self

import numpy as np

from brake_monitor.decoding.block_decoder import BlockDecoder
from brake_monitor.decoding.dbc import BusDatabase, load_buses
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.decoding.j1939 import pgn_bits
from brake_monitor.decoding.matching import Matching
from brake_monitor.decoding.message_decoder import MessageDecoder
from brake_monitor.decoding.pole_wheel import PoleWheel
from brake_monitor.decoding.routing import build_routes, doubles
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.decoding.time_outs import Passage, TimeOuts
from brake_monitor.frame import CanFilter, Frame, FrameKind
from brake_monitor.frame_block import FrameBlock, Identifier
from brake_monitor.samples import Channel, Quality, Quantity, Sample
from brake_monitor.settings.config import Settings

_UNMAPPED, _NO_DATA = -1, -2  # instead of the place of a message


class SignalDecoder:
    """Turns frames into samples. Pure once built: its only clock is the frames' own time.

    `counts` goes up as frames pass; `remarks` are doubts about the mapping, and about the DBC files where no mapped
    signal is harmed; `matchings` tell for each mapped message which frames are taken for it, `counters` by bus and
    message which rolling counter is verified, `qualifiers` by measurand what else tells whether to believe a value.
    """

    def __init__(self, settings: Settings, databases: Mapping[str, BusDatabase]) -> None:
        """`databases` holds one entry per configured bus. InputError when the mapping does not fit them."""
        self.counts = DecodeCounts()
        self.remarks = tuple(remark for database in databases.values() for remark in database.remarks)
        built = build_routes(settings, databases)
        self.remarks += (*(remark for route in built for remark in route.remarks), *doubles(settings))
        entries = [entry for route in built for entry in route.entries]
        self._time_outs = TimeOuts(entries)
        self._by_channel = sorted(
            entries, key=lambda entry: (list(Quantity).index(entry.channel.quantity), entry.channel.wheelset)
        )
        self.counters = {
            (route.matching.bus, route.message.name): route.counter.field.name
            for route in built
            if route.counter is not None
        }
        self.qualifiers = {e.channel.measurand: e.qualifier for e in self._by_channel if e.qualifier is not None}
        self.channels: tuple[Channel, ...] = tuple(entry.channel for entry in self._by_channel)
        self._by_measurand = {entry.channel.measurand: entry for entry in entries}
        self._messages = tuple(
            MessageDecoder(route, [self.channels.index(entry.channel) for entry in route.entries], self.counts)
            for route in built
        )
        self.pole_wheels = {
            channel.measurand: PoleWheel(channel.noise_std)
            for channel in self.channels
            if channel.quantity is Quantity.AXLE_SPEED
        }
        self._blocks = BlockDecoder(self._messages, self.counts)
        self.matchings: tuple[Matching, ...] = tuple(message.matching for message in self._messages)
        self._by_id: dict[Identifier, MessageDecoder] = {}
        self._by_pgn: dict[tuple[str, int], MessageDecoder] = {}
        for message in self._messages:
            matching = message.matching
            if matching.by == "pgn":
                self._by_pgn[matching.bus, pgn_bits(matching.can_id)] = message
            else:
                self._by_id[matching.bus, matching.extended, matching.can_id] = message
        self._other_width = {(bus, not extended, can_id) for bus, extended, can_id in self._by_id}

    @classmethod
    def from_settings(cls, settings: Settings) -> Self:
        """Read the DBC files that the settings name; InputError when one is bad or the mapping does not fit."""
        return cls(settings, load_buses(settings))

    def decode(self, frame: Frame) -> list[Sample]:
        """Return the samples of a frame; none when it is not mapped, broken or of no use, which is counted."""
        _, bus, can_id, extended, _, kind = frame
        if kind:
            self._count_kind(kind)
            return []
        key = (bus, extended, can_id)
        message = self._by_id.get(key) or self._message_by_pgn(key)
        if message is not None:
            samples = message.decode(frame)
            if message.tells_wheel_speeds:
                self._put_right(samples)
            return samples
        self.pass_over({key: 1})
        return []

    def decode_block(self, block: FrameBlock) -> SampleBlock:
        """Return the samples of a block's frames, counted: the very ones that `decode` gives of one after the other.

        Which channels are good is not noted by this, but as the samples pass (`note`, `passage`): a time-out may lapse
        within the block.
        """
        identifiers, place = block.identifiers
        found = [self._by_id.get(key) or self._message_by_pgn(key) for key in identifiers]
        numbers = [_UNMAPPED if message is None else self._messages.index(message) for message in found]
        number = np.array(numbers, dtype=np.int64)[place]
        for odd, frame in block.odd.items():
            if frame.kind:
                number[odd] = _NO_DATA
                self._count_kind(frame.kind)
        self.pass_over(block.identified(number == _UNMAPPED))
        samples = SampleBlock.of(self.channels, block.time_s, self._blocks.decode(block, number))
        for (quantity, wheelset), pole_wheel in self.pole_wheels.items():
            told = samples.good(quantity, wheelset)
            samples.value[told.places] = list(map(pole_wheel.true, told.time_s.tolist(), told.value.tolist()))
        return samples

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
        lapsed = self._time_outs.expire(time_s)
        if lapsed:
            self.counts.stale += len(lapsed)
        return lapsed

    def note(self, samples: Iterable[Sample]) -> None:
        """Note which channels samples of `decode_block` show to be good."""
        for sample in samples:
            if sample.quality is Quality.GOOD:
                self._by_measurand[sample.measurand].good_s = sample.time_s

    def passage(self, samples: SampleBlock, first_frame: int = 0) -> Passage:
        """Note it for the samples of a block, from one of its frames with samples on, as they pass."""
        return Passage(self._time_outs, self._by_channel, samples, first_frame)

    def can_filters(self, bus: str) -> list[CanFilter]:
        """Return the kernel filters that let the mapped messages of a bus through and nothing else."""
        return [matching.can_filter() for matching in self.matchings if matching.bus == bus]

    def _message_by_pgn(self, key: Identifier) -> MessageDecoder | None:
        bus, extended, can_id = key
        return self._by_pgn.get((bus, pgn_bits(can_id))) if extended and self._by_pgn else None

    def _put_right(self, samples: list[Sample]) -> None:
        """Take away from wheel speeds what their pole wheels add."""
        for place, sample in enumerate(samples):
            if sample.quantity is Quantity.AXLE_SPEED and sample.quality is Quality.GOOD:
                true = self.pole_wheels[sample.measurand].true(sample.time_s, sample.value)
                if true != sample.value:
                    samples[place] = sample._replace(value=true)

    def _count_kind(self, kind: FrameKind) -> None:
        self.counts.frames += 1
        if kind is FrameKind.REMOTE:
            self.counts.remote_frames += 1
        else:
            self.counts.error_frames += 1
