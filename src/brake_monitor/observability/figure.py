"""What the sensors tell, as a figure."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from brake_monitor.figure_style import BLUE, GREEN, ORANGE, PURPLE, SKY, VERMILION
from brake_monitor.host import extras
from brake_monitor.host.whole_file import whole_file
from brake_monitor.observability.survey import ADHESIONS, SPEEDS_KMH, Survey

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FORMATS = (".svg", ".png")
MIDDLE = (80.0, 0.10)  # km/h and adhesion of the curves that compare unknowns
CURVE_STEPS = 50
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, SKY, ORANGE, "#000000", "#8c564b", "#7f7f00")


def draw(survey: Survey, path: Path) -> None:
    """Two panels over pressing force: what each set of unknowns costs, and what speed and adhesion change."""
    extras.require("report", f"{path}: a figure")
    from matplotlib import rc_context  # noqa: PLC0415 - an extra, and slow to import
    from matplotlib.figure import Figure  # noqa: PLC0415

    kind = path.suffix.lower().removeprefix(".")
    with rc_context({"svg.hashsalt": survey.vehicle_id, "font.size": 9.0}):  # the same input gives the same file
        figure = Figure(figsize=(13.0, 6.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw_variants(left, survey)
        _draw_grid(right, survey)
        figure.suptitle(
            f"{survey.vehicle_id}: what a window of {survey.window_s:g} s tells about friction and adhesion"
        )
        with whole_file(path) as part:
            figure.savefig(part, format=kind, dpi=150, metadata={"Date": None} if kind == "svg" else {})


def _forces_n(survey: Survey) -> list[float]:
    return [survey.full_force_n * i / CURVE_STEPS for i in range(CURVE_STEPS + 1)]


def _draw_variants(axes: "Axes", survey: Survey) -> None:
    forces_n = _forces_n(survey)
    never = []
    for variant, colour in zip(survey.variants, COLOURS, strict=False):
        curve = [survey.at(variant, force, *MIDDLE).smallest_singular_value for force in forces_n]
        if max(curve) == 0.0:
            never.append(variant.name)
            continue
        style = "--" if variant.has_deceleration else "-"
        width = 5.0 if len(variant.patterns) == 1 else 1.5  # without d coasting adds nothing: one curve on the other
        axes.plot(np.array(forces_n) / 1e3, curve, style, lw=width, color=colour, label=variant.name)
    for name in never:
        axes.plot([0.0, forces_n[-1] / 1e3], [0.0, 0.0], color="0.6", lw=4.0, clip_on=False, label=f"{name}: never")
    _label(axes, survey, f"unknowns; instants looked at ({MIDDLE[0]:g} km/h, adhesion {MIDDLE[1]:.2f})")


def _draw_grid(axes: "Axes", survey: Survey) -> None:
    forces_n, paper = _forces_n(survey), survey.variants[0]
    for speed_kmh, width in zip(SPEEDS_KMH, (6.0, 3.5, 1.0), strict=True):  # one curve on the other, all to be seen
        for adhesion, colour in zip(ADHESIONS, COLOURS, strict=False):
            curve = [survey.at(paper, force, speed_kmh, adhesion).smallest_singular_value for force in forces_n]
            label = f"{speed_kmh:g} km/h, adhesion {adhesion:.2f}"
            axes.plot(np.array(forces_n) / 1e3, curve, lw=width, alpha=1.0 / width, color=colour, label=label)
    _label(axes, survey, paper.name)


def _label(axes: "Axes", survey: Survey, title: str) -> None:
    axes.axhline(1.0, color="0.4", lw=0.8)
    axes.annotate("as much as was known before", (survey.full_force_n * 1e-5, 1.0), ha="left", va="bottom", color="0.4")
    axes.plot(0.0, 0.0, "o", color="k", clip_on=False, label="0 kN: friction leaves no trace")
    axes.set(title=title, xlabel="pressing force per wheelset [kN]", ylabel="smallest singular value s [sigmas]")
    axes.set_xlim(0.0, survey.full_force_n / 1e3)
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=7.0, loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=2)
