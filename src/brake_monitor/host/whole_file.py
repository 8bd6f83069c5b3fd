"""A file that appears whole or not at all, whatever interrupts its writing."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from brake_monitor.errors import WorkError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a neighbour of `path` with the same suffixes to write to; it takes the place of `path` when complete.

    A link stays one: what it leads to is written.
    Raises WorkError when the disk does not let it be written.
    """
    try:
        is_directory, place = path.is_dir(), _followed(path)
        # A device, a pipe or what some process has open is not replaced.
        is_special = place.is_symlink() or (place.exists() and not place.is_file())
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error
    if is_directory:
        raise WorkError(f"{path}: cannot be written: it is a directory")
    # Two processes may write the same file: the last one's stays, whole.
    part = place if is_special else place.with_name(f".part-{os.getpid()}-{path.name}")
    try:
        yield part
        if not is_special:
            part.replace(place)
    except BrokenPipeError:  # the reader of a pipe went away
        raise
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if not is_special:
            part.unlink(missing_ok=True)


def _followed(path: Path) -> Path:
    """Follow links to the file to write; links of the system, such as /dev/stdout, do not lead to a file name."""
    with suppress(FileNotFoundError):
        path.stat()  # OSError where links lead in a circle
    place = path.parent.resolve() / path.name
    if place.is_symlink() and not place.is_relative_to("/dev") and not place.is_relative_to("/proc"):
        return _followed(place.parent / place.readlink())
    return place
