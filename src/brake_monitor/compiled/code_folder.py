"""The folder on disk for machine code."""

from functools import cache
from hashlib import sha256
from importlib.metadata import version
from os import environ
from pathlib import Path


@cache
def folder() -> Path:
    """Where it is kept, for this very version of our sources and of numba."""
    tag = sha256(version("numba").encode())
    package = Path(__file__).parents[1]
    for pattern in ("*.py", "estimation/*.py", "compiled/*.py"):
        for source in sorted(package.glob(pattern)):
            tag.update(source.read_bytes())
    base = environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "brake-monitor" / tag.hexdigest()[:16]
