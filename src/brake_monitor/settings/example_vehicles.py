"""The example vehicles that come with the package: where their files are, and their settings."""

from pathlib import Path

from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings
from brake_monitor.settings.config_text import EXAMPLES_FOLDER

EXAMPLES = ("rig", "wagon", "bogie", "railcar")


def example_config(name: str) -> Path:
    """The configuration of an example vehicle: rig (1 wheelset), wagon (2), bogie (4), railcar (4, for motors)."""
    return EXAMPLES_FOLDER / f"{name}.toml"


def example_settings(name: str) -> Settings:
    """The settings of an example vehicle, as its configuration has them."""
    return load_settings(example_config(name))
