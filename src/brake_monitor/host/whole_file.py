"""A file that appears whole or not at all, whatever interrupts its writing."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from brake_monitor.errors import InputError, WorkError


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """Give a neighbour of `path` with its last two suffixes to write to; it takes the place of `path` when complete.

    A link stays one: what it leads to is written.
    Raises WorkError when the disk does not let it be written.
    """
    with _saying_where(path):
        is_directory, target = path.is_dir(), _followed(path)
        is_special = _is_special(target)
    if is_directory:
        raise WorkError(f"{path}: cannot be written: it is a directory")
    # Two processes may write the same file: the last one's stays, whole. python-can takes all suffixes for the format.
    kind = "".join(path.suffixes[-2:])
    name = path.name.removesuffix(kind).replace(".", "_") + kind
    part = target if is_special else target.with_name(f".part-{os.getpid()}-{name}")
    try:
        with _saying_where(path):
            yield part
            if not is_special:
                part.replace(target)
    finally:
        if not is_special:
            with suppress(OSError):  # it has taken its place, or the disk takes no changes any more
                part.unlink()


def check_can_write(path: Path) -> None:
    """WorkError where `whole_file` could not even begin, which is better known before the work than after it."""
    with _saying_where(path):
        target = _followed(path)
        if not _is_special(target):
            TemporaryFile(dir=target.parent).close()


def check_can_write_in(folder: Path) -> None:
    """WorkError when the folder, or the one that it would be created in, takes no files."""
    with _saying_where(folder):
        there = next(place for place in (folder, *folder.parents) if place.exists())
        TemporaryFile(dir=there).close()


def make_folder(path: Path) -> None:
    """Create the folder where there is none; InputError when it is a file, WorkError when the disk does not let it."""
    if path.exists() and not path.is_dir():
        raise InputError(f"-o {path}: expected a directory, this is a file")
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise WorkError(f"{path}: cannot be created: {error.strerror}") from error
    check_can_write_in(path)


@contextmanager
def _saying_where(path: Path) -> Iterator[None]:
    """WorkError of whatever the system refuses."""
    try:
        yield
    except BrokenPipeError:  # the reader of a pipe went away
        raise
    except OSError as error:
        raise WorkError(f"{path}: cannot be written: {error.strerror or error}") from error


def _is_special(target: Path) -> bool:
    """Whether it is a device, a pipe or what some process has open, which is not replaced."""
    return target.is_symlink() or (target.exists() and not target.is_file())


def _followed(path: Path) -> Path:
    """Follow links to the file to write; links of the system, such as /dev/stdout, do not lead to a file name."""
    with suppress(FileNotFoundError):
        path.stat()  # OSError where links lead in a circle
    target = path.parent.resolve() / path.name
    if target.is_symlink() and not target.is_relative_to("/dev") and not target.is_relative_to("/proc"):
        return _followed(target.parent / target.readlink())
    return target
