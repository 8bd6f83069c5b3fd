"""Scores against targets: one result per case, and the tables they go into."""

import csv
from collections.abc import Iterable, Iterator
from io import StringIO
from math import isnan

import msgspec
from msgspec import Struct

from brake_monitor import __version__
from brake_monitor.plural import plural
from brake_monitor.validation.cases import Case, Limits
from brake_monitor.validation.runs import Outcome
from brake_monitor.validation.scores import Score

WITHIN_REACH_FACTOR = 1.2  # of what is possible at all, where that is more than the target
RIG_PRESET_FACTOR = 2.0  # how much better than the paper's tuning ours is to be on the paper's sensors


class Result(Struct, frozen=True):
    """One case over all its seeds."""

    case: Case
    score: Score
    limits: Limits

    @property
    def misses(self) -> tuple[str, ...]:
        """Names of the row's columns that are beyond their limit."""
        score, limits = self.score, self.limits
        bounded = {
            "adhesion_rmse": (score.adhesion.rmse, limits.adhesion_rmse),
            "worst_error": (score.worst, limits.worst),
            "longest_large_error_s": (score.longest_large_s, limits.longest_large_s),
            "longest_dishonest_s": (score.longest_dishonest_s, limits.longest_dishonest_s),
            "friction_rmse": (score.friction.rmse, limits.friction_rmse),
        }
        misses = [name for name, (value, limit) in bounded.items() if limit is not None and value > limit]
        if limits.coverage:
            low, high = limits.coverage
            covering = {"adhesion_coverage": score.adhesion.coverage, "friction_coverage": score.friction.coverage}
            misses += [name for name, value in covering.items() if not (isnan(value) or low <= value <= high)]
        return tuple(misses)

    @property
    def has_target(self) -> bool:
        """Whether anything is demanded of this case."""
        return self.limits != Limits()

    @property
    def verdict(self) -> str:
        """`pass`, `miss`, or empty where nothing is demanded."""
        if not self.has_target:
            return ""
        return "miss" if self.misses else "pass"

    def row(self) -> dict[str, str | int | float | None]:
        """The result as a flat record."""
        case, score, limits = self.case, self.score, self.limits
        return {
            "vehicle": case.vehicle,
            "wheelsets": case.wheelset_count,
            "scenario": case.scenario,
            "condition": case.condition,
            "estimator": case.variant,
            "runs": score.runs,
            "adhesion_rmse": _rounded(score.adhesion.rmse),
            "adhesion_rmse_limit": limits.adhesion_rmse,
            "adhesion_rmse_worst_run": _rounded(score.worst_run_rmse),
            "worst_error": _rounded(score.worst),
            "worst_error_limit": limits.worst,
            "longest_large_error_s": _rounded(score.longest_large_s),
            "longest_large_error_limit_s": limits.longest_large_s,
            "adhesion_coverage": _rounded(score.adhesion.coverage),
            "adhesion_nees": _rounded(score.adhesion.nees),
            "friction_rmse": _rounded(score.friction.rmse),
            "friction_rmse_limit": limits.friction_rmse,
            "friction_coverage": _rounded(score.friction.coverage),
            "friction_nees": _rounded(score.friction.nees),
            "longest_dishonest_s": _rounded(score.longest_dishonest_s),
            "longest_dishonest_limit_s": limits.longest_dishonest_s,
            "valid_share": _rounded(score.valid_share),
            "verdict": self.verdict,
            "misses": " ".join(self.misses),
        }


def results(outcomes: Iterable[Outcome]) -> list[Result]:
    """Put the seeds of each case together and hold them against the targets, in the order of tables."""
    by_case: dict[Case, list[Outcome]] = {}
    for outcome in outcomes:
        by_case.setdefault(outcome.case, []).append(outcome)
    pooled = {
        case: Score.together(outcome.score for outcome in sorted(by_case[case], key=lambda o: o.seed))
        for case in sorted(by_case, key=lambda case: case.place)
    }
    return [Result(case, score, _limits(case, pooled)) for case, score in pooled.items()]


def _limits(case: Case, scores: dict[Case, Score]) -> Limits:
    """The case's targets; on the paper's sensors ours is measured by what the paper's tuning reaches.

    A target that not even the informed estimator reaches is replaced by what that one reaches and 20 %.
    """
    paper = msgspec.structs.replace(case, variant="rig")
    if case.vehicle == "laboratory" and case.variant == "wagon" and paper in scores:
        return Limits(adhesion_rmse=scores[paper].adhesion.rmse / RIG_PRESET_FACTOR)
    informed = msgspec.structs.replace(case, variant="informed")
    return _within_reach(case.limits, scores[informed]) if informed in scores else case.limits


def _within_reach(limits: Limits, possible: Score) -> Limits:
    reached = {"adhesion_rmse": possible.adhesion.rmse, "longest_large_s": possible.longest_large_s}
    return msgspec.structs.replace(
        limits,
        **{
            name: WITHIN_REACH_FACTOR * value
            for name, value in reached.items()
            if (limit := getattr(limits, name)) is not None and value > limit
        },
    )


def as_csv(found: list[Result]) -> str:
    """All results as a table."""
    text = StringIO()
    rows = [result.row() for result in found]
    writer = csv.DictWriter(text, rows[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def as_json(found: list[Result], seeds: int) -> str:
    """All results with what they were made by."""
    document = {"version": __version__, "seeds": seeds, "results": [result.row() for result in found]}
    return msgspec.json.format(msgspec.json.encode(document)).decode() + "\n"


def told(found: list[Result]) -> Iterator[str]:
    """The outcome in a few lines: how many targets are met, and where they are missed."""
    judged = [result for result in found if result.has_target]
    missed = [result for result in judged if result.misses]
    compared = f"; {more} more without targets" if (more := len(found) - len(judged)) else ""
    yield f"targets are met by {len(judged) - len(missed)} of {plural(len(judged), 'case')}{compared}"
    for result in missed:
        row = result.row()
        yield f"  {result.case.name}: " + ", ".join(f"{name} {row[name]:.4g}" for name in result.misses)


def _rounded(value: float) -> float | None:
    """Six significant digits; nothing where nothing was judged."""
    return None if isnan(value) else float(f"{value:.6g}")
