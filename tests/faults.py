"""What may go wrong with a wagon's frames on their way to the monitor.

A fault takes all frames of a drive in the order of their arrival and gives them back changed. Its times count from the
drive's beginning; a frame's own time is when it arrived, so a frame that is late carries a later time.
"""

from collections.abc import Callable
from functools import cache
from itertools import count, pairwise
from math import inf

import numpy as np
from cantools.database import load_file
from cantools.database.can import Database

from brake_monitor.frame import Frame
from brake_monitor.settings.example_vehicles import example_config
from brake_monitor.simulator.simulate import EPOCH_S

Fault = Callable[[list[Frame]], list[Frame]]
Change = Callable[[float, float], float]  # (time, physical value) → physical value

SENSORS = {
    "vehicle speed": ("GNSS", "v_ground"),
    "wheel speed": ("WSP", "n_A"),
    "pressing force": ("BCU", "p_A"),
}
GATEWAY = (("GNSS", "v_ground"), ("WSP", "n_A"), ("WSP", "n_B"), ("BCU", "p_A"), ("BCU", "p_B"))
ERROR_CODE = {"v_ground": 65535, "n_A": 65534, "p_A": 65534}  # as wagon.dbc has them
BEYOND_RANGE = {"v_ground": 200.0, "n_A": 500.0, "p_A": 20.0}  # in the DBC's units


@cache
def database(vehicle: str = "wagon") -> Database:
    """An example vehicle's DBC, as cantools understands it."""
    loaded = load_file(example_config(vehicle).with_suffix(".dbc"))
    assert isinstance(loaded, Database)
    return loaded


def within(frame: Frame, from_s: float, to_s: float) -> bool:
    return from_s <= frame.time_s - EPOCH_S < to_s


def carries(frame: Frame, message: str, vehicle: str = "wagon") -> bool:
    described = database(vehicle).get_message_by_name(message)
    return (frame.can_id, frame.extended) == (described.frame_id, described.is_extended_frame)


def in_order(frames: list[Frame]) -> list[Frame]:
    return sorted(frames, key=lambda frame: frame.time_s)


def silence(from_s: float, to_s: float) -> Fault:
    """The whole bus says nothing."""
    return lambda frames: [frame for frame in frames if not within(frame, from_s, to_s)]


def lost(message: str, from_s: float, to_s: float, *, vehicle: str = "wagon") -> Fault:
    """One message is not sent."""
    return lambda frames: [f for f in frames if not (carries(f, message, vehicle) and within(f, from_s, to_s))]


def changed(
    message: str, signals: tuple[str, ...], change: Change, from_s: float, to_s: float, *, vehicle: str = "wagon"
) -> Fault:
    """The sensor says something else; counters and the rest of the frame go on."""
    described = database(vehicle).get_message_by_name(message)

    def rewritten(frame: Frame) -> Frame:
        values = described.decode(frame.data, decode_choices=False)
        for signal in signals:
            field = described.get_signal_by_name(signal)
            value = change(frame.time_s - EPOCH_S, values[signal])
            values[signal] = min(max(value, 0.0), field.scale * (2**field.length - 1))
        return frame._replace(data=described.encode(values, strict=False))

    return lambda frames: [
        rewritten(f) if carries(f, message, vehicle) and within(f, from_s, to_s) else f for f in frames
    ]


def signal_changed(sensor: str, change: Change, from_s: float, to_s: float) -> Fault:
    message, signal = SENSORS[sensor]
    return changed(message, (signal,), change, from_s, to_s)


def error_code(sensor: str, from_s: float, to_s: float) -> Fault:
    """The sender itself says that the value is no measurement."""
    message, signal = SENSORS[sensor]
    scale = database().get_message_by_name(message).get_signal_by_name(signal).scale
    return changed(message, (signal,), lambda _, __: ERROR_CODE[signal] * scale, from_s, to_s)


def beyond_range(sensor: str, from_s: float, to_s: float) -> Fault:
    message, signal = SENSORS[sensor]
    return changed(message, (signal,), lambda _, __: BEYOND_RANGE[signal], from_s, to_s)


def frozen(sensor: str, from_s: float, to_s: float) -> Fault:
    """The sensor repeats its last value; its control unit goes on counting."""
    message, signal = SENSORS[sensor]
    return told_again(message, signal, from_s, to_s)


def told_again(message: str, signal: str, from_s: float, to_s: float, *, vehicle: str = "wagon") -> Fault:
    """A value is told again and again; the rest of the frame goes on."""
    seen: list[float] = []

    def repeat(_: float, value: float) -> float:
        seen.append(value)
        return seen[0]

    return changed(message, (signal,), repeat, from_s, to_s, vehicle=vehicle)


def repeating_gateway(from_s: float, to_s: float) -> Fault:
    """A gateway tells all signals again that it was told last, in frames of its own that count on."""

    def repeat(frames: list[Frame]) -> list[Frame]:
        for message, signal in GATEWAY:
            frames = told_again(message, signal, from_s, to_s)(frames)
        return frames

    return repeat


def biased(sensor: str, factor: float, from_s: float = 0.0) -> Fault:
    return signal_changed(sensor, lambda _, value: factor * value, from_s, inf)


def spiking(sensor: str, by: float, every: int = 17) -> Fault:
    """A single reading in so many is off; an unsigned signal then says zero at the least."""
    readings = count()
    return signal_changed(sensor, lambda _, value: value + by * (next(readings) % every == 0), 0.0, inf)


def scattered(sensor: str, by: float, share: float, seed: int) -> Fault:
    """Readings here and there are off by so much, up or down: now and then two or three of them in a row."""
    rng = np.random.default_rng(seed)
    return signal_changed(sensor, lambda _, value: value + by * (rng.random() < share) * rng.choice((-1, 1)), 0.0, inf)


def noisy(message: str, signals: tuple[str, ...], std: float, from_s: float) -> Fault:
    """Readings that go to and fro, each on its own: too wide a gap, a shield that is open."""
    rng = np.random.default_rng(0)
    return changed(message, signals, lambda _, value: value + rng.normal(0.0, std), from_s, inf)


def stuck(message: str, from_s: float, to_s: float) -> Fault:
    """The control unit repeats its last frame, counter included."""

    def repeat(frames: list[Frame]) -> list[Frame]:
        data, found = b"", []
        for frame in frames:
            if not carries(frame, message):
                found.append(frame)
                continue
            data = data if within(frame, from_s, to_s) else frame.data
            found.append(frame._replace(data=data))
        return found

    return repeat


def lagging(message: str, lag_s: float) -> Fault:
    """The sensor filters or waits, and says so to nobody."""
    return lambda frames: in_order([f._replace(time_s=f.time_s + lag_s) if carries(f, message) else f for f in frames])


def jittered(message: str, most_s: float) -> Fault:
    """Each frame of one message waits in a queue for up to most_s; the queue keeps its order."""

    def delay(frames: list[Frame]) -> list[Frame]:
        rng, last_s, found = np.random.default_rng(8), 0.0, []
        for frame in frames:
            if not carries(frame, message):
                found.append(frame)
                continue
            last_s = max(last_s + 1e-4, frame.time_s + rng.uniform(0.0, most_s))
            found.append(frame._replace(time_s=round(last_s, 6)))
        return in_order(found)

    return delay


def duplicated(share: float) -> Fault:
    """A gateway sends some frames twice."""
    rng = np.random.default_rng(9)
    return lambda frames: [copy for frame in frames for copy in [frame] * (1 + (rng.random() < share))]


def swapped(share: float) -> Fault:
    """Some frames are handed over after their successor, with their own times."""

    def swap(frames: list[Frame]) -> list[Frame]:
        rng, found = np.random.default_rng(10), list(frames)
        for k, _ in enumerate(pairwise(frames)):
            if rng.random() < share:
                found[k], found[k + 1] = found[k + 1], found[k]
        return found

    return swap


def clock_set(at_s: float, by_s: float) -> Fault:
    """The clock that stamps the frames is set, by so much."""
    return lambda frames: [f if within(f, 0.0, at_s) else f._replace(time_s=round(f.time_s + by_s, 6)) for f in frames]
