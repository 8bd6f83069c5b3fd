"""Every figure of a report as a picture of its own, SVG or PNG, for papers and slides."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from brake_monitor.arrays import Floats
from brake_monitor.estimation.estimate import SLOWEST_MPS
from brake_monitor.figure_style import BLUE, DARK, GREEN, PURPLE, STYLE, VERMILION
from brake_monitor.host.whole_file import whole_file
from brake_monitor.report.curves import to_draw
from brake_monitor.report.recording import Recording
from brake_monitor.report.track_map import TrackMap, beginnings, stretches

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WHEELSETS = ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":"), (PURPLE, "-."))  # dashes: nobody needs the colours
VEHICLE, RAIL, GIVES = DARK, BLUE, VERMILION
LEVEL_COLOURS = ("#f6c9ae", "#fbe3c4", "#fdf3dc")
MOST_POINTS = 6000
OWN_STYLE = {"axes.spines.right": False, "lines.linewidth": 1.2, "svg.hashsalt": "brake-monitor"}

Draw = Callable[["Axes"], None]


def write_figures(recording: Recording, folder: Path, suffix: str) -> Iterator[Path]:
    """Write them; gives each path. Needs the extra `report`."""
    import matplotlib  # noqa: PLC0415 - an extra, and slow to import
    from matplotlib.figure import Figure  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE | OWN_STYLE):
        for name, draw in _figures(recording):
            figure = Figure(figsize=(9.0, 3.6), layout="constrained")
            draw(figure.subplots())
            path = folder / f"{name}.{suffix}"
            _save(figure, path, suffix)
            yield path


def _save(figure: Figure, path: Path, suffix: str) -> None:
    nothing_of_now = {"svg": {"Date": None}, "png": {"Software": None}}[suffix]
    with whole_file(path) as part:
        figure.savefig(part, format=suffix, dpi=160, metadata=nothing_of_now)


def _figures(recording: Recording) -> Iterator[tuple[str, Draw]]:
    table = recording.curves.table()
    every, columns = recording.curves.columns(table), recording.curves.columns(to_draw(table, MOST_POINTS))
    time_s = columns["time_s"] - recording.begun_s
    yield "adhesion", partial(_adhesion, recording, columns, time_s)
    yield "speeds", partial(_speeds, columns, time_s)
    yield "pressing_forces", partial(_per_wheelset, columns, time_s, ("pressing_force_n", 1e-3, "pressing force, kN"))
    yield "slip", partial(_per_wheelset, _with_slip(columns), time_s, ("slip", 100.0, "slip, %"))
    for i in columns["wheelsets"]:
        yield f"friction_{i}", partial(_friction, recording, columns, time_s, i)
    yield "adhesion_over_slip", partial(_over_slip, every)
    if np.isfinite(every["latitude_deg"] + every["longitude_deg"]).any():
        yield "map", partial(_map, recording, every)


def _with_slip(columns: dict[str, Any]) -> dict[str, Any]:
    """Slip only where the vehicle is fast enough for it."""
    with np.errstate(invalid="ignore"):
        slow = ~(columns["speed_mps"] > SLOWEST_MPS)
    wheelsets = {i: own | {"slip": np.where(slow, np.nan, own["slip"])} for i, own in columns["wheelsets"].items()}
    return columns | {"wheelsets": wheelsets}


def _whole(time_s: Floats) -> tuple[float, float]:
    """The time axis: a gap at its beginning or end is to be seen, too."""
    return (float(time_s[0]), float(time_s[-1])) if len(time_s) > 1 else (0.0, 1.0)


def _style(i: int) -> dict[str, Any]:
    colour, dash = WHEELSETS[(i - 1) % len(WHEELSETS)]
    return {"color": colour, "linestyle": dash, "label": f"wheelset {i}"}


def _adhesion(recording: Recording, columns: dict[str, Any], time_s: Floats, axes: Axes) -> None:
    rule = recording.settings.alarms.low_adhesion
    adhesion, std = columns["adhesion"], columns["adhesion_std"]
    limits = (0.0, rule.extremely_low, rule.very_low, rule.low)
    for low, high, colour in zip(limits, limits[1:], LEVEL_COLOURS, strict=False):
        axes.axhspan(low, high, color=colour, zorder=0)
    axes.fill_between(time_s, adhesion - std, adhesion + std, color=RAIL, alpha=0.25, linewidth=0)
    axes.plot(time_s, adhesion, color=RAIL, label="in use")
    axes.plot(time_s, columns["adhesion_available"], color=GIVES, linewidth=2.2, label="all that the rail gives")
    axes.set(xlabel="time, s", xlim=_whole(time_s), ylabel="adhesion", ylim=(0.0, None))
    axes.legend(loc="upper right")


def _speeds(columns: dict[str, Any], time_s: Floats, axes: Axes) -> None:
    axes.plot(time_s, columns["speed_mps"] * 3.6, color=VEHICLE, linewidth=2.0, label="vehicle")
    for i, own in _with_slip(columns)["wheelsets"].items():
        axes.plot(time_s, columns["speed_mps"] * (1.0 - own["slip"]) * 3.6, **_style(i))
    axes.set(xlabel="time, s", xlim=_whole(time_s), ylabel="speed, km/h", ylim=(0.0, None))
    axes.legend(loc="upper right")


def _per_wheelset(columns: dict[str, Any], time_s: Floats, what: tuple[str, float, str], axes: Axes) -> None:
    name, factor, label = what
    for i, own in columns["wheelsets"].items():
        nothing = {} if np.isfinite(own[name]).any() else {"label": f"wheelset {i}: –"}
        axes.plot(time_s, own[name] * factor, **_style(i) | nothing)
    axes.set(xlabel="time, s", xlim=_whole(time_s), ylabel=label)
    axes.legend(loc="upper right")


def _friction(recording: Recording, columns: dict[str, Any], time_s: Floats, i: int, axes: Axes) -> None:
    own = columns["wheelsets"][i]
    style = _style(i) | {"linestyle": "-", "label": f"friction, wheelset {i}"}
    friction, std = own["friction"], own["friction_std"]
    held = own["held"] == 1.0
    axes.fill_between(
        time_s, 0.0, 1.0, where=held, transform=axes.get_xaxis_transform(), facecolor="none", edgecolor="#bbbbbb",
        hatch="///", linewidth=0, label="held: pad released",
    )  # fmt: skip
    axes.fill_between(time_s, friction - std, friction + std, color=style["color"], alpha=0.25, linewidth=0)
    axes.plot(time_s, friction, **style)
    axes.axhline(recording.settings.estimator.friction_nominal, color="#666666", linestyle=":", label="nominal")
    axes.set(xlabel="time, s", xlim=_whole(time_s), ylabel="pad friction", ylim=(0.0, None))
    axes.legend(loc="lower right")


def _over_slip(columns: dict[str, Any], axes: Axes) -> None:
    for i, own in _with_slip(columns)["wheelsets"].items():
        marker = "so^D"[(i - 1) % 4]
        every = max(1, len(own["slip"]) // MOST_POINTS)
        axes.scatter(
            own["slip"][::every] * 100.0, own["adhesion"][::every], s=9.0, marker=marker, alpha=0.35, linewidths=0,
            color=_style(i)["color"], label=f"wheelset {i}",
        )  # fmt: skip
    axes.set(xlabel="slip, %", ylabel="adhesion")
    axes.legend(loc="upper right")


def _map(recording: Recording, columns: dict[str, Any], axes: Axes) -> None:
    track = TrackMap(columns["latitude_deg"], columns["longitude_deg"])
    low, very_low = stretches(columns, recording.settings.alarms.low_adhesion)
    axes.plot(track.x_m, track.y_m, color="#999999", label="way of the wagon")
    for where, colour, width, label in ((low, GIVES, 4.0, "low adhesion"), (very_low, VEHICLE, 7.0, "very low")):
        x_m, y_m = (np.where(where, metres, np.nan) for metres in (track.x_m, track.y_m))
        axes.plot(x_m, y_m, color=colour, linewidth=width, solid_capstyle="round", label=label)
    began = [
        track.metres(latitude_deg, longitude_deg) for latitude_deg, longitude_deg, _ in beginnings(recording.alarms)
    ]
    if began:
        axes.plot(*zip(*began, strict=True), "o", color=RAIL, label="where it began")
    axes.set(xlabel="east, m", ylabel="north, m")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="best")
