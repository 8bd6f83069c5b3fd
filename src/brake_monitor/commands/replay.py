"""`brake-monitor replay`: estimates and alarms from a recording."""

import csv
import sys
import time
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from math import inf
from pathlib import Path
from typing import TextIO

from brake_monitor import estimate_table
from brake_monitor.can_source import open_log
from brake_monitor.commands import options as shared
from brake_monitor.commands.summary import Summary
from brake_monitor.config_file import load_settings
from brake_monitor.errors import WorkError
from brake_monitor.frame import Frame
from brake_monitor.pipeline import Pipeline
from brake_monitor.progress import with_progress
from brake_monitor.publisher import Publisher

DESCRIPTION = """\
Replays a recording through the very path that the daemon runs and prints a summary.
Formats by suffix: .log (candump) .asc .blf .trc .csv .db .mf4 (extra 'mf4'), each also .gz.
The same recording always gives the same bytes."""

EXAMPLES = """\
examples:
  brake-monitor replay -c wagon.toml wsp.log                      summary only
  brake-monitor replay -c wagon.toml wsp.log -o estimates.csv     one row per estimate
  brake-monitor replay -c wagon.toml wsp.log --speed 1 --publish  as if it were live, over Zenoh"""


def add_parser(subparsers: "_SubParsersAction[ArgumentParser]") -> None:
    """Describe the command."""
    parser = subparsers.add_parser(
        "replay",
        help="estimates and alarms from a recording",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=RawDescriptionHelpFormatter,
    )
    shared.add_config(parser)
    parser.add_argument("log", type=Path, metavar="LOG", help="the recording")
    parser.add_argument(
        "-o", "--output", type=Path, metavar="OUT.csv", help="write one row per estimate ('-' for stdout)"
    )
    parser.add_argument(
        "--speed",
        type=shared.speed,
        default=inf,
        metavar="FACTOR",
        help="1.0 plays in real time, 'max' (default) as fast as it goes",
    )
    parser.add_argument("--publish", action="store_true", help="publish over Zenoh as configured")
    parser.set_defaults(run=run)


def run(options: Namespace) -> int:
    """Play the recording through the pipeline."""
    settings = load_settings(options.config)
    pipeline = Pipeline.from_settings(settings)
    log = open_log(options.log, settings.can)
    summary = Summary(settings)
    with ExitStack() as stack:
        rows = stack.enter_context(_rows(options.output, settings.vehicle.wheelset_count)) if options.output else None
        publisher = stack.enter_context(Publisher(settings.zenoh, settings.vehicle)) if options.publish else None
        for frame in with_progress(paced(log, options.speed), log.progress, f"replaying {options.log.name}"):
            outputs = pipeline.step(frame)
            if publisher is not None:
                publisher.publish(outputs)
            if outputs.estimate is not None and rows is not None:
                rows.writerow(estimate_table.row(outputs.estimate))
            summary.see(frame, outputs)
    print(summary.text(pipeline), file=sys.stderr if options.output == Path("-") else sys.stdout)
    return 0


def paced(frames: Iterable[Frame], speed: float) -> Iterator[Frame]:
    """Give each frame when its time has come at the given factor of real time."""
    start_s: float | None = None
    begun_s = time.monotonic()
    for frame in frames:
        if speed != inf:
            start_s = frame.time_s if start_s is None else start_s
            wait_s = (frame.time_s - start_s) / speed - (time.monotonic() - begun_s)
            if wait_s > 0.0:
                time.sleep(wait_s)
        yield frame


@contextmanager
def _rows(path: Path, wheelset_count: int) -> Iterator["csv._writer"]:
    """A CSV writer on the file; the file appears whole or not at all."""
    with _whole_file(path) as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(estimate_table.header(wheelset_count))
        yield writer


def _whole_file(path: Path) -> AbstractContextManager[TextIO]:
    return _stdout() if path == Path("-") else _renamed_when_whole(path)


@contextmanager
def _stdout() -> Iterator[TextIO]:
    yield sys.stdout


@contextmanager
def _renamed_when_whole(path: Path) -> Iterator[TextIO]:
    part = path.with_name(path.name + ".part")
    try:
        with part.open("w", encoding="utf-8", newline="") as stream:
            yield stream
        part.replace(path)
    except OSError as error:
        raise WorkError(f"{path}: cannot write the estimates: {error.strerror or error}") from error
    finally:
        part.unlink(missing_ok=True)
