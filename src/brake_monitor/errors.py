"""The two ways a command can fail; both carry one clear sentence for the person at the terminal."""

import re

_LONG_WORD = re.compile(r"\S{300,}")  # longer than any file's own name
_KEPT = 60  # characters of its beginning, and of its end


def brief(sentence: str) -> str:
    """The sentence with a long name or value in it cut in the middle, so that what is wrong with it stays in sight."""
    return _LONG_WORD.sub(lambda found: f"{found[0][:_KEPT]}...{found[0][-_KEPT:]}", sentence)


class BrakeMonitorError(Exception):
    """Base of every error that this package raises on purpose; never shown with a traceback."""

    exit_code = 1

    def __str__(self) -> str:
        """The sentence, without characters that a terminal would obey: the names in it may hold any."""
        sentence = brief(super().__str__())
        if sentence.isprintable():
            return sentence
        return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in sentence)


class InputError(BrakeMonitorError):
    """Bad usage, configuration, DBC, log or option: names the file, key or line and what was expected."""

    exit_code = 2


class WorkError(BrakeMonitorError):
    """The input was good, and yet the work failed (bus gone, disk full, session refused)."""

    exit_code = 1
