"""Recordings through a pipeline, by the block; long ones with a compiled estimator where numba is installed."""

from collections.abc import Callable, Iterable, Iterator

from brake_monitor.compiled.kept_code import can_be_compiled, have_made, with_machine_code
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing.aligned_taker import block_taker
from brake_monitor.processing.pipeline import Outputs, Pipeline

LONG_FRAMES = 200_000  # so many frames to come are worth loading numba (a second); after so many, more are likely


def play(
    pipeline: Pipeline,
    blocks: Iterable[FrameBlock],
    decode: Callable[[FrameBlock], SampleBlock] | None = None,
    *,
    progress: Callable[[], float] | None = None,
    is_one_of_many: bool = False,
) -> Iterator[Outputs]:
    """What the pipeline gives out of the blocks of a recording, decoded by its own decoder, or as `decode` does.

    `progress`, from 0 to 1, is how much of it was read by the block that was given last: it tells a long one from its
    beginning. Of many recordings even short ones are worth the loading of numba, which is then done once for all.
    """
    frames, in_python = 0, can_be_compiled(pipeline.estimator)
    for block in blocks:
        read = frames + len(block)
        if in_python and (is_one_of_many or max(frames, _to_come(read, progress)) >= LONG_FRAMES):
            taker = with_machine_code(pipeline.estimator)
            if taker is None:
                have_made(pipeline.estimator)  # meanwhile Python goes on
            else:
                pipeline.taker, in_python = block_taker(pipeline.estimator, taker), False
        yield from pipeline.play(block, decode and decode(block))
        frames = read


def _to_come(frames: int, progress: Callable[[], float] | None) -> float:
    """How many frames follow these, by the share of the recording that they are; 0 where that is not known."""
    share = progress() if progress else 0.0
    return frames * (1.0 - share) / share if share > 0.0 else 0.0
