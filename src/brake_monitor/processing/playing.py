"""Recordings through a pipeline, by the block; long ones with a compiled estimator where numba is installed."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress

from brake_monitor.compiled.kept_code import EstimatorOrder, KeptCode, can_be_compiled, compiled
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
            in_python = not _takes_machine_code(pipeline)
        yield from pipeline.play(block, decode and decode(block))
        frames += len(block)


def _takes_machine_code(pipeline: Pipeline) -> bool:
    """Let samples be taken by machine code if it is on disk; if not it is made meanwhile."""
    code = KeptCode(EstimatorOrder.of(pipeline.estimator))
    if not code.is_ready:
        with suppress(OSError):  # there is no room to keep it
            code.have_made()
        return False
    pipeline.taker = compiled(pipeline.estimator) or pipeline.taker
    return True
