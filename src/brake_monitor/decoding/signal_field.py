"""The layout of mapped signals: where each lies in a frame, and what its raw number means.

What cantools knows of it is turned into plain integers once, so that decoding a frame touches only the signals that are
mapped.
"""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from math import ceil, floor, inf, isfinite, nan, prod
from sys import float_info

from cantools.database.can import Message, Signal

from brake_monitor.decoding.raw_number import FLOAT_FORMATS, extent, integers, raw_of
from brake_monitor.errors import InputError
from brake_monitor.nearest import nearest

_CYCLE_MS = 0.1, 86.4e6  # no bus is faster; what comes less often than once a day has no cycle

# In the languages that such tables are written in: English, German, French.
_NOT_AVAILABLE = re.compile(
    r"not[\s_-]*(avail|valid)|unavail|(?<![a-z])sna(?![a-z])|(?<![a-z])n/a(?![a-z])|invalid|error"
    r"|nicht[\s_-]*(verf(ü|ue)gbar|g(ü|ue)ltig)|ung(ü|ue)ltig|fehler"
    r"|non[\s_-]*(disponible|valide)|indisponible|erreur",
    re.IGNORECASE,
)
# What has no error may have a short name between, as in "no CAN error", or be one word with it: "kein Sammelfehler".
_ALL_IS_WELL = re.compile(
    r"(?<![a-z])((no|not|without|ohne|pas|sans)[\s_-]*([a-z]{1,3}[\s_-]+|an?|d['’])?(error|invalid|fehler|erreur)"
    r"|keine?[\s_-]*([a-z]{1,3}[\s_-]+)?[a-zäöüß]*fehler)|(error|fehler)[\s_-]*(free|frei)",
    re.IGNORECASE,
)


class Presence(Enum):
    """Whether a frame carries a multiplexed signal."""

    THERE = "there"
    ON_OTHER_PAGE = "on another page"
    UNKNOWN_PAGE = "the multiplexer's number is none that the DBC describes"
    CUT_OFF = "the frame ends before the multiplexer"


@dataclass(frozen=True, slots=True)
class SignalField:
    """Where one signal lies in a frame and what its raw number means.

    `raw_of(data)` gives the raw number, or None when the frame is too short to hold all of it. The signal is
    there only when every multiplexer in `conditions` has one of the values beside it.
    """

    name: str
    length: int  # bits
    end: int  # the bit past its last, counted along the bytes in its own bit order
    is_big_endian: bool
    is_signed: bool
    is_float: bool
    scale: float  # physical = raw * scale + offset
    offset: float
    minimum: float  # physical, wider than in the DBC by what is rounded; -inf and inf when it gives no range
    maximum: float
    not_available: frozenset[int]  # raw values whose label in the value table says so
    conditions: tuple["MultiplexerCondition", ...]
    raw_of: Callable[[bytes], float | None]

    def presence(self, data: bytes) -> "Presence":
        """Return whether a frame carries the signal, by its multiplexers."""
        for condition in self.conditions:
            page = condition.multiplexer.raw_of(data)
            if page is None:
                return Presence.CUT_OFF
            if page not in condition.pages:
                return Presence.ON_OTHER_PAGE if page in condition.known_pages else Presence.UNKNOWN_PAGE
        return Presence.THERE

    def raw_range(self) -> tuple[int, int]:
        """Return the lowest and highest raw number of an integer: the DBC's range, else what fits."""
        ends = sorted((bound - self.offset) / self.scale for bound in (self.minimum, self.maximum))
        least, most = integers(self.length, self.is_signed)
        low, high = (min(max(end, least), most) for end in ends)
        return ceil(low), floor(high)


@dataclass(frozen=True, slots=True)
class MultiplexerCondition:
    """The signal is there when the multiplexer's raw number is in `pages`."""

    multiplexer: SignalField
    pages: frozenset[int]
    known_pages: frozenset[int]  # all that the message describes


def signal_field(message: Message, name: str) -> SignalField:
    """Compile one signal of a message; InputError when it is not there, ambiguous or impossible to decode."""
    return _field(message, _signal(message, name))


def _field(message: Message, signal: Signal, selected: frozenset[str] = frozenset()) -> SignalField:
    """Compile a signal, or a multiplexer that the signals named in `selected` hang on."""
    where = f'signal "{signal.name}" of message "{message.name}"'
    if signal.name in selected:
        raise InputError(f"{where} is a multiplexer that selects itself")
    first, last = extent(signal)
    if first < 0 or last > 8 * message.length:
        raise InputError(f"{where} does not fit: it ends at bit {last}, the message has {8 * message.length}")
    if signal.is_float and signal.length not in FLOAT_FORMATS:
        raise InputError(f"{where} is a floating-point number of {signal.length} bits, expected 16, 32 or 64")
    scale, offset = _double(where, "scale", signal.scale), _double(where, "offset", signal.offset)
    if not (isfinite(scale) and isfinite(offset)) or scale == 0:
        raise InputError(f"{where} has scale {signal.scale} and offset {signal.offset}, expected finite and not 0")
    minimum, maximum = _range(where, signal, scale, offset)
    codes = (code for code, label in (signal.choices or {}).items() if _says_not_available(str(label)))
    return SignalField(
        name=signal.name,
        length=signal.length,
        end=last,
        is_big_endian=signal.byte_order == "big_endian",
        is_signed=signal.is_signed,
        is_float=signal.is_float,
        scale=scale,
        offset=offset,
        minimum=minimum,
        maximum=maximum,
        not_available=frozenset(code for code in codes if _can_be(signal, code)),
        conditions=_conditions(message, signal, selected | {signal.name}),
        raw_of=raw_of(signal),
    )


def message_cycle_s(message: Message) -> float | None:
    """Return the time between two frames of a message, if the DBC knows it."""
    shortest, longest = _CYCLE_MS
    cycle_ms = message.cycle_time
    if not (isinstance(cycle_ms, int | float) and shortest <= cycle_ms <= longest):  # a DBC may define it as text
        return None
    return cycle_ms * 1e-3


def cycle_time_s(message: Message, field: SignalField) -> float | None:
    """Return the time between two frames that carry a signal, perhaps on one page of several, if the DBC knows it."""
    cycle_s = message_cycle_s(message)
    return cycle_s and cycle_s * prod(len(condition.known_pages) for condition in field.conditions)


def _signal(message: Message, name: str) -> Signal:
    found = [signal for signal in message.signals if signal.name == name]
    if not found:
        names = [signal.name for signal in message.signals]
        raise InputError(f'message "{message.name}" has no signal "{name}", {nearest(name, names)}')
    if len(found) > 1:
        raise InputError(f'signal "{name}" is ambiguous: message "{message.name}" has {len(found)} of that name')
    return found[0]


def _double(where: str, what: str, number: float) -> float:
    """Return a number of the DBC, which may have any number of digits, as the float that is calculated with."""
    try:
        return float(number)
    except OverflowError:
        digits = len(str(abs(number)))
        raise InputError(f"{where} has a {what} of {digits} digits, expected 308 at the most") from None


def _range(where: str, signal: Signal, scale: float, offset: float) -> tuple[float, float]:
    if signal.minimum is None or signal.maximum is None or signal.minimum >= signal.maximum:
        return -inf, inf  # "[0|0]" is how a DBC says that there is no range
    minimum, maximum = _double(where, "minimum", signal.minimum), _double(where, "maximum", signal.maximum)
    if not signal.is_float:
        return minimum - 0.5 * abs(scale), maximum + 0.5 * abs(scale)
    least, most = (_nearest_float(signal.length, (end - offset) / scale) * scale + offset for end in (minimum, maximum))
    return min(minimum, least), max(maximum, most)


def _nearest_float(length: int, number: float) -> float:
    """The nearest that so many bits can tell; NaN where they cannot."""
    try:
        nearest_float: float = struct.unpack(FLOAT_FORMATS[length], struct.pack(FLOAT_FORMATS[length], number))[0]
    except OverflowError:
        return nan
    return nearest_float


def _says_not_available(label: str) -> bool:
    return bool(_NOT_AVAILABLE.search(label)) and not _ALL_IS_WELL.search(label)


def _can_be(signal: Signal, code: int) -> bool:
    """Whether a raw number of the value table is one that the signal can have."""
    if signal.is_float:
        return abs(code) <= float_info.max
    least, most = integers(signal.length, signal.is_signed)
    return least <= code <= most


def _conditions(message: Message, signal: Signal, selected: frozenset[str]) -> tuple[MultiplexerCondition, ...]:
    """The conditions for a signal to be there: its multiplexer's page, after those above with extended multiplexing.

    In this order: of a frame on another page of those above the bits of the lower one are something else.
    """
    if signal.multiplexer_signal is None or signal.multiplexer_ids is None:
        return ()
    multiplexer = _field(message, _signal(message, signal.multiplexer_signal), selected)
    siblings = (s for s in message.signals if s.multiplexer_signal == multiplexer.name)
    known = frozenset(page for sibling in siblings for page in sibling.multiplexer_ids or ())
    return *multiplexer.conditions, MultiplexerCondition(multiplexer, frozenset(signal.multiplexer_ids), known)
