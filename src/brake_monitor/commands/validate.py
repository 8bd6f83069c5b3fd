"""`brake-monitor validate`: the accuracy campaign and its report."""

from argparse import ArgumentParser, Namespace
from functools import partial
from math import ceil

from brake_monitor.commands import options as shared
from brake_monitor.desk.progress import counted
from brake_monitor.errors import InputError
from brake_monitor.host import extras
from brake_monitor.host.processes import spread
from brake_monitor.host.whole_file import make_folder
from brake_monitor.plural import plural
from brake_monitor.simulator.physics.compiled import HOW_TO_BE_FASTER, IS_COMPILED
from brake_monitor.validation.campaign import chosen, expected_s, have_compiled, write
from brake_monitor.validation.cases import DRAWN
from brake_monitor.validation.results import told
from brake_monitor.validation.runs import Task, tasks

SEEDS = 20
QUICK_SEEDS = 2

DESCRIPTION = """\
Simulates many brakings, estimates each through the whole path from CAN frames on, and holds every estimate against
the truth: scenarios wsp, sanding, leaf and dry; 1, 2 and 4 wheelsets; gradients, lines, worn wheel, lost frames,
wrong mass, coupler force; and the presets and the paper's own equations for comparison.

Writes report.html (needs nothing but itself), accuracy.csv, accuracy.json and figures/*.svg. The same seeds give the
same numbers. The exit code is 1 when a target is missed."""

EPILOG = """\
examples:
  brake-monitor validate -o accuracy                                 everything: half an hour on two processors
  brake-monitor validate -o accuracy --quick                         two seeds, two-axle wagon only
  brake-monitor validate -o accuracy --only 'wagon/wsp/*' --seeds 5  some cases

A case is named VEHICLE/SCENARIO/CONDITION/ESTIMATOR."""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    parser.add_argument("-o", "--output", type=shared.path, required=True, metavar="DIR", help="folder for the report")
    parser.add_argument("--seeds", type=shared.count, metavar="N", help=f"runs of each case (default: {SEEDS})")
    shared.add_jobs(parser)
    parser.add_argument("--quick", action="store_true", help=f"{QUICK_SEEDS} seeds, two-axle wagon only")
    parser.add_argument("--only", action="append", metavar="PATTERN", help="cases by name; may be given several times")


def run(options: Namespace) -> int:
    """Run the campaign and write its report."""
    extras.require("report", "drawing")
    seeds = options.seeds or (QUICK_SEEDS if options.quick else SEEDS)
    cases = chosen(options.only or ["*"], quick=options.quick)
    if not cases:
        raise InputError(
            f"--only {' '.join(options.only)}: no case has such a name, expected something like 'wagon/wsp/*'"
        )
    make_folder(options.output)
    work = tasks(cases, seeds)
    minutes = expected_s(work) / options.jobs / 60.0
    print(
        f"{plural(len(cases), 'case')} on {plural(len(work), 'simulated drive')} with {plural(seeds, 'seed')}, "
        f"about {ceil(minutes)} min with {plural(options.jobs, 'job')}",
        flush=True,
    )
    if not IS_COMPILED:
        print(HOW_TO_BE_FASTER, flush=True)
    have_compiled(work)
    judged = counted(spread(partial(Task.judge, drawn=DRAWN), work, options.jobs), len(work), "validating")
    found = write([outcome for some in judged for outcome in some], seeds, options.output)
    print("\n".join(told(found)))
    print(f"report: {options.output / 'report.html'}")
    return 1 if any(result.misses for result in found) else 0
