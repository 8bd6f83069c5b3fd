"""Where the rail was slippery: the way of the wagon as an SVG drawing, without tiles from elsewhere."""

from collections.abc import Iterable, Iterator
from html import escape
from math import cos, floor, log10, radians
from typing import TypeVar

import numpy as np

from brake_monitor.arrays import Bools, Floats
from brake_monitor.monitoring.alarm import Alarm
from brake_monitor.report.words import elapsed, number
from brake_monitor.settings.alarm_settings import LowAdhesionRule
from brake_monitor.settings.config import Settings

EARTH_RADIUS_M = 6_371_000.0
WIDTH, HEIGHT, MARGIN = 900.0, 460.0, 36.0
MOST_POINTS = 4000
LEAST_EXTENT_M = 50.0

Number = TypeVar("Number", float, Floats)


class TrackMap:
    """Positions in metres around their middle, seen from above, north up."""

    def __init__(self, latitude_deg: Floats, longitude_deg: Floats) -> None:
        """Positions with NaN where none is known; ValueError when none is."""
        known = np.isfinite(latitude_deg) & np.isfinite(longitude_deg)
        if not known.any():
            raise ValueError("no position is known")
        self._middle = (float(np.median(latitude_deg[known])), float(np.median(longitude_deg[known])))
        self.x_m, self.y_m = self.metres(latitude_deg, longitude_deg)
        extents = [np.nanmax(axis) - np.nanmin(axis) for axis in (self.x_m, self.y_m)]
        room = (
            (WIDTH - 2 * MARGIN) / max(extents[0], LEAST_EXTENT_M),
            (HEIGHT - 2 * MARGIN) / max(extents[1], LEAST_EXTENT_M),
        )
        self.scale = float(min(room))  # drawing units per metre
        self._offset = (
            WIDTH / 2 - self.scale * float(np.nanmax(self.x_m) + np.nanmin(self.x_m)) / 2,
            HEIGHT / 2 + self.scale * float(np.nanmax(self.y_m) + np.nanmin(self.y_m)) / 2,
        )

    def metres(self, latitude_deg: Number, longitude_deg: Number) -> tuple[Number, Number]:
        """A position, or many, east and north of the middle."""
        degree_m = radians(1.0) * EARTH_RADIUS_M
        x_m = (longitude_deg - self._middle[1]) * degree_m * cos(radians(self._middle[0]))
        return x_m, (latitude_deg - self._middle[0]) * degree_m

    def place(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """A position in the drawing."""
        x_m, y_m = self.metres(latitude_deg, longitude_deg)
        return self._offset[0] + self.scale * x_m, self._offset[1] - self.scale * y_m

    def path(self, wanted: Bools | None = None) -> str:
        """The way as SVG path data, where it is wanted; lifted where no position is known."""
        step = max(1, len(self.x_m) // MOST_POINTS)
        drawn, lifted = [], True
        keep = np.isfinite(self.x_m) & np.isfinite(self.y_m)
        if wanted is not None:
            keep &= wanted
        for k in range(0, len(self.x_m), 1 if wanted is not None else step):
            if not keep[k]:
                lifted = True
                continue
            x, y = self._offset[0] + self.scale * self.x_m[k], self._offset[1] - self.scale * self.y_m[k]
            drawn.append(f"{'M' if lifted else 'L'}{x:.1f} {y:.1f}")
            lifted = False
        return "".join(drawn)


def stretches(columns: dict[str, Floats], rule: LowAdhesionRule) -> tuple[Bools, Bools]:
    """Where all that the rail gave was low, and where it was very low."""
    available = columns["adhesion_available"]  # NaN, which is not below, where the wheels asked for less
    with np.errstate(invalid="ignore"):
        return available < rule.low, available < rule.very_low


def beginnings(alarms: Iterable[Alarm]) -> Iterator[tuple[float, float, Alarm]]:
    """Latitude and longitude in degrees where low adhesion began, where that is known."""
    for alarm in alarms:
        where = [alarm.evidence.get(name) for name in ("latitude_deg_start", "longitude_deg_start")]
        if alarm.kind == "low_adhesion" and all(isinstance(one, float) for one in where):
            yield float(where[0] or 0.0), float(where[1] or 0.0), alarm


def drawing(columns: dict[str, Floats], alarms: tuple[Alarm, ...], settings: Settings, begun_s: float) -> str | None:
    """The map with stretches and places of low adhesion; None when no position is mapped."""
    try:
        track = TrackMap(columns["latitude_deg"], columns["longitude_deg"])
    except ValueError:
        return None
    low, very_low = stretches(columns, settings.alarms.low_adhesion)
    places = []
    for latitude_deg, longitude_deg, alarm in beginnings(alarms):
        x, y = track.place(latitude_deg, longitude_deg)
        text = f"{elapsed(alarm.raised_time_s - begun_s)}: {alarm.message}"
        places.append(
            f'<g class="place {alarm.severity}"><title>{escape(text)}</title><circle cx="{x:.1f}" cy="{y:.1f}" r="7"/>'
            f'<text x="{x + 11:.1f}" y="{y + 4:.1f}">{elapsed(alarm.raised_time_s - begun_s)}</text></g>'
        )
    return (
        f'<svg class="map" viewBox="0 0 {WIDTH:.0f} {HEIGHT:.0f}" role="img" aria-label="Map of low adhesion">'
        f'<path class="way" d="{track.path()}"/><path class="low-way" d="{track.path(low)}"/>'
        f'<path class="very-low-way" d="{track.path(very_low)}"/>{"".join(places)}{_scale_bar(track.scale)}'
        f'<g class="north"><path d="M{WIDTH - 24:.0f} 44V16m-6 9l6-10 6 10"/>'
        f'<text x="{WIDTH - 29:.0f}" y="60">N</text></g></svg>'
    )


def _scale_bar(scale: float) -> str:
    longest_m = 200.0 / scale
    power = 10.0 ** floor(log10(longest_m))
    length_m = max(one * power for one in (1.0, 2.0, 5.0) if one * power <= longest_m)
    shown = f"{number(length_m / 1000, 0)} km" if length_m >= 1000 else f"{number(length_m, 0)} m"
    y, end = HEIGHT - 14.0, 16.0 + length_m * scale
    return f'<g class="scale"><path d="M16 {y - 5}v5H{end:.1f}v-5"/><text x="16" y="{y - 9}">{shown}</text></g>'
