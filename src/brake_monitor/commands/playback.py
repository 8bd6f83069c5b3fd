"""One recording through the pipeline, into the files that were asked for."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from math import isinf
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, TextIO

from brake_monitor.bus.can_log import LogSource, open_log
from brake_monitor.commands.file_checks import STDOUT, check_outputs, check_suffix
from brake_monitor.commands.summary import Summary
from brake_monitor.decoding.decode_counts import DecodeCounts
from brake_monitor.desk.json_lines import alarm_line, wear_lines
from brake_monitor.desk.parquet_table import Write, parquet_table
from brake_monitor.desk.progress import with_progress
from brake_monitor.errors import InputError, WorkError
from brake_monitor.frame_block import FrameBlock
from brake_monitor.host.pacing import paced
from brake_monitor.host.whole_file import whole_file
from brake_monitor.plural import plural
from brake_monitor.processing import estimate_table, playing
from brake_monitor.processing.pipeline import Outputs, Pipeline
from brake_monitor.processing.smoother import Smoother
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.config_text import place_of

if TYPE_CHECKING:
    from brake_monitor.publishing.publisher import Publisher


class Playback(NamedTuple):
    """What to play and where to write what comes of it; None: nowhere."""

    config: Path
    log: Path
    estimates: Path | None  # Parquet when it ends in .parquet, else CSV
    alarms: Path | None
    wear: Path | None
    smooth: bool  # the table knows the future
    speed: float  # as a multiple of real time
    publishes: bool
    is_alone: bool  # and shows how far it is

    @property
    def outputs(self) -> dict[str, Path | None]:
        """The outputs by their options."""
        return {"-o": self.estimates, "--alarms": self.alarms, "--wear": self.wear}


def play(playback: Playback) -> str:
    """Play the recording; return the summary. InputError when something in it, or in what is asked, is wrong.

    WorkError when it carries nothing that is mapped; what was asked for is written all the same.
    """
    settings = load_settings(playback.config)
    check_outputs(playback.outputs, settings, playback.log, may_be_stdout=True)
    if playback.estimates is not None:
        check_suffix(playback.estimates, ".csv", ".parquet")
    pipeline = Pipeline.from_settings(settings)
    smoother = Smoother(pipeline) if playback.smooth else None
    publisher = _publisher(settings) if playback.publishes else None
    log = open_log(playback.log, settings.can)
    summary = Summary(settings)
    with ExitStack() as stack:
        write = stack.enter_context(_table(playback.estimates, settings.vehicle.wheelset_count))
        alarms = stack.enter_context(_output(playback.alarms))
        wear = stack.enter_context(_output(playback.wear))
        if publisher is not None:
            stack.enter_context(publisher)
            where = ", ".join(publisher.endpoints or settings.zenoh.connect)
            print(f"publishing {settings.zenoh.prefix}/{settings.vehicle.id}, {where}", file=sys.stderr)
        for outputs in _played(pipeline, log, playback):
            summary.see(outputs)
            if publisher is not None:
                publisher.publish(outputs)
                if outputs.applications:
                    publisher.publish_wear(pipeline.brake_book.brakes, settings.wear)
            if write is not None and outputs.estimate is not None and pipeline.is_told:
                write(smoother.take(outputs.estimate) if smoother else [outputs.estimate])
        if write is not None and smoother is not None:
            write(smoother.finish())
        summary.finish(pipeline)
        if alarms is not None:
            alarms.writelines(alarm_line(alarm) + "\n" for alarm in summary.alarms)
        if wear is not None:
            wear.writelines(line + "\n" for line in wear_lines(pipeline.brake_book.brakes, settings.wear))
    tell_remarks(log)
    check_mapped(pipeline.decoder.counts, playback.log, playback.config)
    return summary.text(pipeline)


def tell_remarks(log: LogSource) -> None:
    """Say on standard error what had to be assumed of a recording that was played to its end."""
    for remark in log.remarks:
        print(f"remark: {remark}", file=sys.stderr)


def check_mapped(counts: DecodeCounts, log: Path, config: Path) -> None:
    """WorkError when nothing could come of a recording, most likely another vehicle's."""
    if not counts.mapped:
        raise WorkError(
            f"{log}: of {plural(counts.frames, 'frame')} none is one that {config} maps; "
            f"'brake-monitor check -c {config} {log}' lists what it carries"
        )


def _played(pipeline: Pipeline, log: LogSource, playback: Playback) -> Iterator[Outputs]:
    """What the pipeline gives for a recording: block by block, or frame by frame at a limited speed."""
    title = f"replaying {playback.log.name}"
    if isinf(playback.speed):
        blocks: Iterable[FrameBlock] = log.blocks()
        if playback.is_alone:
            blocks = with_progress(blocks, log.progress, title)
        yield from playing.play(pipeline, blocks, progress=log.progress)
    else:
        for frame in with_progress(paced(log, playback.speed), log.progress, title):
            yield pipeline.step(frame)


def _publisher(settings: Settings) -> "Publisher":
    from brake_monitor.publishing.publisher import Publisher  # noqa: PLC0415 - slow to import, and seldom wanted
    from brake_monitor.publishing.zenoh_endpoints import naming_endpoints  # noqa: PLC0415 - likewise

    if not settings.zenoh.enabled:
        place = place_of(settings.path, ("zenoh", "enabled"))
        raise InputError(f"{place}: zenoh.enabled: expected true where --publish is given, got false")
    with naming_endpoints(settings.path):
        publisher = Publisher(settings.zenoh, settings.vehicle.id)
    publisher.refuse_acknowledgements("this is a recording, and what it tells of is over")
    return publisher


@contextmanager
def _table(path: Path | None, wheelset_count: int) -> Iterator[Write | None]:
    """Yield a function that appends estimates to the table, Parquet or CSV by its suffix; None without a table."""
    if path is not None and path.suffix.lower() == ".parquet":
        with parquet_table(path, wheelset_count) as write:
            yield write
        return
    with _output(path) as stream:
        if stream is None:
            yield None
            return
        stream.write(",".join(estimate_table.header(wheelset_count)) + "\n")
        yield lambda estimates: stream.writelines([estimate_table.line(e) + "\n" for e in estimates])


@contextmanager
def _output(path: Path | None) -> Iterator[TextIO | None]:
    """The opened file, which appears when it is complete, or stdout."""
    if path is None:
        yield None
    elif path == STDOUT:
        yield sys.stdout
        sys.stdout.flush()  # what cannot be written is told before what is said of it
    else:
        with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
            yield stream
