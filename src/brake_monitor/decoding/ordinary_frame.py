"""The short cut for the ordinary frame: whole, of the DBC's length, every mapped signal in it good and called so.

For each message one function is compiled from its layout, with every number in its place:

    def ordinary(time_s, data):
        if len(data) != 8:
            return None
        little = from_bytes(data, "little")
        raw0 = little & 0xffff
        physical0 = raw0 * 0.01
        raw1 = ...
        if not (-0.005 <= physical0 <= 400.005 and ...):
            return None
        value0 = physical0 * 0.62421972534332
        ...
        return [new(Sample, (time_s, quantity0, 0, value0, good)), ...]

It returns None for every other frame. What that one is worth is told by `MappedSignal.convert`, signal by signal;
both give the same numbers to the last bit, to which a test holds them.
"""

import struct
from collections.abc import Callable, Sequence
from math import inf, isfinite, isnan
from typing import Any

from brake_monitor.decoding.mapped_signal import MappedSignal
from brake_monitor.decoding.qualifier import Qualifier
from brake_monitor.decoding.raw_number import FLOAT_FORMATS
from brake_monitor.decoding.signal_field import SignalField
from brake_monitor.samples import Quality, Sample

OrdinaryFrame = Callable[[float, bytes], list[Sample] | None]

_LARGEST = 1.7976931348623157e308


def ordinary_frame(entries: Sequence[MappedSignal], length: int) -> OrdinaryFrame:
    """Compile the short cut of a message of `length` bytes; with multiplexed signals no frame is ordinary."""
    if any(entry.field.conditions for entry in entries):
        return lambda time_s, data: None
    names: dict[str, Any] = {"from_bytes": int.from_bytes, "new": tuple.__new__, "Sample": Sample, "good": Quality.GOOD}
    lines = [f"if len(data) != {length}: return None"]
    qualifiers = [entry.qualifier for entry in entries if entry.qualifier is not None]
    fields = [*(entry.field for entry in entries), *(qualifier.field for qualifier in qualifiers)]
    lines += [f'{order} = from_bytes(data, "{order}")' for order in sorted({_byte_order(field) for field in fields})]
    conditions, results = _qualified(qualifiers, length, names), []
    for place, entry in enumerate(entries):
        names[f"quantity{place}"] = entry.channel.quantity
        lines += _values(place, entry, length, names)
        conditions += _conditions(place, entry, names)
        results.append(f"new(Sample, (time_s, quantity{place}, {entry.channel.wheelset}, value{place}, good))")
    if conditions:
        lines.append(f"if not ({' and '.join(conditions)}): return None")
    lines.append(f"return [{', '.join(results)}]")
    exec("def ordinary(time_s, data):\n    " + "\n    ".join(lines), names)  # made of numbers and of our own words
    compiled: OrdinaryFrame = names["ordinary"]
    return compiled


def _byte_order(field: SignalField) -> str:
    return "big" if field.is_big_endian else "little"


def _raw(field: SignalField, length: int, names: dict[str, Any]) -> str:
    """The raw number in terms of the frame's."""
    shift = 8 * length - field.end if field.is_big_endian else field.end - field.length
    raw = f"{_byte_order(field)} >> {shift} & {(1 << field.length) - 1:#x}"
    if field.is_float:
        size = field.length // 8
        names[f"float{size}"] = struct.Struct(FLOAT_FORMATS[field.length]).unpack
        raw = f"float{size}(({raw}).to_bytes({size}))[0]"
    elif field.is_signed:
        sign = 1 << (field.length - 1)
        raw = f"({raw} ^ {sign:#x}) - {sign:#x}"
    return raw


def _qualified(qualifiers: Sequence[Qualifier], length: int, names: dict[str, Any]) -> list[str]:
    """What must hold for the values to be called good; once where one qualifier tells of several."""
    conditions: dict[str, None] = {}
    for qualifier in qualifiers:
        good = ", ".join(map(str, sorted(qualifier.good)))
        conditions[f"({_raw(qualifier.field, length, names)}) in {{{good}}}"] = None
    return list(conditions)


def _values(place: int, entry: MappedSignal, length: int, names: dict[str, Any]) -> list[str]:
    """The lines from the frame's number to the SI value, those left out that change nothing."""
    field = entry.field
    offset = f" + {field.offset!r}" if field.offset else ""
    bias = f" + {entry.bias!r}" if entry.bias else ""
    lines = [
        f"raw{place} = {_raw(field, length, names)}",
        f"physical{place} = raw{place} * {field.scale!r}{offset}",
        f"value{place} = physical{place} * {entry.gain!r}{bias}",
    ]
    if entry.is_flag:
        lines.append(f"if value{place} != 0.0 and value{place} != 1.0: return None")
    if entry.minimum > -inf:
        lines.append(f"if value{place} < {entry.minimum!r}: value{place} = {entry.minimum!r}")
    if entry.maximum < inf:
        lines.append(f"if value{place} > {entry.maximum!r}: value{place} = {entry.maximum!r}")
    return lines


def _conditions(place: int, entry: MappedSignal, names: dict[str, Any]) -> list[str]:
    """What must hold for the value to be good, those left out that always do."""
    field = entry.field
    conditions = []
    least, greatest = max(field.minimum, -_LARGEST), min(field.maximum, _LARGEST)
    if field.is_float or isfinite(field.minimum) or isfinite(field.maximum):
        conditions.append(f"{least!r} <= physical{place} <= {greatest!r}")
    if not isnan(entry.no_data_from):
        conditions.append(f"raw{place} < {entry.no_data_from!r}")
    missed = {raw for raw in field.not_available if least <= raw * field.scale + field.offset <= greatest}
    if missed:
        names[f"not_available{place}"] = frozenset(missed)
        conditions.append(f"raw{place} not in not_available{place}")
    return conditions
