"""Frames that are read one by one, or by the small block, gathered into blocks that are worth making."""

from collections.abc import Iterable, Iterator
from itertools import groupby

from brake_monitor.frame import Frame
from brake_monitor.frame_block import FrameBlock

BLOCK_FRAMES = 10_000  # make a block, of which a frame that was read by itself counts for ...
ONE_BY_ONE = 20  # ... as many: it takes as long as they do, and the first block of a recording is read twice


def in_blocks(items: Iterable[Frame | FrameBlock]) -> Iterator[FrameBlock]:
    """Gather frames and small blocks; what came before an error is given before it is raised."""
    held: list[Frame | FrameBlock] = []
    size = 0
    try:
        for item in items:
            held.append(item)
            size += len(item) if isinstance(item, FrameBlock) else ONE_BY_ONE
            if size >= BLOCK_FRAMES:
                yield _together(held)
                held, size = [], 0
    except Exception:
        if held:
            yield _together(held)
        raise
    if held:
        yield _together(held)


def _together(items: Iterable[Frame | FrameBlock]) -> FrameBlock:
    blocks: list[FrameBlock] = []
    for _, alike in groupby(items, type):
        some = list(alike)
        frames = [item for item in some if not isinstance(item, FrameBlock)]
        blocks += [FrameBlock.of(frames)] if frames else [item for item in some if isinstance(item, FrameBlock)]
    return FrameBlock.joined(blocks)
