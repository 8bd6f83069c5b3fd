"""What is wrong with a file, and what stands in it, in words for people."""

import re
import struct

_CSV_COLUMNS = "timestamp, arbitration_id, extended, remote, error, dlc, data"
_NO_NUMBER = re.compile(
    r"(invalid literal for int\(\) with base (?P<base>\d+)|could not convert string to float): (?P<got>.*)", re.DOTALL
)
_OF_PYTHON = LookupError | NameError | AttributeError | TypeError | OverflowError | UnicodeError
_OPEN_FILE = re.compile(r"'?<_io\.\w+[^>]*>'?|\bFrom_FileLike\.mf4\b")  # as asammdf names what it was given


def what_is_wrong(error: Exception) -> str:
    """What a reader found wrong, in words that tell more than Python's own."""
    text = str(error)
    if isinstance(error, struct.error | EOFError):
        return "it ends in the middle"
    if isinstance(error, _OF_PYTHON) or not text:  # what a reader did not expect, or has no word for
        return "its parts do not fit together"
    if number := _NO_NUMBER.fullmatch(text):
        return f"expected a {'hexadecimal ' if number['base'] == '16' else ''}number, got {printable(number['got'])}"
    if "values to unpack" in text:
        return f"expected {_CSV_COLUMNS}, as python-can writes them"
    return printable(_OPEN_FILE.sub("it", text))


def printable(text: str) -> str:
    """Return the beginning of a text of unknown origin as one line."""
    line = " ".join(text.split())[:80]
    return "".join(character if character.isprintable() else "?" for character in line)
