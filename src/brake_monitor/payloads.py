"""What is published: the keys, and the JSON under them. Both are a contract with every subscriber.

JSON knows no NaN and no infinity: such a value is published as null.
"""

import re
from typing import Literal, Self

import msgspec
from msgspec import Struct

from brake_monitor.errors import InputError
from brake_monitor.estimator import Estimate, Status
from brake_monitor.monitoring.alarm import Alarm, Severity

Number = float | None  # null when the value is not a number

_NOT_IN_CHUNK = re.compile(r"[/*$?#\s]")


class KeySpace:
    """Every key of one wagon, made here and nowhere else: `<prefix>/<wagon>/…`; wheelsets count from 1.

    Raises InputError when the prefix or the wagon's id cannot stand in a Zenoh key.
    """

    def __init__(self, prefix: str, wagon_id: str) -> None:
        for chunk in prefix.split("/"):
            _check_chunk(chunk, f"[zenoh] prefix {prefix!r}")
        _check_chunk(wagon_id, f"[vehicle] id {wagon_id!r}")
        self.wagon = f"{prefix}/{wagon_id}"  # also the key of the liveliness token
        self.everything = f"{self.wagon}/**"
        self.adhesion = f"{self.wagon}/adhesion"

    def friction(self, wheelset: int) -> str:
        """Key of the pad friction of one wheelset."""
        return f"{self.wagon}/axle/{wheelset}/friction"

    def alarm(self, kind: str, wheelset: int | None) -> str:
        """Key of an alarm; None when it concerns the wagon."""
        return f"{self.wagon}/alarm/{kind}" + ("" if wheelset is None else f"/{wheelset}")


def _check_chunk(chunk: str, where: str) -> None:
    # A chunk that begins with @ would be hidden from every wildcard subscription.
    if not chunk or chunk.startswith("@") or _NOT_IN_CHUNK.search(chunk):
        raise InputError(f"{where}: expected a name that can stand in a Zenoh key (no / * $ ? # nor white space)")


class AdhesionMessage(Struct, frozen=True):
    """`…/adhesion`: the wagon. `sequence` counts estimates from the publisher's start; a gap is one passed over."""

    time_s: float  # capture time of the newest frame in it
    adhesion: Number  # utilised F_x / F_z; what the rail has to give only while `saturated`
    adhesion_std: Number
    saturated: bool
    speed_mps: Number
    deceleration_mps2: Number  # unmodelled: gradient, wind, coupler
    deceleration_std_mps2: Number
    status: Status
    reasons: tuple[str, ...]
    nis: Number
    reset_count: int
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, estimate: Estimate, sequence: int, publish_time_s: float) -> Self:
        """The wagon's part of an estimate."""
        return cls(
            time_s=estimate.time_s,
            adhesion=estimate.adhesion,
            adhesion_std=estimate.adhesion_std,
            saturated=estimate.saturated,
            speed_mps=estimate.speed_mps,
            deceleration_mps2=estimate.deceleration_mps2,
            deceleration_std_mps2=estimate.deceleration_std_mps2,
            status=estimate.status,
            reasons=estimate.reasons,
            nis=estimate.nis,
            reset_count=estimate.reset_count,
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class FrictionMessage(Struct, frozen=True):
    """`…/axle/<i>/friction`: one wheelset and its brake; `sequence` is that of the adhesion of the same estimate."""

    time_s: float
    wheelset: int  # from 1
    friction: Number
    friction_std: Number
    status: Status
    slip: Number
    omega_radps: Number
    pressing_force_n: Number
    adhesion: Number  # of this wheelset
    adhesion_std: Number
    wsp_active: bool
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, estimate: Estimate, wheelset: int, sequence: int, publish_time_s: float) -> Self:
        """The part of an estimate that belongs to one wheelset, counted from 1."""
        own = estimate.wheelsets[wheelset - 1]
        return cls(
            time_s=estimate.time_s,
            wheelset=wheelset,
            friction=own.friction,
            friction_std=own.friction_std,
            status=own.friction_status,
            slip=own.slip,
            omega_radps=own.omega_radps,
            pressing_force_n=own.pressing_force_n,
            adhesion=own.adhesion,
            adhesion_std=own.adhesion_std,
            wsp_active=own.wsp_active,
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class AlarmMessage(Struct, frozen=True):
    """`…/alarm/<kind>[/<i>]`: an alarm at each change; `sequence` counts changes from the start, gapless."""

    time_s: float  # when it changed
    state: Literal["open", "cleared"]
    id: str
    kind: str
    wheelset: int | None
    severity: Severity
    message: str
    raised_time_s: float
    acknowledged_time_s: float | None
    cleared_time_s: float | None
    evidence: dict[str, float | str | None]
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, alarm: Alarm, sequence: int, publish_time_s: float) -> Self:
        """The alarm as it stands now."""
        return cls(
            time_s=alarm.updated_time_s,
            state="open" if alarm.cleared_time_s is None else "cleared",
            id=alarm.id,
            kind=alarm.kind,
            wheelset=alarm.wheelset,
            severity=alarm.severity,
            message=alarm.message,
            raised_time_s=alarm.raised_time_s,
            acknowledged_time_s=alarm.acknowledged_time_s,
            cleared_time_s=alarm.cleared_time_s,
            evidence=alarm.evidence,
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


Message = AdhesionMessage | FrictionMessage | AlarmMessage

_encoder = msgspec.json.Encoder()


def encode(message: Message) -> bytes:
    """JSON, on one line, UTF-8."""
    return _encoder.encode(message)
