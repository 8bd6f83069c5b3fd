"""`brake-monitor tune`: noise densities fitted to recordings."""

from argparse import ArgumentParser, Namespace
from collections.abc import Iterator
from itertools import zip_longest

from brake_monitor.bus.can_log import open_log
from brake_monitor.commands import options as shared
from brake_monitor.commands.file_checks import check_once
from brake_monitor.commands.playback import tell_remarks
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.desk.progress import counted, with_progress
from brake_monitor.errors import InputError
from brake_monitor.estimation.model.tuning import resolve
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.tuner.fit import fit, fittable, fragment
from brake_monitor.tuner.recording import Recording, read_recording, read_truth
from brake_monitor.tuner.scores import Judge
from brake_monitor.tuner.workers import scoring
from brake_monitor.validation.scores import LEAST_SPEED_MPS, SETTLED_S

EVALUATIONS = 100
WORTH_COMPILING = 5_000_000  # samples to be taken

DESCRIPTION = """\
Fits the estimator's noise densities to recordings, starting from what the configuration says, and prints
an [estimator.tuning] table for it. The result is never worse than the start.

With a truth it seeks the densities that make the errors of adhesion and friction small and the published intervals
honest. Without one it seeks those that make the recorded speeds most probable, near the preset. Speeds tell little of
friction: such a fit can be too sure of it. Try it against a truth, or against what you know of your brakes."""

EPILOG = """\
examples:
  brake-monitor tune -c wagon.toml monday.blf tuesday.blf                speeds and pressures alone
  brake-monitor tune -c wagon.toml wsp.log --truth wsp.csv               where adhesion was measured too
  brake-monitor tune -c wagon.toml a.log b.log --truth a.csv --truth b.csv

A truth is a CSV with the columns time_s (as in the log), adhesion and, where known, friction_1 ... friction_N.
Recordings should hold slides as well as service brakings: what does not occur in them cannot be fitted."""


def add_options(parser: ArgumentParser) -> None:
    """Its options."""
    shared.add_config(parser)
    parser.add_argument("log", type=shared.path, nargs="+", metavar="LOG", help="a recording")
    parser.add_argument(
        "--truth", type=shared.path, action="append", default=[], metavar="CSV", help="one for each log, in their order"
    )
    parser.add_argument(
        "--evaluations",
        type=shared.count,
        default=EVALUATIONS,
        metavar="N",
        help=f"runs of the estimator over all recordings, at most (default: {EVALUATIONS})",
    )
    shared.add_jobs(parser, "processes, at most one per log")


def run(options: Namespace) -> int:
    """Fit and print the fragment."""
    settings = load_settings(options.config)
    check_once(options.log)
    if options.truth and len(options.truth) != len(options.log):
        raise InputError(f"--truth: expected one for each of {len(options.log)} logs, got {len(options.truth)}")
    start = resolve(settings.estimator)
    names = fittable(start, settings.vehicle.wheelset_count)
    if not names:
        raise InputError(f"{options.config}: estimator.tuning: every density is 0, there is nothing to fit")
    recordings = list(_recordings(options, settings))
    judge = Judge(settings.vehicle, settings.estimator, SignalDecoder.from_settings(settings).channels)
    if sum(len(recording.samples) for recording in recordings) * options.evaluations > WORTH_COMPILING:
        judge.have_compiled()
    with scoring(judge, recordings, options.jobs) as score:
        trials = fit(start, names, score, options.evaluations)
        fits = [next(trials)]
        if not fits[0].before.judged:
            raise InputError(
                f"{', '.join(map(str, options.truth))}: nothing to judge within the truth's time: the wagon is "
                f"slower than {LEAST_SPEED_MPS:g} m/s, or its recording is younger than {SETTLED_S:g} s"
            )
        fits += counted(trials, options.evaluations - 1, "fitting")
    print(fragment(fits[-1], settings.estimator.preset, [path.name for path in options.log]))
    return 0


def _recordings(options: Namespace, settings: Settings) -> Iterator[Recording]:
    for log_path, truth_path in zip_longest(options.log, options.truth):
        truth = read_truth(truth_path, settings.vehicle.wheelset_count) if truth_path else None
        log = open_log(log_path, settings.can)
        blocks = with_progress(log.blocks(), log.progress, f"reading {log_path.name}")
        recording = read_recording(log_path, blocks, SignalDecoder.from_settings(settings), truth)
        tell_remarks(log)
        yield recording
