"""Fits the noise densities of an estimator to recordings."""

from collections.abc import Callable, Iterator

from msgspec import Struct
from msgspec.structs import asdict, replace

from brake_monitor.estimation.model.tuning import FITTED_DENSITIES, PRESETS, Tuning
from brake_monitor.plural import plural
from brake_monitor.settings.config import Preset
from brake_monitor.tuner.scores import Score
from brake_monitor.tuner.search import Point, descend


class Fit(Struct, frozen=True):
    """How far a fit has come."""

    start: Tuning
    before: Score
    tuning: Tuning  # the best so far
    after: Score
    evaluations: int


def fittable(tuning: Tuning, wheelset_count: int) -> list[str]:
    """The densities that can be fitted: not those that are switched off, nor what one wheelset has beside itself."""
    return [
        name
        for name in FITTED_DENSITIES
        if getattr(tuning, name) > 0.0 and not (wheelset_count == 1 and name.endswith("_own"))
    ]


def fit(start: Tuning, names: list[str], score: Callable[[Tuning], Score], evaluations: int) -> Iterator[Fit]:
    """Lower the cost of the score over the named densities; give the best so far after each evaluation."""
    first: Point = tuple(getattr(start, name) for name in names)
    before = score(start)
    seen = {first: before}

    def tuned(point: Point) -> Tuning:
        return replace(start, **dict(zip(names, point, strict=True)))

    def cost(point: Point) -> float:
        if point not in seen:
            seen[point] = score(tuned(point))
        return seen[point].cost

    for found in descend(first, cost, before.least_gain, evaluations):
        yield Fit(start, before, tuned(found.point), seen[found.point], found.evaluations)


def fragment(fit: Fit, preset: Preset, sources: list[str]) -> str:
    """The fit as TOML for the configuration: what differs from the preset, and what it gained."""
    before, after = fit.before.told(), fit.after.told()
    lines = [
        f"# brake-monitor tune, {plural(fit.evaluations, 'evaluation')} over {', '.join(map(repr, sources))}",
        *(f"# {name}: {before[name]} -> {after[name]}" for name in before),
        f'# goes with preset = "{preset}"' + ("" if fit.tuning != fit.start else "; nothing better was found"),
        "[estimator.tuning]",
    ]
    old, new = asdict(PRESETS[preset]), asdict(fit.tuning)
    lines += [f"{name} = {new[name]!r}  # preset {old[name]:g}" for name in new if new[name] != old[name]]
    return "\n".join(lines)
