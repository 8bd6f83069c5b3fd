"""Brake-unit monitor: wheel-rail adhesion and brake friction, estimated live from a wagon's CAN bus."""

from importlib.metadata import version

__version__ = version("brake-monitor")
