"""`brake-monitor replay`: estimates and alarms from recordings."""

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from math import inf, isinf
from os.path import realpath
from pathlib import Path
from typing import NamedTuple

from brake_monitor.commands import options as shared
from brake_monitor.commands.file_checks import STDOUT, beside, check_once
from brake_monitor.commands.playback import Playback, play
from brake_monitor.desk.progress import counted
from brake_monitor.errors import BrakeMonitorError, InputError
from brake_monitor.host.processes import spread
from brake_monitor.settings.config_file import load_settings

DESCRIPTION = """\
Replays recordings through the very path that the daemon runs and prints a summary of each.
Formats by suffix: .log (candump) .asc .blf .trc .csv .db .mf4 (extra 'mf4'), each also .gz.
The same recording always gives the same bytes. Several are played in parallel, and none learns from another."""

EPILOG = """\
examples:
  brake-monitor replay -c wagon.toml wsp.log                      summary only
  brake-monitor replay -c wagon.toml wsp.log -o estimates.csv     one row per estimate
  brake-monitor replay -c wagon.toml wsp.log -o estimates.parquet  the same as Parquet (extra 'parquet')
  brake-monitor replay -c wagon.toml wsp.log -o smooth.csv --smooth
  brake-monitor replay -c wagon.toml wsp.log --alarms alarms.jsonl  one JSON object per alarm
  brake-monitor replay -c wagon.toml wsp.log --wear wear.jsonl    one JSON object per wheelset
  brake-monitor replay -c wagon.toml wsp.log --speed 1 --publish  as if it were live, over Zenoh
  brake-monitor replay -c wagon.toml may/*.blf -o 'may/*.csv'     several, each into a file of its own name"""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument("logs", type=shared.path, nargs="+", metavar="LOG", help="a recording")
    parser.add_argument(
        "-o",
        "--output",
        type=shared.path,
        metavar="OUT.csv",
        help="write one row per estimate ('-' for stdout); Parquet when it ends in .parquet; "
        "of several recordings a '*' in the name stands for the recording's",
    )
    parser.add_argument(
        "--alarms",
        type=shared.path,
        metavar="OUT.jsonl",
        help="write one JSON object per alarm, in the order of raising, as it stands at the end ('-' for stdout)",
    )
    parser.add_argument(
        "--wear",
        type=shared.path,
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
    shared.add_jobs(parser, "processes for several recordings")


def run(options: Namespace) -> int:
    """Play the recordings through the pipeline."""
    if options.smooth and options.output is None:
        raise InputError("--smooth changes nothing but the table: say where to write it with -o OUT.csv")
    if len(options.logs) > 1:
        return _play_several(options)
    playback = _playback(options, options.logs[0])
    text = play(playback)
    print(text, file=beside(playback.outputs.values()))
    return 0


def _playback(options: Namespace, log: Path) -> Playback:
    """What to do with one of the recordings."""
    return Playback(
        options.config,
        log,
        _placed(options.output, log),
        _placed(options.alarms, log),
        _placed(options.wear, log),
        options.smooth,
        options.speed,
        options.publish,
        is_alone=len(options.logs) == 1,
    )


def _placed(pattern: Path | None, log: Path) -> Path | None:
    """Where an output of a recording goes: '*' is the recording's name."""
    if pattern is None or "*" not in pattern.name:
        return pattern
    return pattern.with_name(pattern.name.replace("*", _name(log)))


def _name(log: Path) -> str:
    """Without what tells its kind."""
    return Path(log.stem).stem if log.suffix.lower() == ".gz" else log.stem


# -- several recordings --------------------------------------------------------------------------------------------


class Replayed(NamedTuple):
    """What is said of one of several recordings."""

    number: int  # from 0, in the order given
    summary: str
    error: str
    exit_code: int


def _play_several(options: Namespace) -> int:
    """Play each by itself; a damaged one does not keep the others from being played."""
    if options.publish or not isinf(options.speed):
        raise InputError("--publish and --speed are for one recording: several are played at the same time")
    load_settings(options.config)  # once, so that its faults are not repeated for each recording
    playbacks = [_playback(options, log) for log in options.logs]
    _check_apart(playbacks)
    found = spread(_tell, list(enumerate(playbacks)), options.jobs)
    told = sorted(counted(found, len(playbacks), "replaying"))
    print("\n\n".join(f"{options.logs[one.number]}\n{one.summary or 'not played'}" for one in told), flush=True)
    for one in told:
        if one.error:
            print(f"brake-monitor: {one.error}", file=sys.stderr)
    return max(one.exit_code for one in told)


def _tell(numbered: tuple[int, Playback]) -> Replayed:
    number, playback = numbered
    try:
        return Replayed(number, play(playback), "", 0)
    except BrakeMonitorError as error:
        return Replayed(number, "", str(error), error.exit_code)


def _check_apart(playbacks: Sequence[Playback]) -> None:
    """InputError where an output would take the place of another's, or of a recording."""
    check_once(playback.log for playback in playbacks)
    recordings = {realpath(playback.log) for playback in playbacks}
    taken: dict[str, Path] = {}  # by output, the recording that it is of
    for playback in playbacks:
        for option, path in playback.outputs.items():
            if path is None:
                continue
            if realpath(path) in recordings:
                raise InputError(f"{option} {path}: this is one of the recordings, which would be lost")
            other = taken.setdefault(realpath(path), playback.log)
            if path != STDOUT and other != playback.log and _name(other) == _name(playback.log):
                raise InputError(
                    f"{option} {path}: what comes of two recordings cannot both go there; {other} and "
                    f"{playback.log} are both named {_name(playback.log)}"
                )
            if path == STDOUT or other != playback.log:
                raise InputError(
                    f"{option} {path}: what comes of several recordings cannot all go there; write a '*' for the "
                    f"name of each, as in {option} '*{path.suffix}'"
                )
