"""Brake-unit monitor: wheel-rail adhesion and brake friction, estimated live from a wagon's CAN bus."""

import logging

__version__: str

logging.getLogger(__name__).addHandler(logging.NullHandler())  # who runs us decides where the log goes


def __getattr__(name: str) -> str:
    """`__version__`, once it is asked for: to look it up takes as long as all else that is loaded here."""
    if name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib.metadata import version  # noqa: PLC0415 - slow to import

    return version("brake-monitor")
