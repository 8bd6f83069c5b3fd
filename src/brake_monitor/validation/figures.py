"""The paper's Fig. 4, 5 and 6 drawn from our own runs, and the error with what is published about it; all as SVG."""

from __future__ import annotations

from collections.abc import Callable
from io import StringIO
from typing import TYPE_CHECKING

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.figure_style import BLUE, DARK, GREEN, SKY, STYLE, VERMILION
from brake_monitor.validation.scores import LARGE_ERROR, LEAST_FORCE_N, LEAST_SPEED_MPS, judged, pressed
from brake_monitor.validation.series import Series

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TRUE, ADHESION, FRICTION, WHEEL, FORCE = DARK, BLUE, VERMILION, SKY, GREEN
BAND_ALPHA = 0.25
BAND_SIGMAS = 2.0
BAND_EVERY = 8  # a band needs fewer points than a line
OWN_STYLE = {
    "axes.titlesize": 10.5,
    "axes.titlelocation": "left",
    "lines.linewidth": 1.1,
    "path.simplify_threshold": 0.3,
    "svg.fonttype": "path",
}


def braking_figure(series: Series, title: str) -> str:
    """Layout of the paper's Fig. 4 and 5 for one wheelset: inputs on top, true and estimated coefficients below."""
    return _svg(_draw_braking, series, title, 7.0)


def _draw_braking(figure: Figure, series: Series, title: str) -> None:
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 3.0))
    _draw_inputs(top, series)
    top.set_title(title)
    _draw_coefficients(bottom, series)
    bottom.set_xlabel("time in s")
    bottom.set_xlim(0.0, series.time_s[-1])


def _draw_inputs(axes: Axes, series: Series) -> None:
    """What the estimator is given: speeds and pressing force."""
    truth = series.truth
    radius_m = _rolling_radius_m(series)
    axes.plot(series.time_s, truth.omega_radps[:, 0] * radius_m * 3.6, color=WHEEL, label="wheel  ω r$_W$")
    axes.plot(series.time_s, truth.speed_mps * 3.6, color=TRUE, label="wagon  v$_x$")
    axes.set_ylabel("speed in km/h")
    axes.set_ylim(0.0)
    force = axes.twinx()
    force.plot(series.time_s, series.pressing_force_n[:, 0] / 1000.0, color=FORCE, lw=0.8, label="pads  F$_⊥$")
    force.set_ylabel("pressing force in kN", color=FORCE)
    force.set_ylim(0.0, 1.9 * float(np.max(series.pressing_force_n)) / 1000.0)
    force.grid(visible=False)
    _legend(axes, force)


def _draw_coefficients(axes: Axes, series: Series) -> None:
    """True and estimated adhesion on the left axis, friction on the right one, with 2 sigma bands."""
    truth, time_s = series.truth, series.time_s
    moving = truth.speed_mps > LEAST_SPEED_MPS  # what was held through standstill is no estimate of it
    adhesion = np.where(moving, series.adhesion, np.nan)
    _band(axes, time_s, adhesion, series.adhesion_std, colour=ADHESION)
    axes.plot(time_s, adhesion, color=ADHESION, lw=1.3, label="adhesion µ$_W$, estimated ± 2 σ")
    axes.plot(time_s, truth.adhesion, color=TRUE, lw=0.6, label="true")
    axes.set_ylabel("adhesion µ$_W$", color=ADHESION)
    axes.set_ylim(-0.01, 0.24)
    friction = axes.twinx()
    estimated = np.where(moving, series.friction[:, 0], np.nan)
    _band(friction, time_s, estimated, series.friction_std[:, 0], colour=FRICTION)
    friction.plot(time_s, estimated, color=FRICTION, lw=1.3, label="friction µ$_B$, estimated ± 2 σ")
    on_disc = truth.pressing_force_n[:, 0] > LEAST_FORCE_N
    shown = np.where(on_disc, truth.friction[:, 0], np.nan)
    friction.plot(time_s, shown, color=TRUE, lw=1.0, ls=(0, (3, 1)), label="true, pad on disc")
    friction.set_ylabel("friction µ$_B$", color=FRICTION)
    friction.set_ylim(-0.25, 0.55)
    friction.set_yticks([0.2, 0.3, 0.4, 0.5])
    friction.grid(visible=False)
    _legend(axes, friction)


def slip_figure(series: Series, title: str) -> str:
    """Layout of the paper's Fig. 6 for one wheelset: adhesion over slip, and below it the absolute error."""
    return _svg(_draw_slip, series, title, 6.2)


def _draw_slip(figure: Figure, series: Series, title: str) -> None:
    counts, truth = judged(series), series.truth
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=(3.0, 2.0))
    dots = {"ls": "none", "marker": ".", "rasterized": True}
    slip = 100.0 * truth.slip[counts, 0]
    estimated_slip = 100.0 * series.slip[counts, 0]
    top.plot(estimated_slip, series.adhesion[counts], color=WHEEL, ms=4.0, label="estimated", **dots)
    top.plot(slip, truth.adhesion[counts], color=TRUE, ms=1.5, label="true", **dots)
    top.set_ylabel("adhesion µ$_W$")
    top.set_title(title)
    top.legend(markerscale=3.0)
    error = np.abs(series.adhesion - truth.adhesion)[counts]
    bottom.plot(slip, error, color=ADHESION, ms=3.0, **dots)
    bottom.axhline(LARGE_ERROR, color=FRICTION, lw=1.0)
    bottom.annotate(
        "the paper's bound", (0.99, LARGE_ERROR), xycoords=("axes fraction", "data"), ha="right", va="bottom"
    )
    bottom.set_ylim(0.0, max(0.024, 1.05 * float(np.max(error))))
    bottom.set_ylabel("absolute error")
    bottom.set_xlabel("slip in %")


def error_figure(series: Series, title: str) -> str:
    """Estimation errors over time within the 2 sigma bands that are published with the estimates."""
    return _svg(_draw_errors, series, title, 6.2)


def _draw_errors(figure: Figure, series: Series, title: str) -> None:
    truth, time_s = series.truth, series.time_s
    top, bottom = figure.subplots(2, 1, sharex=True)
    error = np.where(judged(series), series.adhesion - truth.adhesion, np.nan)
    _draw_error(top, time_s, error, series.adhesion_std, ADHESION)
    reach = max(LARGE_ERROR, float(np.nanmax(np.abs(error))))
    top.set_ylim(-reach, reach)
    top.set_ylabel("error of adhesion")
    top.set_title(title)
    error = np.where(pressed(series)[:, 0], series.friction[:, 0] - truth.friction[:, 0], np.nan)
    _draw_error(bottom, time_s, error, series.friction_std[:, 0], FRICTION)
    bottom.set_ylabel("error of friction, wheelset 1")
    bottom.set_xlabel("time in s")
    bottom.set_xlim(0.0, time_s[-1])


def _draw_error(axes: Axes, time_s: Floats, error: Floats, std: Floats, colour: str) -> None:
    _band(
        axes, time_s, np.zeros_like(std), np.where(np.isnan(error), np.nan, std), colour=colour, label="published ± 2 σ"
    )
    axes.plot(time_s, error, color=colour, lw=0.8, label="estimated − true")
    axes.legend(loc="upper right", ncols=2)


def _band(axes: Axes, time_s: Floats, middle: Floats, std: Floats, *, colour: str, label: str | None = None) -> None:
    low, high = middle - BAND_SIGMAS * std, middle + BAND_SIGMAS * std
    every = slice(None, None, BAND_EVERY)
    axes.fill_between(time_s[every], low[every], high[every], color=colour, alpha=BAND_ALPHA, lw=0.0, label=label)


def _legend(left: Axes, right: Axes) -> None:
    """One legend for both vertical axes."""
    handles, labels = (
        a + b for a, b in zip(left.get_legend_handles_labels(), right.get_legend_handles_labels(), strict=True)
    )
    left.legend(handles, labels, loc="upper center", ncols=len(labels), bbox_to_anchor=(0.5, 1.02))


def _rolling_radius_m(series: Series) -> float:
    """The true wheel radius: of the first sample, where the wheel rolls freely."""
    return float(series.truth.speed_mps[0] / series.truth.omega_radps[0, 0])


def _svg(draw: Callable[[Figure, Series, str], None], series: Series, title: str, height_inch: float) -> str:
    """The <svg> element alone: no prolog, no date, identifiers that depend on the figure only."""
    import matplotlib  # noqa: PLC0415 - an extra, and slow to import
    from matplotlib.figure import Figure as NewFigure  # noqa: PLC0415

    text = StringIO()
    with matplotlib.rc_context(STYLE | OWN_STYLE | {"svg.hashsalt": title}):
        figure = NewFigure(figsize=(9.0, height_inch), layout="constrained", facecolor="white")
        draw(figure, series, title)
        figure.savefig(text, format="svg", dpi=150, metadata={"Date": None, "Creator": None})
    svg = text.getvalue()
    return svg[svg.index("<svg") :]
