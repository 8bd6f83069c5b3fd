"""What a page is told, as values: the fleet in a line for each wagon, or one wagon in full. Times are Unix seconds."""

from typing import Any

import msgspec
from msgspec import Struct

from brake_monitor.dashboard.fleet import Fleet
from brake_monitor.desk.watched import Wagon
from brake_monitor.monitoring.alarm import Severity
from brake_monitor.publishing.payloads import AlarmMessage

SPARKS_EVERY = 10  # pushes
SPARK_DECIMALS = 3
MOST_LISTED = 400  # wagons in the overview, the most urgent ones

_encode = msgspec.json.Encoder().encode


class Line(Struct, frozen=True):
    """A wagon in the overview."""

    id: str
    state: str
    age_s: float | None  # of the newest estimate
    status: str | None
    speed_mps: float | None
    adhesion: float | None
    adhesion_std: float | None
    level: str | None  # the worst that applies while saturated; None: adhesion is only what is used
    alarms: dict[str, int]  # open ones by severity
    worst: dict[str, Any] | None
    pads_mm: float | None  # remaining, of the most worn wheelset
    spark: list[float | None] | None  # lowest adhesion by second; None: as told before


class Viewer:
    """One browser's view. Remembers what the page was told, and tells only what is new."""

    def __init__(self, fleet: Fleet, wagon: str | None) -> None:
        self._fleet = fleet
        self._wagon = wagon
        fleet.looked_at = wagon or fleet.looked_at
        self._turn = 0
        self._told: dict[str, Any] = {}
        self._rows: tuple[int, int] = (-1, 0)  # epoch, number of the next row to tell

    def news(self, now_s: float) -> bytes:
        """The next message to the page, as JSON."""
        with self._fleet.lock:
            message = self._overview(now_s) if self._wagon is None else self._in_full(self._wagon, now_s)
        self._turn += 1
        return _encode(message)

    def _overview(self, now_s: float) -> dict[str, Any]:
        wagons = sorted(self._fleet.watched.wagons.values(), key=lambda wagon: wagon.urgency(now_s))
        sparks = self._turn % SPARKS_EVERY == 0
        return {
            "view": "fleet",
            "wagons": [_line(wagon, now_s, sparks=sparks) for wagon in wagons[:MOST_LISTED]],
            "more": max(0, len(wagons) - MOST_LISTED),
            **self._own(),
        }

    def _in_full(self, name: str, now_s: float) -> dict[str, Any]:
        wagon = self._fleet.watched.wagons.get(name)
        message: dict[str, Any] = {"view": "wagon", "id": name, **self._own()}
        message |= self._changed("names", sorted(self._fleet.watched.wagons)[:MOST_LISTED])
        if wagon is None:
            return message | {"state": "unknown"}
        message |= {"state": wagon.state(now_s), "age_s": wagon.age_s(now_s), "level": wagon.level}
        message |= self._changed("adhesion", wagon.adhesion)
        message |= self._changed("health", wagon.health)
        message |= self._changed("meta", wagon.meta)
        message |= self._changed("levels", wagon.levels())
        message |= self._changed("wear", [wagon.wear[i] for i in sorted(wagon.wear)])
        message |= self._changed("alarms", [*wagon.open_alarms(), *wagon.past_alarms()])
        recent = self._fleet.recent.get(name)
        if recent is not None:
            epoch, first = self._rows
            first = first if epoch == recent.epoch else 0
            end = recent.ready()
            if end > first or epoch != recent.epoch:
                message["rows"] = {"anew": epoch != recent.epoch, **recent.columns(first, end)}
                self._rows = (recent.epoch, end)
        return message

    def _own(self) -> dict[str, Any]:
        return {
            "connected": self._fleet.is_connected,
            "was_connected": self._fleet.was_connected,
            "heard": self._fleet.heard,
            "not_understood": self._fleet.watched.not_understood,
        }

    def _changed(self, name: str, value: Any) -> dict[str, Any]:
        if name in self._told and self._told[name] == value:
            return {}
        self._told[name] = value
        return {name: value}


def _line(wagon: Wagon, now_s: float, *, sparks: bool) -> Line:
    message, still = wagon.adhesion, wagon.open_alarms()
    remaining_mm = [wear.remaining_mm for wear in wagon.wear.values() if wear.remaining_mm is not None]
    return Line(
        id=wagon.name,
        state=wagon.state(now_s),
        age_s=wagon.age_s(now_s),
        status=message.status if message else None,
        speed_mps=message.speed_mps if message else None,
        adhesion=message.adhesion if message else None,
        adhesion_std=message.adhesion_std if message else None,
        level=wagon.level,
        alarms={severity: sum(alarm.severity is severity for alarm in still) for severity in Severity},
        worst=_in_short(still[0]) if still else None,
        pads_mm=min(remaining_mm, default=None),
        spark=[moment and round(moment.adhesion, SPARK_DECIMALS) for moment in wagon.history] if sparks else None,
    )


def _in_short(alarm: AlarmMessage) -> dict[str, Any]:
    return {
        "kind": alarm.kind,
        "wheelset": alarm.wheelset,
        "severity": alarm.severity,
        "acknowledged": alarm.acknowledged_time_s is not None,
    }
