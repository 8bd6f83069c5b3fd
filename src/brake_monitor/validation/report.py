"""The campaign as one HTML page that needs no other file."""

from collections.abc import Iterable, Iterator
from html import escape
from math import isnan

from brake_monitor import __version__
from brake_monitor.plural import plural
from brake_monitor.validation.cases import COMPARED_ON, CONDITIONS, Case, own_preset
from brake_monitor.validation.results import Result, told
from brake_monitor.validation.variants import VARIANTS

STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #222; margin: 2em auto; max-width: 76em; padding: 0 1em }
h1, h2 { line-height: 1.2 } h2 { margin-top: 2em }
svg { max-width: 60em; width: 100%; height: auto; display: block }
div.wide { overflow-x: auto }
table { border-collapse: collapse; font-size: 13px; font-variant-numeric: tabular-nums }
th, td { padding: .25em .7em; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th { border-bottom: 2px solid #888; vertical-align: bottom } td.text, th.text { text-align: left }
td.miss { background: #fbe3d6; font-weight: 600 } small { color: #666 }
"""

INTRODUCTION = """
<p>Every figure compares estimates with the truth of a simulated plant that shares no equation with the estimator.
The frames went through DBC, mapping and pipeline as on a vehicle. Sensors of the vehicles <i>single</i>, <i>wagon</i>
and <i>bogie</i> (1, 2 and 4 wheelsets): wheel speeds every 20 ms in steps of 0.01 km/h with σ = 0.01 m/s, vehicle speed
every 50 ms with σ = 0.02 m/s, cylinder pressure every 10 ms in steps of 0.002 bar. Judged after the first 3 s and above
2 m/s, at every fused frame; friction where the pad presses with more than 5 kN.</p>
<p>Values beyond their target are marked ✗. <b>Worst</b>: greatest adhesion error. <b>Large</b>: longest time that the
adhesion error stays above 0.02. <b>Inside</b>: how often the published 95 % interval holds the truth.
<b>NEES</b>: mean squared error over published variance, 1 when both agree. <b>Overconfident</b>: longest time that an
estimate is <i>valid</i> while wrong by more than three of its standard deviations. <b>Valid</b>: share of estimates
with that status. Where an estimator that is told everything but the adhesion does not reach a target either, what that
one reaches and 20 % take its place.</p>
"""

COLUMNS = (
    ("adhesion<br>RMSE", "adhesion_rmse", "adhesion_rmse_limit", ".4f"),
    ("worst<br>run", "adhesion_rmse_worst_run", "", ".4f"),
    ("worst", "worst_error", "worst_error_limit", ".3f"),
    ("large<br>s", "longest_large_error_s", "longest_large_error_limit_s", ".2f"),
    ("inside", "adhesion_coverage", "", ".1%"),
    ("NEES", "adhesion_nees", "", ".2f"),
    ("friction<br>RMSE", "friction_rmse", "friction_rmse_limit", ".4f"),
    ("inside", "friction_coverage", "", ".1%"),
    ("NEES", "friction_nees", "", ".2f"),
    ("over-<br>confident s", "longest_dishonest_s", "longest_dishonest_limit_s", ".2f"),
    ("valid", "valid_share", "", ".1%"),
)


def html(found: list[Result], figures: Iterable[tuple[str, str]], seeds: int) -> str:
    """The page; `figures` are captions with their SVG."""
    return "\n".join(_page(found, figures, seeds))


def _page(found: list[Result], figures: Iterable[tuple[str, str]], seeds: int) -> Iterator[str]:
    yield '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Accuracy</title>'
    yield f"<style>{STYLE}</style></head><body><h1>How accurate the estimates are</h1>"
    yield f"<p><small>brake-monitor {__version__}, {plural(seeds, 'seed')} per case</small></p>"
    lines = list(told(found))
    yield f"<p><b>{escape(lines[0])}</b>.</p>"
    yield INTRODUCTION
    for caption, svg in figures:
        yield f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"
    yield from _section("Accuracy", [r for r in found if _is_accuracy(r.case)])
    yield from _comparison(found)
    yield from _section("What is possible at all", [r for r in found if r.case.variant == "informed"])
    yield from _section("Inside a train, for comparison", [r for r in found if _is_coupled(r.case)])
    yield from _section("The paper’s sensors and covariances", [r for r in found if r.case.vehicle == "laboratory"])
    yield "</body></html>\n"


def _is_accuracy(case: Case) -> bool:
    return case.vehicle != "laboratory" and case.variant == own_preset(case.condition)


def _is_coupled(case: Case) -> bool:
    return case.condition == "coupled" and case.variant in ("wagon", "without_d")


def _section(title: str, chosen: list[Result]) -> Iterator[str]:
    """A table with one row per result, and nothing where there is none."""
    if not chosen:
        return
    heads = "".join(f"<th>{head}</th>" for head, *_ in COLUMNS)
    names = "".join(f'<th class="text">{name}</th>' for name in ("vehicle", "scenario", "condition", "estimator"))
    yield f'<h2>{title}</h2><div class="wide"><table><tr>{names}{heads}<th class="text">targets</th></tr>'
    for result in chosen:
        case, row = result.case, result.row()
        texts = (case.vehicle, case.scenario, CONDITIONS[case.condition].label, VARIANTS[case.variant].label)
        cells = "".join(f'<td class="text">{escape(text)}</td>' for text in texts)
        for _, column, limit, form in COLUMNS:
            cells += _cell(row[column], row.get(limit), form, missed=column in result.misses)
        yield f'<tr>{cells}<td class="text">{result.verdict}</td></tr>'
    yield "</table></div>"


def _cell(value: object, limit: object, form: str, *, missed: bool) -> str:
    if not isinstance(value, float):
        return "<td>–</td>"
    bound = f" <small>≤ {limit:g}</small>" if isinstance(limit, float) else ""
    return f'<td class="miss">✗ {value:{form}}{bound}</td>' if missed else f"<td>{value:{form}}{bound}</td>"


def _comparison(found: list[Result]) -> Iterator[str]:
    """RMSE of adhesion and friction of every variant, side by side."""
    by_case = {result.case: result for result in found}
    places = [place for place in COMPARED_ON if any(Case(*place, name) in by_case for name in VARIANTS)]
    if not places:
        return
    heads = "".join(f"<th>{scenario}<br>{CONDITIONS[name].label}</th>" for _, scenario, name in places)
    yield "<h2>Paper, presets and variants</h2><p>RMSE of adhesion / of friction, two-axle wagon with CAN sensors.</p>"
    yield f'<div class="wide"><table><tr><th class="text">estimator</th>{heads}</tr>'
    for name in VARIANTS:
        cells = "".join(_pair(by_case.get(Case(*place, name))) for place in places)
        yield f'<tr><td class="text">{escape(VARIANTS[name].label)}</td>{cells}</tr>'
    yield "</table></div>"


def _pair(result: Result | None) -> str:
    if result is None or isnan(result.score.adhesion.rmse):
        return "<td>–</td>"
    return f"<td>{result.score.adhesion.rmse:.4f} / {result.score.friction.rmse:.3f}</td>"
