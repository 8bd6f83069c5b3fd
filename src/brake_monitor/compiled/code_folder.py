"""The folder on disk for machine code."""

from functools import cache
from hashlib import sha256
from importlib.metadata import version
from os import environ
from pathlib import Path


@cache
def folder() -> Path:
    """The folder for this version of our sources and of numba; OSError where there can be none.

    numba itself would notice changes in the outermost function's source alone.
    """
    cache_folder = _cache_folder()
    tag = sha256(version("numba").encode())
    for source in sources():
        tag.update(source.read_bytes())
    return cache_folder / "brake-monitor" / tag.hexdigest()[:16]


def sources() -> list[Path]:
    """All source files that machine code may depend on."""
    package = Path(__file__).parents[1]
    patterns = ("*.py", "estimation/**/*.py", "compiled/*.py")
    return [source for pattern in patterns for source in sorted(package.glob(pattern))]


def _cache_folder() -> Path:
    if directory := environ.get("XDG_CACHE_HOME"):
        return Path(directory)
    try:
        return Path.home() / ".cache"
    except RuntimeError as error:  # a user without a home
        raise FileNotFoundError(str(error)) from None
