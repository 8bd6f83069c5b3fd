"""What the sensors tell, as text."""

from dataclasses import replace
from itertools import product

from brake_monitor.observability.analysis import Observability, Variant
from brake_monitor.observability.survey import ADHESIONS, SPEEDS_KMH, Survey

READING = """\
Each cell: rank/states, then the smallest singular value s. A rank below the number of states means
directions that leave no trace in the sensors. A change of one prior sigma in the direction seen
worst shows as s sigmas of the sensors within the window; at 0 it is never seen, at 1 the window
says as much as was known before. Prior sigmas: {prior}."""

Table = dict[Variant, list[Observability]]  # the worst over the grid, at each force of the table


def text(survey: Survey) -> str:
    """The tables, and what they mean for the vehicle."""
    noise, period_ms, prior = survey.sensors.noise_std, survey.sensors.period_s * 1e3, survey.prior
    table = {variant: [survey.over_grid(variant, f) for f in survey.table_forces_n] for variant in survey.variants}
    lines = [
        f"{survey.vehicle_id}: what a window of {survey.window_s:g} s tells about friction and adhesion",
        f"sensors (1 sigma): wheel speed {noise[0]:.3g} rad/s every {period_ms[0]:g} ms, "
        f"vehicle speed {noise[-1]:.3g} m/s every {period_ms[-1]:g} ms",
        "",
        READING.format(
            prior=f"mu_b {prior.friction_std:g}, mu_w {prior.adhesion_std:g}, d {prior.deceleration_std:g} m/s²"
        ),
        "",
        *_variant_lines(survey, table),
        "",
        *_remarks(survey, table),
        "",
        *_grid_lines(survey),
    ]
    return "\n".join(lines)


def _header(title: str, survey: Survey) -> str:
    return f"{title:<52}" + "".join(f"{f'{force / 1e3:g} kN':>12}" for force in survey.table_forces_n)


def _row(title: str, seen: list[Observability]) -> str:
    cells = (f"{f'{one.rank}/{one.states}':>6}{_number(one.smallest_singular_value):>6}" for one in seen)
    return f"{title:<52}" + "".join(cells)


def _number(value: float) -> str:
    """About three digits in five characters; an exact zero shows as such."""
    if value == 0.0:
        return "0"
    if value < 0.001:
        return "<.001"
    decimals = next((d for d, below in ((3, 1.0), (2, 10.0), (1, 100.0)) if value < below), 0)
    return f"{value:.{decimals}f}"


def _variant_lines(survey: Survey, table: Table) -> list[str]:
    full_kn = survey.full_force_n / 1e3
    lines = [_header("unknown; instants looked at (worst over the grid)", survey)]
    for variant, seen in table.items():
        full = seen[-1]
        how = "no trace" if full.rank < full.states else "seen worst"
        lines += [_row(variant.name, seen), f"    {how} at {full_kn:g} kN: {full.weakest}"]
    return lines


def _remarks(survey: Survey, table: Table) -> list[str]:
    """What the table means for the vehicle, in its own numbers."""
    paper = survey.variants[0]
    held = survey.over_grid(paper, survey.contact_force_n)
    lines = [
        f"at 0 kN, whatever else is known, no trace is left of {table[paper][0].weakest}",
        f"below {survey.contact_force_n / 1e3:g} kN friction is held: there the paper's map has "
        f"s = {_number(held.smallest_singular_value)}",
    ]
    if len(paper.patterns[0]) > 1:
        lines += [
            "one mu_w: all wheelsets use the same adhesion, which ends as soon as one of them slides",
            "mu_w per wheelset: no pressure common to all tells their frictions apart, released ones do (WSP)",
        ]
    for variant, seen in table.items():
        without = next(
            (table[v][-1] for v in table if v == replace(variant, has_deceleration=False, name=v.name)), None
        )
        if variant.has_deceleration and without is not None and without.rank == without.states:
            instants = variant.name.partition("; ")[2] or "one instant"
            fall = [_number(one.smallest_singular_value) for one in (without, seen[-1])]
            lines.append(
                f"price of d at {survey.full_force_n / 1e3:g} kN, {instants}: s falls from {' to '.join(fall)}"
            )
    return lines


def _grid_lines(survey: Survey) -> list[str]:
    """The paper's own map at each speed and adhesion."""
    paper = survey.variants[0]
    lines = [_header(paper.name, survey)]
    for speed_kmh, adhesion in product(SPEEDS_KMH, ADHESIONS):
        seen = [survey.at(paper, force, speed_kmh, adhesion) for force in survey.table_forces_n]
        lines.append(_row(f"    at {speed_kmh:g} km/h, adhesion {adhesion:.2f}", seen))
    return [*lines, "speed acts only through the drag, adhesion only through the wheel loads: both hardly matter here"]
