"""The configured mapping against the DBC files: which message carries which of our quantities, and how."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from math import inf, isfinite, isnan, nan, sqrt

from cantools.database.can import Message

from brake_monitor.can_filter import CanFilter
from brake_monitor.config import Settings, SignalMapping
from brake_monitor.dbc import BusDatabase, SignalField, cycle_time_s, signal_field
from brake_monitor.errors import InputError
from brake_monitor.j1939 import first_not_available, pgn_bits, pgn_mask
from brake_monitor.rolling_counter import RollingCounter
from brake_monitor.samples import Channel, Quality, Quantity
from brake_monitor.units import si_factor

# Standard deviation in SI when the mapping gives none: what such a sensor on a wagon is usually worth.
DEFAULT_NOISE_STD: Mapping[Quantity, float] = {
    Quantity.SPEED: 0.05,
    Quantity.AXLE_SPEED: 0.1,
    Quantity.PRESSING_FORCE: 500.0,
    Quantity.WSP_ACTIVE: 0.0,
    Quantity.SANDING: 0.0,
    Quantity.LOAD_FORCE: 2000.0,
    Quantity.GRADIENT: 0.002,
    Quantity.WHEEL_TORQUE: 100.0,
    Quantity.LATITUDE: 5e-5,  # about 5 m
    Quantity.LONGITUDE: 5e-5,
}

# When neither the mapping nor the DBC's cycle time says how long a value may be used.
_TIMEOUT_S = 1.0
_SLOW_TIMEOUT_S = 5.0
_SLOW = frozenset({Quantity.LOAD_FORCE, Quantity.GRADIENT, Quantity.LATITUDE, Quantity.LONGITUDE})
_CYCLES_TO_TIMEOUT = 5.0

_GOOD = Quality.GOOD  # looking a member up in its enumeration is slow, and every value needs this one


@dataclass(slots=True)
class MappedSignal:
    """One mapped signal on its way from raw number to sample."""

    channel: Channel
    field: SignalField
    mapping: SignalMapping
    si_factor: float
    minimum: float  # clamps in the mapping's unit
    maximum: float
    no_data_from: float  # J1939 codes: raw values from here on are no measurement; NaN, which nothing reaches, without
    is_counted: bool  # its message's rolling counter must be good
    deadline_s: float = -inf  # when it becomes stale; inf once that was told

    def convert(self, raw: float) -> tuple[float, Quality]:
        """Return the SI value and what is to be thought of it."""
        field, mapping = self.field, self.mapping
        physical = raw * field.scale + field.offset
        value = physical * mapping.scale + mapping.offset
        if value < self.minimum:
            value = self.minimum
        elif value > self.maximum:
            value = self.maximum
        value *= self.si_factor
        if raw >= self.no_data_from or raw in field.not_available or isnan(raw):
            return value, Quality.NOT_AVAILABLE
        if field.minimum <= physical <= field.maximum and isfinite(physical):
            return value, _GOOD
        return value, Quality.OUT_OF_RANGE


@dataclass(frozen=True, slots=True)
class Route:
    """The mapped signals of one message and how its frames are known."""

    bus: str
    message: Message
    match: str
    entries: tuple[MappedSignal, ...]
    counter: RollingCounter | None

    def can_filters(self) -> Iterator[CanFilter]:
        """Give the kernel filters that let the message's frames through."""
        can_id, extended = self.message.frame_id, self.message.is_extended_frame
        if self.match == "pgn":
            yield CanFilter(can_id=pgn_bits(can_id), can_mask=pgn_mask(can_id), extended=True)
            return
        for width in (False, True) if self.match == "number" else (extended,):
            yield CanFilter(can_id=can_id, can_mask=0x1FFFFFFF if width else 0x7FF, extended=width)


def build_routes(settings: Settings, databases: Mapping[str, BusDatabase]) -> tuple[Route, ...]:
    """Group the mapped signals by message; InputError names configuration file and key."""
    grouped: dict[tuple[str, str], list[tuple[str, Message, MappedSignal]]] = {}
    for key, quantity, wheelset, mapping in _mappings(settings):
        try:
            message = databases[mapping.bus].message(mapping.message)
            entry = _mapped_signal(settings, quantity, wheelset, mapping, message)
        except InputError as error:
            raise InputError(f"{settings.path}: {key}: {error}") from None
        grouped.setdefault((mapping.bus, mapping.message), []).append((key, message, entry))
    return tuple(_route(settings, databases[bus], group) for (bus, _), group in grouped.items())


def _mappings(settings: Settings) -> Iterator[tuple[str, Quantity, int, SignalMapping]]:
    for quantity in Quantity:
        found = getattr(settings.signals, quantity)
        if isinstance(found, SignalMapping):
            yield f"signals.{quantity}", quantity, 0, found
        else:
            for wheelset, mapping in enumerate(found or ()):
                yield f"signals.{quantity}[{wheelset + 1}]", quantity, wheelset, mapping


def _mapped_signal(
    settings: Settings, quantity: Quantity, wheelset: int, mapping: SignalMapping, message: Message
) -> MappedSignal:
    field = signal_field(message, mapping.signal)
    wheel_radius_m = settings.vehicle.wheel_radius_m[wheelset] if quantity is Quantity.AXLE_SPEED else 1.0
    factor = si_factor(quantity, mapping.unit, wheel_radius_m)
    sigma = DEFAULT_NOISE_STD[quantity] if mapping.noise_std is None else mapping.noise_std * factor
    lsb = 0.0 if field.is_float else abs(field.scale * mapping.scale * factor)
    cycle_s = cycle_time_s(message)
    default_timeout_s = _SLOW_TIMEOUT_S if quantity in _SLOW else _TIMEOUT_S
    no_data_from = None
    if mapping.match == "pgn" and not (field.is_signed or field.is_float):
        no_data_from = first_not_available(field.length)
    return MappedSignal(
        channel=Channel(
            quantity=quantity,
            wheelset=wheelset,
            bus=mapping.bus,
            message=mapping.message,
            signal=mapping.signal,
            noise_std=sqrt(sigma**2 + lsb**2 / 12.0),
            delay_s=mapping.delay_s,
            timeout_s=mapping.timeout_s or (cycle_s * _CYCLES_TO_TIMEOUT if cycle_s else default_timeout_s),
        ),
        field=field,
        mapping=mapping,
        si_factor=factor,
        minimum=-inf if mapping.min is None else mapping.min,
        maximum=inf if mapping.max is None else mapping.max,
        no_data_from=nan if no_data_from is None else no_data_from,
        is_counted=bool(mapping.counter),
    )


def _route(settings: Settings, database: BusDatabase, group: list[tuple[str, Message, MappedSignal]]) -> Route:
    """Put the signals of one message together; InputError when they contradict each other or it has a double."""
    key, message, first = group[0]
    match = first.mapping.match
    for other_key, _, other in group[1:]:
        if other.mapping.match != match:
            raise InputError(
                f'{settings.path}: {other_key}: match = "{other.mapping.match}", but {key} matches the same message '
                f'"{message.name}" by "{match}"'
            )
    if match == "pgn" and not message.is_extended_frame:
        raise InputError(f'{settings.path}: {key}: message "{message.name}" has an 11-bit id, which has no PGN')
    double = database.double_of(message, _IDENTITY[match])
    if double is not None:
        raise InputError(
            f'{settings.path}: {key}: message "{message.name}" is ambiguous on bus "{database.bus}": '
            f'by {match} it cannot be told from "{double}"'
        )
    return Route(
        database.bus, message, match, tuple(entry for _, _, entry in group), _counter(settings, message, group)
    )


_IDENTITY: Mapping[str, Callable[[Message], object]] = {
    "id": lambda message: (message.is_extended_frame, message.frame_id),
    "number": lambda message: message.frame_id,
    "pgn": lambda message: message.is_extended_frame and pgn_bits(message.frame_id),
}


def _counter(
    settings: Settings, message: Message, group: list[tuple[str, Message, MappedSignal]]
) -> RollingCounter | None:
    counted = [(key, entry) for key, _, entry in group if entry.mapping.counter]
    if not counted:
        return None
    key, first = counted[0]
    for other_key, other in counted[1:]:
        if other.mapping.counter != first.mapping.counter:
            raise InputError(
                f'{settings.path}: {other_key}.counter: "{other.mapping.counter}", but {key} names '
                f'"{first.mapping.counter}" in the same message'
            )
    try:
        field = signal_field(message, first.mapping.counter)
    except InputError as error:
        raise InputError(f"{settings.path}: {key}.counter: {error}") from None
    if field.is_float or field.is_signed or field.conditions:
        raise InputError(
            f'{settings.path}: {key}.counter: signal "{field.name}" cannot be a rolling counter: '
            "expected an unsigned integer that is in every frame"
        )
    lowest, highest = field.raw_range()
    return RollingCounter(field.raw_of, lowest, highest, max(entry.channel.timeout_s for _, entry in counted))
