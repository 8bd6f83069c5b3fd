"""Recordings through a pipeline, by the block; long ones with a compiled estimator where numba is installed."""

from collections.abc import Callable, Iterable, Iterator

from brake_monitor.compiled.kept_code import can_be_compiled, compiled, have_made
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing.pipeline import Outputs, Pipeline

LONG_FRAMES = 200_000  # played so far: then what is left is likely to be worth the second that numba takes to load


def play(
    pipeline: Pipeline,
    blocks: Iterable[FrameBlock],
    decode: Callable[[FrameBlock], SampleBlock] | None = None,
    *,
    is_one_of_many: bool = False,
) -> Iterator[Outputs]:
    """What the pipeline gives out of the blocks of a recording, decoded by its own decoder, or as `decode` does.

    Of many recordings even short ones are worth the loading of numba, which is then done once for all.
    """
    frames, in_python = 0, can_be_compiled(pipeline.estimator)
    for block in blocks:
        if in_python and (is_one_of_many or frames >= LONG_FRAMES):
            taker = compiled(pipeline.estimator)
            if taker is None:
                have_made(pipeline.estimator)  # meanwhile Python goes on
            else:
                pipeline.taker, in_python = taker, False
        yield from pipeline.play(block, decode and decode(block))
        frames += len(block)
