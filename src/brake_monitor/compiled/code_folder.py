"""The folder on disk for machine code."""

from functools import cache
from hashlib import sha256
from importlib.metadata import version
from os import environ
from pathlib import Path


@cache
def folder() -> Path:
    """Where it is kept, for this very version of our sources and of numba; OSError where that can be nowhere."""
    cache_folder = _cache_folder()
    tag = sha256(version("numba").encode())
    package = Path(__file__).parents[1]
    for pattern in ("*.py", "estimation/*.py", "compiled/*.py"):
        for source in sorted(package.glob(pattern)):
            tag.update(source.read_bytes())
    return cache_folder / "brake-monitor" / tag.hexdigest()[:16]


def _cache_folder() -> Path:
    if directory := environ.get("XDG_CACHE_HOME"):
        return Path(directory)
    try:
        return Path.home() / ".cache"
    except RuntimeError as error:  # a user without a home
        raise FileNotFoundError(str(error)) from None
