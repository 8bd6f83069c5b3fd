"""The DBC files of a bus, as cantools reads and checks them, and what is wrong in them."""

import logging
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from decimal import InvalidOperation
from pathlib import Path

from cantools.database import load_string
from cantools.database.can import Database, Message
from cantools.database.errors import Error as CantoolsError

from brake_monitor.errors import InputError
from brake_monitor.nearest import nearest
from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_text import place_of

# What cantools raises on text that is not a DBC, besides its own errors.
_PARSER_ERRORS = (CantoolsError, ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)

logging.getLogger("cantools").setLevel(logging.ERROR)  # it warns of doubles as it loads them; `_doubles` tells of them

_LARGEST = 50_000_000  # bytes; those of whole vehicles have a tenth of it, a recording given by mistake has more
# A frame has 64 bytes at the most, what transport protocols put together 4095. cantools sets aside as much as a message
# or a signal is written to have, and takes time by the square of it: of a wrong digit it would never come to an end.
_MOST_BYTES = 4095
_MOST_PAGES = 65536  # of a multiplexer that one signal is on
_MESSAGE_LENGTH = re.compile(r"\bBO_\s+\d+\s+(\w+)\s*:\s*(\d+)")
_SIGNAL_PLACE = re.compile(r"\bSG_\s+(\w+)[^:\n]*:\s*(\d+)\s*\|\s*(\d+)")
_MESSAGE_OR_PAGED = re.compile(r"\b(?:BO_\s+\d+\s+(\w+)|SG_\s+(\w+)\s+m\d+M?\s*:)")
_SIGNAL_PAGES = re.compile(r"\bSG_MUL_VAL_\s+\d+\s+(\w+)\s+\w+([\d\s,-]+);")
_NO_INTEGER = re.compile(r"invalid literal for int\(\) with base 10: (.*)")
_PAGE_RANGE = re.compile(r"(\d+)\s*-\s*(\d+)")

_TEXT = re.compile(r'"(?:[^"\\]|\\.?)*+(?:"|\Z)', re.DOTALL)  # units and comments
# Where editors keep signals that no message has any more; cantools leaves it out.
_HOMELESS_ID = "3221225472"
_HOMELESS = re.compile(r"^BO_[ \t]+\d+[ \t]+VECTOR__INDEPENDENT_SIG_MSG\b.*(?:\n[ \t]*SG_\s.*)*", re.MULTILINE)
# Where a line cannot be read cantools puts a mark into it, and shows all of the line.
_HERE = ">>!<<"
_SHOWN = 80  # characters, to each side of the mark
# What is said of a signal that no message has: newer cantools refuse the file for it, and list all that there is.
_ORPHANS = re.compile(r"(VAL_|SIG_VALTYPE_) (\d+) (\w+)")
_ENTRY = re.compile(r'^[ \t]*(VAL_|SIG_VALTYPE_)\s+(\d+)\s+(\w+)\b(?:[^;"]|"(?:[^"\\]|\\.)*")*+;', re.MULTILINE)


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


def load_buses(settings: Settings) -> dict[str, BusDatabase]:
    """The DBC files of each bus, by its name; InputError also says where the configuration names a bad one."""
    several, databases = len(settings.can) > 1, {}
    for place, bus in enumerate(settings.can):
        try:
            databases[bus.name] = load_bus(bus.name, bus.dbc)
        except InputError as error:
            line = place_of(settings.path, ("can", place, "dbc"))
            raise InputError(f"{line}: can{f'[{place + 1}]' if several else ''}.dbc: {error}") from None
    return databases


def load_bus(bus: str, paths: Iterable[Path]) -> BusDatabase:
    """Read the DBC files of a bus; InputError names the file and what is wrong with it.

    A file that is readable but not consistent (a signal that does not fit its message, two that overlap) is kept
    with a remark: real files have such places, and `signal_field` refuses a mapped signal that does not fit.
    """
    files, remarks = [], []
    for path in paths:
        text = _read(path)
        if not text.strip():
            raise InputError(f"{path}: expected a DBC file, this is empty")
        if what := next(_immense(text), None):
            raise InputError(f"{path}: {what}")
        try:
            file, orphans = _parse(text, strict=True)
        except _PARSER_ERRORS as strict_error:
            try:
                file, orphans = _parse(text, strict=False)
            except _PARSER_ERRORS:
                raise InputError(f"{path}: not a DBC file that can be read: {_one_line(strict_error)}") from None
            remarks.append(f"{path}: {_one_line(strict_error)}")
        if not file.messages:
            raise InputError(f"{path}: not a DBC file that can be used: it describes no message")
        remarks += [
            f"{path}: {remark}"
            for remark in (*orphans, *_losses(text, file), *_without_page(text, file), *_doubles(file))
        ]
        files.append((path, file))
    return BusDatabase(bus, tuple(files), tuple(remarks))


def _read(path: Path) -> str:
    try:
        if path.is_fifo():  # it would be waited for, perhaps for ever
            raise InputError(f"{path}: expected a DBC file, this is a pipe")
        with path.open("rb") as file:
            data = file.read(_LARGEST + 1)
    except FileNotFoundError as error:
        hint = nearest(path.name, sorted(other.name for other in path.parent.glob("*.dbc")))
        raise InputError(f"{path}: cannot be read: {error.strerror}; of DBC files {hint}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None
    if len(data) > _LARGEST:
        raise InputError(f"{path}: expected a DBC file, this has more than {_LARGEST // 10**6} MB")
    if data.startswith((BOM_UTF16_LE, BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:  # older editors wrote the Windows code page
        return data.decode("cp1252", errors="replace")


def _parse(text: str, strict: bool) -> tuple[Database, list[str]]:
    """What the text describes, and what of it was left out."""
    try:
        file = load_string(text, database_format="dbc", strict=strict)
    except CantoolsError as error:
        rest, orphans = _without_orphans(text, str(error))
        if rest == text:
            raise
        file, more = _parse(rest, strict)
        return file, orphans + more
    assert isinstance(file, Database)  # load_string also knows a format for diagnostics
    return file, []


def _without_orphans(text: str, said: str) -> tuple[str, list[str]]:
    """The text without the entries that cantools says are unused, and a remark on each that an editor did not keep."""
    orphans = dict.fromkeys(_ORPHANS.findall(said)) if "unused" in said else {}
    rest = _ENTRY.sub(lambda entry: "" if entry.groups() in orphans else entry[0], text) if orphans else text
    told = [" ".join(orphan) for orphan in orphans if orphan[1] != _HOMELESS_ID]
    return rest, [f"{orphan} is left out: no message has such a signal" for orphan in told]


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
    written = len(re.findall(r"^[ \t]*SG_\s", _HOMELESS.sub("", _TEXT.sub("", text)), re.MULTILINE))
    read = sum(len(message.signals) for message in file.messages)
    if read < written:
        yield f"{written - read} of {written} signals could not be read; is the file cut off?"


def _without_page(text: str, file: Database) -> Iterable[str]:
    """Tell of signals whose page is written but not the multiplexer: cantools takes them to be in every frame."""
    message, written = "", defaultdict[str, set[str]](set)
    for name, signal in _MESSAGE_OR_PAGED.findall(_TEXT.sub("", text)):
        message = name or message
        written[message].add(signal)
    for read in file.messages:
        names = [f'"{s.name}"' for s in read.signals if s.name in written[read.name] and not s.multiplexer_ids]
        if names:
            trouble = f'message "{read.name}" has no multiplexer, or several, for the page of {" and ".join(names)}'
            yield f"{trouble}: taken from every frame"


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
    cause = getattr(error, "e_dbc", None) or error  # cantools tries several formats, and tells what each made of it
    if isinstance(cause, KeyError):  # of one of its own tables: all that it says is the name
        return f"it uses {cause}, which it does not define"
    if isinstance(cause, InvalidOperation):  # of these it says what Python says, which names nothing in the file
        return "an attribute that it defines as a number (INT, HEX or FLOAT) is given something else"
    if isinstance(cause, IndexError):
        return "a number points beyond a list, as that of an attribute (ENUM) with fewer choices"
    if no_integer := _NO_INTEGER.fullmatch(str(cause)):
        return f"expected a whole number, got {no_integer[1]}"
    line = _shortened(" ".join(str(cause).split()))
    return "".join(c if c.isprintable() else "?" for c in line)  # a terminal obeys some of what a binary file holds


def _shortened(line: str) -> str:
    """What cantools says, of the line that it shows no more than what is next to its mark."""
    before, here, rest = line.partition(_HERE)
    if not here:
        return line
    where, quote, read = before.partition('"')
    read = read if len(read) <= _SHOWN else f"…{read[-_SHOWN:]}"
    rest = rest if len(rest) <= _SHOWN else f'{rest[:_SHOWN]}…"'
    return f"{where}{quote}{read}{here}{rest}"


def _hex(message: Message) -> str:
    return f"{message.frame_id:#x}"
