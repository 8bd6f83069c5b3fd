"""Sensor values → CAN frames: the signal mapping and the DBC, run backwards."""

from binascii import crc32
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from math import nan
from typing import Any

import numpy as np
from cantools.database.can import Message, Signal
from numpy.typing import NDArray

from brake_monitor.arrays import Bytes, Floats
from brake_monitor.decoding.dbc import load_buses
from brake_monitor.decoding.signal_field import SignalField, message_cycle_s, signal_field
from brake_monitor.errors import InputError
from brake_monitor.frame import Frame
from brake_monitor.settings.config import CanBus, Settings, SignalMapping
from brake_monitor.settings.units import si_factor
from brake_monitor.simulator.sensor_faults import SensorFailure, SensorFault
from brake_monitor.simulator.sensors import Sensors

Raw = NDArray[Any]  # integers, or float64 where the signal is a float

DEFAULT_CYCLE_S = 0.1  # of a mapped message whose DBC names none
LONGEST_FRAME = 64  # bytes, of CAN FD; what is longer a transport protocol sends in several
SPEEDS = frozenset({"speed", "axle_speed"})
LEAST_LATENCY_S = 0.2e-3  # from sampling to the frame's capture: transmission ...
MEAN_WAIT_S = 0.3e-3  # ... and arbitration, exponentially distributed
LONGEST_WAIT_S = 1.0e-3


@dataclass(frozen=True, slots=True)
class _Source:
    """One mapped signal: which quantity it carries, for which entry of its list."""

    quantity: str
    place: int
    places: int
    mapping: SignalMapping


@dataclass(frozen=True, slots=True)
class _Page:
    """Signals that travel in one frame; a message without multiplexer has a single page."""

    selectors: dict[str, int]
    signals: tuple[str, ...]


def signal_unit(settings: Settings, mapping: SignalMapping) -> str:
    """Unit that the DBC gives to the mapped signal (may be empty); InputError when there is no such signal."""
    message = load_buses(settings)[mapping.bus].message(mapping.message)
    signal_field(message, mapping.signal)
    return str(message.get_signal_by_name(mapping.signal).unit or "")


def encode(
    settings: Settings,
    sensors: Sensors,
    *,
    duration_s: float,
    start_s: float,
    seed: int,
    loss: float,
    faults: Sequence[SensorFault] = (),
) -> list[Frame]:
    """All frames of a run in order of time, `start_s` being the time of the trace's first row.

    Each message runs at its own phase and keeps its cycle; frames are captured a little after their sampling,
    and the fraction `loss` of them never arrives (the rolling counters show it), nor those of a sensor that is lost.
    """
    files = load_buses(settings)
    mapped: defaultdict[Message, dict[str, _Source]] = defaultdict(dict)
    for source in _sources(settings):
        message = files[source.mapping.bus].message(source.mapping.message)
        for name in filter(None, (source.mapping.signal, source.mapping.qualifier)):
            signal_field(message, name)
        mapped[message][source.mapping.signal] = source
    frames: list[Frame] = []
    for bus in settings.can:
        for _, file in files[bus.name].files:
            for message in file.messages:
                cycle_s = message_cycle_s(message) or (DEFAULT_CYCLE_S if message in mapped else 0.0)
                if cycle_s and message.length <= LONGEST_FRAME:
                    rng = np.random.default_rng([seed, crc32(f"{bus.name}/{message.name}".encode())])
                    encoder = _MessageEncoder(bus, message, mapped.get(message, {}), settings, faults)
                    frames += encoder.frames(
                        sensors, cycle_s=cycle_s, duration_s=duration_s, start_s=start_s, loss=loss, rng=rng
                    )
    frames.sort()
    return frames


class _MessageEncoder:
    """One message: which signals carry what, its pages, qualifiers and counters."""

    def __init__(
        self,
        bus: CanBus,
        message: Message,
        mapped: dict[str, _Source],
        settings: Settings,
        faults: Sequence[SensorFault],
    ) -> None:
        self._bus = bus
        self._message = message
        self._fields = _fields(message)
        self._mapped = mapped
        self._radii_m = settings.vehicle.wheel_radius_m
        self._faults = {
            name: [fault for fault in faults if (fault.quantity, fault.place) == (source.quantity, source.place)]
            for name, source in mapped.items()
        }
        counters = {source.mapping.counter for source in mapped.values()} - {""}
        self._counters = {name: signal_field(message, name) for name in counters}
        self._qualifiers = _qualifiers(source.mapping for source in mapped.values())
        self._pages = list(_pages(message.signal_tree))

    def frames(
        self,
        sensors: Sensors,
        *,
        cycle_s: float,
        duration_s: float,
        start_s: float,
        loss: float,
        rng: np.random.Generator,
    ) -> Iterator[Frame]:
        """Frames of this message over the whole run."""
        times_s = np.arange(rng.uniform(0.0, cycle_s), duration_s, cycle_s)
        waits_s = np.minimum(rng.exponential(MEAN_WAIT_S, len(times_s)), LONGEST_WAIT_S)
        captured = start_s + times_s + LEAST_LATENCY_S + waits_s
        kept = rng.random(len(times_s)) >= loss
        for fault in chain.from_iterable(self._faults.values()):
            if fault.failure is SensorFailure.LOST:
                kept &= ~fault.acts(times_s)
        columns = {name: self._raw(name, sensors, times_s, rng) for name in self._mapped}
        data = self._data(columns, len(times_s))
        bus, can_id, extended = self._bus.name, self._message.frame_id, self._message.is_extended_frame
        for time_s, payload, arrives in zip(captured.tolist(), data, kept.tolist(), strict=True):
            if arrives:
                yield Frame(round(time_s, 6), bus, can_id, extended, payload)

    def _data(self, columns: dict[str, Raw], count: int) -> list[bytes]:
        """The payloads of `count` frames: mapped signals' raw values, qualifiers, counters, and the rest at rest."""
        values = {name: np.full(count, _resting(self._signal(name), field)) for name, field in self._fields.items()}
        values |= {name: np.full(count, good) for name, good in self._qualifiers.items()}
        values |= columns | {name: _turns(field, count) for name, field in self._counters.items()}
        payload = np.zeros((count, self._message.length), dtype=np.uint8)
        for place, page in enumerate(self._pages):
            rows = slice(place, None, len(self._pages))
            for name, field in self._fields.items():
                if name in page.selectors:
                    put(payload[rows], field, np.full(count, page.selectors[name])[rows])
                elif name in page.signals:
                    put(payload[rows], field, values[name][rows])
        whole, length = payload.tobytes(), self._message.length
        return [whole[k * length : (k + 1) * length] for k in range(count)]

    def _signal(self, name: str) -> Signal:
        return self._message.get_signal_by_name(name)

    def _raw(self, name: str, sensors: Sensors, times_s: Floats, rng: np.random.Generator) -> Raw:
        """Measured, converted and quantised values of one mapped signal."""
        source = self._mapped[name]
        mapping = source.mapping
        radius_m = self._radii_m[source.place if source.quantity == "axle_speed" else 0]
        truth = sensors.read(source.quantity, source.place, source.places, times_s - mapping.delay_s)
        if source.quantity in SPEEDS and (self._signal(name).minimum or 0.0) >= 0.0:
            truth = np.abs(truth)  # many a speed has no sign on the bus
        noise = rng.normal(0.0, mapping.noise_std or 0.0, len(times_s))
        if source.quantity == "axle_speed":
            noise[truth == 0.0] = 0.0  # a pulse generator that does not turn gives no pulses
        si = si_factor(source.quantity, mapping.unit, radius_m)
        in_unit = truth / si + noise
        for fault in self._faults[name]:
            in_unit = fault.reading(times_s, in_unit, si)
        field = self._fields[name]
        raw = _raw_values(field, (in_unit - mapping.offset) / mapping.scale)
        for fault in self._faults[name]:
            if fault.failure is SensorFailure.ERROR_CODE:
                raw[fault.acts(times_s)] = _error_code(field)
        return raw


def _sources(settings: Settings) -> list[_Source]:
    """Every mapped signal of the configuration."""
    mapped = list(settings.signals.mapped())
    places = Counter(quantity for quantity, *_ in mapped)
    return [_Source(quantity, place or 0, places[quantity], mapping) for quantity, place, mapping in mapped]


def _fields(message: Message) -> dict[str, SignalField]:
    """Where the signals of a message lie; without those that cannot be decoded, which are never mapped."""
    fields = {}
    for signal in message.signals:
        with suppress(InputError):
            fields[signal.name] = signal_field(message, signal.name)
    return fields


def _pages(tree: Sequence[Any]) -> Iterator[_Page]:
    """Every combination of multiplexer values of a cantools signal tree, with the signals it carries."""
    plain = tuple(node for node in tree if isinstance(node, str))
    pages = [_Page({}, plain)]
    for node in tree:
        if isinstance(node, str):
            continue
        ((selector, branches),) = node.items()
        pages = [
            _Page(page.selectors | {selector: value} | inner.selectors, page.signals + inner.signals)
            for page in pages
            for value, branch in branches.items()
            for inner in _pages(branch)
        ]
    yield from pages


def _qualifiers(mappings: Iterable[SignalMapping]) -> dict[str, int]:
    """By name of a qualifier the number that is good for the most of those that name it."""
    good: defaultdict[str, Counter[int]] = defaultdict(Counter)
    for mapping in mappings:
        if mapping.qualifier:
            good[mapping.qualifier].update(mapping.good_numbers)
    return {name: numbers.most_common(1)[0][0] for name, numbers in good.items()}


def _resting(signal: Signal, field: SignalField) -> float:
    """What a signal that nothing is mapped to carries: its start value, else zero or the nearest allowed value."""
    nothing = min(max(0.0, field.minimum), field.maximum)
    raw = (nothing - field.offset) / field.scale if signal.raw_initial is None else signal.raw_initial
    if field.is_float:
        return raw
    lowest, highest = field.raw_range()
    return round(min(max(raw, lowest), highest))


def _turns(field: SignalField, count: int) -> Raw:
    """What a rolling counter carries in successive frames."""
    lowest, highest = field.raw_range()
    return np.array([lowest + turn % (highest - lowest + 1) for turn in range(count)])


def _raw_values(field: SignalField, physical: Floats) -> Raw:
    """Physical values → raw ones, kept within the DBC's range and the signal's bits."""
    if field.is_float:
        return (np.clip(physical, field.minimum, field.maximum) - field.offset) / field.scale
    raw = np.clip(np.rint((physical - field.offset) / field.scale), *field.raw_range())
    return raw.astype(np.int64 if field.is_signed else np.uint64)


def _error_code(field: SignalField) -> float:
    """The raw value that stands for "no measurement": the DBC's own, else all bits set."""
    if field.not_available:
        return min(field.not_available)
    if field.is_float:
        return nan
    return -1 if field.is_signed else (1 << field.length) - 1


def put(payload: Bytes, field: SignalField, raw: Raw) -> None:
    """Write raw values into the bits of their signal; payload has shape (frames, bytes)."""
    if field.is_float:
        raw = raw.astype(f"f{field.length // 8}").view(f"i{field.length // 8}")
    for k, place in enumerate(_bit_places(field)):
        payload[:, place // 8] |= ((raw >> k & 1) << place % 8).astype(np.uint8)


def _bit_places(field: SignalField) -> list[int]:
    """Where each bit stands in the payload (8 · byte + bit, bit 0 the least significant), from the least one on.

    A big-endian signal (Motorola) ends at its least significant bit, and counts from bit 7 of a byte down.
    """
    if not field.is_big_endian:
        return [*range(field.end - field.length, field.end)]
    return [8 * (n // 8) + 7 - n % 8 for n in range(field.end - 1, field.end - field.length - 1, -1)]
