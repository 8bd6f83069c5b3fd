"""DBC files → the layout of mapped signals: where each lies in a frame, and what its raw number means.

cantools reads and checks the file; what it knows of a signal's layout is turned into plain integers once,
so that decoding a frame touches only the signals that are mapped.
"""

import logging
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from enum import Enum
from math import ceil, floor, inf, isfinite, prod
from pathlib import Path
from sys import float_info

from cantools.database import load_string
from cantools.database.can import Database, Message, Signal
from cantools.database.errors import Error as CantoolsError

from brake_monitor.decoding.raw_number import FLOAT_FORMATS, extent, integers, raw_of
from brake_monitor.errors import InputError
from brake_monitor.nearest import nearest

# What cantools raises on text that is not a DBC, besides its own errors.
_PARSER_ERRORS = (CantoolsError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)

logging.getLogger("cantools").setLevel(logging.ERROR)  # it warns of doubles as it loads them; `_doubles` tells of them

# A frame has 64 bytes at the most, what transport protocols put together 4095. cantools sets aside as much as a message
# or a signal is written to have, and takes time by the square of it: of a wrong digit it would never come to an end.
_MOST_BYTES = 4095
_MOST_PAGES = 65536  # of a multiplexer that one signal is on
_MESSAGE_LENGTH = re.compile(r"\bBO_\s+\d+\s+(\w+)\s*:\s*(\d+)")
_SIGNAL_PLACE = re.compile(r"\bSG_\s+(\w+)[^:\n]*:\s*(\d+)\s*\|\s*(\d+)")
_SIGNAL_PAGES = re.compile(r"\bSG_MUL_VAL_\s+\d+\s+(\w+)\s+\w+([\d\s,-]+);")
_PAGE_RANGE = re.compile(r"(\d+)\s*-\s*(\d+)")

_CYCLE_MS = 0.1, 86.4e6  # no bus is faster; what comes less often than once a day has no cycle

# In the languages that such tables are written in: English, German, French.
_NOT_AVAILABLE = re.compile(
    r"not[\s_-]*avail|unavailable|(?<![a-z])sna(?![a-z])|(?<![a-z])n/a(?![a-z])|invalid|error"
    r"|nicht[\s_-]*verf(ü|ue)gbar|ung(ü|ue)ltig|fehler|non[\s_-]*disponible|indisponible|erreur",
    re.IGNORECASE,
)
_ALL_IS_WELL = re.compile(
    r"\b(no|not|without|keine?|ohne|pas|sans)[\s_-]*(an?[\s_-]*|d['’e][\s_-]*)?(error|invalid|fehler|erreur)|no_error"
    r"|(error|fehler)[\s_-]*(free|frei)",
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
    minimum: float  # physical, half an LSB wider than in the DBC for rounding; -inf and inf when it gives no range
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


@dataclass(frozen=True, slots=True)
class BusDatabase:
    """All DBC files of one bus."""

    bus: str
    files: tuple[tuple[Path, Database], ...]
    remarks: tuple[str, ...]  # what is wrong in the files without harming the signals that are mapped

    def message(self, name: str) -> Message:
        """Return the message of that name; InputError when there is none or more than one."""
        found = [(path, message) for path, file in self.files for message in file.messages if message.name == name]
        paths = ", ".join(str(path) for path, _ in self.files)
        if not found:
            names = [message.name for _, file in self.files for message in file.messages]
            raise InputError(f'{paths}: no message is named "{name}", {nearest(name, names)}')
        if len(found) > 1:
            places = " and ".join(f"{path} (id {_hex(message)})" for path, message in found)
            raise InputError(f'message "{name}" is ambiguous on bus "{self.bus}": it stands in {places}')
        return found[0][1]

    def file_of(self, message: Message) -> tuple[Path, Database]:
        """Return the file that describes a message of the bus."""
        return next((path, file) for path, file in self.files if any(other is message for other in file.messages))

    def double_of(self, message: Message, identity: Callable[[Message], object]) -> str | None:
        """Return the name of another message with the same identity on the bus, if there is one."""
        wanted = identity(message)
        others = (other for _, file in self.files for other in file.messages if other is not message)
        return next((other.name for other in others if identity(other) == wanted), None)


def load_bus(bus: str, paths: Iterable[Path]) -> BusDatabase:
    """Read the DBC files of a bus; InputError names the file and what is wrong with it.

    A file that is readable but not consistent (a signal that does not fit its message, two that overlap) is kept
    with a remark: real files have such places, and `signal_field` refuses a mapped signal that does not fit.
    """
    files, remarks = [], []
    for path in paths:
        text = _read(path)
        if what := next(_immense(text), None):
            raise InputError(f"{path}: {what}")
        try:
            file = _parse(text, strict=True)
        except _PARSER_ERRORS as strict_error:
            try:
                file = _parse(text, strict=False)
            except _PARSER_ERRORS:
                raise InputError(f"{path}: not a DBC file that can be read: {_one_line(strict_error)}") from None
            remarks.append(f"{path}: {_one_line(strict_error)}")
        if not file.messages:
            raise InputError(f"{path}: not a DBC file that can be used: it describes no message")
        remarks += [f"{path}: {remark}" for remark in (*_losses(text, file), *_doubles(file))]
        files.append((path, file))
    return BusDatabase(bus, tuple(files), tuple(remarks))


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
    minimum, maximum = _range(where, signal)
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


def _read(path: Path) -> str:
    try:
        data = path.read_bytes()
    except FileNotFoundError as error:
        hint = nearest(path.name, sorted(other.name for other in path.parent.glob("*.dbc")))
        raise InputError(f"{path}: cannot be read: {error.strerror}; of DBC files {hint}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # older editors wrote the Windows code page
        return data.decode("cp1252", errors="replace")


def _parse(text: str, strict: bool) -> Database:
    file = load_string(text, database_format="dbc", strict=strict)
    assert isinstance(file, Database)  # load_string also knows a format for diagnostics
    return file


def _immense(text: str) -> Iterator[str]:
    """Tell of sizes that no message has."""
    for name, length in _MESSAGE_LENGTH.findall(text):
        if _exceeds(length, _MOST_BYTES):
            yield f'message "{name}" is written to have {length:.20} bytes, expected {_MOST_BYTES} at the most'
    for name, *bits in _SIGNAL_PLACE.findall(text):
        if any(_exceeds(number, 8 * _MOST_BYTES) for number in bits):
            place = "|".join(f"{number:.20}" for number in bits)
            yield f'signal "{name}" is written to be at bits {place}, expected {8 * _MOST_BYTES} at the most'
    for name, pages in _SIGNAL_PAGES.findall(text):
        count = sum(max(float(last) - float(first), 0.0) for first, last in _PAGE_RANGE.findall(pages))
        if count > _MOST_PAGES:
            yield f'signal "{name}" is written to be on more than {_MOST_PAGES} pages of its multiplexer'


def _exceeds(digits: str, most: int) -> bool:
    """Whether a number that may have any number of digits is greater."""
    digits = digits.lstrip("0")
    return len(digits) > len(str(most)) or int(digits or "0") > most


def _losses(text: str, file: Database) -> Iterable[str]:
    """Tell what cantools passed over: it takes the end of a file that was cut off, or a damaged line, for nothing."""
    written = len(re.findall(r"^[ \t]*SG_\s", text, re.MULTILINE))
    read = sum(len(message.signals) for message in file.messages)
    if read < written:
        yield f"{written - read} of {written} signals could not be read; is the file cut off?"


def _doubles(file: Database) -> Iterable[str]:
    """Tell of names and identifiers that several messages have."""
    by_name: defaultdict[str, list[str]] = defaultdict(list)
    by_id: defaultdict[tuple[bool, int], list[str]] = defaultdict(list)
    for message in file.messages:
        by_name[message.name].append(_hex(message))
        by_id[message.is_extended_frame, message.frame_id].append(f'"{message.name}"')
    for name, ids in by_name.items():
        if len(ids) > 1:
            yield f'{len(ids)} messages are named "{name}": {" and ".join(ids)}'
    for (_, can_id), names in by_id.items():
        if len(names) > 1:
            yield f"{len(names)} messages have the id {can_id:#x}: {' and '.join(names)}"


def _one_line(error: BaseException) -> str:
    line = " ".join(str(error).removeprefix("DBC: ").split())
    return "".join(c if c.isprintable() else "?" for c in line)  # a terminal obeys some of what a binary file holds


def _hex(message: Message) -> str:
    return f"{message.frame_id:#x}"


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


def _range(where: str, signal: Signal) -> tuple[float, float]:
    if signal.minimum is None or signal.maximum is None or signal.minimum >= signal.maximum:
        return -inf, inf  # "[0|0]" is how a DBC says that there is no range
    tolerance = 0.0 if signal.is_float else 0.5 * abs(signal.scale)
    return _double(where, "minimum", signal.minimum) - tolerance, _double(where, "maximum", signal.maximum) + tolerance


def _says_not_available(label: str) -> bool:
    return bool(_NOT_AVAILABLE.search(label)) and not _ALL_IS_WELL.search(label)


def _can_be(signal: Signal, code: int) -> bool:
    """Whether a raw number of the value table is one that the signal can have."""
    if signal.is_float:
        return abs(code) <= float_info.max
    least, most = integers(signal.length, signal.is_signed)
    return least <= code <= most


def _conditions(message: Message, signal: Signal, selected: frozenset[str]) -> tuple[MultiplexerCondition, ...]:
    """The conditions for a signal to be there: its multiplexer's page and, with extended multiplexing, those above."""
    if signal.multiplexer_signal is None or signal.multiplexer_ids is None:
        return ()
    multiplexer = _field(message, _signal(message, signal.multiplexer_signal), selected)
    siblings = (s for s in message.signals if s.multiplexer_signal == multiplexer.name)
    known = frozenset(page for sibling in siblings for page in sibling.multiplexer_ids or ())
    return MultiplexerCondition(multiplexer, frozenset(signal.multiplexer_ids), known), *multiplexer.conditions
