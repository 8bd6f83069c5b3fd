"""A file that appears whole or not at all, whatever interrupts its writing."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from brake_monitor.errors import WorkError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a neighbour of `path` with the same suffixes to write to; it takes the place of `path` when complete.

    Raises WorkError when the disk does not let it be written.
    """
    try:
        is_directory, is_special = path.is_dir(), path.exists() and not path.is_file()
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error
    if is_directory:
        raise WorkError(f"{path}: cannot be written: it is a directory")
    # A device or a pipe is not replaced. Two processes may write the same file: the last one's stays, whole.
    part = path if is_special else path.with_name(f".part-{os.getpid()}-{path.name}")
    try:
        yield part
        if not is_special:
            part.replace(path)
    except BrokenPipeError:  # who read a pipe went away
        raise
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        if not is_special:
            part.unlink(missing_ok=True)
