"""Recordings through a pipeline, by the block; long ones with a compiled estimator where numba is installed."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from importlib.util import find_spec

from brake_monitor.errors import WorkError
from brake_monitor.frame_block import FrameBlock
from brake_monitor.pipeline import Outputs, Pipeline
from brake_monitor.sample_block import SampleBlock

LONG_FRAMES = 200_000  # played so far: then what is left is likely to be worth the second that numba takes to load


def play(
    pipeline: Pipeline,
    blocks: Iterable[FrameBlock],
    decode: Callable[[FrameBlock], SampleBlock] | None = None,
    *,
    compile_after: int = LONG_FRAMES,
) -> Iterator[Outputs]:
    """What the pipeline gives out of the blocks of a recording, decoded by its own decoder, or as `decode` does.

    Machine code takes over from the first block that begins after so many frames.
    """
    frames, is_short = 0, True
    for block in blocks:
        if is_short and frames >= compile_after:
            is_short = False
            _compile(pipeline)
        yield from pipeline.play(block, decode and decode(block))
        frames += len(block)


def _compile(pipeline: Pipeline) -> None:
    """Let samples be taken by machine code where there is any."""
    if not pipeline.estimator.can_be_compiled or find_spec("numba") is None:
        return
    from brake_monitor.compiled_estimator import CompiledEstimator  # noqa: PLC0415 - loads numba

    with suppress(OSError, RuntimeError, WorkError):  # there is no room to keep it
        pipeline.taker = CompiledEstimator(pipeline.estimator)
