"""Puts a report together: one file that needs no network and no other file."""

import base64
import zlib
from html import escape
from importlib.resources import files
from re import MULTILINE, sub
from string import Template
from typing import Any

import msgspec
import numpy as np

from brake_monitor import __version__
from brake_monitor.arrays import Floats
from brake_monitor.dashboard.recent import WAGON_COLUMNS, WHEELSET_COLUMNS
from brake_monitor.report import tables, track_map
from brake_monitor.report.curves import to_draw
from brake_monitor.report.recording import Recording
from brake_monitor.report.summary import summary

STEPS = 65_000  # an unsigned 16-bit number for each value, the last ones of which mean: not known
UNKNOWN = 65_535
COMPRESSION = 9

SECTIONS = {
    "summary": "Summary",
    "alarms": "Alarms",
    "figures": "Figures",
    "stops": "Brake applications",
    "map": "Map",
    "wear": "Wear",
    "data": "Data",
    "settings": "Settings",
}
MAP_LEGEND = (
    '<p class="muted small">The way, north up. Thick: the wheels asked for more than the rail gave, and that was '
    "little; darker: very little. Circles: low-adhesion alarms.</p>"
)

SHARED = ("words.js", "charts.js", "curves.js", "history.js")  # the dashboard's own


def page(recording: Recording, name: str, source: str) -> str:
    """The report of a recording of that file name, with the text of its configuration, as HTML."""
    return Template(_own("report.html")).substitute(
        wagon=escape(recording.settings.vehicle.id),
        name=escape(name),
        style=_static("vendor/uPlot.min.css") + _static("style.css") + _own("report.css"),
        links="".join(f'<a href="#{key}">{head}</a>' for key, head in SECTIONS.items()),
        facts=tables.facts(recording),
        summary="".join(f"<li>{escape(text)}</li>" for text in summary(recording)),
        alarms=tables.alarms(recording),
        stops=tables.applications(recording),
        map=_map(recording),
        wear=tables.wear(recording),
        quality=tables.signals(recording) + tables.frames(recording),
        settings=tables.settings(recording, source),
        version=__version__,
        licence=_static("vendor/uPlot.LICENSE"),
        data=_data(recording),
        uplot=_static("vendor/uPlot.iife.min.js"),
        program=_program(),
    )


def _map(recording: Recording) -> str:
    columns = recording.curves.columns(recording.curves.table())
    drawn = track_map.drawing(columns, recording.alarms, recording.settings, recording.begun_s)
    return "<p class=muted>No position is mapped.</p>" if drawn is None else drawn + MAP_LEGEND


def _static(name: str) -> str:
    return (files("brake_monitor.dashboard") / "static" / name).read_text(encoding="utf-8")


def _own(name: str) -> str:
    return (files("brake_monitor.report") / "static" / name).read_text(encoding="utf-8")


def _program() -> str:
    """The dashboard's modules and the report's own as one: without what only ties files together."""
    joined = "\n".join([*map(_static, SHARED), "{", _own("report.js"), "}"])
    return sub(r"^export ", "", sub(r"^import .*;$", "", joined, flags=MULTILINE), flags=MULTILINE)


def _data(recording: Recording) -> str:
    """Everything that the figures show; each column scaled to 16 bits and packed, so that an hour is a small file."""
    settings, begun_s = recording.settings, recording.begun_s
    columns = recording.curves.columns(to_draw(recording.curves.table()))
    usual_s = 1.0 / settings.output.rate_hz if settings.output.rate_hz else 0.1
    drawn_s = float(np.median(np.diff(columns["time_s"]))) if len(columns["time_s"]) > 1 else 0.0  # of days it is more
    data: dict[str, Any] = {
        "columns": {
            "time_s": _packed(columns["time_s"] - begun_s, exact=True),
            **{name: _packed(columns[name]) for name in WAGON_COLUMNS},
            "wheelsets": {
                str(i): {name: _packed(own[name]) for name in WHEELSET_COLUMNS}
                for i, own in columns["wheelsets"].items()
            },
        },
        "spans": [[record.start_time_s - begun_s, record.end_time_s - begun_s] for record in recording.applications],
        "levels": settings.alarms.low_adhesion.levels,
        "friction_nominal": settings.estimator.friction_nominal,
        "radii_m": settings.vehicle.wheel_radius_m,
        "period_s": max(usual_s, drawn_s),
    }
    return msgspec.json.encode(data).decode().replace("<", "\\u003c")


def _packed(values: Floats, *, exact: bool = False) -> dict[str, Any]:
    """`least` + k `step`, k as little-endian 16-bit numbers, zlib, base64; times exactly, as 64-bit floats."""
    if exact:
        return {"bits": 64, "packed": _text(values.astype("<f8").tobytes())}
    known = np.isfinite(values)
    least, greatest = (float(values[known].min()), float(values[known].max())) if known.any() else (0.0, 0.0)
    step = (greatest - least) / STEPS or 1.0
    whole = np.full(len(values), UNKNOWN, dtype="<u2")
    whole[known] = np.round((values[known] - least) / step).astype("<u2")
    return {"bits": 16, "least": least, "step": step, "packed": _text(whole.tobytes())}


def _text(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, COMPRESSION)).decode()
