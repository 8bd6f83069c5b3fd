"""`brake-monitor validate-alarms`: which alarms come, how soon, and which should not have."""

import os
from argparse import ArgumentParser, Namespace
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import msgspec

from brake_monitor.alarm_campaign.drives import Drive, chosen, service_drives, trouble_drives
from brake_monitor.alarm_campaign.outcome import Outcome, judge
from brake_monitor.alarm_campaign.tables import by_drive, failures, markdown
from brake_monitor.commands import options as shared
from brake_monitor.desk.progress import counted
from brake_monitor.errors import InputError, WorkError
from brake_monitor.host.processes import spread
from brake_monitor.host.whole_file import make_folder, whole_file
from brake_monitor.plural import plural
from brake_monitor.simulator.physics.compiled import HOW_TO_BE_FASTER, IS_COMPILED

SEEDS = 5
HOURS = 100.0
HOURS_OF_SERVICE = shared.number("hours, 0 or more", 0.0, 1e5)
OUTCOMES = "outcomes.jsonl"

DESCRIPTION = """\
Simulates drives on which something is wrong (see `brake-monitor simulate --help`) and hours of ordinary service, takes
each through the whole path from CAN frames to alarms, and holds the alarms against those that are due by the truth.

Writes alarms.md (detection delays and false alarms by kind), drives.md (by drive), failures.txt (each alarm that came
late, never, or wrongly) and outcomes.jsonl. The exit code is 1 when there is a failure."""

EPILOG = """\
examples:
  brake-monitor validate-alarms -o alarms                               everything: up to two hours on two processors
  brake-monitor validate-alarms -o alarms --resume                      go on after an interruption
  brake-monitor validate-alarms -o alarms --only 'wagon/stuck/*' --hours 0
  brake-monitor validate-alarms -o alarms --only '*/service/*' --hours 10

A drive is named VEHICLE/SCENARIO/SEED; the vehicles are single, wagon and bogie (1, 2 and 4 wheelsets)."""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("-o", "--output", type=shared.path, required=True, metavar="DIR", help="folder for the tables")
    parser.add_argument("--seeds", type=shared.count, default=SEEDS, metavar="N", help=f"of each (default: {SEEDS})")
    parser.add_argument(
        "--hours", type=HOURS_OF_SERVICE, default=HOURS, metavar="H", help=f"of ordinary service (default: {HOURS:g})"
    )
    shared.add_jobs(parser)
    parser.add_argument("--only", action="append", metavar="PATTERN", help="drives by name; may be given several times")
    parser.add_argument("--resume", action="store_true", help="leave out the drives that DIR already has")


def run(options: Namespace) -> int:
    """Drive, judge and write."""
    drives = chosen((*trouble_drives(options.seeds), *service_drives(options.hours)), options.only or ["*"])
    if not drives:
        raise InputError("--only, --hours: nothing is left to drive; a pattern is something like 'wagon/stuck/*'")
    make_folder(options.output)
    path = options.output / OUTCOMES
    if not options.resume:
        path.open("wb").close()
    known = _known(path)
    todo = [drive for drive in drives if drive not in known]
    hours = sum(drive.expected_s for drive in todo) / 3600.0
    print(f"{plural(len(todo), 'drive')}, up to {hours:.1f} simulated hours, {plural(options.jobs, 'job')}", flush=True)
    if not IS_COMPILED:
        print(HOW_TO_BE_FASTER, flush=True)
    found = [known[drive] for drive in drives if drive in known]
    judged = spread(partial(judge, is_one_of_many=len(todo) > 1), todo, options.jobs)
    for outcome in counted(judged, len(todo), "driving"):
        _note(outcome, path)
        found.append(outcome)
    _write(found, options.output)
    print(markdown(found), end="")
    return 1 if any(True for _ in failures(found)) else 0


def _note(outcome: Outcome, path: Path) -> None:
    """Append an outcome; WorkError when the disk does not let it."""
    try:
        with path.open("ab") as stream:
            stream.write(msgspec.json.encode(outcome) + b"\n")
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error


def _known(path: Path) -> dict[Drive, Outcome]:
    """What an earlier run noted; a last line that was cut short is removed, and its drive driven again."""
    if not path.is_file():
        return {}
    *lines, cut_short = path.read_bytes().split(b"\n")
    if cut_short:
        os.truncate(path, path.stat().st_size - len(cut_short))
    return {outcome.drive: outcome for outcome in _whole(lines)}


def _whole(lines: Iterable[bytes]) -> Iterator[Outcome]:
    for line in lines:
        with suppress(msgspec.DecodeError):  # a power cut may leave damaged lines; those drives are driven again
            yield msgspec.json.decode(line, type=Outcome)


def _write(found: list[Outcome], folder: Path) -> None:
    """The tables, whole or not at all."""
    texts = {
        "alarms.md": markdown(found),
        "drives.md": by_drive(found),
        "failures.txt": "".join(f"{line}\n" for line in failures(found)),
    }
    for name, text in texts.items():
        with whole_file(folder / name) as part:
            part.write_text(text, encoding="utf-8")
