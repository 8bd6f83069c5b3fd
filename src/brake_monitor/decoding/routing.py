"""The configured mapping against the DBC files: which message carries which of our quantities, and how."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from math import inf, nan, sqrt

from cantools.database.can import Message

from brake_monitor.decoding.dbc import BusDatabase
from brake_monitor.decoding.j1939 import first_not_available
from brake_monitor.decoding.mapped_signal import MappedSignal
from brake_monitor.decoding.matching import Matching, matching_of
from brake_monitor.decoding.qualifier import Qualifier, as_qualifier, good_numbers
from brake_monitor.decoding.rolling_counter import RollingCounter, as_counter
from brake_monitor.decoding.signal_field import SignalField, cycle_time_s, signal_field
from brake_monitor.errors import InputError
from brake_monitor.samples import ESSENTIAL, MEASURED, TRAITS, Channel, Quantity
from brake_monitor.settings.config import Settings, SignalMapping
from brake_monitor.settings.config_text import place_of
from brake_monitor.settings.toml_lines import KeyPath
from brake_monitor.settings.units import default_unit, has_unit, is_unit, si_factor

CYCLES_TO_TIMEOUT = 5.0
_LARGEST_STEP = 1e24  # SI; what is squared must still be a number


@dataclass(frozen=True, slots=True)
class Route:
    """The mapped signals of one message and how its frames are known."""

    matching: Matching
    message: Message
    entries: tuple[MappedSignal, ...]
    counter: RollingCounter | None
    remarks: tuple[str, ...]  # doubts about the units and ranges of its signals


@dataclass(frozen=True, slots=True)
class _Wanted:
    """One entry of the configuration's [signals]."""

    settings: Settings
    place: KeyPath
    quantity: Quantity
    wheelset: int
    mapping: SignalMapping

    @property
    def key(self) -> str:
        """The name for messages, such as `signals.axle_speed[2]`; lists count from 1."""
        return f"signals.{self.quantity}" + (f"[{self.wheelset + 1}]" if len(self.place) > 2 else "")

    def refusal(self, name: str, sentence: str) -> InputError:
        """Says what is wrong, with file and line; `name`: of the entry's key that it is about, "" for the entry."""
        key, place = (f"{self.key}.{name}", (*self.place, name)) if name else (self.key, self.place)
        return InputError(f"{place_of(self.settings.path, place)}: {key}: {sentence}")

    @contextmanager
    def named(self, name: str = "") -> Iterator[None]:
        """Put the place in the configuration before what is wrong with it."""
        try:
            yield
        except InputError as error:
            raise self.refusal(name, str(error)) from None


def build_routes(settings: Settings, databases: Mapping[str, BusDatabase]) -> tuple[Route, ...]:
    """Group the mapped signals by message; InputError names configuration file and key."""
    grouped: dict[tuple[str, str], list[_Wanted]] = {}
    for wanted in _wanted(settings):
        grouped.setdefault((wanted.mapping.bus, wanted.mapping.message), []).append(wanted)
    return tuple(_route(databases[bus], group) for (bus, _), group in grouped.items())


def doubles(settings: Settings) -> Iterator[str]:
    """Say where one signal stands for two of the quantities that are weighed against each other."""
    seen: dict[tuple[str, str, str], _Wanted] = {}
    for wanted in _wanted(settings):
        mapping = wanted.mapping
        if wanted.quantity not in ESSENTIAL:
            continue
        first = seen.setdefault((mapping.bus, mapping.message, mapping.signal), wanted)
        if first is wanted:
            continue
        match first.quantity, wanted.quantity:
            case Quantity.PRESSING_FORCE, Quantity.PRESSING_FORCE:
                means = "which one cylinder for both explains"
            case Quantity.AXLE_SPEED, Quantity.AXLE_SPEED:
                means = "which only coupled wheelsets explain"
            case Quantity.SPEED, Quantity.AXLE_SPEED:
                means = "so that no slip is seen"
            case _:
                means = "which nothing explains"
        yield f'{first.key} and {wanted.key} are both "{mapping.signal}" of "{mapping.message}", {means}'


def _wanted(settings: Settings) -> Iterator[_Wanted]:
    for name, place, mapping in settings.signals.mapped():
        key = ("signals", name) if place is None else ("signals", name, place)
        yield _Wanted(settings, key, Quantity(name), place or 0, mapping)


def _route(database: BusDatabase, group: list[_Wanted]) -> Route:
    """Put the signals of one message together; InputError when one does not fit or they contradict each other."""
    first = group[0]
    with first.named():
        message = database.message(first.mapping.message)
    counted = [wanted for wanted in group if wanted.mapping.counter]
    counter_fields = _counter_fields(counted, message)  # before they are compared: one may not exist
    for name in ("match", "counter"):
        _check_agreement(group, name)
    says_how = next((wanted for wanted in group if wanted.mapping.match), first)
    with says_how.named():
        matching = matching_of(database, message, says_how.mapping.match)
    entries = []
    for wanted in group:
        with wanted.named():
            entry = _mapped_signal(wanted, message, matching.is_j1939)
        entry.qualifier = _qualifier(wanted, message, entry.field)
        entries.append(entry)
    counter = None
    if counter_fields:
        timeout_s = max(entry.channel.timeout_s for entry in entries if entry.counter)
        with counted[0].named("counter"):
            counter = RollingCounter(counter_fields[0], timeout_s)
    doubts = (doubt(wanted, message) for doubt in (_unit_remark, _range_remark) for wanted in group)
    return Route(matching, message, tuple(entries), counter, tuple(remark for remark in doubts if remark))


def _check_agreement(group: list[_Wanted], name: str) -> None:
    """InputError when two entries say different things of their message; one that says nothing agrees with all."""
    said = [(wanted, value) for wanted in group if (value := getattr(wanted.mapping, name))]
    for wanted, value in said[1:]:
        first, wants = said[0]
        if value != wants:
            sentence = f'"{value}", but {first.key} says "{wants}" of the same message "{first.mapping.message}"'
            raise wanted.refusal(name, sentence)


def _mapped_signal(wanted: _Wanted, message: Message, is_j1939: bool) -> MappedSignal:
    quantity, mapping = wanted.quantity, wanted.mapping
    field = signal_field(message, mapping.signal)
    is_of_wheel = quantity is Quantity.AXLE_SPEED
    wheel_radius_m = wanted.settings.vehicle.wheel_radius_m[wanted.wheelset] if is_of_wheel else 1.0
    factor = si_factor(quantity, mapping.unit, wheel_radius_m)
    noise_std = _noise_std(wanted, field, factor)
    cycle_s = cycle_time_s(message, field)
    no_data_from = None
    if is_j1939 and not (field.is_signed or field.is_float):
        no_data_from = first_not_available(field.length)
    return MappedSignal(
        channel=Channel(
            quantity=quantity,
            wheelset=wanted.wheelset,
            bus=mapping.bus,
            message=mapping.message,
            signal=mapping.signal,
            noise_std=noise_std,
            delay_s=mapping.delay_s,
            timeout_s=mapping.timeout_s or (cycle_s * CYCLES_TO_TIMEOUT if cycle_s else TRAITS[quantity].timeout_s),
        ),
        field=field,
        gain=mapping.scale * factor,
        bias=mapping.offset * factor,
        minimum=-inf if mapping.min is None else mapping.min * factor,
        maximum=inf if mapping.max is None else mapping.max * factor,
        no_data_from=nan if no_data_from is None else no_data_from,
        counter=mapping.counter,
    )


def _noise_std(wanted: _Wanted, field: SignalField, factor: float) -> float:
    """Of the sensor and of the steps in which its signal tells; `factor` makes SI of the mapping's unit."""
    quantity, mapping = wanted.quantity, wanted.mapping
    sigma = TRAITS[quantity].noise_std if mapping.noise_std is None else mapping.noise_std * factor
    lsb = 0.0 if field.is_float else abs(field.scale * (mapping.scale * factor))
    if lsb > _LARGEST_STEP:
        raise InputError(f'one step of signal "{mapping.signal}" in the DBC is {lsb:g} in SI, expected a measurement')
    noise_std = sqrt(sigma**2 + lsb**2 / 12.0)
    if quantity in MEASURED and noise_std**2 == 0.0:
        sentence = "expected a noise_std of more than 0: it has no steps that would make up for it"
        raise InputError(f'signal "{mapping.signal}": {sentence}')
    return noise_std


def _qualifier(wanted: _Wanted, message: Message, qualified: SignalField) -> Qualifier | None:
    """What the entry names to judge its values."""
    mapping = wanted.mapping
    if not mapping.qualifier:
        return None
    with wanted.named("qualifier"):
        field = as_qualifier(signal_field(message, mapping.qualifier), qualified)
    with wanted.named("qualifier_good"):
        return Qualifier(field, good_numbers(field, mapping.good_numbers))


def _unit_remark(wanted: _Wanted, message: Message) -> str | None:
    """Say where the DBC's unit is not the one that its values are taken in; a `scale` is taken to convert it."""
    quantity, mapping = wanted.quantity, wanted.mapping
    written, default = message.get_signal_by_name(mapping.signal).unit or "", default_unit(quantity)
    if mapping.scale != 1.0 or default == "":
        return None
    if not written:
        if mapping.unit or not has_unit(quantity):
            return None
        return f"{wanted.key}: neither the mapping nor the DBC names a unit: taken as {default}"
    if is_unit(written, mapping.unit or default):
        return None
    taken = f"the mapping takes it as {mapping.unit}"
    if not mapping.unit:
        taken = f"and without `unit` it is taken as {default}"
    return f'{wanted.key}: the DBC has "{mapping.signal}" in {written}, {taken}; `unit` or `scale` converts'


def _range_remark(wanted: _Wanted, message: Message) -> str | None:
    """Say where the DBC gives no range by what looks like one: a value out of it is believed."""
    signal = message.get_signal_by_name(wanted.mapping.signal)
    least, most = signal.minimum or 0, signal.maximum or 0
    if least < most or least == most == 0:
        return None
    return f'{wanted.key}: the DBC gives "{signal.name}" the range [{least}|{most}], which holds nothing: not used'


def _counter_fields(counted: list[_Wanted], message: Message) -> list[SignalField]:
    """The counter that each of the entries names."""
    fields = []
    for wanted in counted:
        with wanted.named("counter"):
            fields.append(as_counter(signal_field(message, wanted.mapping.counter)))
    return fields
