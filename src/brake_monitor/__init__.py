"""Brake-unit monitor: wheel-rail adhesion and brake friction, estimated live from a wagon's CAN bus."""

import logging

__version__: str

logging.getLogger(__name__).addHandler(logging.NullHandler())  # the program that uses us decides where the log goes


def __getattr__(name: str) -> str:
    """`__version__`, looked up only when asked for: that takes as long as all other imports here."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415 - slow to import

    try:
        return version("brake-monitor")
    except PackageNotFoundError:  # run from its sources
        return "(not installed)"
