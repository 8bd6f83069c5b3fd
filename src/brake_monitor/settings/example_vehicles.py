"""The example vehicles that come with the package: where their files are, and their settings."""

from importlib.resources import files
from pathlib import Path

from brake_monitor.settings.config import Settings
from brake_monitor.settings.config_file import load_settings

EXAMPLES = ("rig", "wagon", "bogie", "railcar")


def example_config(name: str) -> Path:
    """The configuration of an example vehicle: rig (1 wheelset), wagon (2), bogie (4), railcar (4, for motors)."""
    return Path(str(files("brake_monitor"))) / "vehicles" / f"{name}.toml"


def example_settings(name: str) -> Settings:
    """The settings of an example vehicle, as its configuration has them."""
    return load_settings(example_config(name))
