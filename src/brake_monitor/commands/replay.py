"""`brake-monitor replay`: estimates and alarms from a recording."""

import sys
from argparse import ArgumentParser, Namespace, RawDescriptionHelpFormatter, _SubParsersAction
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from math import inf, isinf
from pathlib import Path
from typing import TextIO

from brake_monitor import alarm_lines, estimate_table, wear_lines
from brake_monitor.can_log import LogSource, open_log
from brake_monitor.commands import options as shared
from brake_monitor.commands.places import check_places, check_suffix
from brake_monitor.commands.summary import Summary
from brake_monitor.config_file import load_settings
from brake_monitor.errors import InputError
from brake_monitor.pacing import paced
from brake_monitor.parquet_table import Write, parquet_table
from brake_monitor.pipeline import Outputs, Pipeline
from brake_monitor.progress import with_progress
from brake_monitor.publisher import Publisher
from brake_monitor.smoother import Smoother
from brake_monitor.whole_file import whole_file

STDOUT = Path("-")

DESCRIPTION = """\
Replays a recording through the very path that the daemon runs and prints a summary.
Formats by suffix: .log (candump) .asc .blf .trc .csv .db .mf4 (extra 'mf4'), each also .gz.
The same recording always gives the same bytes."""

EXAMPLES = """\
examples:
  brake-monitor replay -c wagon.toml wsp.log                      summary only
  brake-monitor replay -c wagon.toml wsp.log -o estimates.csv     one row per estimate
  brake-monitor replay -c wagon.toml wsp.log -o estimates.parquet the same as Parquet (extra 'parquet')
  brake-monitor replay -c wagon.toml wsp.log -o smooth.csv --smooth
  brake-monitor replay -c wagon.toml wsp.log --alarms alarms.jsonl  one JSON object per alarm
  brake-monitor replay -c wagon.toml wsp.log --wear wear.jsonl    one JSON object per wheelset
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
        "-o",
        "--output",
        type=Path,
        metavar="OUT.csv",
        help="write one row per estimate ('-' for stdout); Parquet when it ends in .parquet",
    )
    parser.add_argument(
        "--alarms",
        type=Path,
        metavar="OUT.jsonl",
        help="write one JSON object per alarm, in the order of raising, as it stands at the end ('-' for stdout)",
    )
    parser.add_argument(
        "--wear",
        type=Path,
        metavar="OUT.jsonl",
        help="write one JSON object per wheelset: use and thickness of its pads at the end ('-' for stdout)",
    )
    parser.add_argument(
        "--smooth",
        action="store_true",
        help="better numbers in OUT.csv, from what came later too; status, alarms and summary stay as they are live",
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
    if options.smooth and options.output is None:
        raise InputError("--smooth changes nothing but the table: say where to write it with -o OUT.csv")
    settings = load_settings(options.config)
    places = {"-o": options.output, "--alarms": options.alarms, "--wear": options.wear}
    check_places(places, options.config, settings, options.log)
    if options.output is not None:
        check_suffix(options.output, ".csv", ".parquet")
    pipeline = Pipeline.from_settings(settings)
    smoother = Smoother(settings, pipeline) if options.smooth else None
    log = open_log(options.log, settings.can)
    summary = Summary(settings)
    with ExitStack() as stack:
        write = stack.enter_context(_table(options.output, settings.vehicle.wheelset_count)) if options.output else None
        alarms = stack.enter_context(_output(options.alarms)) if options.alarms else None
        wear = stack.enter_context(_output(options.wear)) if options.wear else None
        publisher = stack.enter_context(Publisher(settings.zenoh, settings.vehicle.id)) if options.publish else None
        for outputs in _played(pipeline, log, options.speed, f"replaying {options.log.name}"):
            summary.see(outputs)
            if publisher is not None:
                publisher.publish(outputs)
                if outputs.stops:
                    publisher.publish_wear(pipeline.brake_book.brakes, settings.wear)
            if write is not None and outputs.estimate is not None:
                write(smoother.take(outputs.estimate) if smoother else [outputs.estimate])
        if write is not None and smoother is not None:
            write(smoother.finish())
        summary.finish(pipeline)
        if alarms is not None:
            alarms.writelines(alarm_lines.line(alarm) + "\n" for alarm in summary.alarms)
        if wear is not None:
            wear.writelines(line + "\n" for line in wear_lines.lines(pipeline.brake_book.brakes, settings.wear))
    uses_stdout = STDOUT in (options.output, options.alarms, options.wear)
    print(summary.text(pipeline), file=sys.stderr if uses_stdout else sys.stdout)
    return 0


def _played(pipeline: Pipeline, log: LogSource, speed: float, title: str) -> Iterator[Outputs]:
    """What the pipeline gives out of a recording; frame by frame where each has its time."""
    if isinf(speed):
        for block in with_progress(log.blocks(), log.progress, title, every=1):
            yield from pipeline.play(block)
    else:
        for frame in with_progress(paced(log, speed), log.progress, title):
            yield pipeline.step(frame)


@contextmanager
def _table(path: Path, wheelset_count: int) -> Iterator[Write]:
    """Gives what writes estimates to a table of the kind that the suffix says."""
    if path.suffix.lower() == ".parquet":
        with parquet_table(path, wheelset_count) as write:
            yield write
        return
    with _output(path) as stream:
        stream.write(",".join(estimate_table.header(wheelset_count)) + "\n")
        yield lambda estimates: stream.writelines(",".join(estimate_table.row(e)) + "\n" for e in estimates)


@contextmanager
def _output(path: Path) -> Iterator[TextIO]:
    """The opened file, which appears when it is complete, or stdout."""
    if path == STDOUT:
        yield sys.stdout
        return
    with whole_file(path) as part, part.open("w", encoding="utf-8", newline="") as stream:
        yield stream
