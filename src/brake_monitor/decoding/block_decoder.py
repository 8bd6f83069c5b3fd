"""The mapped frames of a block, all at once: the same samples that their messages give frame by frame."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from brake_monitor.arrays import Bools, Ints, indices
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.decoding.message_decoder import MessageDecoder
from brake_monitor.decoding.qualifier import Qualifier
from brake_monitor.decoding.sample_block import Columns
from brake_monitor.decoding.signal_table import RawTable, ValueTable
from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock
from brake_monitor.samples import Quality

_NO_LENGTH = -2  # no frame has it


class _Condition(NamedTuple):
    """A signal is there when a multiplexer, given by its place in the table of raw numbers, has one of the pages."""

    multiplexer: int
    pages: Sequence[int]
    known_pages: Sequence[int]


class BlockDecoder:
    """Takes whole frames by tables; those of another length than the DBC's, and whatever fits no table, one by one."""

    def __init__(self, messages: Sequence[MessageDecoder], counts: DecodeCounts) -> None:
        """`counts` go up as frames are decoded."""
        self._messages = messages
        self._counts = counts
        tabled = [message for message in messages if message.fits_tables]
        entries = [entry for message in tabled for entry in message.entries]
        fields = [entry.field for entry in entries]
        self._value = ValueTable(entries)
        self._channel = np.array([channel for message in tabled for channel in message.channels], dtype=np.int64)
        self._names_counter = np.array([entry.counter != "" for entry in entries], dtype=np.bool_)
        self._counter: dict[int, int] = {}  # by message that fits, its counter among the raw numbers
        for place, message in enumerate(messages):
            if message.fits_tables and message.counter is not None:
                self._counter[place] = len(fields)
                fields.append(message.counter.field)
        self._conditions: dict[int, list[_Condition]] = {}  # by multiplexed signal
        for signal, entry in enumerate(entries):
            for condition in entry.field.conditions:
                pages, known = ([*numbers] for numbers in (condition.pages, condition.known_pages))
                self._conditions.setdefault(signal, []).append(_Condition(len(fields), pages, known))
                fields.append(condition.multiplexer)
        self._qualifiers: dict[int, tuple[int, Qualifier]] = {}  # by signal, with its place among the raw numbers
        for signal, entry in enumerate(entries):
            if entry.qualifier is not None:
                self._qualifiers[signal] = len(fields), entry.qualifier
                fields.append(entry.qualifier.field)
        self._raw = RawTable(fields)
        lengths = [message.length if message.fits_tables else _NO_LENGTH for message in messages]
        sizes = [len(message.entries) if message.fits_tables else 0 for message in messages]
        self._length, self._size = np.array(lengths, dtype=np.int64), np.array(sizes, dtype=np.int64)
        self._first = np.cumsum(self._size) - self._size  # of each message's signals in the tables

    def decode(self, block: FrameBlock, message: Ints) -> list[Columns]:
        """The samples of a block; `message` is the place of each frame's among the messages, below 0 for none."""
        mapped = np.flatnonzero(message >= 0)
        self._counts.frames += len(mapped)
        self._counts.mapped += len(mapped)
        is_whole = block.length[mapped] == self._length[message[mapped]]
        whole, others = mapped[is_whole], mapped[~is_whole]
        singly = dict(zip(others.tolist(), block.frames(others), strict=True)) if len(others) else {}
        counter_is_good = self._judge_counters(block, message, singly)
        parts = [self._together(block, whole, message[whole], counter_is_good[whole])]
        if singly:
            parts.append(self._one_by_one(singly, message, counter_is_good))
        return parts

    def _judge_counters(self, block: FrameBlock, message: Ints, singly: dict[int, Frame]) -> Bools:
        """Whether the rolling counter of each frame's message, if it has one, is good; of those that fit tables."""
        is_good = np.ones(len(block), dtype=np.bool_)
        for place, signal in self._counter.items():
            own = self._messages[place]
            frames = np.flatnonzero(message == place)
            is_whole = block.length[frames] == own.length
            raw = np.empty(len(frames), dtype=np.int64)
            raw[is_whole] = self._raw.raw(block, frames[is_whole], np.full(is_whole.sum(), signal))
            raw[~is_whole] = [own.counter_of(singly[other]) for other in frames[~is_whole].tolist()]
            is_good[frames] = own.check_all(block.time_s[frames], raw)
        return is_good

    def _together(self, block: FrameBlock, frame: Ints, message: Ints, counter_is_good: Bools) -> Columns:
        """The samples of whole frames; each array with one entry per frame."""
        size = self._size[message]
        first = np.cumsum(size) - size  # sample of each frame
        number = np.repeat(np.arange(len(frame)), indices(size))  # of each sample's frame
        signal = np.arange(len(number)) + (self._first[message] - first)[number]
        if self._conditions:
            is_there = self._are_there(block, frame, number, signal)
            number, signal = number[is_there], signal[is_there]
        raw = self._raw.raw(block, frame[number], signal)
        with np.errstate(over="ignore", invalid="ignore"):
            value, quality = self._value.convert(signal, raw)
        is_old = self._names_counter[signal] & ~counter_is_good[number]
        if self._qualifiers:
            quality[self._rejected(block, frame[number], signal, ~is_old)] = Quality.NOT_AVAILABLE
        quality[is_old] = Quality.BAD_COUNTER
        self._counts.take_all(quality)
        return Columns(frame[number], self._channel[signal], value, quality)

    def _are_there(self, block: FrameBlock, frame: Ints, number: Ints, signal: Ints) -> Bools:
        """Which signals the pages of their frames have; `number` is the place of each signal's frame among these."""
        is_there = np.ones(len(signal), dtype=np.bool_)
        is_unknown_page = np.zeros(len(frame), dtype=np.bool_)
        for multiplexed, conditions in self._conditions.items():
            own = np.flatnonzero(signal == multiplexed)
            for multiplexer, pages, known_pages in conditions:
                page = self._raw.raw(block, frame[number[own]], np.full(len(own), multiplexer))
                is_on_page = np.isin(page, pages)
                is_unknown_page[number[own[~(is_on_page | np.isin(page, known_pages))]]] = True
                is_there[own[~is_on_page]] = False
                own = own[is_on_page]
        self._counts.unknown_multiplexer += int(is_unknown_page.sum())
        return is_there

    def _rejected(self, block: FrameBlock, frame: Ints, signal: Ints, is_judged: Bools) -> Ints:
        """Places of the judged samples that their qualifiers reject; each array has one entry per sample."""
        rejected = [np.zeros(0, dtype=np.int64)]
        for qualified, (place, qualifier) in self._qualifiers.items():
            own = np.flatnonzero((signal == qualified) & is_judged)
            raw = self._raw.raw(block, frame[own], np.full(len(own), place))
            rejected.append(own[~np.isin(raw, [*qualifier.good])])
            qualifier.rejected += len(rejected[-1])
        return np.concatenate(rejected)

    def _one_by_one(self, singly: dict[int, Frame], message: Ints, counter_is_good: Bools) -> Columns:
        """The samples of frames by their places."""
        found: list[tuple[int, int, float, Quality]] = []
        for place, frame in singly.items():
            own = self._messages[message[place]]
            is_good = bool(counter_is_good[place]) if own.fits_tables else own.check(frame)
            found += [
                (place, own.channels[entry], sample.value, sample.quality)
                for entry, sample in own.samples(frame, is_good)
            ]
        return Columns.of(found)
