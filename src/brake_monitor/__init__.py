"""Brake-unit monitor: wheel-rail adhesion and brake friction, estimated live from a wagon's CAN bus."""

import logging
from importlib.metadata import version

__version__ = version("brake-monitor")

logging.getLogger(__name__).addHandler(logging.NullHandler())  # who runs us decides where the log goes
