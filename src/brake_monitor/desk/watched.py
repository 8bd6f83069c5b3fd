"""What a watcher knows of a fleet from what it has heard over Zenoh. No clock, no network: time and bytes are given."""

from collections import deque
from math import isnan, nan
from typing import Any

from brake_monitor.desk.foreign_message import decoded, is_sound, kind_of
from brake_monitor.desk.text_marks import Moment
from brake_monitor.estimation.estimate import SLOWEST_MPS, Status
from brake_monitor.publishing.payloads import (
    AdhesionMessage,
    AlarmMessage,
    FrictionMessage,
    HealthMessage,
    MetaMessage,
    WearMessage,
)
from brake_monitor.settings.alarm_settings import LowAdhesionRule, level_of

LONGEST_NAME = 100  # characters
MOST_WAGONS = 2000
HISTORY = 120  # sparkline bins
BIN_S = 1.0
FROZEN_S = 2.0  # without a new estimate for longer a wagon is told as frozen
PERIODS = 2.5  # so many periods of a daemon that gives out few estimates may pass before one is missed
ALARMS_KEPT = 50  # per wagon, cleared ones first to go
DEFAULT_LEVELS = LowAdhesionRule().levels


class Wagon:
    """The newest that was heard of one wagon."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.alive = False  # its liveliness token is there
        self.heard_s: float | None = None  # when the last new estimate came, by the watcher's clock
        self.adhesion: AdhesionMessage | None = None
        self.health: HealthMessage | None = None
        self.meta: MetaMessage | None = None
        self.friction: dict[int, FrictionMessage] = {}
        self.wear: dict[int, WearMessage] = {}
        self.alarms: dict[str, AlarmMessage] = {}
        self.history: deque[Moment | None] = deque(maxlen=HISTORY)
        self._bin = 0

    def open_alarms(self) -> list[AlarmMessage]:
        """The gravest first, then the newest."""
        still = [alarm for alarm in self.alarms.values() if alarm.state == "open"]
        return sorted(still, key=lambda alarm: (-alarm.severity.rank, -alarm.raised_time_s))

    def urgency(self, now_s: float) -> tuple[int, bool, str]:
        """By which a fleet is sorted: the gravest alarms first, then what is not live, then by name."""
        still = self.open_alarms()
        return (-still[0].severity.rank if still else 1, self.is_live(now_s), self.name)

    def past_alarms(self) -> list[AlarmMessage]:
        """Cleared ones, the newest first."""
        cleared = [alarm for alarm in self.alarms.values() if alarm.state == "cleared"]
        return sorted(cleared, key=lambda alarm: -alarm.raised_time_s)

    def levels(self) -> dict[str, float]:
        """The ladder of low adhesion: the wagon's own, or what is usual."""
        told = self.meta.adhesion_levels if self.meta else {}
        return DEFAULT_LEVELS | {name: told[name] for name in DEFAULT_LEVELS if name in told}

    def level_of(self, moment: Moment) -> str | None:
        """Where adhesion stands on the ladder while the wheels use all that the rail gives; else None."""
        if not moment.saturated or isnan(moment.adhesion):
            return None
        return level_of(moment.adhesion, self.levels())

    @property
    def level(self) -> str | None:
        """Where the newest adhesion stands on it; None as well before the first."""
        return self.level_of(moment_of(self.adhesion)) if self.adhesion else None

    def wheel_kmh(self, own: FrictionMessage) -> float:
        """Circumferential speed of a wheelset; NaN where nothing tells it.

        From slip, which knows the learned radius; near standstill, where it tells nothing, from the configured one.
        """
        speed_mps = self.adhesion.speed_mps if self.adhesion else None
        if speed_mps is not None and speed_mps > SLOWEST_MPS:
            return nan if own.slip is None else speed_mps * (1.0 - own.slip) * 3.6
        radii_m = self.meta.wheel_radius_m if self.meta else ()
        if own.omega_radps is None or own.wheelset > len(radii_m):
            return nan
        return own.omega_radps * radii_m[own.wheelset - 1] * 3.6

    def age_s(self, now_s: float) -> float | None:
        """Seconds since the last estimate came; None before the first."""
        return None if self.heard_s is None else now_s - self.heard_s

    def state(self, now_s: float) -> str:
        """In a word: live, frozen (alive, but nothing new comes), silent (alive, nothing came yet) or gone."""
        if not self.alive:
            return "gone"
        age_s = self.age_s(now_s)
        if age_s is None:
            return "silent"
        rate_hz = self.meta.estimate_rate_hz if self.meta else 0.0
        return "frozen" if age_s > max(FROZEN_S, PERIODS / rate_hz if rate_hz > 0.0 else 0.0) else "live"

    def is_live(self, now_s: float) -> bool:
        """Whether what is shown is so now."""
        return self.state(now_s) == "live"

    def take(self, message: Any, now_s: float) -> None:
        """Note a message of this wagon."""
        match message:
            case AdhesionMessage():
                if self.adhesion is None or message.time_s != self.adhesion.time_s:
                    self.heard_s = now_s
                self.adhesion = message
                self._remember(message, now_s)
            case HealthMessage():
                self.health = message
                self._forget_unknown(message)
            case MetaMessage():
                self.meta = message
            case FrictionMessage():
                self.friction[message.wheelset] = message
            case WearMessage():
                self.wear[message.wheelset] = message
            case AlarmMessage():
                known = self.alarms.get(message.id)
                if known is None or _is_later(message, known):  # an answer may be older than what was heard
                    self.alarms[message.id] = message
                while len(self.alarms) > ALARMS_KEPT:
                    cleared = (name for name, alarm in self.alarms.items() if alarm.state == "cleared")
                    del self.alarms[next(cleared, next(iter(self.alarms)))]

    def _forget_unknown(self, health: HealthMessage) -> None:
        """Forget alarms that a daemon which restarted without a memory no longer knows: nobody will clear them."""
        for alarm in self.open_alarms():
            if alarm.id not in health.open_alarms and alarm.publish_time_s < health.publish_time_s:
                del self.alarms[alarm.id]

    def _remember(self, message: AdhesionMessage, now_s: float) -> None:
        now = moment_of(message)
        step = int(now_s // BIN_S) - self._bin
        self._bin += step
        if step or not self.history:
            self.history.extend([None] * min(step - 1, HISTORY) if len(self.history) else [])
            self.history.append(now)
        else:
            self.history[-1] = now.beside(self.history[-1])


def moment_of(message: AdhesionMessage) -> Moment:
    """What the sparkline shows of it: a gap where the estimate says of itself that it is invalid."""
    if message.adhesion is None or message.status is Status.INVALID:
        return Moment(nan, message.saturated)
    return Moment(message.adhesion, message.saturated)


def _is_later(message: AlarmMessage, known: AlarmMessage) -> bool:
    """By `sequence`, since `time_s` goes back when a clock is set, and lies behind an acknowledgement if a sensor lags.

    A daemon that could not keep its last events uses their numbers again, with a later `publish_time_s`.
    """
    return message.sequence >= known.sequence or message.publish_time_s > known.publish_time_s


class Watched:
    """A fleet under one prefix. What cannot be understood is counted and left out."""

    def __init__(self, prefix: str) -> None:
        self.wagons: dict[str, Wagon] = {}
        self.not_understood = 0
        self._prefix = f"{prefix}/"

    def take(self, key: str, encoding: str, payload: bytes, now_s: float) -> AlarmMessage | None:
        """Note what was heard; the alarm when it was a change of one that is news."""
        heard = self.understood(key, encoding, payload)
        if heard is None:
            return None
        wagon, message = heard
        is_news = isinstance(message, AlarmMessage) and wagon.alarms.get(message.id) != message
        wagon.take(message, now_s)
        return message if is_news else None

    def understood(self, key: str, encoding: str, payload: bytes) -> tuple[Wagon, Any] | None:
        """Whose message it is, and what it says; None when it is none of ours or cannot be understood."""
        name, _, below = key.removeprefix(self._prefix).partition("/")
        kind = kind_of(below)
        if kind is None:
            return None
        message = decoded(payload, kind, encoding)
        wagon = self._wagon(name) if message is not None and is_sound(message) else None
        if wagon is None:
            self.not_understood += 1
            return None
        return wagon, message

    def lives(self, key: str, alive: bool) -> None:
        """Note that a wagon's daemon came or went."""
        wagon = self._wagon(self.wagon_of(key))
        if wagon is not None:
            wagon.alive = alive

    def wagon_of(self, key: str) -> str:
        """The id of the wagon that a key is of."""
        return key.removeprefix(self._prefix).partition("/")[0]

    def _wagon(self, name: str) -> Wagon | None:
        fits = len(self.wagons) < MOST_WAGONS and 0 < len(name) <= LONGEST_NAME and name.isprintable()
        if name not in self.wagons and fits:
            self.wagons[name] = Wagon(name)
        return self.wagons.get(name)
