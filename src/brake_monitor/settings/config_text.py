"""The text of a configuration file, and how its faults are told: file, line, key, and what was expected."""

import re
import tomllib
from importlib.resources import files
from pathlib import Path
from typing import Any, NoReturn, Self

from brake_monitor.errors import InputError
from brake_monitor.nearest import nearest_file
from brake_monitor.settings.toml_lines import KeyPath, key_lines, line_of

EXAMPLES_FOLDER = Path(str(files("brake_monitor"))) / "vehicles"
LARGEST = 10_000_000  # bytes; a device may have no end
_LARGEST_SHOWN = 10**40
_LONGEST_SHOWN = 100  # characters of a text
_MOST_DIGITS = 4300  # of a whole number that Python reads
_MORE_DIGITS = re.compile(rf"\d[\d_]{{{_MOST_DIGITS},}}")
_PLAINER = {  # than tomllib's own
    "Illegal character '\\n'": "a text in quotes does not end on its line",
    "Invalid value": "expected a number, true, false, or a text in quotes",
}
_BROKEN_TABLE = ("Invalid initial character for a key part", "Unclosed inline table")
_DECIMAL_COMMA = re.compile(r"=\s*[+-]?\d+,\d")


class ConfigText:
    """Knows where each key stands, and refuses what must not be there."""

    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._text = text
        self._lines: dict[KeyPath, int] = {}

    @classmethod
    def read(cls, path: Path) -> Self:
        """From a file; InputError when it cannot be read."""
        try:
            with path.open("rb") as file:
                content = file.read(LARGEST + 1)
        except OSError as error:
            hint = nearest_file(path)
            if isinstance(error, FileNotFoundError) and not hint:
                hint = f"; example vehicles are in {EXAMPLES_FOLDER}"
            raise InputError(f"{path}: cannot be read: {error.strerror}{hint}") from None
        if len(content) > LARGEST:
            raise InputError(f"{path}: expected a configuration in TOML, this has more than {LARGEST // 10**6} MB")
        try:
            return cls(path, content.decode("utf-8-sig").replace("\r\n", "\n"))
        except UnicodeDecodeError as error:
            line = content.count(b"\n", 0, error.start) + 1
            raise InputError(f"{path}:{line}: expected a configuration in TOML, this is not text in UTF-8") from None

    def table(self) -> dict[str, Any]:
        """What it says; InputError when it is not TOML."""
        try:
            table = tomllib.loads(self._text)
            self._lines = key_lines(self._text)
        except tomllib.TOMLDecodeError as error:
            place = re.search(r"^(.*) \(at (?:line (\d+), column \d+|end of document)\)$", str(error))
            last = self._text.count("\n") + 1
            what, line = (place[1], int(place[2] or last)) if place else (str(error), 1)
            sentence = _in_words(what, self._text.split("\n")[line - 1])
            raise InputError(f"{self._path}:{line}: not valid TOML: {sentence}") from None
        except RecursionError:
            raise InputError(f"{self._path}: not valid TOML: nested too deeply") from None
        except ValueError:  # tomllib's own are those above
            number = _MORE_DIGITS.search(self._text)
            line = self._text.count("\n", 0, number.start()) + 1 if number else 1
            sentence = f"expected numbers of {_MOST_DIGITS} digits at the most"
            raise InputError(f"{self._path}:{line}: {sentence}") from None
        return table

    def refuse(self, key: KeyPath, sentence: str) -> NoReturn:
        """InputError about what stands at a key."""
        raise InputError(f"{self.place_of(key)}: {_dotted(self._as_written(key))}: {sentence}")

    def place_of(self, key: KeyPath) -> str:
        """FILE:LINE of a key, or of the nearest table above it."""
        return f"{self._path}:{line_of(self._lines, self._as_written(key))}"

    def _as_written(self, key: KeyPath) -> KeyPath:
        """Without places that are not in the text: what was given once was made a list."""
        written: KeyPath = ()
        for part in key:
            if not isinstance(part, int) or (*written, part) in self._lines:
                written = (*written, part)
        return written


def place_of(path: Path, key: KeyPath) -> str:
    """Return "FILE:LINE" of a key in a configuration that was loaded, for what is found wrong with it later."""
    try:
        text = ConfigText.read(path)
        text.table()
        return text.place_of(key)
    except (InputError, IndexError, ValueError):  # the file has changed since, or never existed
        return f"{path}"


def one_of(names: Any) -> str:
    """The names that may be chosen from."""
    return "one of " + ", ".join(f'"{name}"' for name in sorted(names))


def shown(value: Any) -> str:
    """Render a found value as its author wrote it, or say what it is where that would be long."""
    match value:
        case dict():
            return "a table"
        case list():
            return "a list"
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"' if len(value) <= _LONGEST_SHOWN else f'"{value[:_LONGEST_SHOWN]}..."'
        case int() if abs(value) > _LARGEST_SHOWN:
            return "a number of more than 40 digits"
        case _:
            return str(value)


def _in_words(what: str, line: str) -> str:
    """What tomllib says, put better where it would not help the author of the line."""
    name = line.partition("=")[0].strip()
    if what == "Cannot overwrite a value":
        return f"{name} stands twice" + (", once without [[ ]]" if name.startswith("[[") else "")
    if re.fullmatch(r"Cannot declare \(.*\) twice", what):
        return f"the table {name} stands twice"
    if _DECIMAL_COMMA.search(line):
        return "expected a decimal point, not a comma"
    if what in _BROKEN_TABLE and line.count("{") > line.count("}"):
        return "what stands in { } has to stand on one line"
    return _PLAINER.get(what, what)


def _dotted(key: KeyPath) -> str:
    """vehicle.mass_kg, signals.axle_speed[2].unit: places are counted from 1 like wheelsets."""
    return "".join(f"[{part + 1}]" if isinstance(part, int) else f".{part}" for part in key).lstrip(".")
