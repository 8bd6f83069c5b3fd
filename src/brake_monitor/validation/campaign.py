"""The whole campaign: which cases, what they will cost, and the files that come out."""

from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from pathlib import Path

from msgspec.structs import replace

from brake_monitor.compiled.kept_code import have_made
from brake_monitor.decoding.signals import SignalDecoder
from brake_monitor.estimation.estimator import Estimator
from brake_monitor.host.whole_file import make_folder, whole_file
from brake_monitor.settings.config import Preset
from brake_monitor.validation import figures
from brake_monitor.validation.cases import ERROR_FIGURE, SANDING_FIGURE, WSP_FIGURE, Case, all_cases
from brake_monitor.validation.report import html
from brake_monitor.validation.results import Result, as_csv, as_json, results
from brake_monitor.validation.runs import Outcome, Task
from brake_monitor.validation.series import Series
from brake_monitor.validation.variants import VARIANTS
from brake_monitor.validation.vehicles import campaign_settings

QUICK_VEHICLES = ("wagon",)
SIMULATE_S, SIMULATE_EACH_S = 0.3, 0.15  # processor time of a run of the plant, and for each of its wheelsets
ESTIMATE_S, ESTIMATE_EACH_S = 0.2, 0.06  # likewise of an estimator
WORTH_COMPILING_S = 100.0


def chosen(patterns: Iterable[str], *, quick: bool) -> list[Case]:
    """The campaign's cases whose name matches one of the patterns."""
    cases = all_cases(QUICK_VEHICLES) if quick else all_cases()
    return [case for case in cases if any(fnmatchcase(case.name, pattern) for pattern in patterns)]


def expected_s(tasks: Sequence[Task]) -> float:
    """About how much processor time the tasks take on a small computer."""
    total = 0.0
    for task in tasks:
        count = task.cases[0].wheelset_count
        total += SIMULATE_S + SIMULATE_EACH_S * count + len(task.cases) * (ESTIMATE_S + ESTIMATE_EACH_S * count)
    return total


def have_compiled(tasks: Sequence[Task]) -> None:
    """Let machine code of the estimators be made where the tasks are worth it; they run in Python until it is there."""
    if expected_s(tasks) > WORTH_COMPILING_S:
        cases = [case for task in tasks for case in task.cases]
        presets = {(case.vehicle, VARIANTS[case.variant].preset) for case in cases}
        have_made(*[_estimator(vehicle, preset) for vehicle, preset in sorted(presets)])


def _estimator(vehicle: str, preset: Preset) -> Estimator:
    settings = campaign_settings(vehicle)
    channels = SignalDecoder.from_settings(settings).channels
    return Estimator(settings.vehicle, replace(settings.estimator, preset=preset), channels)


def write(outcomes: Sequence[Outcome], seeds: int, folder: Path) -> list[Result]:
    """Judge the runs; write report.html, accuracy.csv, accuracy.json and figures/*.svg into `folder`."""
    found = results(outcomes)
    drawn = list(_figures({outcome.case: outcome.series for outcome in outcomes if outcome.series is not None}))
    files = {
        folder / "accuracy.csv": as_csv(found),
        folder / "accuracy.json": as_json(found, seeds),
        **{folder / "figures" / f"{name}.svg": svg for name, _, svg in drawn},
        folder / "report.html": html(found, [(caption, svg) for _, caption, svg in drawn], seeds),
    }
    for path, text in files.items():
        make_folder(path.parent)
        with whole_file(path) as part:
            part.write_text(text, encoding="utf-8")
    return found


def _figures(series: dict[Case, Series]) -> Iterator[tuple[str, str, str]]:
    """Name, caption and SVG of every figure whose run is there."""
    if WSP_FIGURE in series:
        caption = "Wheel-slide protection at work from 120 km/h (the paper’s Fig. 4), one wheelset with CAN sensors"
        yield "wsp", caption, figures.braking_figure(series[WSP_FIGURE], "Wheel-slide protection, from 120 km/h")
    if SANDING_FIGURE in series:
        run = series[SANDING_FIGURE]
        caption = "Sanding from 200 km/h (the paper’s Fig. 5), one wheelset with CAN sensors"
        yield "sanding", caption, figures.braking_figure(run, "Sanding, from 200 km/h")
        caption = "Adhesion over slip in the sanding run, and its error (the paper’s Fig. 6)"
        yield "slip", caption, figures.slip_figure(run, "Adhesion over slip, sanding")
    if ERROR_FIGURE in series:
        caption = "Errors over time in the run with wheel-slide protection, two-axle wagon, within what is published"
        yield "error", caption, figures.error_figure(series[ERROR_FIGURE], "Error over time, wagon")
