"""Recordings through a pipeline, by the block; long ones with a compiled estimator where numba is installed."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from importlib.util import find_spec

from brake_monitor.compiled.kept_code import EstimatorOrder, KeptCode
from brake_monitor.decoding.sample_block import SampleBlock
from brake_monitor.errors import WorkError
from brake_monitor.frame_block import FrameBlock
from brake_monitor.processing.pipeline import Outputs, Pipeline

LONG_FRAMES = 200_000  # to come: worth the second that numba takes to load; played so far: more is likely to come


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
    frames, in_python = 0, pipeline.estimator.can_be_compiled and find_spec("numba") is not None
    for block in blocks:
        read = frames + len(block)
        if in_python and (is_one_of_many or max(frames, _to_come(read, progress)) >= LONG_FRAMES):
            in_python = not _takes_machine_code(pipeline)
        yield from pipeline.play(block, decode and decode(block))
        frames = read


def _to_come(frames: int, progress: Callable[[], float] | None) -> float:
    """How many frames follow these, by the share of the recording that they are; 0 where that is not known."""
    share = progress() if progress else 0.0
    return frames * (1.0 - share) / share if share > 0.0 else 0.0


def _takes_machine_code(pipeline: Pipeline) -> bool:
    """Let samples be taken by machine code if it is on disk; if not it is made meanwhile."""
    settings, channels = pipeline.settings, tuple(pipeline.decoder.channels)
    code = KeptCode(EstimatorOrder(settings.vehicle, settings.estimator, channels))
    if not code.is_ready:
        with suppress(OSError):  # there is no room to keep it
            code.have_made()
        return False
    from brake_monitor.compiled.compiled_estimator import CompiledEstimator  # noqa: PLC0415 - loads numba

    with suppress(OSError, RuntimeError, WorkError):  # it is there, but cannot be loaded: Python goes on
        pipeline.taker = CompiledEstimator(pipeline.estimator)
    return True
