"""What is published, as it stands on the wire: a contract with every subscriber.

Each value has its unit in its name. `time_s` is the capture time (Unix, of the newest frame in it), `publish_time_s`
when it was handed to Zenoh, `sequence` counts on from 1. What is not a number (NaN, ±∞), or was never told, is null.
"""

from math import isfinite
from typing import Annotated, Literal, NamedTuple, Self

from msgspec import Meta, Struct

from brake_monitor.estimation.estimate import Estimate, Status
from brake_monitor.monitoring.alarm import Alarm, Severity
from brake_monitor.monitoring.brake_units.brakes import Brakes
from brake_monitor.monitoring.brake_units.wear import pad_life
from brake_monitor.publishing.encoding import Format
from brake_monitor.samples import Quantity
from brake_monitor.settings.wear_settings import WearSettings

Number = float | None  # null when the value is not a number, or nothing has told it
Flag = bool | None  # null where no signal tells it now
Quality = Literal["good", "uncertain", "bad"]  # in one word, for readers who do not need the reasons

LONGEST_REQUEST = 1024  # bytes of anything that comes from outside


def _number(value: float | None, *, is_known: bool = True) -> Number:
    return value if value is not None and is_known and isfinite(value) else None


def _flag(value: bool, *, is_known: bool) -> Flag:
    return value if is_known else None


def quality_of(status: Status) -> Quality:
    """The status in one word."""
    if status is Status.VALID:
        return "good"
    return "bad" if status is Status.INVALID else "uncertain"


class AdhesionMessage(Struct, frozen=True):
    """`…/adhesion`: the wagon. `sequence` counts estimates from the daemon's start; a gap is one passed over."""

    time_s: float
    adhesion: Number  # utilised F_x / F_z; what the rail has to give only while `saturated`
    adhesion_std: Number
    saturated: bool
    speed_mps: Number
    deceleration_mps2: Number  # unmodelled: gradient, wind, coupler
    deceleration_std_mps2: Number
    distance_m: Number  # travelled since the daemon's start
    latitude_deg: Number
    longitude_deg: Number
    sanding: Flag
    mass_kg: Number
    status: Status
    quality: Quality
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
            adhesion=_number(estimate.adhesion),
            adhesion_std=_number(estimate.adhesion_std),
            saturated=estimate.saturated,
            speed_mps=_number(estimate.speed_mps, is_known=estimate.knows(Quantity.SPEED)),
            deceleration_mps2=_number(estimate.deceleration_mps2),
            deceleration_std_mps2=_number(estimate.deceleration_std_mps2),
            distance_m=_number(estimate.distance_m),
            latitude_deg=_number(estimate.latitude_deg),
            longitude_deg=_number(estimate.longitude_deg),
            sanding=_flag(estimate.sanding, is_known=estimate.knows(Quantity.SANDING)),
            mass_kg=_number(estimate.mass_kg),
            status=estimate.status,
            quality=quality_of(estimate.status),
            reasons=estimate.reasons,
            nis=_number(estimate.nis),
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
    status: Status  # of the friction
    quality: Quality
    slip: Number
    omega_radps: Number
    pressing_force_n: Number
    adhesion: Number  # of this wheelset
    adhesion_std: Number
    wsp_active: Flag
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, estimate: Estimate, wheelset: int, sequence: int, publish_time_s: float) -> Self:
        """The part of an estimate that belongs to one brake, counted from 1."""
        i = wheelset - 1
        own = estimate.wheelsets[i]
        return cls(
            time_s=estimate.time_s,
            wheelset=wheelset,
            friction=_number(own.friction),
            friction_std=_number(own.friction_std),
            status=own.friction_status,
            quality=quality_of(own.friction_status),
            slip=_number(own.slip, is_known=estimate.knows_slip(i)),
            omega_radps=_number(own.omega_radps, is_known=estimate.knows(Quantity.AXLE_SPEED, i)),
            pressing_force_n=_number(own.pressing_force_n, is_known=estimate.knows(Quantity.PRESSING_FORCE, i)),
            adhesion=_number(own.adhesion),
            adhesion_std=_number(own.adhesion_std),
            wsp_active=_flag(own.wsp_active, is_known=estimate.knows(Quantity.WSP_ACTIVE, i)),
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class AxleAdhesionMessage(Struct, frozen=True):
    """`…/axle/<i>/adhesion`: what one wheelset uses of the rail; `sequence` is that of the same estimate."""

    time_s: float
    wheelset: int  # from 1
    adhesion: Number  # its own F_x / F_z
    adhesion_std: Number
    slip: Number
    wsp_active: Flag
    status: Status
    quality: Quality
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, estimate: Estimate, wheelset: int, sequence: int, publish_time_s: float) -> Self:
        """The part of an estimate that belongs to one wheelset's contact, counted from 1."""
        i = wheelset - 1
        own = estimate.wheelsets[i]
        return cls(
            time_s=estimate.time_s,
            wheelset=wheelset,
            adhesion=_number(own.adhesion),
            adhesion_std=_number(own.adhesion_std),
            slip=_number(own.slip, is_known=estimate.knows_slip(i)),
            wsp_active=_flag(own.wsp_active, is_known=estimate.knows(Quantity.WSP_ACTIVE, i)),
            status=own.adhesion_status,
            quality=quality_of(own.adhesion_status),
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class AlarmMessage(Struct, frozen=True):
    """`…/alarm/<kind>[/<i>]`: an alarm at each change.

    `sequence` counts the changes of all alarms together, gapless over restarts.
    """

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
            evidence={name: _number(v) if isinstance(v, float) else v for name, v in alarm.evidence.items()},
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class WearMessage(Struct, frozen=True):
    """`…/axle/<i>/wear`: the pads of one wheelset, after each brake application and at the daemon's start.

    `sequence` is gapless under its key, over restarts as well. Thickness with the interval that holds it with 95 %.
    """

    time_s: float
    wheelset: int  # from 1
    thickness_mm: Number  # by the energy that went through the pads
    thickness_low_mm: Number
    thickness_high_mm: Number
    archard_thickness_mm: Number  # by Archard's law, which needs no friction
    archard_thickness_low_mm: Number
    archard_thickness_high_mm: Number
    remaining_mm: Number  # to the limit
    remaining_stops: Number  # null: too little recent use to tell
    remaining_km: Number
    pad_energy_j: Number  # since the pads were fitted, as the next three
    stops: Number
    sliding_distance_m: Number
    distance_m: Number
    fitted_time_s: float | None
    gauged_time_s: float | None  # null: taken as new, never measured
    disc_temperature_c: Number  # estimated
    status: Status  # converging: never measured, so only as good as the settings
    quality: Quality
    sequence: int
    publish_time_s: float

    @classmethod
    def of(cls, brakes: Brakes, wheelset: int, settings: WearSettings, sequence: int, publish_time_s: float) -> Self:
        """The state of one brake unit, counted from 1."""
        unit = brakes.units[wheelset - 1]
        pads, life = unit.pads, pad_life(unit.pads, settings)
        status = Status.CONVERGING if pads.gauged_time_s is None else Status.VALID
        return cls(
            time_s=publish_time_s if brakes.time_s is None else brakes.time_s,
            wheelset=wheelset,
            thickness_mm=_number(life.by_energy.value_mm),
            thickness_low_mm=_number(life.by_energy.low_mm),
            thickness_high_mm=_number(life.by_energy.high_mm),
            archard_thickness_mm=_number(life.by_archard.value_mm),
            archard_thickness_low_mm=_number(life.by_archard.low_mm),
            archard_thickness_high_mm=_number(life.by_archard.high_mm),
            remaining_mm=_number(life.remaining_mm),
            remaining_stops=_number(life.remaining_stops),
            remaining_km=_number(life.remaining_km),
            pad_energy_j=_number(pads.since_fitted.energy_j),
            stops=_number(pads.since_fitted.stops),
            sliding_distance_m=_number(pads.since_fitted.sliding_distance_m),
            distance_m=_number(pads.since_fitted.distance_m),
            fitted_time_s=pads.fitted_time_s,
            gauged_time_s=pads.gauged_time_s,
            disc_temperature_c=_number(unit.disc_temperature_c),
            status=status,
            quality=quality_of(status),
            sequence=sequence,
            publish_time_s=publish_time_s,
        )


class Counter(NamedTuple):
    """What a number of `HealthMessage` tells that only grows, in words for OpenMetrics."""

    told: str


class Gauge(NamedTuple):
    """... and one that may fall again."""

    told: str


class HealthMessage(Struct, frozen=True):
    """`…/health`: how the daemon does, once a second. Counters begin at 0 with the daemon.

    That it lives is told by its liveliness token; whether what it says is fresh, by `data_age_s`.
    """

    time_s: float  # capture time of the newest estimate; 0 before the first
    data_age_s: Number  # of the newest reading that the estimates contain; null before the first
    status: Status
    quality: Quality
    uptime_s: Annotated[float, Gauge("time since the daemon began")]
    frames: Annotated[int, Counter("CAN frames received")]
    mapped_frames: Annotated[int, Counter("CAN frames of a mapped message")]
    decode_errors: Annotated[int, Counter("frames and samples that could not be used")]
    lost_frames: Annotated[int, Counter("frames lost by their rolling counters")]
    dropped_frames: Annotated[int, Counter("CAN frames that the kernel dropped because nobody fetched them in time")]
    stale_signals: tuple[str, ...]  # mapped signals that are not good now: `<message>.<signal> <condition>`
    buses_down: tuple[str, ...]
    bus_failures: Annotated[int, Counter("times that a CAN bus failed")]
    frames_waiting: Annotated[int, Gauge("CAN frames that wait for the estimator")]
    # Captured up to 50 ms before; what is later restarts the filter:
    late_samples: Annotated[int, Counter("samples captured before what had been fused already")]
    # Left out, unless they went on to:
    outliers: Annotated[int, Counter("samples that contradicted the estimate")]
    filter_resets: Annotated[int, Counter("restarts of the estimator's filter")]
    memory_failure: str  # why the memory cannot be written; empty when it can
    open_alarms: tuple[str, ...]  # ids of all that are, by what was published before this
    estimates_sent: Annotated[int, Counter("estimates published")]
    estimates_replaced: Annotated[int, Counter("estimates replaced by a newer one before they were published")]
    events_sent: Annotated[int, Counter("alarms and wear published")]
    events_waiting: Annotated[int, Gauge("alarms and wear that wait to be published")]
    events_lost: Annotated[int, Counter("alarms and wear given up because too many waited")]
    queries_answered: Annotated[int, Counter("questions answered over Zenoh")]
    queries_refused: Annotated[int, Counter("questions refused over Zenoh")]
    publish_failures: Annotated[int, Counter("publications that Zenoh refused, events that could not be kept")]
    latency_bounds_s: tuple[float, ...]  # upper ends of the classes of `latency_counts`, whose last has none
    latency_counts: tuple[int, ...]  # estimates by their time from capture to publication
    latency_sum_s: float  # of all of them
    cpu_s: Annotated[float, Counter("processor time used")]
    memory_bytes: Annotated[int, Gauge("resident memory")]
    versions: dict[str, str]
    sequence: int
    publish_time_s: float


class MetaMessage(Struct, frozen=True):
    """`…/meta`: what is published, in which units, from what and by whom."""

    time_s: float  # when the daemon began
    wagon: str
    wheelsets: int
    preset: str
    estimate_rate_hz: float  # 0: every fused frame
    mass_kg: float
    axle_positions_m: tuple[float, ...]
    wheel_radius_m: tuple[float, ...]
    buses: tuple[str, ...]  # "<name>: <interface> <channel>"
    signals: dict[str, str]  # what is mapped to what: "axle_speed/1" → "<message>.<signal>"
    encoding: Format
    accepts_acknowledgements: bool
    units: dict[str, str]  # ending of a value's name → unit
    schemas: dict[str, str]  # key of a payload → key that its JSON Schema is to be got from
    versions: dict[str, str]
    sequence: int
    publish_time_s: float
    adhesion_levels: dict[str, float] = {}  # below which the rail is "low", "very_low", "extremely_low"
    friction_nominal: Number = None
    new_pad_thickness_mm: Number = None
    pad_limit_mm: Number = None
    pad_margin_mm: Number = None  # pads so close to their limit are `pad_near_limit`


class AcknowledgeRequest(Struct, frozen=True, forbid_unknown_fields=True):
    """What a `get` on `…/acknowledge` carries."""

    id: Annotated[str, Meta(min_length=1, max_length=200)]  # of an open alarm


class AcknowledgeReply(Struct, frozen=True):
    """... and what it is answered: handed over; the alarm itself follows on its own key."""

    id: str
    accepted: Literal[True] = True


Message = (
    AdhesionMessage | FrictionMessage | AxleAdhesionMessage | WearMessage | AlarmMessage | HealthMessage | MetaMessage
)
