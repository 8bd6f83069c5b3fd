"""The newest frames, packed by the hundred: a quarter of the memory that they take one by one."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock

FRAMES_AT_HAND = 150_000  # some 8 MB; a busy bus then reaches back less far
FRAMES_IN_BLOCK = 256


@dataclass(frozen=True)
class FrameSpan:
    """The frames of a span of time, unpacked as they are read. Spans that overlap share their blocks."""

    blocks: tuple[FrameBlock, ...]
    begin_s: float
    end_s: float

    def __iter__(self) -> Iterator[Frame]:
        return (frame for frame in chain.from_iterable(self.blocks) if self.begin_s <= frame.time_s <= self.end_s)


def frame_count(spans: Iterable[FrameSpan]) -> int:
    """How many frames the spans keep in memory; frames in several spans count once."""
    return sum(map(len, {id(block): block for span in spans for block in span.blocks}.values()))


class FramesAtHand:
    """What arrived last. Time is the frames'."""

    def __init__(self) -> None:
        self._blocks: deque[FrameBlock] = deque()
        self._loose: list[Frame] = []  # newer than all blocks
        self._packed = 0

    def add(self, frames: Sequence[Frame]) -> None:
        """Take what arrived."""
        self._loose.extend(frames)
        if len(self._loose) >= FRAMES_IN_BLOCK:
            self._pack()

    def forget_before(self, time_s: float) -> None:
        """Blocks that end before `time_s` go."""
        while self._blocks and self._blocks[0].time_s[-1] < time_s:
            self._forget_block()

    def keep_near(self, time_s: float, within_s: float) -> None:
        """Keep only frames within `within_s` of `time_s`, wherever they stand: a clock was set."""
        self._loose = [frame for frame in chain(*self._blocks, self._loose) if abs(frame.time_s - time_s) < within_s]
        self._blocks.clear()
        self._packed = 0

    def between(self, begin_s: float, end_s: float) -> FrameSpan:
        """The frames of these times, both included."""
        self._pack()
        near = (block for block in self._blocks if block.time_s.max() >= begin_s and block.time_s.min() <= end_s)
        return FrameSpan(tuple(near), begin_s, end_s)

    def _pack(self) -> None:
        if self._loose:
            self._blocks.append(FrameBlock.of(self._loose))
            self._packed += len(self._loose)
            self._loose = []
        while self._packed > FRAMES_AT_HAND:
            self._forget_block()

    def _forget_block(self) -> None:
        self._packed -= len(self._blocks.popleft())
